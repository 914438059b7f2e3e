"""Runs the tests in stages: `python -m tests.driver test`, usually called by make; `vcan docker` runs those two.

First it installs what the stages need, where it may (root and apt-get).  A stage whose needs are not met is left out,
the others run all the same.  At the end stands what ran, what was left out, and how to get it; with CI=true leaving
something out is a failure.
"""

import argparse
import os
import sys
import time
from collections.abc import Mapping, MutableMapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import chain, groupby
from pathlib import Path
from tempfile import TemporaryFile
from typing import TextIO

from tests.driver import needs
from tests.driver.commands import INTERRUPTED, Commands
from tests.driver.outcome import Outcome, Tally, summary
from tests.driver.stages import BYTECODE, PLANS, REPORTS, STAGES, Stage, Turn

COMMANDS = Commands()
PYTEST_FAILED = 1  # pytest's exit code for tests that failed, as opposed to a run that broke off
APART = (Turn.ALONE, Turn.FIRST)
AGAIN_LIMIT = 5  # files: more than a busy host explains


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
    COMMANDS.install()
    _install(plan)
    began = time.monotonic()
    outcomes = list[Outcome]()
    for turn, group in groupby(plan, key=lambda stage: stage.turn if stage.turn in APART else None):
        stages = [*group]
        is_together = turn is not Turn.ALONE and len(stages) > 1
        outcomes += run_together(stages) if is_together else [run_stage(stage) for stage in stages]
    code = summary(outcomes, time.monotonic() - began, in_ci)
    return INTERRUPTED if COMMANDS.is_interrupted else code


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


def run_together(stages: Sequence[Stage]) -> list[Outcome]:
    """Run stages in their turns, and show what each has to say when it is done; `Turn` says which run at once."""
    after, patient = ([stage for stage in stages if stage.turn is turn] for turn in (Turn.AFTER, Turn.BEHIND))
    beside = [stage for stage in stages if stage not in after + patient]

    def run(stage: Stage) -> tuple[Outcome, str]:
        with TemporaryFile("w+", encoding="utf-8", errors="replace") as output:
            outcome = run_stage(stage, output, is_behind=stage in patient and len(patient) < len(stages))
            output.seek(0)
            return outcome, output.read()

    say(f"side by side: {', '.join(stage.name for stage in (*beside, *patient))}")
    outcomes = []
    with ThreadPoolExecutor(max(len(beside), 1)) as at_once, ThreadPoolExecutor(1) as behind:
        texts = behind.map(run, patient)
        for outcome, text in chain(at_once.map(run, beside), map(run, after), texts):
            sys.stdout.write(text)
            sys.stdout.flush()
            outcomes.append(outcome)
    return outcomes


def run_stage(stage: Stage, output: TextIO | None = None, *, is_behind: bool = False) -> Outcome:
    """Run a stage, or run it behind others; it writes to `output`, which is a file, or to where this program writes."""
    missing = needs.missing(stage.needs)
    lacking = [f"{stage.name} needs {need.name}: {need.remedy}" for need in (*missing, *needs.missing(stage.wants))]
    if missing:
        return Outcome(stage.name, None, 0.0, left_out=lacking)
    if COMMANDS.is_interrupted:
        return Outcome(stage.name, None, 0.0, left_out=[f"{stage.name}: the run was interrupted before"])
    say(f"{stage.name}: {stage.about}", output)
    if stage.report is not None:
        stage.report.unlink(missing_ok=True)
    began = time.monotonic()
    try:
        with stage.around() as environment:
            outcome = _tried(stage, {**os.environ, **environment}, output, is_behind=is_behind)
    except RuntimeError as fault:
        say(f"{stage.name}: {fault}", output)
        outcome = Outcome(stage.name, False)
    skipped = [*lacking, *outcome.tally.skipped]
    outcome = replace(outcome, seconds=time.monotonic() - began, left_out=skipped)
    say(f"{stage.name}: {outcome.word} after {outcome.times}", output)
    return outcome


def _tried(stage: Stage, environment: Mapping[str, str], output: TextIO | None, *, is_behind: bool) -> Outcome:
    """Run the stage, and what failed of a stage in real time once more, if it is little."""
    code, cpu_s = COMMANDS.run(stage.command(), environment, output, is_behind=is_behind)
    tally = Tally.of(stage.report) if stage.report is not None else Tally()
    outcome = Outcome(stage.name, code == 0, cpu_s=cpu_s, tally=tally)
    if code != PYTEST_FAILED or stage.again is None or not 0 < tally.failed_files <= AGAIN_LIMIT:
        return outcome
    say(f"{stage.name}: {tally.failed} failed and run again, alone: {', '.join(tally.failures)}", output)
    code, more_s = COMMANDS.run(stage.again(), environment, output)
    outcome = replace(outcome, cpu_s=cpu_s + more_s)
    if code != 0:
        return outcome
    passed = replace(tally, passed=tally.passed + tally.failed, failed=0, failures=())
    return replace(outcome, is_ok=True, tally=passed, unsteady=tally.failures)


def say(text: str, output: TextIO | None = None) -> None:
    output = output or sys.stdout
    output.write(f"\n--- {text}\n")
    output.flush()


if __name__ == "__main__":
    sys.exit(main())
