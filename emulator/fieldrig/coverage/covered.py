"""Coverage in Python: what programs run within a `with` block."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fieldrig.coverage.collecting import Collector, collecting
from fieldrig.coverage.places import News
from fieldrig.coverage.reports.table import said, table
from fieldrig.coverage.summary import Coverage
from fieldrig.coverage.wanted import Wanted


class Covered:
    """The coverage so far of the programs that were loaded in a block of `covered`; behind it, that at its end."""

    def __init__(self, collector: Collector) -> None:
        self._collector = collector
        self._at_end: News | None = None

    def end(self) -> None:
        """Keep what has run until now, because the notes of the processes are about to go."""
        self._at_end = self._collector.news()

    def _coverage(self) -> Coverage:
        return Coverage(self._at_end if self._at_end is not None else self._collector.news())

    @property
    def per_cent(self) -> float:
        """The share of statements, branches, steps and transitions that have run; 100 without a program."""
        return self._coverage().total.count().per_cent

    @property
    def missed(self) -> list[str]:
        """The places that have not run, as FILE:LINE, and behind that the name of a branch, a step or a transition."""
        files = self._coverage().files()
        places = [(file.name, place) for file in files for place, has_run in file.places if not has_run]
        return [f"{name}:{place.line} {said(place)}".rstrip() for name, place in places]

    def __str__(self) -> str:
        """Return the table with a row for each program part."""
        return "\n".join(table(self._coverage()))

    def write(
        self,
        *,
        data: Path | None = None,
        lcov: Path | None = None,
        cobertura: Path | None = None,
        html: Path | None = None,
    ) -> None:
        """Write reports: files for `fieldrig coverage`, LCOV and Cobertura, and a folder with a page.

        OSError if that fails.
        """
        Wanted(data, lcov, cobertura, html).write(self._coverage())


@contextmanager
def covered(*, detail: bool = False) -> Iterator[Covered]:
    """Note which statements and branches run of the programs that are loaded meanwhile, alone or in rigs.

        with covered() as seen:
            plc = program("pump.st")
            plc.block("Pump")(level=90)
        assert seen.per_cent > 50, str(seen)

    With `detail`, conditions, MC/DC and the states of enumerations count too.  Programs that were loaded before have no
    marks.
    """
    with collecting(is_detailed=detail) as collector:
        seen = Covered(collector)
        try:
            yield seen
        finally:
            seen.end()
