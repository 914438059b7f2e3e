"""How a process shares its time between outsiders and everything else in it, such as the cycle of a ring.

Whatever handles bytes of outsiders reports the time that it took.  When this is more than a slice, all readers of the
process wait: until the timers that are due have had their turn, or, where a cycle has to be kept, until the outsiders
have had no more than their share.  What they send meanwhile stays in the buffers of the system, whose flow control
stops them.
"""

import time
from typing import Final, Protocol

from fieldrig.clock import MS, US, Clock, Timer

SLICE_NS: Final = 2 * MS
"""Time that outsiders may take without a pause."""
SLICE_BESIDE_A_CYCLE_NS: Final = 400 * US
"""The same in a process with the end of a ring, whose cycle may be 1 ms."""
SHARE_BESIDE_A_CYCLE: Final = 0.25
"""Their share of the time there.  A controller with a ring of 4 ms keeps 0.99 of its cycles with it, see the bench."""


class Reader(Protocol):
    """Reads what outsiders send."""

    def wait(self, is_waiting: bool) -> None:
        """Read nothing, or go on."""


class Pace:
    """The time of one process."""

    def __init__(self, clock: Clock, share: float = 1.0, slice_ns: int = SLICE_NS) -> None:
        """`share` is the greatest part of the time for outsiders, above 0; with 1 they only give way to what is due."""
        self._clock, self._share, self._slice_ns = clock, share, slice_ns
        self.portion_ns = slice_ns // 2
        """The time that one portion of bytes should take at most."""
        self._readers: dict[Reader, None] = {}
        self._taken_ns = 0
        self._latest_ns = 0
        self._timer: Timer | None = None
        self.pauses = 0
        """How often the readers had to wait."""

    @property
    def is_pausing(self) -> bool:
        return self._timer is not None

    def add(self, reader: Reader) -> None:
        """Add a reader, which waits at once if the others do."""
        self._readers[reader] = None
        if self.is_pausing:
            reader.wait(True)

    def remove(self, reader: Reader) -> None:
        self._readers.pop(reader, None)

    def spent(self, began_ns: int) -> int:
        """Note that something of outsiders was handled since `began_ns`, and return the time that it took."""
        now_ns = time.monotonic_ns()
        took_ns = now_ns - began_ns
        share = self._share
        if share < 1:
            forgotten_ns = (began_ns - self._latest_ns) * share / (1 - share)
            self._taken_ns = max(0, self._taken_ns - int(forgotten_ns)) + took_ns
        else:
            self._taken_ns = took_ns + (self._taken_ns if began_ns - self._latest_ns < self._slice_ns else 0)
        self._latest_ns = now_ns
        if self._taken_ns >= self._slice_ns and not self.is_pausing:
            self._pause(now_ns + int(self._taken_ns * (1 - share) / share))
        return took_ns

    def _pause(self, until_ns: int) -> None:
        self.pauses += 1
        for reader in self._readers:
            reader.wait(True)
        self._timer = self._clock.call_at(until_ns, self._go_on)

    def _go_on(self) -> None:
        self._timer = None
        self._taken_ns = 0
        for reader in list(self._readers):
            reader.wait(False)


def beside_a_cycle(clock: Clock) -> Pace:
    """Return the pace of a process that has a cycle to keep."""
    return Pace(clock, SHARE_BESIDE_A_CYCLE, SLICE_BESIDE_A_CYCLE_NS)
