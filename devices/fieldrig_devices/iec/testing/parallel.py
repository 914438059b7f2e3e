"""Runs the chosen cases of sources, in this process or in several."""

from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import Final

from fieldrig.coverage import collecting
from fieldrig_devices.iec.testing.case import FAULT, Case, Failure, Limits, Outcome, Source, Verdict

Work = tuple[Source, Sequence[Case]]
_SMALLEST: Final = 20
"""Cases of one file that one process runs; each process compiles the file again."""


def run(work: Sequence[Work], limits: Limits, workers: int) -> Iterator[Outcome]:
    """Yield the outcomes in the order of the work, as soon as they are there.

    If a process dies, as one that the system ends for its memory, its tests run again in a process of their own, so
    that only the one that it dies of is an error.
    """
    if workers <= 1:
        for source, cases in work:
            yield from source.run(cases, limits)
        return
    parts = [part for source, cases in work for part in _parts(source, cases, workers)]
    with _pool(min(workers, len(parts) or 1)) as pool:
        promised = [_begun(pool, source, cases, limits) for source, cases in parts]
        for (source, cases), outcomes in zip(parts, promised, strict=True):
            try:
                if outcomes is None:
                    raise BrokenProcessPool
                yield from outcomes.result()
            except BrokenProcessPool:
                yield from _again(source, cases, limits)


def _pool(workers: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"))


def _begun(
    pool: ProcessPoolExecutor, source: Source, cases: Sequence[Case], limits: Limits
) -> Future[list[Outcome]] | None:
    """Give the pool a part of the work; None if one of its processes has died already."""
    try:
        return pool.submit(_run, (source, cases, limits))
    except BrokenProcessPool:
        return None


def _again(source: Source, cases: Sequence[Case], limits: Limits) -> Iterator[Outcome]:
    """Run cases whose process has died in one of their own, in smaller parts until it is clear which one kills it."""
    with _pool(1) as pool:
        try:
            yield from pool.submit(_run, (source, cases, limits)).result()
            return
        except BrokenProcessPool:
            pass
    middle = len(cases) // 2
    if middle:
        yield from _again(source, cases[:middle], limits)
        yield from _again(source, cases[middle:], limits)
    else:
        yield from (_lost(case) for case in cases)


def _lost(case: Case) -> Outcome:
    message = "the process of this test was ended from outside, as the system does without memory"
    return Outcome(case, Verdict.ERROR, (Failure(FAULT, "", "", message, case.file, case.line, 0),))


def _parts(source: Source, cases: Sequence[Case], workers: int) -> Iterator[Work]:
    size = max(-(-len(cases) // workers), _SMALLEST)
    for first in range(0, len(cases), size):
        yield source, cases[first : first + size]


def _run(work: tuple[Source, Sequence[Case], Limits]) -> list[Outcome]:
    source, cases, limits = work
    outcomes = list(source.run(cases, limits))
    collecting.flush()
    return outcomes
