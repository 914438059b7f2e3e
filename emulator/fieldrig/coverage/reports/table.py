"""The table of coverage for the terminal."""

from collections.abc import Iterator
from typing import Final

from fieldrig.coverage.places import Kind
from fieldrig.coverage.summary import Count, Coverage, Part, pous, ranges

_WIDEST_NAME: Final = 40
NOTHING: Final = "coverage: the tests need no code of a program"


def table(coverage: Coverage) -> Iterator[str]:
    """Yield the lines of a table with a row for each POU, under its file, and the total."""
    total = coverage.total
    if not total.places:
        yield NOTHING
        return
    has_charts = total.count(Kind.STEP, Kind.TRANSITION).all > 0
    rows = [(file, pous(file)) for file in coverage.files()]
    names = ["total", *(f"  {pou.name}" for _, inside in rows for pou in inside)]
    width = min(max(map(len, names)), _WIDEST_NAME)
    chart = f"{'steps':>10}  {'transitions':>11}" if has_charts else ""
    yield f"{'coverage':<{width}}  {'statements':>11}  {'branches':>10}{chart}  {'%':>5}  not run"
    for file, inside in rows:
        yield file.name
        for pou in inside:
            yield _row(f"  {pou.name}", pou, width, has_charts=has_charts) + _missed(pou)
    yield _row("total", total, width, has_charts=has_charts).rstrip()


def _row(name: str, part: Part, width: int, *, has_charts: bool) -> str:
    shown = f"{name:<{width}}  {_count(part.count(Kind.STATEMENT)):>11}  {_count(part.count(Kind.BRANCH)):>10}"
    if has_charts:
        shown += f"{_count(part.count(Kind.STEP)):>10}  {_count(part.count(Kind.TRANSITION)):>11}"
    return f"{shown}  {per_cent(part.count()):>5}  "


def _missed(part: Part) -> str:
    lines = ranges(part.missed_lines(), part.lines())
    branches = ", ".join(f"{place.line} {place.what}" for place in part.missed_branches())
    return "; ".join(one for one in (lines, branches) if one)


def _count(count: Count) -> str:
    return f"{count.run}/{count.all}" if count.all else "-"


def per_cent(count: Count) -> str:
    """Return the share with one digit, cut and not rounded, so that 100.0 is all."""
    return f"{int(count.per_cent * 10 + 1e-9) / 10:.1f}"
