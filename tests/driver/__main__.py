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
from collections.abc import Mapping, MutableMapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from tests.driver import needs
from tests.driver.outcome import Outcome, Tally, summary
from tests.driver.stages import BYTECODE, CHECKS, PLANS, REPORTS, STAGES, Stage

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
    keep_bytecode(os.environ)
    REPORTS.mkdir(parents=True, exist_ok=True)
    _install(plan)
    began = time.monotonic()
    checks = [stage for stage in plan if stage in CHECKS]
    outcomes = [*run_checks(checks), *(run_stage(stage) for stage in plan if stage not in checks)]
    return summary(outcomes, time.monotonic() - began, in_ci)


def keep_bytecode(environment: MutableMapping[str, str]) -> None:
    """Let all processes of the tests share one folder of byte code, also where the user wants none beside the sources.

    A run starts about a thousand processes of ours, and each would compile its modules again.
    """
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    environment["PYTHONPYCACHEPREFIX"] = str(BYTECODE.resolve())


def _install(plan: Sequence[Stage]) -> None:
    wanted = needs.missing(dict.fromkeys(need for stage in plan for need in (*stage.needs, *stage.wants)))
    if wanted and needs.may_install():
        say(f"installing {', '.join(need.name for need in wanted)}")
        needs.install(wanted)


def run_checks(checks: Sequence[Stage]) -> list[Outcome]:
    """Run checks side by side, and say what each has to say when it is done."""

    def run(check: Stage) -> tuple[float, subprocess.CompletedProcess[str]]:
        began = time.monotonic()
        done = subprocess.run(check.command(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        return time.monotonic() - began, done

    outcomes = []
    with ThreadPoolExecutor() as pool:
        for check, (seconds, done) in zip(checks, pool.map(run, checks), strict=True):
            say(f"{check.name}: {check.about}")
            sys.stdout.write(done.stdout)
            outcomes.append(Outcome(check.name, done.returncode == 0, seconds))
    return outcomes


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
