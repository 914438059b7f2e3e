"""The plans of configs/searches: each loads, holds by itself, and a few runs of each find nothing."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from fieldrig_devices.search.command import app

pytestmark = pytest.mark.long

PLANS = sorted((Path(__file__).parents[3] / "configs" / "searches").glob("*.yaml"))


@pytest.mark.parametrize("plan", PLANS, ids=lambda plan: plan.stem)
def test_a_shipped_plan_holds_and_a_few_runs_find_nothing(plan: Path, tmp_path: Path) -> None:
    options = ["--strategy", "swarm,archive", "--most", "3", "--budget", "10min", "-j", "1"]
    shown = CliRunner().invoke(app, ["run", str(plan), *options, "--corpus", str(tmp_path / "runs")])
    assert shown.exit_code == 0, shown.output
    assert "nothing was found" in shown.output
