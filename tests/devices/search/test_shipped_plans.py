"""The plans of configs/searches: each loads with all that it names; cheap ones hold, and a few runs find nothing."""

from collections.abc import Mapping
from pathlib import Path
from random import Random

import pytest
from typer.testing import CliRunner

from fieldrig.clock import MS
from fieldrig.config.rig_file import load
from fieldrig.virtual.rig import Rig
from fieldrig_devices.scenarios.play import play
from fieldrig_devices.search.bench import Bench
from fieldrig_devices.search.command import app
from fieldrig_devices.search.piece import Piece
from fieldrig_devices.search.plan import load_plan
from fieldrig_devices.search.vary import choices_of

pytestmark = [pytest.mark.lean, pytest.mark.long]

PLANS = sorted((Path(__file__).parents[3] / "configs" / "searches").glob("*.yaml"))
CHEAP = ("drive", "energy-meter", "lab", "own-device", "smart-io")
"""Rigs that run far faster than real time, without a program; the campaigns of the others are in campaigns.md."""


@pytest.mark.parametrize("plan", PLANS, ids=lambda plan: plan.stem)
def test_a_shipped_plan_names_what_its_rig_has(plan: Path) -> None:
    given = load_plan(plan)
    with Rig(load(given.scenario.rig, ("time=virtual", *given.scenario.overrides))) as rig:
        choices = choices_of(rig, given.vary)
        for act in (next(one.all(0)) for one in choices if one.verb == "fault"):
            assert isinstance(act.value, Mapping)
            rig.add_fault(act.where, {**act.value, "start_ms": 1_000_000})  # it is taken, and never begins
        parts = {*rig.buses, *rig.config.devices}
        assert {place.partition("/")[0] for one in given.scenario.properties for place in one.places} <= parts


@pytest.mark.parametrize("name", CHEAP)
def test_a_cheap_plan_holds_and_a_few_runs_find_nothing(name: str, tmp_path: Path) -> None:
    plan = next(one for one in PLANS if one.stem == name)
    options = ["--strategy", "swarm", "--most", "3", "--budget", "10min", "-j", "1", "--corpus", str(tmp_path / "c")]
    shown = CliRunner().invoke(app, ["run", str(plan), *options])
    assert shown.exit_code == 0, shown.output
    assert "nothing was found" in shown.output


@pytest.mark.parametrize("name", CHEAP)
def test_a_run_is_the_same_in_a_branch_and_in_a_new_rig(name: str) -> None:
    plan, dice = load_plan(next(one for one in PLANS if one.stem == name)), Random(32)
    given = plan.scenario
    with Bench(plan) as bench:
        instants = sorted(dice.randrange(given.length_ns // MS) * MS for _ in range(4))
        acts = tuple(dice.choice(bench.choices).thrown(dice, at_ns) for at_ns in instants)
        in_a_branch, again = (bench.told(Piece(acts, 0, given.length_ns)) for _ in range(2))
    with Rig(load(given.rig, ("time=virtual", *given.overrides))) as rig:
        rig.run_until(given.after_ns)
        schedule = sorted((*given.schedule, *acts), key=lambda act: act.at_ns)
        alone = play(rig, tuple(schedule), given.properties, given.length_ns, recovery=given.recovery, stops_early=True)
    assert in_a_branch.hash == again.hash == alone.hash
    assert in_a_branch.violations == again.violations == alone.violations
