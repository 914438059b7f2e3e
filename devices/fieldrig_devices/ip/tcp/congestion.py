"""How much may be in flight: slow start, congestion avoidance, fast retransmit and recovery.

Source: RFC 5681 (Reno), with the rule of RFC 6582 for a partial acknowledgment.  Sizes are in bytes.
"""

from typing import Final

DUPLICATES: Final = 3
"""The number of duplicate acknowledgments after which a segment counts as lost (RFC 5681, 3.2)."""


class Reno:
    def __init__(self, mss: int) -> None:
        self._mss = mss
        self.window = first_window(mss)
        self.threshold = 1 << 30
        """Slow start ends here (ssthresh).  It begins as high as possible (RFC 5681, 3.1)."""
        self._duplicates = 0
        self._recover: int | None = None
        """Recovery ends when this position is acknowledged; None outside of it."""
        self._lost_before: int | None = None
        """Duplicates up to this position say nothing about a new loss (RFC 6582, 3.2 step 1)."""

    @property
    def is_recovering(self) -> bool:
        return self._recover is not None

    def advanced(self, acknowledged: int, position: int, in_flight: int) -> bool:
        """Take an acknowledgment of `acknowledged` new bytes up to `position`.

        True if the segment at `position` is lost as well (a partial acknowledgment), and has to be sent again.
        """
        self._duplicates = 0
        if self._recover is None:
            grown = min(acknowledged, self._mss)
            if self.window >= self.threshold:
                grown = max(self._mss * self._mss // self.window, 1)  # RFC 5681, equation 3
            self.window += grown
            return False
        if position >= self._recover:  # RFC 6582, 3.2 step 3, full acknowledgment
            self.window = min(self.threshold, max(in_flight, self._mss) + self._mss)
            self._recover = None
            return False
        self.window = max(self.window - acknowledged, 0) + self._mss
        return True

    def duplicated(self, position: int, highest: int, in_flight: int) -> bool:
        """Take a duplicate acknowledgment of `position`; True if the segment there has to be sent again now."""
        self._duplicates += 1
        if self._recover is not None:
            self.window += self._mss  # a segment has left the network
            return False
        if self._duplicates != DUPLICATES or (self._lost_before is not None and position <= self._lost_before):
            return False
        self._lose(in_flight)
        self._recover = self._lost_before = highest
        self.window = self.threshold + DUPLICATES * self._mss
        return True

    def timed_out(self, highest: int, in_flight: int, is_first: bool) -> None:
        """Begin again with one segment; a repeated time-out does not lower the threshold again (RFC 5681, 3.1)."""
        if is_first:
            self._lose(in_flight)
        self.window = self._mss
        self._duplicates, self._recover, self._lost_before = 0, None, highest

    def idled(self) -> None:
        """Begin again with a small window after a time-out without sending (RFC 5681, 4.1)."""
        self.window = min(self.window, first_window(self._mss))

    def _lose(self, in_flight: int) -> None:
        self.threshold = max(in_flight // 2, 2 * self._mss)  # RFC 5681, equation 4


def first_window(mss: int) -> int:
    """Return the initial window (RFC 5681, 3.1)."""
    return min(4 * mss, max(2 * mss, 4380))
