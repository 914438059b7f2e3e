"""The coverage that a command was asked for: its options, and the reports at the end."""

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from fieldrig.cli.common import writing

if TYPE_CHECKING:
    from fieldrig.coverage.collecting import Collector
    from fieldrig.coverage.summary import Coverage

PAGE: Final = "index.html"

Shown = Annotated[bool, typer.Option("--coverage", help="Show which statements and branches of programs have run.")]


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


@dataclass(frozen=True, slots=True)
class Reports:
    """The reports of coverage that are wanted."""

    is_shown: bool = False
    data: Path | None = None
    lcov: Path | None = None
    cobertura: Path | None = None
    folder: Path | None = None
    least: float | None = None
    """The least share in per cent."""

    @property
    def are_wanted(self) -> bool:
        files = (self.data, self.lcov, self.cobertura, self.folder)
        return self.is_shown or self.least is not None or any(file is not None for file in files)

    def report(self, coverage: "Coverage", *, is_quiet: bool = False) -> bool:
        """Write the reports.  False if too little of the programs has run."""
        from fieldrig.coverage.reports.table import NOTHING, per_cent, table

        for line in () if is_quiet else table(coverage):
            typer.echo(line)
        self._write(coverage)
        share = coverage.total.count()
        if not self.least or (share.all and share.per_cent >= self.least):
            return True
        if not share.all:
            typer.echo(NOTHING, err=True)
            return False
        typer.echo(f"coverage is {per_cent(share)} %: expected at least {self.least:g} %", err=True)
        return False

    def _write(self, coverage: "Coverage") -> None:
        from fieldrig.coverage.data import written
        from fieldrig.coverage.reports.cobertura import cobertura
        from fieldrig.coverage.reports.lcov import lcov
        from fieldrig.coverage.reports.page import page
        from fieldrig.storage.store import replace_file

        file = self.folder / PAGE if self.folder is not None else None
        for path, made in ((self.data, written), (self.lcov, lcov), (self.cobertura, cobertura), (file, page)):
            if path is not None:
                with writing(path.parent):
                    path.parent.mkdir(parents=True, exist_ok=True)
                    replace_file(path, made(coverage))


class Covering(ExitStack):
    """A context in which programs have marks, if a report is wanted."""

    def __init__(self, reports: Reports) -> None:
        super().__init__()
        self._reports = reports
        self._collector: Collector | None = None

    def __enter__(self) -> "Covering":
        super().__enter__()
        if self._reports.are_wanted:
            from fieldrig.coverage.collecting import collecting

            self._collector = self.enter_context(collecting())
        return self

    def report(self, *, is_quiet: bool = False) -> bool:
        """Write the reports of what has run so far.  False if too little has."""
        if self._collector is None:
            return True
        from fieldrig.coverage.summary import Coverage

        return self._reports.report(Coverage(self._collector.news()), is_quiet=is_quiet)
