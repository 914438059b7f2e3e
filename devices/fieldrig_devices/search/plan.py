"""Plans of a search: a scenario that holds, and the actions and faults that may come at any time besides.

rig: ../feeder.yaml
after: 60s
for: 5s
steps:
  - {at: 100ms, set: {feeder/g_bStart: true}}
properties:
  sealed hot: {never: wires/feeder.seal and not feeder/g_bHot}
vary:
  - {fault: stepper trip duration_ms=300}
  - {press: {feeder/panel.key1: true}, hold: 100ms}
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Final, NamedTuple, Self

from pydantic import Field, model_validator

from fieldrig.config.settings_file import settings_of
from fieldrig.config.yaml_source import Source, read_file
from fieldrig.settings import ConfigFile, WrongKey, refuse_all
from fieldrig.text.durations import duration_ns
from fieldrig_devices.scenarios.property import Kind
from fieldrig_devices.scenarios.scenario_file import Scenario, ScenarioSettings, scenario_of, with_lines
from fieldrig_devices.search.piece import World
from fieldrig_devices.search.state_places import Sort
from fieldrig_devices.search.vary import FaultsSettings, VarySettings

EVERY_FAULT: Final = VarySettings(faults=FaultsSettings())
MOST_WORLDS: Final = 16


class PlanSettings(ScenarioSettings):
    vary: list[VarySettings] = Field(
        default=[EVERY_FAULT],
        description="what may happen besides, at any time; without it, every fault of all buses and devices",
        min_length=1,
    )
    worlds: dict[str, Annotated[list[int | float | bool | str], Field(min_length=1)]] = Field(
        default={},
        description="overrides of the rig with their values, such as seed or the load of a plant, or other times of "
        "the scenario, `after` and `jitter`; one at a time",
    )
    edges: list[str] = Field(
        default=[], description="further places whose changes are instants for `sweep`, besides those of the properties"
    )
    states: list[str] = Field(
        default=[], description="further places whose values are a state of the machine for `archive`"
    )
    state_kinds: list[Sort] = Field(
        default=list(Sort), description="what else is a state of the machine for `archive`; without it, all of these"
    )

    @model_validator(mode="after")
    def _has_not_too_many_worlds(self) -> Self:
        count = sum(map(len, self.worlds.values()))
        if count > MOST_WORLDS:
            raise ValueError(f"worlds has {count} values: expected at most {MOST_WORLDS}, as each is a rig in memory")
        refuse_all(self._wrong_times())
        return self

    def _wrong_times(self) -> Iterator[WrongKey]:
        for key in _TIMES:
            for number, value in enumerate(self.worlds.get(key, ())):
                try:
                    _time_of(value)
                except ValueError as wrong:
                    yield WrongKey(("worlds", key, number), str(wrong), "expected a time with a unit, such as 60.0013s")
        if self.worlds.get("jitter") and self.master is None:
            yield WrongKey(("worlds", "jitter"), "only a master wakes up late", "expected `master` as well")


class PropertyFileSettings(PlanSettings):
    rig: ConfigFile | None = Field(default=None, description="the rig file, unless it is given by the command")  # type: ignore[assignment]


class Plan(NamedTuple):
    """A plan that was loaded and checked."""

    scenario: Scenario
    vary: tuple[VarySettings, ...]
    worlds: tuple[tuple[str, ...], ...]
    """The worlds, each with its overrides or times; the first has none."""
    edges: tuple[str, ...]
    states: tuple[str, ...]
    sorts: frozenset[Sort]

    @property
    def recovers(self) -> bool:
        """True if the machine has to come back, so that each piece is judged after its end too."""
        return any(one.kind is Kind.EVENTUALLY for one in self.scenario.properties)


_TIMES: Final = ("after", "jitter")
"""The worlds that are other times of a scenario: its begin in the cycles of the rig, and how late its master is."""


def _time_of(value: object) -> int:
    return duration_ns(value if isinstance(value, str) else str(value))


def in_world(scenario: Scenario, world: World) -> Scenario:
    """Return a scenario in a world: with other overrides of the rig, or other times."""
    for words in world:
        match words.partition("="):
            case "after", _, value:
                scenario = scenario._replace(after_ns=_time_of(value))
            case "jitter", _, value:
                scenario = scenario._replace(jitter_ns=_time_of(value))
            case _:
                scenario = scenario._replace(overrides=(*scenario.overrides, words))
    return scenario


def load_plan(path: Path, overrides: Sequence[str] = ()) -> Plan:
    """Return the plan of a file.  ConfigError with every mistake; places are looked up when the search begins."""
    source = read_file(path)
    return _plan_of(settings_of(source, PlanSettings), source, overrides)


def plan_for(rig: Path, path: Path, overrides: Sequence[str] = ()) -> Plan:
    """Return the plan of a file of properties for a rig.  ConfigError with every mistake."""
    source = read_file(path)
    given = settings_of(source, PropertyFileSettings)
    return _plan_of(given.model_copy(update={"rig": rig}), source, overrides)


def _plan_of(given: PlanSettings, source: Source, overrides: Sequence[str]) -> Plan:
    scenario = with_lines(scenario_of(given), source)
    scenario = scenario._replace(overrides=(*scenario.overrides, *overrides))
    judged = tuple(dict.fromkeys(place for one in scenario.properties for place in one.places))
    return Plan(
        scenario,
        tuple(given.vary),
        ((), *((f"{key}={value}",) for key, values in given.worlds.items() for value in values)),
        tuple(dict.fromkeys((*judged, *given.edges))),
        tuple(dict.fromkeys((*judged, *given.states))),
        frozenset(given.state_kinds),
    )
