"""The programs of a task, which run one after the other in each of its cycles."""

from collections.abc import Sequence
from typing import Final, Protocol

from fieldrig_devices.iec.host import Pending
from fieldrig_devices.iec.tasks.task import WorkState


class Thread(Protocol):
    """A program that runs in slices: `iec.runtime.Thread`."""

    @property
    def state(self) -> WorkState: ...

    @property
    def wake(self) -> Pending | None: ...

    def start(self) -> None: ...

    def run(self, budget_ns: int) -> int: ...


class Programs:
    """The work of a task that runs programs."""

    def __init__(self, threads: Sequence[Thread]) -> None:
        """At least one thread."""
        self.threads: Final = tuple(threads)
        self.state = WorkState.ENDED
        self._number = 0

    @property
    def present(self) -> Thread:
        """The program that runs, or that has run last."""
        return self.threads[self._number]

    @property
    def wake(self) -> Pending | None:
        return self.present.wake

    def begin(self) -> None:
        self._number = 0
        self.present.start()
        self.state = WorkState.READY

    def run(self, budget_ns: int) -> int:
        threads = self.threads
        while True:
            thread = threads[self._number]
            budget_ns = thread.run(budget_ns)
            state = self.state = thread.state
            if state is not WorkState.ENDED or self._number == len(threads) - 1:
                return budget_ns
            self._number += 1
            threads[self._number].start()
            self.state = WorkState.READY
            if budget_ns <= 0:
                return budget_ns
