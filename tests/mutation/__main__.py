"""Mutation of the code behind the manuals' rows: `python -m tests.mutation`, usually called by `make mutation`.

A row counts as shown if its tests fail without its behaviour.  This takes a sample of the rows, changes one place of
the code that their tests run (an operator, a comparison, a number, a condition), and runs the tests of that row that
pass through this place: they should fail.  A place that few rows have in common is taken sooner than one that all tests
pass through.  If they all pass, the tests of the other rows that pass through it are run: if one of them fails, the
place may serve that row alone.

A person has to read what survives: the place may serve no row, or the change may make no difference.  Rows
that only system tests or foreign peers show are left out, and so are tables and constants (see `record`).  The work is
done in copies of the tree under build/mutation, so a run that is killed leaves the code as it was.  Which lines each
test runs is kept there too, until the devices change.  The result goes to docs/developers/mutation.md.
"""

import argparse
import hashlib
import json
import os
import random
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue

from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator
from tests.mutation.page import page
from tests.mutation.places import Mutant, Verdict, chosen
from tests.mutation.record import VARIABLE

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/developers/mutation.md"
BUILD = ROOT / "build" / "mutation"
HERE = "{copy}"
"""Stands for the folder of the copy in the name of a parametrized test."""
COPIED = ("emulator", "bus", "devices", "page", "tests", "configs", "docs", "pyproject.toml")
MARKS = "manual and not system and not real and not docker and not long"
LIMIT_S = 300
RECORDING_S = 1800
AT_ONCE = 2
PASSED, FAILED, INTERRUPTED, NOT_FOUND = 0, 1, 2, 4  # exit codes of pytest; the last two if a module cannot be imported

Tests = dict[str, list[str]]
"""The tests of each row."""
Recorded = dict[str, dict[str, list[int]]]
"""The lines that each test runs, by file."""


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutation", description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--rows", type=int, default=40, help="how many rows are sampled")
    parser.add_argument("--each", type=int, default=2, help="mutants of each row")
    parser.add_argument("--minutes", type=float, default=20, help="no mutant is begun later than this after the first")
    parser.add_argument("--seed", default="fieldrig", help="another word takes other rows and places")
    parser.add_argument("--at-once", type=int, default=AT_ONCE, help="how many run at once")
    parser.add_argument("--only", nargs="*", metavar="ROW", help="these rows instead of a sample; the page stays")
    asked = parser.parse_args()
    commit = _commit()
    copies = [Copy(BUILD / f"copy{number}") for number in range(asked.at_once)]
    tests = copies[0].tests_by_row()
    if unknown := set(asked.only or ()) - tests.keys():
        parser.error(f"no test in virtual time shows {', '.join(sorted(unknown))}")
    recorded = recorded_by(copies, tests)
    lines = lines_by_row(tests, recorded)
    chance = random.Random(asked.seed)
    rows = asked.only or sorted(chance.sample(sorted(tests), min(asked.rows, len(tests))))
    mutants = [mutant for row in rows for mutant in chosen(row, lines, asked.each, chance, copies[0].folder)]
    chance.shuffle(mutants)  # what the limit cuts off is of no row in particular
    until = time.monotonic() + asked.minutes * 60
    free: SimpleQueue[Copy] = SimpleQueue()
    for copy in copies:
        free.put(copy)

    def judge(mutant: Mutant) -> Verdict | None:
        """Return None if the time is up."""
        if time.monotonic() > until:
            return None
        copy = free.get()
        try:
            verdict = copy.judge(mutant, running(mutant, tests, recorded), running_of_others(mutant, tests, recorded))
        finally:
            free.put(copy)
        change = f"{mutant.operator}#{mutant.occurrence}"
        sys.stdout.write(f"{mutant.row} {verdict.value:9} {mutant.file}:{mutant.line} {change}: {mutant.source}\n")
        sys.stdout.flush()
        return verdict

    with ThreadPoolExecutor(len(copies)) as pool:
        verdicts = list(pool.map(judge, mutants))
    if not asked.only:
        judged = [(mutant, verdict) for mutant, verdict in zip(mutants, verdicts, strict=True) if verdict is not None]
        judged.sort(key=lambda item: (item[0].row, item[0].file, item[0].line))
        PAGE.write_text(page(commit, asked.seed, len(tests), judged), encoding="utf-8")
    return 0


def recorded_by(copies: Sequence["Copy"], tests: Tests) -> Recorded:
    """Return the lines of all these tests: from the last run if the devices are the same, else from a run of them."""
    kept = BUILD / f"lines-{_digest(copies[0].folder / 'devices')}.json"
    lines: Recorded = json.loads(kept.read_text()) if kept.exists() else {}
    missing = sorted({nodeid for nodeids in tests.values() for nodeid in nodeids} - lines.keys())
    if not missing:
        return lines
    with ThreadPoolExecutor(len(copies)) as pool:
        parts = [missing[number :: len(copies)] for number in range(len(copies))]
        for part in pool.map(Copy.record, copies, parts):
            lines |= part
    for nodeid in missing:
        if not lines.setdefault(nodeid, {}):
            sys.stdout.write(f"{nodeid} is left out: it fails on its own, or runs no code of the devices\n")
    for old in BUILD.glob("lines-*.json"):
        old.unlink()
    half = kept.with_suffix(".half")
    half.write_text(json.dumps(lines))
    half.replace(kept)
    return lines


def lines_by_row(tests: Tests, recorded: Recorded) -> dict[str, dict[str, set[int]]]:
    """Return the lines that the tests of each row run, by file."""
    found: dict[str, dict[str, set[int]]] = {}
    for row, nodeids in tests.items():
        files = found.setdefault(row, {})
        for nodeid in nodeids:
            for file, lines in recorded.get(nodeid, {}).items():
                files.setdefault(file, set()).update(lines)
    return found


def running(mutant: Mutant, tests: Tests, recorded: Recorded) -> list[str]:
    """Return the row's tests that run the changed line: no other one can fail."""
    return [item for item in tests[mutant.row] if mutant.line in recorded.get(item, {}).get(mutant.file, ())]


def running_of_others(mutant: Mutant, tests: Tests, recorded: Recorded) -> list[str]:
    """Return the tests of other rows alone that run the changed line, those that run the least of the code first."""
    own = set(tests[mutant.row])
    others = {nodeid for nodeids in tests.values() for nodeid in nodeids} - own
    found = [other for other in others if mutant.line in recorded.get(other, {}).get(mutant.file, ())]
    return sorted(found, key=lambda item: (sum(map(len, recorded[item].values())), item))


def _commit() -> str:
    command = ["git", "describe", "--always", "--dirty=, with changes that are not committed"]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip()


class Copy:
    """A copy of the tree, and pytest in it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        for name in COPIED:
            source = ROOT / name
            if source.is_dir():
                shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__", "node_modules"))
            else:
                shutil.copy(source, folder / name)

    def pytest(self, *arguments: str, report: Path | None = None, limit_s: float = LIMIT_S) -> int:
        """Return the exit code, which is 1 too if the tests don't end; a plugin of ours writes to `report`."""
        paths = os.pathsep.join(str(self.folder / name) for name in ("emulator", "bus", "devices", "page", ""))
        environment = {**os.environ, "PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "1"}
        if report is not None:
            environment[VARIABLE] = str(report)
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", MARKS, *arguments]
        try:
            return subprocess.run(
                command, cwd=self.folder, env=environment, stdout=subprocess.DEVNULL, timeout=limit_s, check=False
            ).returncode
        except subprocess.TimeoutExpired:
            return FAILED

    def tests_by_row(self) -> Tests:
        file = self.folder / "rows.json"
        self.pytest("--collect-only", "-p", "tests.mutation.collect", report=file)
        tests: Tests = json.loads(self._everywhere(file.read_text()))
        return tests

    def record(self, nodeids: Sequence[str]) -> Recorded:
        """Run these tests and return their lines; tests that fail have none."""
        file = self.folder / "lines.json"
        file.write_text(json.dumps([self._here(nodeid) for nodeid in nodeids]))  # more than a command line takes
        files = sorted({nodeid.partition("::")[0] for nodeid in nodeids})
        arguments = (f"--timeout={RECORDING_S}", "-p", "tests.mutation.record", *files)
        code = self.pytest(*arguments, report=file, limit_s=RECORDING_S)
        if code not in (PASSED, FAILED):
            raise SystemExit(f"the tests cannot be recorded (exit code {code})")
        recorded: Recorded = json.loads(self._everywhere(file.read_text()))
        return recorded

    def _here(self, nodeid: str) -> str:
        return nodeid.replace(HERE, str(self.folder))

    def _everywhere(self, nodeids: str) -> str:
        return nodeids.replace(str(self.folder), HERE)

    def judge(self, mutant: Mutant, own: Sequence[str], others: Sequence[str]) -> Verdict:
        """Run the row's own tests and, if they all pass, those of other rows."""
        if not self.survives(mutant, own):
            return Verdict.KILLED
        if others and not self.survives(mutant, others):
            return Verdict.ELSEWHERE
        return Verdict.SURVIVED

    def survives(self, mutant: Mutant, nodeids: Sequence[str]) -> bool:
        file = self.folder / mutant.file
        before = file.read_text(encoding="utf-8")
        after = mutate_code(before, get_operator(mutant.operator)(), mutant.occurrence)
        assert after is not None, f"no occurrence {mutant.occurrence} of {mutant.operator} in {mutant.file}"
        file.write_text(after, encoding="utf-8")
        try:
            code = self.pytest("-x", *map(self._here, nodeids))
        finally:
            file.write_text(before, encoding="utf-8")
        if code not in (PASSED, FAILED, INTERRUPTED, NOT_FOUND):
            raise SystemExit(f"pytest ran no test of {mutant.row} (exit code {code})")
        return code == PASSED


def _digest(folder: Path) -> str:
    digest = hashlib.sha256()
    for file in sorted(folder.rglob("*.py")):
        digest.update(str(file.relative_to(folder)).encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]


if __name__ == "__main__":
    sys.exit(main())
