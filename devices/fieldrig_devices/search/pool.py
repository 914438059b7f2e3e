"""Runs in branches beside each other, at most a number of them at a time."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from fieldrig.virtual.branch import Branch

if TYPE_CHECKING:
    from types import TracebackType

Take = Callable[[Any], None]
"""Gets the result of a run."""


class Pool:
    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._running: dict[Branch, tuple[Take, bool]] = {}

    def start(
        self, branch: Branch, take: Take, function: Callable[..., Any], *arguments: Any, is_kept: bool = False
    ) -> None:
        """Call a function in a branch, which then ends unless it is kept; waits while there are too many."""
        while len(self._running) >= self._workers:
            self.wait()
        branch.start(function, *arguments)
        self._running[branch] = take, is_kept

    def finish(self) -> None:
        """Wait for all runs."""
        while self._running:
            self.wait()

    def wait(self) -> None:
        """Wait until a run has ended, and have its result taken."""
        from multiprocessing.connection import wait

        files = {branch.fileno(): branch for branch in self._running}
        for file in wait(list(files)):
            assert isinstance(file, int)
            branch = files[file]
            take, is_kept = self._running.pop(branch)
            result = branch.result()
            if not is_kept:
                branch.close()
            take(result)

    def __enter__(self) -> "Pool":
        return self

    def __exit__(
        self, kind: "type[BaseException] | None", fault: BaseException | None, tb: "TracebackType | None"
    ) -> None:
        for branch in self._running:
            branch.close()
        self._running.clear()
