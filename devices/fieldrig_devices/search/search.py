"""A search: a control run, the strategies, and for each property the smallest ways in which it does not hold."""

import math
from collections import deque
from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

from fieldrig.errors import RigError
from fieldrig.points.values import counted
from fieldrig.system.stopwatch import Stopwatch
from fieldrig.virtual.readings import seconds
from fieldrig_devices.search.bench import Bench
from fieldrig_devices.search.causes import Causes
from fieldrig_devices.search.corpus import Corpus
from fieldrig_devices.search.crew import Crew
from fieldrig_devices.search.memory import Memory
from fieldrig_devices.search.outcome import Outcome
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.plan import Plan
from fieldrig_devices.search.strategies import STRATEGIES
from fieldrig_devices.search.strategy import WHOLE, Shard, Strategy, Task

NEWS_S: Final = 30.0
"""Time of the host between two words about a search that goes on."""


class Limits(NamedTuple):
    """The end of a search: whichever comes first."""

    budget_s: float
    """The time of the host."""
    most_runs: int
    cpu_s: float = math.inf
    """The time of processors, of all branches together; that of the workers of a cluster counts as well."""
    is_first: bool = False
    """True if one finding is enough."""


class Search:
    """Its findings, and their order, depend on plan, seed and shard, and not on the crew."""

    def __init__(
        self,
        plan: Plan,
        bench: Bench,
        crew: Crew,
        corpus: Corpus,
        seed: int,
        shard: Shard = WHOLE,
        identity: bytes | None = None,
    ) -> None:
        """`bench` is the rig on this machine, for the control run and for shrinking; `crew` plays the pieces.

        With an `identity` of plan and rig, what a search with the same one has played into the corpus is not played
        again.
        """
        self._plan, self._bench, self._crew, self._corpus = plan, bench, crew, corpus
        self._seed, self._shard = seed, shard
        self._causes = Causes(bench, corpus)
        self._memory = Memory(corpus, identity)
        self._watch = Stopwatch()
        self._played_s = 0.0
        self.runs = 0
        """Pieces that were played, without those that an earlier search has played."""

    @property
    def cpu_s(self) -> float:
        """The processor time of the search so far, in seconds, with that of its branches."""
        return self._watch.busy_seconds + self._bench.cpu_s + self._played_s

    def go(
        self,
        strategies: Sequence[str],
        limits: Limits,
        tell: Callable[[str], None],
        say: Callable[[str], None] = lambda line: None,
        news_s: float = NEWS_S,
    ) -> None:
        """Search.  RigError if the scenario does not hold without any action besides, or for a plan with mistakes.

        `tell` is called with the results; `say` each `news_s` seconds with how far the search is.
        """
        self._bench.check()
        self._check_control()
        task = Task(self._plan, self._bench, self._seed, self._shard)
        from_begin = self._plan.scenario.master is not None  # no branch has its threads
        turns = [_Turns(name, STRATEGIES[name](task), from_begin=from_begin) for name in strategies]
        watch, said_s = Stopwatch(), 0.0

        def is_over() -> bool:
            nonlocal said_s
            if watch.seconds - said_s >= news_s:
                said_s = watch.seconds
                say(self._news(said_s, turns))
            found = limits.is_first and bool(self._corpus.findings())
            return found or watch.seconds >= limits.budget_s or self.cpu_s >= limits.cpu_s

        self._follow(turns, limits.most_runs, is_over)
        for one in turns:
            tell(one.strategy.told())
        if self._memory.known:
            tell(f"{counted(self._memory.known, 'run')} of earlier searches were not played again")
        for name, count in self._causes.not_repeated.items():
            tell(
                f"{name}: broken in {counted(count, 'run')}, but not again in the same; does a master depend on chance?"
            )

    def _news(self, after_s: float, turns: "Sequence[_Turns]") -> str:
        found = counted(len(self._corpus.findings()), "finding")
        parts = "; ".join(one.strategy.told() for one in turns)
        return f"after {after_s:.0f} s: {counted(self.runs, 'run')}, {found}; {parts}"

    def _follow(self, turns: "Sequence[_Turns]", most: int, is_over: Callable[[], bool]) -> None:
        """Have the pieces of the strategies played: always the same number ahead, so that the crew has work.

        A piece is chosen when the outcome of the one `ahead` before it is known, whether more of them are known or not.
        The strategy that has had the least virtual time has the next turn.
        """
        opened: deque[tuple[_Turns, Piece, Outcome | None]] = deque()
        while not is_over():
            while self.runs < most and (turn := _next(turns)) is not None and turn.open < turn.strategy.ahead:
                piece = turn.strategy.piece()
                if piece is None:
                    turn.is_done = True
                    continue
                turn.begin(piece)
                known = self._memory.recall(piece, learns=turn.strategy.learns)
                opened.append((turn, piece, known))
                if known is None:
                    self._crew.start(piece)
                    self.runs += 1
            if not opened:
                return
            turn, piece, known = opened.popleft()
            played = self._crew.next() if known is None else known.run(piece)
            turn.open -= 1
            if known is not None:
                self._causes.recall(played, known.shrunk)
            else:
                self._take(piece, played, turn)
            if not turn.strategy.take(played) and known is None:
                self._crew.drop(played)

    def _check_control(self) -> None:
        for wrong in self._bench.nominal.violations:
            what = f"{wrong.property} does not hold without any action besides: at {seconds(wrong.at_ns)} {wrong.what}"
            raise RigError(what, "fix the property or the scenario first; `fieldrig scenario run` shows it as well")

    def _take(self, piece: Piece, played: Run, turn: "_Turns") -> None:
        self._played_s += played.cpu_s
        learns = turn.strategy.learns
        if not played.violations:
            self._corpus.add(played, turn.name, self._memory.record(piece, played, (), learns=learns))
            return
        self._corpus.add(played, turn.name)
        record = self._memory.record(piece, played, self._causes.take(played), learns=learns)
        if record is not None:
            self._corpus.keep(record)


class _Turns:
    """A strategy with the virtual time that it has had."""

    def __init__(self, name: str, strategy: Strategy, *, from_begin: bool) -> None:
        """`from_begin`: a piece is played with all that comes before it."""
        self.name, self.strategy, self._from_begin = name, strategy, from_begin
        self.played_ns = 0
        self.open = 0
        """Pieces that were started and have no outcome yet."""
        self.is_done = False

    def begin(self, piece: Piece) -> None:
        self.open += 1
        self.played_ns += piece.until_ns - (0 if self._from_begin else piece.from_ns)


def _next(turns: Sequence[_Turns]) -> _Turns | None:
    """Return the strategy that has had the least virtual time, of those that have something left."""
    return min((one for one in turns if not one.is_done), key=lambda one: one.played_ns, default=None)
