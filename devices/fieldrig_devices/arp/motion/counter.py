"""The position counter, with its latch: it converts encoder counts to user units, which wrap between two limits.

Source: manual 3.2, @ParX[1], [3], [5], [6]; digest chapters 6.2 and 12.  Both limits are valid positions; a position
beyond the maximum continues from the minimum, and vice versa.  The encoder's own counter has 32 bits, so a jump of half
its range or more looks like a jump the other way.
"""

import math

from fieldrig_devices.arp.fixed import signed
from fieldrig_devices.arp.motion.flags import AxisFlag, AxisFlags


class Span:
    """Range of a counter.  If its limits are in the wrong order, the counter does not wrap."""

    __slots__ = ("high", "length", "low")

    def __init__(self, low: float, high: float) -> None:
        if low >= high:
            low, high = -math.inf, math.inf
        self.low, self.high = low, high
        self.length = high - low

    def laps(self, value: float) -> int:
        """Number of ranges by which a value is above the maximum (positive) or below the minimum (negative); 0 if
        within."""
        if value > self.high:
            return math.ceil((value - self.high) / self.length)
        if value < self.low:
            return -math.ceil((self.low - value) / self.length)
        return 0

    def back(self, value: float, laps: int) -> float:
        """Move a value back by `laps` ranges, into the range of the counter."""
        return min(max(value - laps * self.length, self.low), self.high) if laps else value

    def wrapped(self, value: float) -> float:
        return self.back(value, self.laps(value))


class Counter:
    __slots__ = ("_net", "_origin", "_per_count", "counts", "delta", "reading", "span")

    def __init__(self, span: Span, per_count: float) -> None:
        self.span, self._per_count = span, per_count
        self.counts = self.delta = self._net = 0
        self.reading = self._origin = 0.0

    def configure(self, span: Span, per_count: float) -> None:
        """Change range and scale.  The reading is kept, even outside the new range."""
        self.span, self._per_count = span, per_count
        self.preset(self.reading)

    def preset(self, reading: float) -> None:
        self.reading = self._origin = reading
        self._net = 0

    def skip_to(self, counts: int) -> None:
        """Take over the encoder's counts without motion."""
        self.counts, self.delta = signed(counts), 0

    def take(self, counts: int) -> int:
        """Take one sample of the encoder.  Returns how many ranges were passed; negative below the minimum."""
        if counts == self.counts:
            self.delta = 0
            return 0
        self.delta = signed(counts - self.counts)
        self.counts = signed(counts)
        self._net += self.delta
        reading = self._origin + self._net * self._per_count
        span = self.span
        if span.low <= reading <= span.high:
            self.reading = reading
            return 0
        laps = span.laps(reading)
        self.preset(span.back(reading, laps))
        return laps


class Latch:
    """The latch input of an axis: an edge captures the position once if it is armed.

    Source: manual 4.2.1, 4.6 (F265, F266); digest chapter 8.2.  The input is sampled in each control loop, so the
    position is that of the loop that sees the edge.
    """

    def __init__(self, flags: AxisFlags) -> None:
        self._flags = flags
        self.level: int | None = None
        self.rising = self.falling = 0.0

    def take(self, level: int, reading: float) -> None:
        """Handle a changed input.  The first level that is seen is not an edge."""
        is_first, self.level = self.level is None, level
        arm = AxisFlag.ARM_RISING if level else AxisFlag.ARM_FALLING
        if is_first or not self._flags[arm]:
            return
        if level:
            self.rising = reading
        else:
            self.falling = reading
        self._flags[arm] = 0
