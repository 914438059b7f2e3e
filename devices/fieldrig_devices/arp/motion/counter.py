"""The position counter: encoder counts to a reading in user units that goes round between two limits.

Source: manual 3.2, @ParX[1], [3], [5], [6]; digest chapters 6.2 and 12.  Both limits are positions that an axis can
stand on; what goes beyond the maximum goes on from the minimum and the other way round.  The encoder's own counter has
32 bits, so a jump of half of that or more looks like one the other way.
"""

import math

from fieldrig_devices.arp.fixed import signed


class Span:
    """The range of a counter.  With its limits in the wrong order nothing goes round."""

    __slots__ = ("high", "length", "low")

    def __init__(self, low: float, high: float) -> None:
        if low >= high:
            low, high = -math.inf, math.inf
        self.low, self.high = low, high
        self.length = high - low

    def laps(self, value: float) -> int:
        """How many ranges a value lies beyond the maximum, or, negative, the minimum; 0 within."""
        if value > self.high:
            return math.ceil((value - self.high) / self.length)
        if value < self.low:
            return -math.ceil((self.low - value) / self.length)
        return 0

    def back(self, value: float, laps: int) -> float:
        """A value that lies `laps` beyond, as the counter has it."""
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
        """The reading stays, even if it is outside the new range."""
        self.span, self._per_count = span, per_count
        self.preset(self.reading)

    def preset(self, reading: float) -> None:
        self.reading = self._origin = reading
        self._net = 0

    def skip_to(self, counts: int) -> None:
        """The encoder is there, and that is no motion."""
        self.counts, self.delta = signed(counts), 0

    def take(self, counts: int) -> int:
        """What the encoder says in this sample; returns how many ranges were passed, negative beyond the minimum."""
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
