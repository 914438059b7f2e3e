"""The key `vary` of a plan: what may happen besides the scenario, by names and patterns, and the choices of a rig.

vary:
  - {fault: stepper trip duration_ms=300}
  - {faults: stepper}                               # every fault that it can have
  - {faults: {where: buses, kinds: [drop, delay]}}
  - {press: {panel/key*: true}, hold: [50ms, 500ms]}
  - {set: {drive/speed_set: {from: 0, to: 60}}}
  - {restart: "*"}
"""

from collections.abc import Iterable, Iterator, Mapping
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Annotated, Any, Final, Self

from pydantic import BeforeValidator, Field, PlainValidator, model_validator

from fieldrig.clock import MS, S
from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.faults.condition import condition_of
from fieldrig.points.names import split_point
from fieldrig.settings import Settings, refuse_all
from fieldrig.text.nearest import closest
from fieldrig_devices.scenarios.act import Verb
from fieldrig_devices.scenarios.property_settings import Duration
from fieldrig_devices.scenarios.scenario_file import VERBS, FaultText, wrong_hold
from fieldrig_devices.search.choices import Choice, Span
from fieldrig_devices.search.fault_choices import fault_choices, matching_parts

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig

WILD: Final = "*"


def _as_list(value: Any) -> Any:
    return value if isinstance(value, list) else [value]


def _as_faults(value: Any) -> Any:
    return {"where": value} if isinstance(value, str | list) else value


def _values(value: Any) -> "Values":
    """Return the values of a place: one, those of a list, or a span."""
    if isinstance(value, dict):
        if value.keys() != {"from", "to"} or not all(type(one) in (int, float) for one in value.values()):
            raise ValueError("expected {from: NUMBER, to: NUMBER}")
        if value["from"] > value["to"]:
            raise ValueError("it is empty: expected `from` at most as large as `to`")
        return Span(value["from"], value["to"])
    listed = value if isinstance(value, list) else [value]
    if not listed or not all(isinstance(one, bool | int | float | str) for one in listed):
        raise ValueError("expected a value, a list of values, or {from: NUMBER, to: NUMBER}")
    return tuple(listed)


Values = tuple[Value, ...] | Span
GivenValues = Annotated[Any, PlainValidator(_values, json_schema_input_type=Any)]
Texts = Annotated[list[str], BeforeValidator(_as_list)]
SomeTexts = Annotated[Texts, Field(min_length=1)]
Durations = Annotated[list[Duration], BeforeValidator(_as_list), Field(min_length=1)]


class FaultsSettings(Settings):
    where: SomeTexts = Field(
        default=[WILD], description="buses and devices by name, by kind, or all of `buses` or `devices`; with * and ?"
    )
    kinds: SomeTexts = Field(default=[WILD], description="faults by their `what`, with * and ?")
    durations: Durations = Field(default=[100 * MS, 1 * S], description="how long they last")
    when: Texts = Field(default=[], description="conditions at which they begin, instead of at any instant")
    given: dict[str, Value] = Field(default={}, alias="with", description="keys of the faults, such as the wire")

    @model_validator(mode="after")
    def _has_conditions(self) -> Self:
        for one in self.when:
            condition_of(one)
        return self


class VarySettings(Settings):
    """Something that may happen at any instant."""

    set: dict[str, GivenValues] | None = Field(
        default=None, description="places with values: one, a list, or a span {from: 0, to: 60}; names may have * and ?"
    )
    press: dict[str, GivenValues] | None = Field(
        default=None, description="places with values that they have for a time"
    )
    hold: Durations = Field(default=[100 * MS], description="the time of `press`, or a list of times")
    fault: FaultText | None = Field(default=None, description="a fault, as `fieldrig fault` takes it: stepper trip")
    faults: Annotated[FaultsSettings | None, BeforeValidator(_as_faults)] = Field(
        default=None, description="all faults of some buses and devices: their names, or {where: ..., kinds: ...}"
    )
    send: dict[str, SomeTexts] | None = Field(
        default=None, description="CAN buses with frames as of `cansend`, and serial lines with bytes in hex"
    )
    clear: SomeTexts | None = Field(default=None, description="buses or devices whose faults end")
    restart: SomeTexts | None = Field(default=None, description="devices that are switched off and on")

    @model_validator(mode="after")
    def _does_one_thing(self) -> Self:
        known = (*VERBS, "faults")
        given = [name for name in known if getattr(self, name, None) is not None]
        if len(given) != 1:
            what = f"it has {' and '.join(given)}" if given else "it does nothing"
            raise ValueError(f"{what}: expected one of {', '.join(known)}")
        refuse_all(wrong_hold(self.model_fields_set, given))
        return self

    @property
    def key(self) -> str:
        """The key of what it lets happen."""
        return next(name for name in (*VERBS, "faults") if getattr(self, name, None) is not None)


def choices_of(rig: "Rig", vary: Iterable[VarySettings]) -> tuple[Choice, ...]:
    """Return what may happen to a rig.  ControlError, with the nearest name, for what it does not have."""
    found = [choice for one in vary for choice in choices_for(rig, one)]
    return tuple({repr(choice): choice for choice in found}.values())


def choices_for(rig: "Rig", given: VarySettings) -> Iterator[Choice]:
    """Yield what one entry lets happen."""
    yield from _writes(rig, "set", given.set, (0,))
    yield from _writes(rig, "press", given.press, tuple(given.hold))
    if given.fault is not None:
        fault = dict(given.fault)
        yield Choice("fault", fault.pop("where"), (fault,))
    if given.faults is not None:
        yield from fault_choices(rig, given.faults)
    for bus, texts in (given.send or {}).items():
        yield Choice("send", bus, tuple(texts))
    for part in matching_parts(rig, given.clear or ()):
        yield Choice("clear", part)
    for pattern in given.restart or ():
        if rig.config.devices.keys().isdisjoint(matching_parts(rig, (pattern,))):
            raise ControlError(f"{pattern} is no device", "expected the name of one, as buses are never switched off")
    for part in matching_parts(rig, given.restart or ()):
        if part in rig.config.devices:
            yield Choice("restart", part)


def _writes(rig: "Rig", verb: Verb, places: Mapping[str, Values] | None, holds_ns: tuple[int, ...]) -> Iterator[Choice]:
    for pattern, values in (places or {}).items():
        for place in _matching_places(rig, pattern):
            if isinstance(values, Span):
                yield Choice(verb, place, span=values, holds_ns=holds_ns)
            else:
                yield Choice(verb, place, values, holds_ns=holds_ns)


def _matching_places(rig: "Rig", pattern: str) -> list[str]:
    """Return the places of a pattern; a name without * and ? is one place, whatever it is."""
    if not any(sign in pattern for sign in "*?"):
        return [pattern]
    part, key = split_point(pattern)
    found = [
        f"{device}/{known}"
        for device in rig.config.devices
        if fnmatchcase(device, part)
        for known, fact in rig.facts(device).items()
        if fact["writable"] and fnmatchcase(known, key)
    ]
    if not found:
        raise ControlError(f"no place that can be written is {pattern!r}", closest(part, list(rig.config.devices)))
    return found
