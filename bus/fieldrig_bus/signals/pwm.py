"""Pulse-width modulation on a wire: frequency, duty and the instant at which the first cycle begins.

A cycle begins with its high part, and every edge is rounded up to a nanosecond.  A receiver that does not handle
waveforms sees the duty in per cent.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from fieldrig.clock import S
from fieldrig_bus.signals.parabola import Exact
from fieldrig_bus.signals.signal import Signal

FASTEST_HZ: Final = 10_000_000


@dataclass(frozen=True, slots=True)
class Pwm(Signal):
    """A PWM output from `start_ns` until the next signal on this wire.  `value` is the duty in %, from 0 to 100.

    At 0 % the output is always low and at 100 % always high, so neither has an edge.
    """

    unit: str = "%"
    start_ns: int = 0
    frequency: Exact = 1
    """Frequency in Hz, above 0."""

    @property
    def _high(self) -> Fraction:
        """The high part of a cycle, from 0 to 1."""
        return Fraction(self.value) / 100

    def level_at(self, now_ns: int) -> bool:
        """Return True while the output is high."""
        if now_ns < self.start_ns:
            return False
        high = self._high
        return high > 0 and (high >= 1 or now_ns < self._instant_ns(self._cycles_at(now_ns) + high))

    def cycles_at(self, now_ns: int) -> int:
        """Return how many cycles have begun up to and including `now_ns`, whatever the duty."""
        return 0 if now_ns < self.start_ns else self._cycles_at(now_ns) + 1

    def cycle_ns(self, number: int) -> int:
        """Return the instant at which the cycle of this number begins, from 1, whatever the duty."""
        return self._instant_ns(number - 1)

    def pulses_at(self, now_ns: int) -> int:
        """Return how many rising edges there were up to and including `now_ns`."""
        return self.cycles_at(now_ns) if 0 < self._high < 1 else 0

    def rise_ns(self, number: int) -> int | None:
        """Return the instant of the rising edge of this number, from 1; None without edges."""
        return self._instant_ns(number - 1) if 0 < self._high < 1 and number > 0 else None

    def edges(self, from_ns: int, before_ns: int) -> Iterator[tuple[int, bool]]:
        """Yield the edges from `from_ns` on and before `before_ns`: instant and level."""
        high = self._high
        if not 0 < high < 1:
            return
        cycle = self._cycles_at(max(from_ns - 1, self.start_ns))
        while True:
            for instant_ns, level in ((self._instant_ns(cycle), True), (self._instant_ns(cycle + high), False)):
                if instant_ns >= before_ns:
                    return
                if instant_ns >= from_ns:
                    yield instant_ns, level
            cycle += 1

    def _cycles_at(self, now_ns: int) -> int:
        return (now_ns - self.start_ns) * self.frequency.numerator // (S * self.frequency.denominator)

    def _instant_ns(self, cycles: int | Fraction) -> int:
        period_ns = Fraction(S) / self.frequency
        return self.start_ns - (-cycles * period_ns).__floor__()
