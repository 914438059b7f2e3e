"""The frames that a PAM has to send, by the free frames of each basic cycle (PAML-167).

Set-points leave with the cycle for which they were computed, and so do the orders that open and close the way for them.
Commands take the frames that remain, at least one in each cycle, and wait in a FIFO for the next.
"""

from collections import deque
from collections.abc import Callable
from typing import Final

from fieldrig_bus.ring.pam.message import Frame
from fieldrig_devices.pamring.codec import ENCODERS
from fieldrig_devices.pamring.frames import EndOfPipe, Group, Order, SetPoint

AT_ONCE: Final = frozenset({SetPoint, EndOfPipe, Group})


class Outbox:
    """The frames of one PAM that have not left yet."""

    def __init__(self, frames_per_cycle: int, most_waiting: int, on_full: Callable[[], None]) -> None:
        """`on_full` is called once when the FIFO is full, and not again before it has been empty."""
        self._frames_per_cycle, self._most_waiting = frames_per_cycle, most_waiting
        self._at_once: list[Frame] = []
        self._waiting: deque[Frame] = deque()
        self._on_full = on_full
        self._is_full = False
        """True since a command was dropped, until the FIFO has been empty."""

    def __len__(self) -> int:
        """The number of commands that wait."""
        return len(self._waiting)

    def put(self, target: int, order: Order) -> None:
        """Add an order.  Without room for it, it is lost."""
        order_class = order.__class__
        if order_class in AT_ONCE:
            self._at_once.append((target, ENCODERS[order_class](order)))
        elif len(self._waiting) < self._most_waiting:
            self._waiting.append((target, ENCODERS[order_class](order)))
        elif not self._is_full:
            self._is_full = True
            self._on_full()

    def take(self) -> tuple[Frame, ...]:
        """Remove and return the frames of a cycle."""
        frames, self._at_once = self._at_once, []
        waiting = self._waiting
        if waiting:
            for _ in range(max(1, min(len(waiting), self._frames_per_cycle - len(frames)))):
                frames.append(waiting.popleft())
        if not waiting:
            self._is_full = False
        return tuple(frames)

    def clear(self) -> None:
        """Drop everything that has not left yet."""
        self._at_once.clear()
        self._waiting.clear()
