"""The coverage that a command was asked for: its options, and the reports at the end."""

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fieldrig.errors import UsageError

if TYPE_CHECKING:
    from fieldrig.coverage.collecting import Collector
    from fieldrig.coverage.summary import Coverage

Shown = Annotated[bool, typer.Option("--coverage", help="Show which statements and branches of programs have run.")]

Detail = Annotated[
    bool,
    typer.Option("--coverage-detail", help="Count conditions, MC/DC and the states of enumerations in coverage too."),
]


def _file(option: str, about: str) -> Any:
    return typer.Option(option, metavar="FILE", help=about, show_default=False)


Data = Annotated[Path | None, _file("--coverage-data", "Write coverage for `fieldrig coverage`, which adds up runs.")]
Lcov = Annotated[Path | None, _file("--lcov", "Write coverage as LCOV.")]
Cobertura = Annotated[Path | None, _file("--cobertura", "Write coverage as Cobertura.")]
Page = Annotated[
    Path | None,
    typer.Option(
        "--coverage-html", metavar="FOLDER", help="Write coverage as a page with the source.", show_default=False
    ),
]
Least = Annotated[
    float | None,
    typer.Option(
        "--fail-under",
        metavar="PERCENT",
        min=0.0,
        max=100.0,
        help="Exit with 1 if coverage is less.",
        show_default=False,
    ),
]


class Covering(ExitStack):
    """A context in which programs have marks, if a report is wanted."""

    def __init__(
        self,
        is_shown: bool,
        is_detailed: bool,
        data: Path | None,
        lcov: Path | None,
        cobertura: Path | None,
        folder: Path | None,
        least: float | None,
    ) -> None:
        """Take the options of a command."""
        super().__init__()
        self._is_detailed, self._files = is_detailed, (data, lcov, cobertura, folder, least)
        self._is_wanted = is_shown or is_detailed
        self._collector: Collector | None = None

    def __enter__(self) -> "Covering":
        super().__enter__()
        if self._is_wanted or any(one is not None for one in self._files):
            from fieldrig.coverage.collecting import collecting

            self._collector = self.enter_context(collecting(is_detailed=self._is_detailed))
        return self

    def report(self, *, is_quiet: bool = False) -> bool:
        """Write the reports of what has run so far.  False if too little has."""
        if self._collector is None:
            return True
        from fieldrig.coverage.summary import Coverage

        return report(Coverage(self._collector.news()), *self._files, is_quiet=is_quiet)


def report(
    coverage: "Coverage",
    data: Path | None,
    lcov: Path | None,
    cobertura: Path | None,
    folder: Path | None,
    least: float | None,
    *,
    is_quiet: bool = False,
) -> bool:
    """Print the table and write the files.  False if too little of the programs has run."""
    from fieldrig.coverage.reports.table import table
    from fieldrig.coverage.wanted import Wanted

    wanted = Wanted(data, lcov, cobertura, folder, least)
    for line in () if is_quiet else table(coverage):
        typer.echo(line)
    try:
        wanted.write(coverage)
    except OSError as cause:
        raise UsageError(f"{cause.filename} cannot be written", cause.strerror or str(cause)) from cause
    shortfall = wanted.shortfall(coverage)
    if shortfall:
        typer.echo(shortfall, err=True)
    return not shortfall
