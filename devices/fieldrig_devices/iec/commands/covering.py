"""The coverage that `fieldrig iec test` was asked for."""

from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from fieldrig.cli.common import writing

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fieldrig_devices.iec.coverage.summary import Coverage
    from fieldrig_devices.iec.testing.case import Outcome

PAGE = "index.html"


@dataclass(frozen=True, slots=True)
class Covering:
    """Which reports are wanted; without any, programs have no marks."""

    is_shown: bool = False
    lcov: Path | None = None
    cobertura: Path | None = None
    folder: Path | None = None
    least: float | None = None
    """The least share in per cent."""

    @property
    def is_wanted(self) -> bool:
        files = (self.lcov, self.cobertura, self.folder)
        return self.is_shown or self.least is not None or any(file is not None for file in files)

    def collecting(self) -> AbstractContextManager[None]:
        from fieldrig_devices.iec.coverage.collecting import collecting

        return collecting() if self.is_wanted else nullcontext()

    def report(self, outcomes: "Sequence[Outcome]", *, is_quiet: bool) -> bool:
        """Write the reports.  False if the tests have run too little of the program."""
        if not self.is_wanted:
            return True
        from fieldrig_devices.iec.coverage.reports.table import NOTHING, per_cent, table
        from fieldrig_devices.iec.coverage.summary import Coverage

        coverage = Coverage()
        for outcome in outcomes:
            coverage.add(outcome.reached)
        for line in table(coverage) if not is_quiet else ():
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
        from fieldrig.storage.store import replace_file
        from fieldrig_devices.iec.coverage.reports.cobertura import cobertura
        from fieldrig_devices.iec.coverage.reports.lcov import lcov
        from fieldrig_devices.iec.coverage.reports.page import page

        file = self.folder / PAGE if self.folder is not None else None
        for path, made in ((self.lcov, lcov), (self.cobertura, cobertura), (file, page)):
            if path is not None:
                with writing(path.parent):
                    path.parent.mkdir(parents=True, exist_ok=True)
                    replace_file(path, made(coverage))
