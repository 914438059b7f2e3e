"""Scenario files: which rig, what happens to it, and what has to hold.

rig: ../feeder.yaml
after: 60s
steps:
  - {at: 0s, set: {feeder/g_bStart: true}}
  - {at: 500ms, fault: stepper trip duration_ms=300}
properties:
  stops: {within: 50ms, condition: not feeder/g_bBusy, after: stepper/fault}
"""

from collections.abc import Collection, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple, Self

from pydantic import BeforeValidator, Field, model_validator

from fieldrig.clock import S
from fieldrig.config.settings_file import settings_of
from fieldrig.config.yaml_source import Source, read_file
from fieldrig.device import Value
from fieldrig.errors import ConfigError, Mistake
from fieldrig.faults.words import fault_of_words, split_words
from fieldrig.settings import ConfigFile, Settings, WrongKey, WrongSettingsError, refuse_all
from fieldrig_devices.scenarios.act import Act, Schedule, Verb
from fieldrig_devices.scenarios.property import Property
from fieldrig_devices.scenarios.property_settings import Condition, Duration, PropertySettings

LEAST_LENGTH_NS: Final = 1 * S
"""A scenario without `for` goes on for this time after its last action, or for the longest time of a property."""


def _fault(value: Any) -> dict[str, str]:
    """Return the bus or device of a fault, in `where`, with the fault in its one form."""
    words = split_words(value) if isinstance(value, str) else []
    if len(words) < 2:
        raise ValueError("expected a bus or device with a fault, such as: stepper trip duration_ms=300")
    return {"where": words[0], **fault_of_words(words[1:])}


FaultText = Annotated[dict[str, str], BeforeValidator(_fault, json_schema_input_type=str)]
VERBS: Final[tuple[Verb, ...]] = ("set", "press", "fault", "clear", "restart", "send")


def wrong_hold(keys: Collection[str], verbs: Collection[str]) -> Iterator[WrongKey]:
    """Yield what is wrong with the keys of an action: only `press` has a time."""
    if "hold" in keys and "press" not in verbs:
        yield WrongKey(("hold",), f"{' and '.join(verbs)} takes no time", "only `press` has `hold`")


class ActionSettings(Settings):
    """One action, at whatever instant."""

    set: dict[str, Value] | None = Field(default=None, min_length=1, description="places with their new values")
    press: dict[str, Value] | None = Field(
        default=None, min_length=1, description="places with values that they have for a time"
    )
    hold: Duration = Field(default=100_000_000, description="the time of `press`")
    fault: FaultText | None = Field(
        default=None, description="a bus or device with a fault, as `fieldrig fault` takes it: stepper trip"
    )
    clear: str | None = Field(default=None, description="a bus or device whose faults end")
    restart: str | None = Field(default=None, description="a device that is switched off and on")
    send: dict[str, str] | None = Field(
        default=None,
        min_length=1,
        description="CAN buses with a frame as of `cansend`, and serial lines with bytes in hex",
    )

    @model_validator(mode="after")
    def _does_one_thing(self) -> Self:
        given = [verb for verb in VERBS if getattr(self, verb) is not None]
        if len(given) != 1:
            what = f"it has {' and '.join(given)}" if given else "it does nothing"
            raise ValueError(f"{what}: expected one of {', '.join(VERBS)}")
        refuse_all(wrong_hold(self.model_fields_set, given))
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
        for bus, text in (self.send or {}).items():
            yield Act(at_ns, "send", bus, text)


class StepSettings(ActionSettings):
    """An action with its instant, or its milestone."""

    at: Duration | None = Field(
        default=None, description="the instant, from the begin of the scenario; with `when`, the time from then on"
    )
    when: Condition = Field(
        default=None, description="a condition, as of faults: the step comes when it has become true"
    )
    nth: int = Field(default=1, ge=1, le=1_000_000, description="how many times it has to become true")

    @model_validator(mode="after")
    def _has_an_instant(self) -> Self:
        if self.at is None and self.when is None:
            raise ValueError("it says nothing of when: expected at: 1.5s, or when: tank/level > 1")
        if self.nth > 1 and self.when is None:
            raise ValueError("nth counts how often `when` has become true: expected `when` as well")
        return self

    def timed_acts(self) -> Iterator[Act]:
        """Yield the action, one for each place that it writes."""
        when = "" if self.when is None else self.when.text
        for act in self.acts(self.at or 0):
            yield act._replace(when=when, nth=self.nth)


def _timed(steps: Sequence[StepSettings]) -> list[tuple[int, int]]:
    """Return the numbers and instants of the steps without milestones."""
    return [(number, step.at or 0) for number, step in enumerate(steps) if step.when is None]


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
    master: ConfigFile | None = Field(
        default=None, description="a program of Python that begins with the scenario, as a master in virtual time"
    )
    lateness: Duration | None = Field(
        default=None, description="the longest time by which a step may come late in real time; without it, any"
    )
    forgives: bool = Field(
        default=False, description="a value that a device refuses is no error, as in a search, which finds such steps"
    )
    jitter: Duration = Field(default=0, description="wake the master late by up to this time, by chance from the seed")

    @model_validator(mode="after")
    def _is_in_order(self) -> Self:
        timed = _timed(self.steps)
        wrong = [
            WrongKey((key, number, "at"), "it is before the step above", "expected steps in the order of time")
            for key, steps in (("steps", timed), ("recover", _timed(self.recover)))
            for (_, before_ns), (number, at_ns) in pairwise(steps)
            if at_ns < before_ns
        ]
        if self.length is not None and timed and timed[-1][1] > self.length:
            wrong.append(WrongKey(("for",), "the last step is later", "expected a longer time"))
        if self.jitter and self.master is None:
            wrong.append(WrongKey(("jitter",), "only a master wakes up late", "expected `master` as well"))
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
    """The actions of the operator in the end; their instants count from the end of all faults."""
    properties: tuple[Property, ...]
    source: Source | None = None
    """The file, with the lines of its keys; None without one."""
    master: Path | None = None
    """A program of Python that acts as a master."""
    jitter_ns: int = 0
    """The longest time by which the master wakes up late."""
    forgives: bool = False
    """True if a value that a device refuses is no error."""
    lateness_ns: int | None = None
    """The longest time by which a step may come late in real time."""


def load_scenario(path: Path) -> Scenario:
    """Return the scenario of a file.  ConfigError with every mistake; places are looked up when it runs."""
    source = read_file(path)
    if isinstance(source.data, dict) and "vary" in source.data:
        remedy = "`fieldrig search run FILE` takes it"
        raise ConfigError([Mistake(*source.mark(("vary",)), "vary", "this is the plan of a search", remedy)])
    return with_lines(scenario_of(settings_of(source, ScenarioSettings)), source)


def with_lines(scenario: Scenario, source: Source) -> Scenario:
    """Return a scenario with the file that it comes from, and the lines of its properties there."""
    lined = [one._replace(line=source.mark(("properties", one.name)).line or 0) for one in scenario.properties]
    return scenario._replace(properties=tuple(lined), source=source)


def scenario_of(given: ScenarioSettings) -> Scenario:
    """Return the scenario of settings that were checked."""
    schedule, recovery = (
        tuple(act for step in steps for act in step.timed_acts()) for steps in (given.steps, given.recover)
    )
    properties = tuple(one.property(name) for name, one in given.properties.items())
    length_ns = length_of(schedule, properties) if given.length is None else given.length
    scenario = Scenario(given.rig, tuple(given.overrides), given.after, length_ns, schedule, recovery, properties)
    return scenario._replace(
        master=given.master, jitter_ns=given.jitter, forgives=given.forgives, lateness_ns=given.lateness
    )


def length_of(schedule: Schedule, properties: Sequence[Property]) -> int:
    """Return a length that is enough for the last action and the longest wait of a property, in nanoseconds."""
    last_ns = max((act.end_ns for act in schedule if not act.when), default=0)
    last_ns += sum(act.end_ns for act in schedule if act.when)  # each may come after the one before it
    longest_ns = max((one.within_ns or 0 for one in properties), default=0)
    return last_ns + longest_ns + LEAST_LENGTH_NS
