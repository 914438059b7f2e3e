"""The reports of coverage that a user has asked for, from the command line, from pytest or from Python."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from fieldrig.coverage.data import written
from fieldrig.coverage.reports.cobertura import cobertura
from fieldrig.coverage.reports.lcov import lcov
from fieldrig.coverage.reports.page import page
from fieldrig.coverage.reports.table import NOTHING, per_cent
from fieldrig.coverage.summary import Coverage
from fieldrig.system.whole_file import replace_file

PAGE: Final = "index.html"


@dataclass(frozen=True, slots=True)
class Wanted:
    """The files of the reports, and the least share of what has run."""

    data: Path | None = None
    """The file for adding up runs."""
    lcov: Path | None = None
    cobertura: Path | None = None
    folder: Path | None = None
    """The folder of the page."""
    least: float | None = None
    """In per cent."""

    def __bool__(self) -> bool:
        return any(one is not None for one in (self.data, self.lcov, self.cobertura, self.folder, self.least))

    def write(self, coverage: Coverage) -> None:
        """Write the files.  OSError, with the name of the file, if that fails."""
        for path, content in self._contents(coverage):
            replace_file(path, content)

    def _contents(self, coverage: Coverage) -> Iterator[tuple[Path, bytes]]:
        file = self.folder / PAGE if self.folder is not None else None
        for path, made in ((self.data, written), (self.lcov, lcov), (self.cobertura, cobertura), (file, page)):
            if path is not None:
                yield path, made(coverage)

    def shortfall(self, coverage: Coverage) -> str:
        """Return a sentence if too little of the programs has run; otherwise nothing."""
        share = coverage.total.count()
        if not self.least or (share.all and share.per_cent >= self.least):
            return ""
        if not share.all:
            return NOTHING
        return f"coverage is {per_cent(share)} %: expected at least {self.least:g} %"
