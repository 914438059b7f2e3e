"""The command `coverage`: what has run of the programs of a rig, or of several runs."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli import covering
from fieldrig.cli.common import Endpoint, argument, reading
from fieldrig.errors import UsageError
from fieldrig.outside.addresses import DEFAULT_ENDPOINT
from fieldrig.system.exits import Exit

if TYPE_CHECKING:
    from fieldrig.coverage.places import News

QUESTION = "coverage/data"
"""The question to a rig for its file of coverage so far."""


def coverage(
    files: Annotated[
        list[Path] | None, argument("[FILE]...", "Files of --coverage-data to add up, instead of asking the rig.")
    ] = None,
    data: covering.Data = None,
    lcov: covering.Lcov = None,
    cobertura: covering.Cobertura = None,
    folder: covering.Page = None,
    least: covering.Least = None,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Show which statements and branches of programs have run so far.

    \b
        fieldrig coverage                            in the rig that runs with --coverage
        fieldrig coverage monday.json tuesday.json   in these runs together
        fieldrig coverage *.json --coverage-html build/coverage --fail-under 90
    """
    from fieldrig.coverage.summary import Coverage

    seen = Coverage(_of_rig(endpoint) if not files else ())
    for news in _of_files(files or ()):
        seen.add(news)
    if not covering.report(seen, data, lcov, cobertura, folder, least):
        raise typer.Exit(Exit.TESTS_FAILED)


def _of_rig(endpoint: str) -> "News":
    from fieldrig.control.messages import Client
    from fieldrig.coverage.data import read

    with Client(endpoint) as client:
        return read(client.ask(QUESTION).encode())


def _of_files(files: Sequence[Path]) -> Iterator["News"]:
    from fieldrig.coverage.data import read

    for file in files:
        with reading(file):
            content = file.read_bytes()
        try:
            yield read(content)
        except ValueError as wrong:
            raise UsageError(f"{file}: {wrong}", "expected a file that --coverage-data has written") from wrong
