"""Checks, before anything happens, that a rig has everything that a scenario names; each mistake has its line."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from fieldrig.config.yaml_source import KeyPath, Source, key_text
from fieldrig.errors import ConfigError, ControlError, Mistake, RigError
from fieldrig.faults.condition import condition_of
from fieldrig.faults.faults import fault_of
from fieldrig.faults.power import models_of_device
from fieldrig.points.names import split_point
from fieldrig.text.nearest import closest
from fieldrig_devices.scenarios.act import Act, RefusedActError, Schedule
from fieldrig_devices.scenarios.expression import expression_of
from fieldrig_devices.scenarios.known_texts import check_compared, check_written
from fieldrig_devices.scenarios.places import ReadOnly, place_of
from fieldrig_devices.scenarios.scenario_file import Scenario
from fieldrig_devices.scenarios.sending import message_of
from fieldrig_devices.scenarios.watching import check_judged

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig


def check(rig: "Rig", scenario: Scenario) -> None:
    """ConfigError, with every mistake, for a scenario whose places, faults or messages the rig does not have."""
    refuse_at(scenario.source, _wrong(rig, scenario))


def refuse_at(source: Source | None, wrong: Iterable[tuple[KeyPath, RigError]]) -> None:
    """ConfigError with these mistakes, each with its line in the source, unless there is none."""
    given = source or Source()
    mistakes = [Mistake(*given.mark(path), key_text(path), one.what, one.remedy) for path, one in wrong]
    if mistakes:
        raise ConfigError(list(dict.fromkeys(mistakes)))


def refused_at(scenario: Scenario, wrong: RefusedActError) -> RigError:
    """Return the refusal of a step as a mistake in its line; as it is if no line of a file has the step."""
    for key, schedule in (("steps", scenario.schedule), ("recover", scenario.recovery)):
        for path, act in _numbered(scenario, key, schedule):
            if scenario.source is not None and act._replace(at_ns=0, when="") == wrong.act._replace(at_ns=0, when=""):
                place = _key_of(path, act)
                mark = scenario.source.mark(place)
                return ConfigError([Mistake(*mark, key_text(place), wrong.what, wrong.remedy)])
    return wrong


def _key_of(path: KeyPath, act: Act) -> KeyPath:
    """Return the key of an action in its step."""
    return (*path, act.verb, *((act.where,) if act.verb in ("set", "press", "send") else ()))


def _wrong(rig: "Rig", scenario: Scenario) -> Iterator[tuple[KeyPath, RigError]]:
    for one in scenario.properties:
        for expression in filter(None, (one.condition, one.after, one.until)):
            yield from _of_expression(rig, _path_of(scenario, one.name, expression.text), expression.text)
    schedules = {"steps": scenario.schedule, "recover": scenario.recovery}
    for path, act in (one for key, schedule in schedules.items() for one in _numbered(scenario, key, schedule)):
        if act.when:
            yield from _of_expression(rig, (*path, "when"), act.when)
        try:
            _check_act(rig, act)
        except RigError as wrong:
            yield _key_of(path, act), wrong


def _of_expression(rig: "Rig", path: KeyPath, text: str) -> Iterator[tuple[KeyPath, RigError]]:
    expression, values = expression_of(text), {}
    for name in expression.places:
        try:
            values[name] = place_of(rig, name).read()
        except RigError as wrong:
            yield path, wrong
    if len(values) == len(expression.places):
        try:
            check_judged(text, expression, values)
            for place, compared in expression.texts:
                check_compared(rig, place, compared, values[place])
        except RigError as wrong:
            yield path, wrong


def _check_act(rig: "Rig", act: Act) -> None:
    """RigError for an action that the rig cannot take; whether a place takes a value is seen when it is written."""
    buses, devices = rig.config.buses, rig.config.devices
    if act.verb in ("set", "press"):
        place = place_of(rig, act.where)
        present = place.read()
        if isinstance(place, ReadOnly):
            place.write(False)
        check_written(rig, act.where, act.value, present)
        device, key = split_point(act.where)
        if device in devices and not rig.facts(device).get(key, {}).get("writable", True):
            raise ControlError(f"{act.where} cannot be written", "expected a point that `fieldrig set` can write")
        return
    known = {"restart": [*devices], "send": [*buses]}.get(act.verb, [*buses, *devices])
    if act.where not in known:
        raise ControlError(f"the rig has no {_SORTS[act.verb]} {act.where!r}", closest(act.where, known))
    if act.verb == "send":
        message_of(buses[act.where].bus, str(act.value))
    if isinstance(act.value, Mapping):
        cls = devices[act.where].cls if act.where in devices else None
        models = models_of_device(cls) if cls is not None else buses[act.where].bus.fault_models
        try:
            when = fault_of(act.value, models).when
            if isinstance(when, str):
                condition = condition_of(when)
                check_compared(rig, condition.point, condition.value, rig.get(condition.point))
        except ValueError as cause:
            what, _, remedy = str(cause).partition("\n")
            raise ControlError(f"{act.where}: {what}", remedy) from cause


_SORTS = {"restart": "device", "send": "bus", "fault": "bus or device", "clear": "bus or device"}


def _path_of(scenario: Scenario, name: str, text: str) -> KeyPath:
    """Return the key of an expression of a property."""
    data = scenario.source.data if scenario.source is not None else {}
    given = data.get("properties", {}).get(name, {}) if isinstance(data, dict) else {}
    key = next((key for key, value in given.items() if value == text), None)
    return ("properties", name) if key is None else ("properties", name, key)


def _numbered(scenario: Scenario, key: str, schedule: Schedule) -> Iterator[tuple[KeyPath, Act]]:
    """Yield each action with the key of its step, which may have several."""
    if scenario.source is None:
        yield from (((key, number), act) for number, act in enumerate(schedule))
        return
    data = scenario.source.data
    steps = data.get(key) or [] if isinstance(data, dict) else []
    acts = iter(schedule)
    for number, step in enumerate(steps):
        for _ in range(max((len(value) for value in step.values() if isinstance(value, dict)), default=1)):
            yield (key, number), next(acts)
