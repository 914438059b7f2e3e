"""The table of coverage for the terminal."""

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

from fieldrig.coverage.places import Kind, Place
from fieldrig.coverage.summary import Count, Coverage, Part, pous, ranges

_WIDEST_NAME: Final = 40
_NARROWEST: Final = 8
NOTHING: Final = "coverage: no code of a program was needed"


def table(coverage: Coverage) -> Iterator[str]:
    """Yield the lines of a table with a row for each POU, under its file, and the total."""
    total = coverage.total
    if not total.places:
        yield NOTHING
        return
    columns = [*columns_of(total)]
    rows = [(file, pous(file)) for file in coverage.files()]
    names = ["total", *(f"  {pou.name}" for _, inside in rows for pou in inside)]
    width = min(max(map(len, names)), _WIDEST_NAME)
    titles = "".join(f"  {column.title:>{column.width}}" for column in columns)
    yield f"{'coverage':<{width}}{titles}  {'%':>5}  not run"
    for file, inside in rows:
        yield file.name
        for pou in inside:
            yield _row(f"  {pou.name}", pou, width, columns) + _missed(pou)
    yield _row("total", total, width, columns).rstrip()


class Column(NamedTuple):
    title: str
    kind: Kind
    is_of_case: bool = False
    """True for the branches of CASE apart from others, which are among the branches too."""

    @property
    def width(self) -> int:
        return max(len(self.title), _NARROWEST)

    def counted(self, part: Part) -> Count:
        return part.count_of_case() if self.is_of_case else part.count(self.kind)


_COLUMNS: Final = (
    Column("statements", Kind.STATEMENT),
    Column("branches", Kind.BRANCH),
    Column("of CASE", Kind.BRANCH, is_of_case=True),
    Column("steps", Kind.STEP),
    Column("transitions", Kind.TRANSITION),
    Column("conditions", Kind.CONDITION),
    Column("MC/DC", Kind.DECIDES),
    Column("states", Kind.STATE),
)
_ALWAYS: Final = 2


def columns_of(total: Part) -> Iterator[Column]:
    """Yield the columns: statements and branches, and of the others those with something to count."""
    for number, column in enumerate(_COLUMNS):
        if number < _ALWAYS or column.counted(total).all:
            yield column


def _row(name: str, part: Part, width: int, columns: Sequence[Column]) -> str:
    counts = "".join(f"  {_count(column.counted(part)):>{column.width}}" for column in columns)
    return f"{name:<{width}}{counts}  {per_cent(part.count()):>5}  "


def _missed(part: Part) -> str:
    lines = ranges(part.missed_lines(), part.lines())
    branches = ", ".join(f"{place.line} {place.what}" for place in part.missed_branches())
    details = ", ".join(f"{place.line} {said(place)}" for place in part.missed_details())
    return "; ".join(one for one in (lines, branches, details) if one)


def said(place: Place) -> str:
    """Return the name of a branch, a condition or a state."""
    return f"{place.what} decides" if place.kind is Kind.DECIDES else place.what


def _count(count: Count) -> str:
    return f"{count.run}/{count.all}" if count.all else "-"


def per_cent(count: Count) -> str:
    """Return the share with one digit, cut and not rounded, so that 100.0 is all."""
    return f"{int(count.per_cent * 10 + 1e-9) / 10:.1f}"
