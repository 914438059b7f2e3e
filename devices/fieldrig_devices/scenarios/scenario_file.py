"""Scenario files: which rig, what happens to it, and what has to hold.

rig: ../feeder.yaml
after: 60s
steps:
  - {at: 0s, set: {feeder/g_bStart: true}}
  - {at: 500ms, fault: stepper trip duration_ms=300}
properties:
  stops: {within: 50ms, condition: not feeder/g_bBusy, after: stepper/fault}
"""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple, Self

from pydantic import BeforeValidator, Field, PlainValidator, model_validator

from fieldrig.clock import S
from fieldrig.config.settings_file import load_settings
from fieldrig.device import Value
from fieldrig.faults.words import fault_of_words
from fieldrig.settings import ConfigFile, Settings, WrongKey, WrongSettingsError, refuse_all
from fieldrig.text.durations import duration_ns
from fieldrig_devices.scenarios.act import Act, Schedule, Verb
from fieldrig_devices.scenarios.expression import Expression, expression_of
from fieldrig_devices.scenarios.property import Kind, Property

LEAST_LENGTH_NS: Final = 1 * S
"""A scenario without `for` goes on for this time after its last action, or for the longest time of a property."""


def _duration(value: Any) -> int:
    if not isinstance(value, str):
        raise ValueError("expected a time with a unit, such as 100ms or 1.5s")
    return duration_ns(value)


def _expression(value: Any) -> Expression:
    if not isinstance(value, str):
        raise ValueError("expected an expression, such as tank/level > 1.5 and not pump/run")
    return expression_of(value)


def _fault(value: Any) -> dict[str, str]:
    """Return the bus or device of a fault, in `where`, with the fault in its one form."""
    words = value.split() if isinstance(value, str) else []
    if len(words) < 2:
        raise ValueError("expected a bus or device with a fault, such as: stepper trip duration_ms=300")
    return {"where": words[0], **fault_of_words(words[1:])}


Duration = Annotated[int, PlainValidator(_duration, json_schema_input_type=str)]
Condition = Annotated[Any, PlainValidator(_expression, json_schema_input_type=str)]
FaultText = Annotated[dict[str, str], BeforeValidator(_fault, json_schema_input_type=str)]
VERBS: Final[tuple[Verb, ...]] = ("set", "press", "fault", "clear", "restart")


class ActionSettings(Settings):
    """One action, at whatever instant."""

    set: dict[str, Value] | None = Field(default=None, description="places with their new values")
    press: dict[str, Value] | None = Field(default=None, description="places with values that they have for a time")
    hold: Duration = Field(default=100_000_000, description="the time of `press`")
    fault: FaultText | None = Field(
        default=None, description="a bus or device with a fault, as `fieldrig fault` takes it: stepper trip"
    )
    clear: str | None = Field(default=None, description="a bus or device whose faults end")
    restart: str | None = Field(default=None, description="a device that is switched off and on")

    @model_validator(mode="after")
    def _does_one_thing(self) -> Self:
        given = [verb for verb in VERBS if getattr(self, verb) is not None]
        if len(given) != 1:
            what = f"it has {' and '.join(given)}" if given else "it does nothing"
            raise ValueError(f"{what}: expected one of {', '.join(VERBS)}")
        return self

    def acts(self, at_ns: int) -> Iterator[Act]:
        """Yield the action at an instant; one for each place that it writes."""
        for place, value in (self.set or {}).items():
            yield Act(at_ns, "set", place, value)
        for place, value in (self.press or {}).items():
            yield Act(at_ns, "press", place, value, self.hold)
        if self.fault is not None:
            fault = dict(self.fault)
            yield Act(at_ns, "fault", fault.pop("where"), fault)
        if self.clear is not None:
            yield Act(at_ns, "clear", self.clear)
        if self.restart is not None:
            yield Act(at_ns, "restart", self.restart)


class StepSettings(ActionSettings):
    at: Duration = Field(description="the instant, from the begin of the scenario")


class PropertySettings(Settings):
    always: Condition = Field(default=None, description="a condition that is true all the time")
    never: Condition = Field(default=None, description="a condition that is never true")
    expect: Condition = Field(default=None, description="a condition that becomes true `within` a time")
    stays: Condition = Field(default=None, description="a condition that is true `until` another one is")
    eventually: Condition = Field(
        default=None, description="a condition that becomes true `within` a time, when all faults are over"
    )
    after: Condition = Field(
        default=None, description="from when on: each instant at which this becomes true; without it, the begin"
    )
    until: Condition = Field(default=None, description="the end of `stays`")
    within: Duration | None = Field(default=None, description="the longest time")
    longer: Duration | None = Field(
        default=None, description="the time for which `always` or `never` may be wrong, such as a delay of the program"
    )

    @model_validator(mode="after")
    def _is_one_property(self) -> Self:
        given = [name for name in _KINDS if getattr(self, name) is not None]
        if len(given) != 1:
            what = f"it has {' and '.join(given)}" if given else "it says nothing"
            raise ValueError(f"{what}: expected one of {', '.join(_KINDS)}")
        refuse_all(self._wrong(_KINDS[given[0]], given[0]))
        return self

    def _wrong(self, kind: Kind, name: str) -> Iterator[WrongKey]:
        if kind in (Kind.WITHIN, Kind.EVENTUALLY) and self.within is None:
            yield WrongKey(("within",), f"{name} needs a time", f"expected {{{name}: ..., within: 100ms}}")
        if kind is Kind.STAYS and self.until is None:
            yield WrongKey(("until",), "stays needs an end", "expected {stays: ..., until: ...}")
        if kind is not Kind.STAYS and self.until is not None:
            yield WrongKey(("until",), f"{name} has no end", "only `stays` has `until`")
        if kind in (Kind.ALWAYS, Kind.NEVER) and self.within is not None:
            yield WrongKey(("within",), f"{name} takes no time", "`expect` and `eventually` have `within`")
        if kind not in (Kind.ALWAYS, Kind.NEVER) and self.longer is not None:
            yield WrongKey(("longer",), f"{name} takes no such time", "`always` and `never` have `longer`")
        if kind is Kind.EVENTUALLY and self.after is not None:
            yield WrongKey(("after",), "eventually begins when all faults are over", "leave `after` out")

    def property(self, name: str) -> Property:
        key = next(one for one in _KINDS if getattr(self, one) is not None)
        longest_ns = self.longer if self.within is None else self.within
        return Property(name, _KINDS[key], getattr(self, key), self.after, self.until, longest_ns)


_KINDS: Final = {
    "always": Kind.ALWAYS,
    "never": Kind.NEVER,
    "expect": Kind.WITHIN,
    "stays": Kind.STAYS,
    "eventually": Kind.EVENTUALLY,
}


class ScenarioSettings(Settings):
    rig: ConfigFile = Field(description="the rig file")
    overrides: list[str] = Field(default=[], description="values beside the rig file, such as seed=3")
    after: Duration = Field(default=0, description="the time for which the rig runs before the scenario begins")
    length: Duration | None = Field(
        default=None, alias="for", description="the length; without it, a time after the last step that is long enough"
    )
    steps: list[StepSettings] = Field(default=[], description="what happens, in the order of time")
    recover: list[StepSettings] = Field(
        default=[],
        description="what the operator does in the end, when no fault is left, so that the machine comes back; in the "
        "order of time, which counts from then",
    )
    properties: dict[str, PropertySettings] = Field(description="what has to hold, by name", min_length=1)

    @model_validator(mode="after")
    def _is_in_order(self) -> Self:
        wrong = [
            WrongKey((key, number, "at"), "it is before the step above", "expected steps in the order of time")
            for key, steps in (("steps", self.steps), ("recover", self.recover))
            for number, (before, step) in enumerate(pairwise(steps), 1)
            if step.at < before.at
        ]
        if self.length is not None and self.steps and self.steps[-1].at > self.length:
            wrong.append(WrongKey(("for",), "the last step is later", "expected a longer time"))
        if wrong:
            raise WrongSettingsError(wrong)
        return self


class Scenario(NamedTuple):
    """A scenario that was loaded and checked."""

    rig: Path
    overrides: tuple[str, ...]
    after_ns: int
    length_ns: int
    schedule: Schedule
    recovery: Schedule
    """What the operator does in the end; its instants count from the end of all faults."""
    properties: tuple[Property, ...]


def load_scenario(path: Path) -> Scenario:
    """Return the scenario of a file.  ConfigError with every mistake; places are looked up when it runs."""
    return scenario_of(load_settings(path, ScenarioSettings))


def scenario_of(given: ScenarioSettings) -> Scenario:
    """Return the scenario of settings that were checked."""
    schedule, recovery = (
        tuple(act for step in steps for act in step.acts(step.at)) for steps in (given.steps, given.recover)
    )
    properties = tuple(one.property(name) for name, one in given.properties.items())
    length_ns = _length_ns(schedule, properties) if given.length is None else given.length
    return Scenario(given.rig, tuple(given.overrides), given.after, length_ns, schedule, recovery, properties)


def _length_ns(schedule: Schedule, properties: tuple[Property, ...]) -> int:
    last_ns = max((act.end_ns for act in schedule), default=0)
    longest_ns = max((one.within_ns or 0 for one in properties), default=0)
    return last_ns + longest_ns + LEAST_LENGTH_NS
