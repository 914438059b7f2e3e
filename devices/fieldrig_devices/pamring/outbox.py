"""The frames that a PAM has to send, by the free frames of each basic cycle (PAML-167).

Set-points leave with the cycle for which they were computed, and so do the orders that open and close the way for them.
Commands take the frames that remain, at least one in each cycle, and wait in a FIFO for the next.
"""

from collections import deque
from typing import Final

from fieldrig_bus.ring.pam.message import Frame
from fieldrig_devices.pamring.codec import encode
from fieldrig_devices.pamring.frames import EndOfPipe, Group, Order, SetPoint

AT_ONCE: Final = frozenset({SetPoint, EndOfPipe, Group})


class Outbox:
    """The frames of one PAM that have not left yet."""

    def __init__(self, frames_per_cycle: int, most_waiting: int) -> None:
        self._frames_per_cycle, self._most_waiting = frames_per_cycle, most_waiting
        self._at_once: list[Frame] = []
        self._waiting: deque[Frame] = deque()
        self.is_full = False
        """True since a command was dropped, until the FIFO has been empty."""

    def __len__(self) -> int:
        """The number of commands that wait."""
        return len(self._waiting)

    def put(self, target: int, order: Order) -> bool:
        """Add an order.  False if there was no room for it; then it is lost."""
        if order.__class__ in AT_ONCE:
            self._at_once.append((target, encode(order)))
        elif len(self._waiting) < self._most_waiting:
            self._waiting.append((target, encode(order)))
        else:
            return False
        return True

    def take(self) -> tuple[Frame, ...]:
        """Remove and return the frames of a cycle."""
        frames, self._at_once = self._at_once, []
        waiting = self._waiting
        if waiting:
            for _ in range(max(1, min(len(waiting), self._frames_per_cycle - len(frames)))):
                frames.append(waiting.popleft())
        if not waiting:
            self.is_full = False
        return tuple(frames)

    def clear(self) -> None:
        """Drop everything that has not left yet."""
        self._at_once.clear()
        self._waiting.clear()
