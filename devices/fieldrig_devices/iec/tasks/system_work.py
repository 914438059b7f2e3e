"""Work of the operating system that shares the processor with the tasks of the program.

Source: PacDrive manual 3173-3223 (digest PD-065): the TCP/IP server at about IEC priority 5, the update of the IO map
of field buses at 4.  A job takes a stated time, and has its effect when the processor begins with it.
"""

from collections import deque
from collections.abc import Callable
from typing import Final

from fieldrig_devices.iec.host import Pending
from fieldrig_devices.iec.tasks.task import WorkState

IO_MAP_PRIORITY: Final = 4
TCP_PRIORITY: Final = 5


class SystemWork:
    """The jobs of one task of the system, as the `Work` of that task."""

    wake: Pending | None = None

    def __init__(self) -> None:
        self._jobs: deque[tuple[int, Callable[[], None]]] = deque()
        self._left_ns = 0

    def add(self, duration_ns: int, action: Callable[[], None]) -> None:
        self._jobs.append((duration_ns, action))

    @property
    def is_busy(self) -> bool:
        return bool(self._jobs or self._left_ns)

    @property
    def state(self) -> WorkState:
        return WorkState.READY if self.is_busy else WorkState.ENDED

    def begin(self) -> None:
        """A cycle has no begin of its own."""

    def run(self, budget_ns: int) -> int:
        """Spend time on one job at most, and return the rest, so that other events have their turn before the next."""
        if not self._left_ns and self._jobs:
            self._left_ns, action = self._jobs.popleft()
            action()
        spent_ns = min(self._left_ns, budget_ns)
        self._left_ns -= spent_ns
        return budget_ns - spent_ns

    def clear(self) -> None:
        self._jobs.clear()
        self._left_ns = 0
