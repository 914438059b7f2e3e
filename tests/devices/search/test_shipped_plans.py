"""The plans of configs/searches: each loads with all that it names; cheap ones hold, and a few runs find nothing."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from fieldrig.config.rig_file import load
from fieldrig.virtual.rig import Rig
from fieldrig_devices.search.command import app
from fieldrig_devices.search.plan import load_plan
from fieldrig_devices.search.vary import choices_of

pytestmark = pytest.mark.long

PLANS = sorted((Path(__file__).parents[3] / "configs" / "searches").glob("*.yaml"))
CHEAP = ("drive", "energy-meter", "lab", "own-device", "smart-io")
"""Rigs that run far faster than real time, without a program; the campaigns of the others are in campaigns.md."""


@pytest.mark.parametrize("plan", PLANS, ids=lambda plan: plan.stem)
def test_a_shipped_plan_names_what_its_rig_has(plan: Path) -> None:
    given = load_plan(plan)
    with Rig(load(given.scenario.rig, ("time=virtual", *given.scenario.overrides))) as rig:
        assert choices_of(rig, given.vary)
        parts = {*rig.buses, *rig.config.devices}
        assert {place.partition("/")[0] for one in given.scenario.properties for place in one.places} <= parts


@pytest.mark.parametrize("name", CHEAP)
def test_a_cheap_plan_holds_and_a_few_runs_find_nothing(name: str, tmp_path: Path) -> None:
    plan = next(one for one in PLANS if one.stem == name)
    options = ["--strategy", "swarm", "--most", "3", "--budget", "10min", "-j", "1", "--corpus", str(tmp_path / "c")]
    shown = CliRunner().invoke(app, ["run", str(plan), *options])
    assert shown.exit_code == 0, shown.output
    assert "nothing was found" in shown.output
