"""Waits for changes of files, and says which tests they touch."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from fieldrig.errors import UsageError
from fieldrig.loop.pacing import elapsed_ns
from fieldrig_devices.iec.source_texts import files_in
from fieldrig_devices.iec.testing.case import Dependent
from fieldrig_devices.iec.testing.parallel import Work

Stamps = dict[Path, tuple[int, int]]
PERIOD_NS = 250_000_000
"""Time between two looks at the files."""


def changes(work_of: Callable[[], list[Work]]) -> Iterator[list[Work]]:
    """Yield the work of the sources that have changed, whenever some have.

    `work_of` returns the present work.  UsageError, for a file that is just being written, is as good as no change.
    """
    needed, next_ns = _needed(work_of()), PERIOD_NS
    known = _stamps(needed.values())
    for now_ns in elapsed_ns(1.0):
        if now_ns < next_ns:
            continue
        next_ns = now_ns + PERIOD_NS
        try:
            work = work_of()
            present = _needed(work)
        except UsageError:
            continue
        before, needed, stamps = needed, present, _stamps(present.values())
        changed = {file for file in known.keys() | stamps.keys() if known.get(file) != stamps.get(file)}
        known = stamps
        touched: list[Work] = [
            (source, cases)
            for source, cases in work
            if isinstance(source, Dependent)
            and not changed.isdisjoint(needed[source.path] | before.get(source.path, set()))
        ]
        if touched:
            yield touched


def _needed(work: list[Work]) -> dict[Path, set[Path]]:
    """Return the files that the tests of each path need: one that is deleted is none of those that they need then."""
    return {source.path: set(source.files()) for source, _ in work if isinstance(source, Dependent)}


def _stamps(needed: Iterable[set[Path]]) -> Stamps:
    """Return the time and the size of every file that a source depends on, or that is beside one of these."""
    files = set[Path]().union(*needed)
    files |= {beside for folder in {file.parent for file in files} for beside in files_in(folder)}
    return {file: stamp for file in files if (stamp := _stamp(file)) is not None}


def _stamp(file: Path) -> tuple[int, int] | None:
    try:
        found = file.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size
