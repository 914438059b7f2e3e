"""The tests that a command is given by paths, names and patterns."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import argument
from fieldrig.errors import UsageError
from fieldrig.text.nearest import closest, nearest_file

if TYPE_CHECKING:
    from fieldrig_devices.iec.dialect import Dialect
    from fieldrig_devices.iec.testing.parallel import Work

Paths = Annotated[
    list[str],
    argument("PATH...", "Test files, also of pytest, or folders with some of ST; PATH::NAME chooses one test."),
]
Keywords = Annotated[
    list[str] | None,
    typer.Option("--keyword", "-k", metavar="TEXT", help="Run only tests with this in FILE::NAME; * and ? work."),
]
Timeout = Annotated[
    float, typer.Option("--timeout", metavar="SECONDS", min=0.001, help="End a test that takes a processor for longer.")
]
Workers = Annotated[int, typer.Option("--jobs", "-j", metavar="N", min=1, help="Run N processes at a time.")]


def chosen_work(paths: Sequence[str], patterns: Sequence[str], dialect: "Dialect") -> "list[Work]":
    """Return the chosen tests of each source.  UsageError if there are none."""
    from fieldrig_devices.iec.testing.chosen import is_chosen, sources_of, split, unmet

    names = [split(path) for path in paths]
    for path, _ in names:
        if not path.exists():
            raise UsageError(f"there is no {path}", nearest_file(path) or "expected a test file or a folder with some")
    known = [(source, source.cases()) for source in sources_of([path for path, _ in names], dialect)]
    if not any(cases for _, cases in known):
        shown = ", ".join(str(path) for path, _ in names)
        beside = [file for path, _ in names if path.is_dir() for file in sorted(path.glob("test_*.py"))]
        expected = "expected TEST 'name' ... END_TEST in a source file, or test_NAME.py"
        raise UsageError(
            f"there are no tests in {shown}",
            f"name a file of pytest itself, such as {beside[0]}" if beside else expected,
        )
    for word, others in unmet([case for _, cases in known for case in cases], names, patterns):
        near = closest(word, others)
        shown = near if near.startswith("did") else "`fieldrig iec test PATH --list` shows all names"
        raise UsageError(f"no test has such a name: {word}", shown)
    work: list[Work] = [
        (source, [case for case in cases if is_chosen(case, names, patterns)]) for source, cases in known
    ]
    work = [(source, cases) for source, cases in work if cases]
    if not work:
        raise UsageError("no test has such names together", "`fieldrig iec test PATH --list` shows all names")
    return work
