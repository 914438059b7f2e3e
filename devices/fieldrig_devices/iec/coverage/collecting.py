"""A switch of this process for marks in the programs that it compiles, and what they have shown so far.

It is one for the whole process, as compilers and run times of all devices of a rig have to see it, and a rig's file
says nothing of it.  A process that was forked goes on with a copy, and reports by itself what it has seen.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from fieldrig_devices.iec.coverage.places import Marked, Place

News = tuple[tuple[Place, bool], ...]
"""Places, and whether they have run."""


class _Collector:
    def __init__(self) -> None:
        self._known: list[Marked] = []
        self._reported: list[bytes] = []

    def use(self, marked: Marked) -> None:
        if marked.hits and not any(marked is known for known in self._known):
            self._known.append(marked)
            self._reported.append(b"")

    def news(self) -> News:
        found: list[tuple[Place, bool]] = []
        for number, (marked, reported) in enumerate(zip(self._known, self._reported, strict=True)):
            hits = bytes(marked.hits)
            if hits != reported:
                found += [
                    (place, hits[mark] == 1)
                    for mark, place in marked.places
                    if not reported or hits[mark] != reported[mark]
                ]
                self._reported[number] = hits
        return tuple(found)


_present: list[_Collector] = []


@contextmanager
def collecting() -> Iterator[None]:
    """Compile programs with marks meanwhile, and note what runs of them."""
    _present.append(_Collector())
    try:
        yield
    finally:
        _present.pop()


def is_on() -> bool:
    return bool(_present)


def use(marked: Marked) -> None:
    """Take note of a program that is loaded."""
    if _present:
        _present[-1].use(marked)


def news() -> News:
    """Return the places of new programs, and those that have run since the last call."""
    return _present[-1].news() if _present else ()
