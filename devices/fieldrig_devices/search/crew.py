"""Crews play the pieces of a search: branches of this machine, or the workers of a cluster behind the same calls."""

from collections import deque
from typing import TYPE_CHECKING, Protocol, Self

from fieldrig.virtual.branch import Branch
from fieldrig_devices.search.bench import Bench
from fieldrig_devices.search.piece import Piece, Run

if TYPE_CHECKING:
    from types import TracebackType


__all__ = ["Bench", "Crew", "LocalCrew"]


class Crew(Protocol):
    """Plays pieces; they end in any order, and their outcomes come in the order in which they were started."""

    def start(self, piece: Piece) -> None:
        """Have a piece played as soon as a worker is free."""

    def next(self) -> Run:
        """Wait for the piece that was started first of those whose outcome was not returned yet."""

    def drop(self, run: Run) -> None:
        """Let the end of this piece go: no other piece goes on from there."""


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
            branch, self._ended[number] = self._bench.result(branch, piece)
            self._bench.park(branch, piece, self._ended[number])
        self._fill()
