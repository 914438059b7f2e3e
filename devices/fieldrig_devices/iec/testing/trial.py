"""Runs the tests of a program with each change of it."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, field
from enum import StrEnum
from multiprocessing import get_context
from pathlib import Path
from typing import Final, NamedTuple

from fieldrig.coverage.collecting import collecting
from fieldrig.coverage.places import Kind, News
from fieldrig_devices.iec.mutation.changes import Change
from fieldrig_devices.iec.mutation.switch import applied, surveying
from fieldrig_devices.iec.testing.case import MISTAKE, Case, Limits, Outcome, Verdict
from fieldrig_devices.iec.testing.parallel import Work, run
from fieldrig_devices.iec.tree import Position

_LONGER: Final = 10.0
"""The number of times that a test may take longer with a change; then it never ends."""
_LEAST_S: Final = 1.0


class Fate(StrEnum):
    """The end of a change."""

    NOTICED = "noticed"
    """A test failed."""
    MISSED = "not noticed"
    """All tests passed."""
    NOT_RUN = "not run"
    """No test runs the line, so none can notice it."""
    NO_PROGRAM = "no program"
    """The program does not compile with it."""


class Result(NamedTuple):
    change: Change
    fate: Fate
    by: Case | None = None
    """The test that noticed it."""


@dataclass
class Baseline:
    """The tests without any change."""

    outcomes: list[Outcome] = field(default_factory=list)
    changes: list[Change] = field(default_factory=list)
    longest_s: float = 0.0

    @property
    def bad(self) -> list[Outcome]:
        return [one for one in self.outcomes if one.verdict in (Verdict.FAILED, Verdict.ERROR)]


def baseline(work: Sequence[Work], limits: Limits) -> tuple[Baseline, "Reached"]:
    """Run the tests as they are; return all changes of the programs that they compile, and what they run of them."""
    found = Baseline()
    with collecting() as collector, surveying() as survey:
        found.outcomes += run(work, limits, 1)
        reached = Reached(collector.news())
    found.changes = sorted(survey.changes)
    found.longest_s = max((one.wall_s for one in found.outcomes), default=0.0)
    return found, reached


class Reached:
    """The places of a program that tests have run."""

    def __init__(self, news: News) -> None:
        self._places: dict[tuple[str, Position], bool] = {}
        self._files: dict[str, bool] = {}
        for place, has_run in news:
            file = Path(place.file).name
            self._files[file] = self._files.get(file, False) or has_run
            if place.kind is not Kind.BRANCH:
                key = file, Position(place.line, place.column)
                self._places[key] = self._places.get(key, False) or has_run

    def has(self, change: Change) -> bool:
        """Return whether a test has run the statement of a change; a declaration runs with anything in its file."""
        file = Path(change.file).name
        return self._places.get((file, change.statement), self._files.get(file, False))


def results(
    changes: Sequence[Change], reached: Reached, work: Sequence[Work], limits: Limits, workers: int
) -> Iterator[Result]:
    """Yield the fate of each change, in their order.  `limits` are those of the tests without a change."""
    orders = [(change, work, limits) for change in changes if reached.has(change)]
    with ExitStack() as stack:
        judged: Iterator[Result] = map(_of_order, orders)
        if workers > 1:
            pool = stack.enter_context(ProcessPoolExecutor(workers, mp_context=get_context("spawn")))
            judged = pool.map(_of_order, orders)
        for change in changes:
            yield next(judged) if reached.has(change) else Result(change, Fate.NOT_RUN)


def with_changes(limits: Limits, longest_s: float) -> Limits:
    """Return the limits of a test with a change, which may never end, from the longest time of one without."""
    return Limits(min(limits.timeout_s, max(_LONGER * longest_s, _LEAST_S)), limits.longest_ns)


def _of_order(order: tuple[Change, Sequence[Work], Limits]) -> Result:
    return _result(*order)


def _result(change: Change, work: Sequence[Work], limits: Limits) -> Result:
    """Run the tests until one of them fails."""
    with applied(change):
        for outcome in run(work, limits, 1):
            if any(failure.kind == MISTAKE for failure in outcome.failures):
                return Result(change, Fate.NO_PROGRAM)
            if outcome.verdict in (Verdict.FAILED, Verdict.ERROR):
                return Result(change, Fate.NOTICED, outcome.case)
    return Result(change, Fate.MISSED)
