"""Runs the tests in stages: `python -m tests.driver test`, usually called by make; `vcan docker` runs those two.

First it installs what the stages need, where it may (root and apt-get).  A stage whose needs are not met is left out,
the others run all the same.  At the end stands what ran, what was left out, and how to get it; with CI=true leaving
something out is a failure.
"""

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from tests.driver import needs
from tests.driver.outcome import Outcome, Tally, summary
from tests.driver.stages import PLANS, REPORTS, STAGES, Stage

PYTEST_FAILED = 1  # pytest's exit code for tests that failed, as opposed to a run that broke off
AGAIN_LIMIT = 5  # more than a busy host explains


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.driver", description=(__doc__ or "").partition("\n")[0])
    parser.add_argument(
        "names", nargs="+", choices=[*PLANS, *STAGES], metavar="NAME", help=", ".join([*PLANS, *STAGES])
    )
    names: list[str] = parser.parse_args().names
    plan = list(dict.fromkeys(stage for name in names for stage in PLANS.get(name) or [STAGES[name]]))
    in_ci = os.environ.get("CI", "").lower() in ("true", "1")
    os.environ["PATH"] = f"{Path(sys.prefix) / 'bin'}{os.pathsep}{os.environ['PATH']}"
    REPORTS.mkdir(parents=True, exist_ok=True)
    _install(plan)
    began = time.monotonic()
    outcomes = [run_stage(stage) for stage in plan]
    return summary(outcomes, time.monotonic() - began, in_ci)


def _install(plan: Sequence[Stage]) -> None:
    wanted = needs.missing(dict.fromkeys(need for stage in plan for need in (*stage.needs, *stage.wants)))
    if wanted and needs.may_install():
        say(f"installing {', '.join(need.name for need in wanted)}")
        needs.install(wanted)


def run_stage(stage: Stage) -> Outcome:
    missing = needs.missing(stage.needs)
    lacking = [f"{stage.name} needs {need.name}: {need.remedy}" for need in (*missing, *needs.missing(stage.wants))]
    if missing:
        return Outcome(stage.name, None, 0.0, left_out=lacking)
    say(f"{stage.name}: {stage.about}")
    if stage.report is not None:
        stage.report.unlink(missing_ok=True)
    began = time.monotonic()
    try:
        with stage.around() as environment:
            is_ok, tally, unsteady = _tried(stage, {**os.environ, **environment})
    except RuntimeError as fault:
        say(f"{stage.name}: {fault}")
        is_ok, tally, unsteady = False, Tally(), ()
    return Outcome(stage.name, is_ok, time.monotonic() - began, tally, [*lacking, *tally.skipped], unsteady)


def _tried(stage: Stage, environment: Mapping[str, str]) -> tuple[bool, Tally, Sequence[str]]:
    """Run the stage, and what failed of a stage in real time once more, if it is little.

    Returns whether all passed, the results, and the tests that passed only the second time.
    """
    code = subprocess.run(stage.command(), env=environment, check=False).returncode
    tally = Tally.of(stage.report) if stage.report is not None else Tally()
    if code != PYTEST_FAILED or stage.again is None or not 0 < tally.failed <= AGAIN_LIMIT:
        return code == 0, tally, ()
    say(f"{stage.name}: {tally.failed} failed and run again, alone: {', '.join(tally.failures)}")
    if subprocess.run(stage.again(), env=environment, check=False).returncode != 0:
        return False, tally, ()
    return True, replace(tally, passed=tally.passed + tally.failed, failed=0, failures=()), tally.failures


def say(text: str) -> None:
    sys.stdout.write(f"\n--- {text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
