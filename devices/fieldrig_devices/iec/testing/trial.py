"""Runs the tests of a program with each change of it."""

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from enum import StrEnum
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Final, NamedTuple

from fieldrig.coverage.collecting import collecting
from fieldrig.coverage.places import Kind, News
from fieldrig_devices.iec.mutation.changes import Change
from fieldrig_devices.iec.mutation.switch import applied, surveying
from fieldrig_devices.iec.testing import stands
from fieldrig_devices.iec.testing.case import Case, Limits, Outcome, Verdict
from fieldrig_devices.iec.testing.parallel import Work, run
from fieldrig_devices.iec.tree import Position

_LONGER: Final = 10.0
"""The number of times that a test may take longer with a change; then it never ends."""
_LEAST_S: Final = 1.0
_LEAST_COST_S: Final = 1e-4
"""Less is not measured."""


class Fate(StrEnum):
    """The end of a change."""

    NOTICED = "noticed"
    """A test failed."""
    MISSED = "not noticed"
    """All tests passed."""
    NOT_RUN = "not run"
    """No test runs the line, so none can notice it."""
    ACCEPTED = "accepted"
    """No test has to notice it, as a person has said; it is not tried."""
    NO_PROGRAM = "no program"
    """The program does not compile with it."""


class Result(NamedTuple):
    change: Change
    fate: Fate
    by: Case | None = None
    """A test that noticed it."""


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
    found.longest_s = max((one.busy_s for one in found.outcomes), default=0.0)
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
    changes: Sequence[Change],
    accepted: Collection[Change],
    before: Baseline,
    reached: Reached,
    work: Sequence[Work],
    limits: Limits,
    workers: int,
) -> Iterator[Result]:
    """Yield the fate of each change, in their order.  `limits` are those of the tests without a change."""
    fates = {change: Fate.NOT_RUN for change in changes if not reached.has(change)}
    fates |= dict.fromkeys(accepted, Fate.ACCEPTED)
    waiting = [change for change in changes if change not in fates]
    trial = Trial(work, with_changes(limits, before.longest_s), before.outcomes)
    with ExitStack() as stack:
        stack.enter_context(stands.kept())
        judged: Iterator[Result] = map(trial.result, waiting)
        if workers > 1:
            judged = _by_workers(trial, waiting, workers)
        for change in changes:
            yield Result(change, fates[change]) if change in fates else next(judged)


def _by_workers(trial: "Trial", waiting: Sequence[Change], workers: int) -> Iterator[Result]:
    """Yield the fates in their order.  A change that its process dies of, such as for its memory, has been noticed."""
    begin, done = partial(_begin, trial), 0
    while done < len(waiting):
        with ProcessPoolExecutor(workers, get_context("spawn"), begin) as pool, suppress(BrokenProcessPool):
            for result in pool.map(_of_worker, waiting[done:]):
                yield result
                done += 1
        if done < len(waiting):  # one of those that ran has killed its process; the first of them tries alone
            yield _alone(begin, waiting[done])
            done += 1


def _alone(begin: Callable[[], None], change: Change) -> Result:
    with ProcessPoolExecutor(1, get_context("spawn"), begin) as pool:
        try:
            return pool.submit(_of_worker, change).result()
        except BrokenProcessPool:
            return Result(change, Fate.NOTICED)


def with_changes(limits: Limits, longest_s: float) -> Limits:
    """Return the limits of a test with a change, which may never end, from the longest time of one without."""
    timeout_s = min(limits.timeout_s, max(_LONGER * longest_s, _LEAST_S))
    return Limits(timeout_s, limits.longest_ns, has_diagrams=False)


class Trial:
    """Tries changes, one after the other, and learns which tests notice some in the shortest time."""

    def __init__(self, work: Sequence[Work], limits: Limits, before: Sequence[Outcome]) -> None:
        self._work, self._limits = work, limits
        self._costs_s = {one.case: max(one.busy_s, _LEAST_COST_S) for one in before}
        self._tried, self._noticed = Counter[Case](), Counter[Case]()

    def result(self, change: Change) -> Result:
        """Run the tests until one of them fails."""
        with applied(change) as present:
            for outcome in run(self._ordered(), self._limits, 1):
                if present.is_refused:
                    return Result(change, Fate.NO_PROGRAM)
                self._tried[outcome.case] += 1
                if outcome.verdict in (Verdict.FAILED, Verdict.ERROR):
                    self._noticed[outcome.case] += 1
                    return Result(change, Fate.NOTICED, outcome.case)
        return Result(change, Fate.MISSED)

    def _ordered(self) -> list[Work]:
        """Return the tests with those first that are the most likely to notice a change in a second."""
        ordered = [(source, sorted(cases, key=self._worth, reverse=True)) for source, cases in self._work]
        return sorted(ordered, key=lambda one: self._worth(one[1][0]), reverse=True)

    def _worth(self, case: Case) -> float:
        # Laplace's rule: a test that was never tried is as good as one that notices every second change
        return (self._noticed[case] + 1) / (self._tried[case] + 2) / self._costs_s.get(case, _LEAST_COST_S)


_until_the_end = ExitStack()
_trials: list[Trial] = []
"""The trial of this process, if it is a worker."""


def _begin(trial: Trial) -> None:
    _trials.append(trial)
    _until_the_end.enter_context(stands.kept())


def _of_worker(change: Change) -> Result:
    return _trials[-1].result(change)
