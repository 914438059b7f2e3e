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

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple, Self

from pydantic import Field, model_validator

from fieldrig.config.settings_file import load_settings
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.scenarios.scenario_file import ActionSettings, Scenario, ScenarioSettings, scenario_of


class PlanSettings(ScenarioSettings):
    vary: list[ActionSettings] = Field(description="what may happen besides, at any time", min_length=1)
    edges: list[str] = Field(
        default=[], description="further places whose changes are instants for `sweep`, besides those of the properties"
    )
    states: list[str] = Field(
        default=[],
        description="places whose values are the state of the machine for `archive`; those of the properties",
    )

    @model_validator(mode="after")
    def _each_does_one_thing(self) -> Self:
        for number, action in enumerate(self.vary):
            if len(list(action.acts(0))) != 1:
                raise ValueError(f"vary[{number}] writes several places: expected one action each")
        return self

    def actions(self) -> Iterator[Act]:
        for action in self.vary:
            yield from action.acts(0)


class Plan(NamedTuple):
    """A plan that was loaded and checked."""

    scenario: Scenario
    actions: tuple[Act, ...]
    """The actions that may come at any time; theirs is 0."""
    edges: tuple[str, ...]
    states: tuple[str, ...]


def load_plan(path: Path) -> Plan:
    """Return the plan of a file.  ConfigError with every mistake; places are looked up when the search begins."""
    given = load_settings(path, PlanSettings)
    scenario = scenario_of(given)
    judged = tuple(dict.fromkeys(place for one in scenario.properties for place in one.places))
    edges = tuple(dict.fromkeys((*judged, *given.edges)))
    return Plan(scenario, tuple(given.actions()), edges, tuple(given.states) or judged)
