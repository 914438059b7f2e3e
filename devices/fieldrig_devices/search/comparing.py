"""Plays what a corpus has again: two versions of a program on the same runs, and findings by themselves."""

from collections.abc import Iterator, Mapping, Sequence
from math import inf
from typing import Final, NamedTuple

from fieldrig_devices.scenarios.guard import OF_EVERY_RIG
from fieldrig_devices.scenarios.report import told
from fieldrig_devices.search.bench import Bench
from fieldrig_devices.search.causes import Causes
from fieldrig_devices.search.corpus import Corpus, Finding
from fieldrig_devices.search.crew import LocalCrew
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.plan import Plan

AHEAD = 64
ARCHIVE: Final = "archive"
"""The strategy whose pieces others go on from."""


class Changed(NamedTuple):
    """A property that holds in one of the two versions only."""

    property: str
    acts: tuple[str, ...]
    is_worse: bool

    def __str__(self) -> str:
        told = "no longer holds" if self.is_worse else "holds now"
        return f"{self.property} {told}: {'; '.join(self.acts) or 'without any action'}"


class _Known(NamedTuple):
    """A run of a corpus."""

    run: Run
    broken: Mapping[str, int]
    """The instants at which properties were broken, by their names."""
    judged_ns: float
    """The instant up to which it was judged, if none was broken."""


class Replayed(NamedTuple):
    """A finding that was played again."""

    finding: Finding
    told: tuple[str, ...]
    """The reason in words; nothing if the property holds now."""
    is_same: bool
    """True if each message is the one of the search."""


def compared(plan: Plan, corpus: Corpus, workers: int = 1) -> list[Changed]:
    """Play all runs of a corpus with the program as it is now.

    A run ends at its first violation, and says nothing of later ones: what only the longer one of two runs shows after
    the end of the other is no change.  Nor is what a run shows after the end of a piece that others could go on from,
    which was not judged any further.  Nor is a property that the plan does not have any more.
    """
    known = {*OF_EVERY_RIG, *(rule.name for rule in plan.scenario.properties)}
    changes = list[Changed]()
    are_cut = not plan.recovers and plan.scenario.master is None
    runs = [
        _Known(
            run, {name: at_ns for name, at_ns, _ in wrong}, run.length_ns if are_cut and strategy == ARCHIVE else inf
        )
        for run, strategy, wrong in corpus.all_runs()
    ]
    with Bench(plan) as bench, LocalCrew(bench, workers) as crew:
        started = iter(runs)
        for number, (run, before, judged_ns) in enumerate(runs):
            for other, *_ in _some(started, AHEAD if number == 0 else 1):
                crew.start(Piece(other.acts, 0, other.length_ns, world=other.world))
            now = {one.property: one.at_ns for one in crew.next().violations}
            shown = (*run.world, *(f"{act} at {act.at_ns / 1e6:g} ms" for act in run.acts))
            better = {name for name in _only(before, now, inf) if name in known}
            worse = _only(now, before, judged_ns)
            changes += [Changed(name, shown, name in worse) for name in sorted(better | worse)]
    return changes


def _only(some: Mapping[str, int], others: Mapping[str, int], end_ns: float) -> set[str]:
    """Return the properties that only the first of two runs breaks, up to the end of the other one.

    The runs have instants by properties; one without any ends at `end_ns`.
    """
    end_ns = min(others.values(), default=end_ns)
    return {name for name, at_ns in some.items() if name not in others and at_ns <= end_ns}


def _some(runs: Iterator[_Known], count: int) -> Iterator[_Known]:
    return (one for _, one in zip(range(count), runs, strict=False))


def replayed(plan: Plan, findings: Sequence[Finding]) -> Iterator[Replayed]:
    """Play findings again."""
    with Bench(plan) as bench:
        for one in findings:
            played = bench.told(Piece(one.acts, 0, one.length_ns, world=one.world))
            violation = next((wrong for wrong in played.violations if wrong.property == one.property), None)
            words = () if violation is None else tuple(told(played, violation))
            yield Replayed(one, words, played.hash == one.hash)


def minimised(plan: Plan, corpus: Corpus, findings: Sequence[Finding]) -> Iterator[Finding]:
    """Make findings small again, from the actions with which they were found; those that hold now stay as they are."""
    with Bench(plan) as bench:
        causes = Causes(bench, corpus)
        for one in findings:
            for acts in (one.found, one.acts):
                played = bench.play(Piece(acts, 0, one.length_ns, world=one.world))
                violation = next((wrong for wrong in played.violations if wrong.property == one.property), None)
                if violation is not None:
                    small = causes.small(violation, played)
                    corpus.replace(one.number, small)
                    yield small._replace(number=one.number)
                    break
