"""The planted bugs are what they say: small patches that break a property, which the shipped program keeps.

`machine-glue` takes 13 s a run, so its scenario is left to the bench, as are the shipped programs of rigs that another
bug has shown already: a search looks through all of them there (tests/bench/planted_bugs.py).
"""

from pathlib import Path

import pytest
from planted_in import PlantedBug, planted_bugs

from fieldrig_devices.scenarios.running import played
from fieldrig_devices.search.plan import load_plan

pytestmark = pytest.mark.lean

BUGS = {bug.name: bug for bug in planted_bugs()}
MOST_LINES = 12
"""Lines of a patch."""
MOST_FAULTS = 4
"""Actions of a scenario by hand; a search makes a finding smaller."""
PLAYED = sorted(set(BUGS) - {"machine-glue"})
SHIPPED = (
    "arp-life-level",
    "conveyor-two-tasks",
    "drive-unhandled-abort",
    "feeder-edge-twice",
    "lab-retry-counter",
    "pam-run-flag",
    "sealer-windup",
    "wrapper-lost-pack",
)


@pytest.fixture
def bug(request: pytest.FixtureRequest) -> PlantedBug:
    return BUGS[request.param]


def test_there_are_twenty_of_all_programs() -> None:
    assert len(BUGS) == 20
    assert len({bug.kind for bug in BUGS.values()}) == 20
    assert {name.partition("-")[0] for name in BUGS} == {
        *("arp", "conveyor", "drive", "feeder", "lab", "machine", "pam", "sealer", "wrapper")
    }


@pytest.mark.parametrize("bug", BUGS, indirect=True)
def test_each_is_a_small_patch_with_a_plan_that_is_right(bug: PlantedBug, tmp_path: Path) -> None:
    plan = load_plan(bug.plan_in(tmp_path))
    assert sum(patch.old.count("\n") + patch.new.count("\n") for patch in bug.patches) <= 2 * MOST_LINES
    assert bug.breaks in [one.name for one in plan.scenario.properties]
    assert len(bug.trigger) <= MOST_FAULTS


@pytest.mark.long
@pytest.mark.parametrize("bug", PLAYED, indirect=True)
def test_its_scenario_by_hand_breaks_its_property(bug: PlantedBug, tmp_path: Path) -> None:
    outcome = played(bug.scenario_in(tmp_path))
    assert bug.breaks in [one.property for one in outcome.played.violations]


@pytest.mark.long
@pytest.mark.parametrize("bug", SHIPPED, indirect=True)
def test_the_shipped_program_keeps_all_properties_in_the_same_scenario(bug: PlantedBug, tmp_path: Path) -> None:
    assert played(bug.scenario_in(tmp_path, clean=True)).played.violations == ()


@pytest.mark.long
@pytest.mark.parametrize("bug", ["wrapper-lost-for-ever", "wrapper-lost-pack"], indirect=True)
def test_what_these_plans_found_in_the_shipped_wrapper_stays_fixed(bug: PlantedBug, tmp_path: Path) -> None:
    """The result of the last run ended each later one at once if an axis was lost while its cam was being set."""
    found = bug._replace(trigger=[{"at": "1228397us", "fault": "ring break after=infeed duration_ms=300"}])
    assert played(found.scenario_in(tmp_path, clean=True)).played.violations == ()


ALARMS = {"conveyor-two-tasks": [{"at": "4200ms", "fault": "ring break after=belt duration_ms=1"}]}
"""Actions with which a search once gave an alarm for a program without its bug: the property said what it does not."""


@pytest.mark.long
@pytest.mark.parametrize("bug", ALARMS, indirect=True)
def test_an_alarm_of_a_program_without_its_bug_is_none_any_more(bug: PlantedBug, tmp_path: Path) -> None:
    outcome = played(bug._replace(trigger=ALARMS[bug.name]).scenario_in(tmp_path, clean=True))
    assert outcome.played.violations == ()
