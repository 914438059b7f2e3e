"""Who plays the pieces of a search: branches of this machine, or the workers of a cluster behind the same calls."""

from collections import OrderedDict, deque
from typing import TYPE_CHECKING, Final, Protocol, Self

from fieldrig.config.rig_file import load
from fieldrig.virtual.branch import Branch
from fieldrig.virtual.rig import Rig
from fieldrig_devices.scenarios.act import Schedule
from fieldrig_devices.search import run
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.plan import Plan

if TYPE_CHECKING:
    from types import TracebackType

MOST_PARKED: Final = 96
"""Branches that are kept at the ends of pieces; of those that were used least recently a worker lets go."""


class Crew(Protocol):
    """Plays pieces; they end in any order, and their outcomes come in the order in which they were started."""

    def start(self, piece: Piece) -> None:
        """Have a piece played as soon as somebody is free."""

    def next(self) -> Run:
        """Wait for the piece that was started first of those whose outcome was not returned yet."""

    def drop(self, run: Run) -> None:
        """Nobody goes on from the end of this piece."""


class Bench:
    """The rig of a plan at the begin of the scenario, with branches on the way, in this process.

    It has no need of anything that another worker has: from `plan` alone it makes what a piece begins with.
    """

    def __init__(self, plan: Plan) -> None:
        """ConfigError or RigError for a rig that cannot be loaded, or that does not have what the plan names."""
        self.plan, scenario = plan, plan.scenario
        self._rig = Rig(load(scenario.rig, ("time=virtual", *scenario.overrides)))
        self._parked: OrderedDict[tuple[Schedule, int], Branch] = OrderedDict()
        try:
            self._rig.run_until(scenario.after_ns)
            self.root = self._rig.branch()
            self.root.call(run.begin, scenario)
            self._trunk, self._trunk_ns = self.root.branch(), 0
        except BaseException:
            self._rig.close()
            raise

    def play(self, piece: Piece) -> Run:
        """Play a piece."""
        branch = self.start(piece)
        played: Run = branch.result()
        self.park(branch, piece, played)
        return played

    def start(self, piece: Piece) -> Branch:
        """Start a piece in a branch of its own; `Branch.result` gives the `Run`, and `park` takes the branch back."""
        branch = self._nearest(piece).branch()
        branch.start(run.play_piece, piece, self.plan.states)
        return branch

    def park(self, branch: Branch, piece: Piece, played: Run) -> None:
        """Keep a branch whose piece has ended if another one may go on from there."""
        if piece.is_whole or played.violations:
            branch.close()
            return
        self._parked[_place(played)] = branch
        if len(self._parked) > MOST_PARKED:
            self._parked.popitem(last=False)[1].close()

    def drop(self, played: Run) -> None:
        """Nobody goes on from the end of this piece."""
        branch = self._parked.pop(_place(played), None)
        if branch is not None:
            branch.close()

    def close(self) -> None:
        for branch in self._parked.values():
            branch.close()
        self._rig.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: "type[BaseException] | None", fault: BaseException | None, tb: "TracebackType | None"
    ) -> None:
        self.close()

    def _nearest(self, piece: Piece) -> Branch:
        """Return a branch that has done the most of what comes before a piece, and nothing else."""
        before = piece.before
        if piece.from_ns == 0:
            return self.root
        if before:
            branch = self._parked.get((before, piece.from_ns))
            if branch is None:
                return self.root
            self._parked.move_to_end((before, piece.from_ns))
            return branch
        if piece.from_ns < self._trunk_ns:
            self._trunk.close()
            self._trunk, self._trunk_ns = self.root.branch(), 0
        if piece.from_ns > self._trunk_ns:
            self._trunk.call(run.advance, piece.from_ns)
            self._trunk_ns = piece.from_ns
        return self._trunk


def _place(played: Run) -> tuple[Schedule, int]:
    return played.acts, played.length_ns


class LocalCrew:
    """Branches of this machine, at most a number of them at a time."""

    def __init__(self, bench: Bench, workers: int) -> None:
        self._bench, self._workers = bench, workers
        self._waiting: deque[Piece] = deque()
        self._running: dict[Branch, tuple[int, Piece]] = {}
        self._ended: dict[int, Run] = {}
        self._started = self._returned = 0

    def start(self, piece: Piece) -> None:
        self._waiting.append(piece)
        self._fill()

    def next(self) -> Run:
        while self._returned not in self._ended:
            self._wait()
        self._returned += 1
        return self._ended.pop(self._returned - 1)

    def drop(self, run: Run) -> None:
        self._bench.drop(run)

    def close(self) -> None:
        """End what still runs."""
        for branch in self._running:
            branch.close()
        self._running.clear()
        self._waiting.clear()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: "type[BaseException] | None", fault: BaseException | None, tb: "TracebackType | None"
    ) -> None:
        self.close()

    def _fill(self) -> None:
        while self._waiting and len(self._running) < self._workers:
            piece = self._waiting.popleft()
            self._running[self._bench.start(piece)] = self._started, piece
            self._started += 1

    def _wait(self) -> None:
        """Wait until a piece has ended."""
        from multiprocessing.connection import wait

        files = {branch.fileno(): branch for branch in self._running}
        for file in wait(list(files)):
            assert isinstance(file, int)
            branch = files[file]
            number, piece = self._running.pop(branch)
            self._ended[number] = branch.result()
            self._bench.park(branch, piece, self._ended[number])
        self._fill()
