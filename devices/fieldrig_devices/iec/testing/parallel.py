"""Runs the chosen cases of sources, in this process or in several."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Final

from fieldrig.coverage import collecting
from fieldrig_devices.iec.testing.case import Case, Limits, Outcome, Source

Work = tuple[Source, Sequence[Case]]
_SMALLEST: Final = 20
"""Cases of one file that one process runs; each process compiles the file again."""


def run(work: Sequence[Work], limits: Limits, workers: int) -> Iterator[Outcome]:
    """Yield the outcomes in the order of the work, as soon as they are there."""
    if workers <= 1:
        for source, cases in work:
            yield from source.run(cases, limits)
        return
    parts = [part for source, cases in work for part in _parts(source, cases, workers)]
    with ProcessPoolExecutor(min(workers, len(parts) or 1), mp_context=get_context("spawn")) as pool:
        for outcomes in pool.map(_run, [(source, cases, limits) for source, cases in parts]):
            yield from outcomes


def _parts(source: Source, cases: Sequence[Case], workers: int) -> Iterator[Work]:
    size = max(-(-len(cases) // workers), _SMALLEST)
    for first in range(0, len(cases), size):
        yield source, cases[first : first + size]


def _run(work: tuple[Source, Sequence[Case], Limits]) -> list[Outcome]:
    source, cases, limits = work
    outcomes = list(source.run(cases, limits))
    collecting.flush()
    return outcomes
