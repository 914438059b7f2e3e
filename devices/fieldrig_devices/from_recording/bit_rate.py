"""The bit rate of a CAN bus, which no recording says: frames that follow each other without a gap show it."""

from collections import Counter
from typing import Final

from fieldrig.clock import US, S
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.length import classical_bits

RATES: Final = (10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000)
"""Bit rates of CiA 301, 6.2, in bit/s, and 100 kbit/s, which many machines have."""
USUAL: Final = 500_000
MOST_PAIRS: Final = 20_000
FEWEST: Final = 5
SHARE: Final = 0.01
STAMP_NS: Final = US
"""Resolution of the time stamps of most recordings."""


class BitRate:
    """Compares the distance of two frames with the bits of the second one."""

    def __init__(self) -> None:
        self._pairs = 0
        self._votes: Counter[int] = Counter()
        self._last_ns: int | None = None

    def take(self, time_ns: int, frame: CanFrame) -> None:
        last_ns, self._last_ns = self._last_ns, time_ns
        if last_ns is None or frame.is_fd or self._pairs >= MOST_PAIRS:
            return
        self._pairs += 1
        distance_ns = time_ns - last_ns
        if not 0 < distance_ns < 160 * S // RATES[0]:
            return
        bits = classical_bits(frame)
        for rate in RATES:
            bit_ns = S // rate
            if abs(distance_ns - bits * bit_ns) <= bit_ns // 2 + STAMP_NS:
                self._votes[rate] += 1

    @property
    def found(self) -> int | None:
        """The bit rate in bit/s; None if the recording does not show it."""
        if not self._votes:
            return None
        rate, votes = self._votes.most_common(1)[0]
        return rate if votes >= max(FEWEST, SHARE * self._pairs) else None
