"""The retransmission time-out, from measured round trips (RFC 6298)."""

from typing import Final

from fieldrig.clock import MS, S

FIRST_NS: Final = 1 * S
"""The time-out before the first measurement (rule 2.1)."""
LEAST_NS: Final = 1 * S
"""Rule 2.4."""
MOST_NS: Final = 60 * S
"""Rule 2.5."""
AFTER_LOST_SYN_NS: Final = 3 * S
"""The time-out for data if the SYN had to be sent twice (rule 5.7)."""
_GRANULARITY_NS: Final = 1 * MS


class RoundTrip:
    """Measures one segment at a time, and never one that was sent twice (Karn's rule, section 3)."""

    def __init__(self) -> None:
        self.timeout_ns = FIRST_NS
        self.smoothed_ns: int | None = None
        """SRTT; None before the first measurement."""
        self._variation_ns = 0
        self._timed: tuple[int, int] | None = None

    def sent(self, now_ns: int, end: int) -> None:
        """Begin to measure a new segment whose last position is before `end`, unless one is measured already."""
        if self._timed is None:
            self._timed = end, now_ns

    def acknowledged(self, now_ns: int, position: int) -> None:
        """Take the measurement if `position` covers the measured segment."""
        if self._timed is not None and position >= self._timed[0]:
            self._measured(now_ns - self._timed[1])
            self._timed = None

    def repeated(self) -> None:
        """Give up the measurement, because a segment is sent again."""
        self._timed = None

    def back_off(self) -> None:
        """Double the time-out (rule 5.5)."""
        self.timeout_ns = min(2 * self.timeout_ns, MOST_NS)

    def opened_after_loss(self) -> None:
        """Begin the transfer of data with 3 s, because the SYN was lost."""
        self.timeout_ns = AFTER_LOST_SYN_NS

    def _measured(self, measured_ns: int) -> None:
        if self.smoothed_ns is None:  # rule 2.2
            self.smoothed_ns, self._variation_ns = measured_ns, measured_ns // 2
        else:  # rule 2.3
            self._variation_ns = (3 * self._variation_ns + abs(self.smoothed_ns - measured_ns)) // 4
            self.smoothed_ns = (7 * self.smoothed_ns + measured_ns) // 8
        timeout_ns = self.smoothed_ns + max(_GRANULARITY_NS, 4 * self._variation_ns)
        self.timeout_ns = min(max(timeout_ns, LEAST_NS), MOST_NS)
