"""The places of a small program that have run, for tests of coverage in every language."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from fieldrig.coverage.collecting import collecting
from fieldrig.coverage.places import Kind
from fieldrig.coverage.summary import Coverage, Part

Missed = list[tuple[int, str]]


@contextmanager
def coverage() -> Iterator[Callable[[], Part]]:
    """Compile programs with marks; what it gives returns all places so far."""
    with collecting() as collected:
        yield lambda: Coverage(collected.news()).total


def missed(part: Part) -> Missed:
    """Return the lines of the statements, and the branches, that have not run."""
    return sorted(
        (place.line, place.what)
        for place, has_run in part.places
        if not has_run and place.kind in (Kind.STATEMENT, Kind.BRANCH)
    )
