"""A search: a control run, the strategies, and for each property the smallest way in which it does not hold."""

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

from fieldrig.errors import RigError
from fieldrig.system.stopwatch import Stopwatch
from fieldrig.virtual.readings import seconds
from fieldrig_devices.scenarios.act import Schedule
from fieldrig_devices.scenarios.property import Violation
from fieldrig_devices.search.corpus import Corpus, Finding
from fieldrig_devices.search.crew import Bench, Crew
from fieldrig_devices.search.minimal import minimal
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.plan import Plan
from fieldrig_devices.search.strategies import STRATEGIES
from fieldrig_devices.search.strategy import WHOLE, Shard, Strategy, Task

MOST_SHRUNK: Final = 3
"""Findings of one property that are made small; further ones are most likely the same."""


class Limits(NamedTuple):
    """The end of a search: whichever comes first."""

    budget_s: float
    """The time of the host."""
    most_runs: int


class Search:
    """What is found, and in which order, depends on plan, seed and shard, and not on the crew."""

    def __init__(self, plan: Plan, bench: Bench, crew: Crew, corpus: Corpus, seed: int, shard: Shard = WHOLE) -> None:
        """`bench` is the rig on this machine, for the control run and for shrinking; `crew` plays the pieces."""
        self._plan, self._bench, self._crew, self._corpus = plan, bench, crew, corpus
        self._seed, self._shard = seed, shard
        self.runs = 0
        self._failing: dict[str, list[Run]] = {}
        """The runs in which a property does not hold, by its name."""

    def go(self, strategies: Sequence[str], limits: Limits, tell: Callable[[str], None]) -> None:
        """Search.  RigError if the scenario does not hold without any action besides."""
        self._check_control()
        watch = Stopwatch()
        for number, name in enumerate(strategies, 1):
            until_s = limits.budget_s * number / len(strategies)
            strategy = STRATEGIES[name](Task(self._plan, self._bench, self._seed, self._shard))

            def may_start(until_s: float = until_s) -> bool:
                return watch.seconds < until_s and self.runs < limits.most_runs

            self._follow(name, strategy, may_start)
            tell(strategy.told())
        for property_name, failing in self._failing.items():
            for one in sorted(failing, key=lambda one: len(one.acts))[:MOST_SHRUNK]:
                self._shrink(property_name, one)

    def _follow(self, name: str, strategy: Strategy, may_start: Callable[[], bool]) -> None:
        """Have the pieces of a strategy played: so many ahead that the crew has work, and always as many.

        A piece is chosen when the outcome of the one `ahead` before it is known, whether more of them are known or not.
        """
        open_pieces = 0
        while True:
            while open_pieces < strategy.ahead and may_start() and (piece := strategy.piece()) is not None:
                self._crew.start(piece)
                self.runs += 1
                open_pieces += 1
            if not open_pieces:
                return
            played = self._crew.next()
            open_pieces -= 1
            self._take(played, name)
            if not strategy.take(played):
                self._crew.drop(played)

    def _check_control(self) -> None:
        played = self._bench.play(Piece((), 0, self._plan.scenario.length_ns))
        for wrong in played.violations:
            what = f"{wrong.property} does not hold without any action besides: at {seconds(wrong.at_ns)} {wrong.what}"
            raise RigError(what, "fix the property or the scenario first; `fieldrig scenario run` shows it as well")

    def _take(self, played: Run, strategy: str) -> None:
        self._corpus.add(played, strategy)
        for violation in played.violations:
            self._failing.setdefault(violation.property, []).append(played)

    def _shrink(self, property_name: str, failing: Run) -> None:
        """Note the fewest actions with which a property does not hold."""
        length_ns = max(failing.length_ns, self._plan.scenario.length_ns)

        def broken(acts: Schedule) -> Violation | None:
            played = self._bench.play(Piece(acts, 0, length_ns))
            return next((one for one in played.violations if one.property == property_name), None)

        acts = minimal(failing.acts, lambda some: broken(some) is not None)
        violation = broken(acts)
        assert violation is not None, "a run is the same each time"
        at_ns, what = violation.at_ns, violation.what
        self._corpus.note(Finding(0, property_name, acts, failing.acts, length_ns, at_ns, what))
