"""A search: a control run, the strategies, and for each property the smallest ways in which it does not hold."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from fieldrig.errors import RigError
from fieldrig.system.stopwatch import Stopwatch
from fieldrig.virtual.readings import seconds
from fieldrig_devices.search.bench import Bench
from fieldrig_devices.search.causes import Causes
from fieldrig_devices.search.corpus import Corpus
from fieldrig_devices.search.crew import Crew
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.plan import Plan
from fieldrig_devices.search.strategies import STRATEGIES
from fieldrig_devices.search.strategy import WHOLE, Shard, Strategy, Task


class Limits(NamedTuple):
    """The end of a search: whichever comes first."""

    budget_s: float
    """The time of the host."""
    most_runs: int
    is_first: bool = False
    """True if one finding is enough."""


class Search:
    """Its findings, and their order, depend on plan, seed and shard, and not on the crew."""

    def __init__(self, plan: Plan, bench: Bench, crew: Crew, corpus: Corpus, seed: int, shard: Shard = WHOLE) -> None:
        """`bench` is the rig on this machine, for the control run and for shrinking; `crew` plays the pieces."""
        self._plan, self._bench, self._crew, self._corpus = plan, bench, crew, corpus
        self._seed, self._shard = seed, shard
        self._causes = Causes(bench, corpus)
        self.runs = 0

    def go(self, strategies: Sequence[str], limits: Limits, tell: Callable[[str], None]) -> None:
        """Search.  RigError if the scenario does not hold without any action besides."""
        self._check_control()
        watch = Stopwatch()
        for number, name in enumerate(strategies, 1):
            until_s = limits.budget_s * number / len(strategies)
            strategy = STRATEGIES[name](Task(self._plan, self._bench, self._seed, self._shard))

            def may_start(until_s: float = until_s) -> bool:
                is_over = limits.is_first and bool(self._corpus.findings())
                return watch.seconds < until_s and self.runs < limits.most_runs and not is_over

            self._follow(name, strategy, may_start)
            tell(strategy.told())

    def _follow(self, name: str, strategy: Strategy, may_start: Callable[[], bool]) -> None:
        """Have the pieces of a strategy played: always the same number ahead, so that the crew has work.

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
        if played.violations:
            self._causes.take(played)
