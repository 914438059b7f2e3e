"""Mutation of the code behind the manuals' rows: `python -m tests.mutation`, usually called by `make mutation`.

A row counts as shown if its tests fail without its behaviour.  This takes a sample of the rows, changes one place of
the code that their tests run (an operator, a comparison, a number, a condition), and runs the tests of that row alone:
they should fail.  A place that few rows have in common is taken sooner than one that all tests pass through.

What survives is to be read by a person: the place may serve another row, or the change may make no difference.  Rows
that only system tests or foreign peers show are left out, and so are tables and constants (see `record`).  The work is
done in a copy of the tree; the result goes to docs/mutation.md.
"""

import argparse
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names
from tests.mutation.record import VARIABLE

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "mutation.md"
COPIED = ("emulator", "bus", "devices", "tests", "configs", "docs", "pyproject.toml")
MARKS = "manual and not system and not real and not docker and not long"
LIMIT_S = 300
BACKGROUND = 60
"""Other rows whose lines tell what many tests have in common."""
LEFT_OUT = ("Variable", "RemoveDecorator", "_Is", "Is_", "ExceptionReplacer", "_Pow", "Pow_", "_Invert", "_UAdd")
"""Operators whose mutants differ from the code in nothing, or break every test."""


@dataclass(frozen=True)
class Mutant:
    row: str
    file: Path
    line: int
    operator: str
    occurrence: int
    source: str
    """The changed line, before the change."""


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutation", description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--rows", type=int, default=40, help="how many rows are sampled")
    parser.add_argument("--each", type=int, default=2, help="mutants of each row")
    parser.add_argument("--seed", default="fieldrig", help="another word takes other rows and places")
    parser.add_argument("--only", nargs="*", metavar="ROW", help="these rows in place of a sample")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="fieldrig-mutation-") as folder:
        work = Work(Path(folder))
        tests = work.tests_by_row()
        chance = random.Random(asked.seed)
        rows = asked.only or sorted(chance.sample(sorted(tests), min(asked.rows, len(tests))))
        beside = chance.sample(sorted(tests), min(BACKGROUND, len(tests)))
        lines = work.lines_by_row({row: tests[row] for row in {*rows, *beside}})
        mutants = [mutant for row in rows for mutant in chosen(row, lines, asked.each, chance, work.folder)]
        survivors = [mutant for mutant in mutants if _say(mutant, work.survives(mutant, tests[mutant.row]))]
    if not asked.only:
        PAGE.write_text(page(asked.seed, mutants, survivors))
    return 0


def _say(mutant: Mutant, survived: bool) -> bool:
    word = "SURVIVED" if survived else "killed"
    sys.stdout.write(f"{mutant.row} {word:8} {mutant.file}:{mutant.line} {mutant.operator}: {mutant.source}\n")
    sys.stdout.flush()
    return survived


class Work:
    """A copy of the tree, and pytest in it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in COPIED:
            source = ROOT / name
            if source.is_dir():
                shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__", "node_modules"))
            else:
                shutil.copy(source, folder / name)

    def pytest(self, *arguments: str, **variables: str) -> int:
        """The exit code; 1 too if the tests don't come to an end."""
        paths = os.pathsep.join(str(self.folder / name) for name in ("emulator", "bus", "devices", ""))
        environment = {**os.environ, "PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "1", **variables}
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments]
        try:
            return subprocess.run(
                command, cwd=self.folder, env=environment, stdout=subprocess.DEVNULL, timeout=LIMIT_S, check=False
            ).returncode
        except subprocess.TimeoutExpired:
            return 1

    def record(self, *arguments: str) -> Any:
        file = self.folder / "lines.json"
        code = self.pytest("-p", "tests.mutation.record", *arguments, **{VARIABLE: str(file)})
        if code != 0:
            raise SystemExit(f"the tests fail before anything was changed (exit code {code})")
        return json.loads(file.read_text())

    def tests_by_row(self) -> dict[str, list[str]]:
        file = self.folder / "rows.json"
        self.pytest("--collect-only", "-m", MARKS, "-p", "tests.mutation.collect", **{VARIABLE: str(file)})
        tests: dict[str, list[str]] = json.loads(file.read_text())
        return tests

    def lines_by_row(self, tests: dict[str, list[str]]) -> dict[str, dict[str, set[int]]]:
        """By row and file."""
        nodeids = sorted({nodeid for of_row in tests.values() for nodeid in of_row})
        recorded = self.record("-m", MARKS, *nodeids)["lines"]
        found: dict[str, dict[str, set[int]]] = {}
        for row, of_row in tests.items():
            files = found.setdefault(row, {})
            for nodeid in of_row:
                for file, lines in recorded.get(nodeid, {}).items():
                    files.setdefault(file, set()).update(lines)
        return found

    def survives(self, mutant: Mutant, nodeids: Sequence[str]) -> bool:
        file = self.folder / mutant.file
        before = file.read_text(encoding="utf-8")
        after = mutate_code(before, get_operator(mutant.operator)(), mutant.occurrence)
        file.write_text(after, encoding="utf-8")
        try:
            return self.pytest("-x", "-m", MARKS, *nodeids) == 0
        finally:
            file.write_text(before, encoding="utf-8")


def chosen(
    row: str, lines: dict[str, dict[str, set[int]]], count: int, chance: random.Random, folder: Path
) -> Iterator[Mutant]:
    """Some of the changes that can be made where this row's tests run, the row's own lines first."""
    shared = Counter((file, line) for files in lines.values() for file, numbers in files.items() for line in numbers)
    places = [(file, line) for file, numbers in sorted(lines[row].items()) for line in sorted(numbers)]
    weights = [1 / shared[place] ** 2 for place in places]
    taken: set[tuple[str, int]] = set()
    for _ in range(100 * count):
        if not places or len(taken) == count:
            return
        file, line = chance.choices(places, weights)[0]
        mutants = [] if (file, line) in taken else list(_mutants_of(row, Path(file), line, folder))
        if mutants:
            taken.add((file, line))
            yield chance.choice(mutants)


def _mutants_of(row: str, file: Path, line: int, folder: Path) -> Iterator[Mutant]:
    text = file.read_text(encoding="utf-8")
    tree = get_ast(text)
    for name in operator_names():
        if any(word in name for word in LEFT_OUT):
            continue
        occurrence = 0
        for node in ast_nodes(tree):
            for (start_line, _), _ in get_operator(name)().mutation_positions(node):
                if start_line == line:
                    yield Mutant(
                        row, file.relative_to(folder), line, name, occurrence, text.splitlines()[line - 1].strip()
                    )
                occurrence += 1


def page(seed: str, mutants: Sequence[Mutant], survivors: Sequence[Mutant]) -> str:
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False
    ).stdout.strip()
    lines = [
        "# Mutation of the rows",
        "",
        "Written by `make mutation`; don't edit. For a sample of the manuals' rows, one place at a time of the code",
        "that a row's tests run was changed, and the tests of that row were run. A mutant is killed if they fail.",
        "",
        f"Commit {commit}, seed `{seed}`, {len({mutant.row for mutant in mutants})} rows.",
        "",
        "| manual | mutants | killed | score |",
        "|---|---|---|---|",
    ]
    for manual in sorted({mutant.row.partition("-")[0] for mutant in mutants}):
        total = sum(mutant.row.startswith(manual) for mutant in mutants)
        left = sum(mutant.row.startswith(manual) for mutant in survivors)
        lines.append(f"| {manual} | {total} | {total - left} | {(total - left) / total:.0%} |")
    lines += ["", "What survived, for a person to read: the place may serve another row.", ""]
    lines += [f"- {one.row}: `{one.file}:{one.line}`, {one.operator.partition('/')[2]}" for one in survivors]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.exit(main())
