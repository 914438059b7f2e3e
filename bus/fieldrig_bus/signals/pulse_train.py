"""A pulse train on a wire: one segment of constant or steadily changing frequency, instead of a message for each edge.

A sender publishes a segment when it begins, and a new one when frequency, rate or direction change.  Every receiver
computes from it, in whole numbers, the instant of each edge and the count at each instant, so all of them agree with
the sender.  The period k of a segment begins with the rising edge, at which the pulse is counted, and ends half high
and half low:

    N(t) = phase + frequency t + rate t^2 / 2       with t in seconds from `start_ns`

The pulse rises where N is a whole number, falls half a period later, and each edge is rounded up to a nanosecond.  A
segment holds up to the instant before the next one's `start_ns`; an edge at that instant belongs to the next one.
A segment has the running totals before it, so a receiver that comes late, or loses a segment, knows what it missed.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Final, Self

from fieldrig.clock import S
from fieldrig_bus.signals.parabola import Exact, Parabola
from fieldrig_bus.signals.signal import Signal

UNIT: Final = "count"
"""The unit of the position, as for encoders, so that an encoder input takes a train too."""
FASTEST_HZ: Final = 10_000_000
"""Highest frequency of a train; the fast inputs of drives end at 4 MHz."""
STEEPEST_HZ_PER_S: Final = 10**12
FINEST_PHASE: Final = 10**18
"""`phase_at` is rounded up to a multiple of one part in this many of a period, and never down to a rising edge."""

_curve = lru_cache(maxsize=1024)(Parabola.of)
"""A receiver asks a segment some twenty times for its curve, which is most of what a segment costs."""


@dataclass(frozen=True, slots=True)
class PulseTrain(Signal):
    """A segment of a pulse train.  `value` is the position before it: pulses forwards less pulses backwards.

    A receiver that does not handle pulses sees the position, as it sees that of a `Motion`.
    """

    unit: str = UNIT
    start_ns: int = 0
    frequency: Exact = 0
    """Frequency in Hz at `start_ns`."""
    rate: Exact = 0
    """Change of the frequency in Hz/s.  A train whose frequency changes has a count."""
    count: int | None = 0
    """Number of pulses that rise in this segment, or None if it ends only when the next one begins."""
    direction: int = 1
    """1 or -1."""
    phase: Exact = 0
    """Part of a period that has passed at `start_ns`, less than 1.  Its pulse rose in the segment before."""
    sent: int = 0
    """Number of pulses before this segment in both directions, since `epoch_ns`."""
    epoch_ns: int = 0
    """The instant at which the totals were 0, such as the start of the sender.  It tells a new sender from an old."""

    @property
    def is_moving(self) -> bool:
        return self.count != 0

    @property
    def end_ns(self) -> int | None:
        """The instant at which the last period is complete or the train has stopped, or None if it has no end."""
        if self.count is None:
            return None
        if not self.count and not self.frequency:
            return self.start_ns
        curve = self._curve()
        passed_ns = curve.time_ns(2 * (self._first + self.count))
        end_ns = curve.peak_ns() if passed_ns is None else passed_ns
        return None if end_ns is None else self.start_ns + end_ns

    @property
    def _first(self) -> int:
        """The number of the first period that begins in this segment."""
        return 1 if self.phase else 0

    def _curve(self) -> Parabola:
        return _curve(self.phase, self.frequency, self.rate)

    def pulses_at(self, now_ns: int) -> int:
        """Return how many pulses of this segment have risen up to and including `now_ns`."""
        if now_ns < self.start_ns or self.count == 0:
            return 0
        risen = self._curve().halves_at(now_ns - self.start_ns) // 2 + 1 - self._first
        return risen if self.count is None else min(risen, self.count)

    def at(self, now_ns: int) -> int:
        """Return the position at `now_ns`: pulses forwards less pulses backwards, since the epoch."""
        return int(self.value) + self.direction * self.pulses_at(now_ns)

    def sent_at(self, now_ns: int) -> int:
        """Return the number of pulses in both directions up to and including `now_ns`, since the epoch."""
        return self.sent + self.pulses_at(now_ns)

    def frequency_at(self, now_ns: int) -> Fraction:
        """Return the exact frequency in Hz; 0 before the segment and after its end."""
        end_ns = self.end_ns
        if now_ns < self.start_ns or (end_ns is not None and now_ns >= end_ns):
            return Fraction(0)
        if not self.rate:
            return Fraction(self.frequency)
        return max(Fraction(0), self.frequency + Fraction(self.rate) * (now_ns - self.start_ns) / S)

    def speed_at(self, now_ns: int) -> float:
        return self.direction * float(self.frequency_at(now_ns))

    def rise_ns(self, number: int) -> int | None:
        """Return the instant at which the pulse of this number rises, from 1; None if it is not in this segment."""
        if number < 1 or (self.count is not None and number > self.count):
            return None
        passed_ns = self._curve().time_ns(2 * (number - 1 + self._first))
        return None if passed_ns is None else self.start_ns + passed_ns

    def fall_ns(self, number: int) -> int | None:
        """Return the instant at which the pulse of this number falls; 0: the pulse that rose before this segment."""
        if number < 1 - self._first or (self.count is not None and number > self.count):
            return None
        curve = self._curve()
        passed_ns = curve.time_ns(2 * (number - 1 + self._first) + 1)
        end_ns = curve.peak_ns() if passed_ns is None else passed_ns
        return None if end_ns is None else self.start_ns + end_ns

    def level_at(self, now_ns: int) -> bool:
        """Return True while the output is high."""
        number = self.pulses_at(now_ns)
        if now_ns < self.start_ns or (number == 0 and not self._first):
            return False
        fall_ns = self.fall_ns(number)
        return fall_ns is None or now_ns < fall_ns

    def edges(self, from_ns: int, before_ns: int) -> Iterator[tuple[int, bool]]:
        """Yield the edges from `from_ns` on and before `before_ns`, as if no other segment came: instant and level."""
        curve = self._curve()
        half = 1 if 0 < self.phase < Fraction(1, 2) else 2 * self._first
        if from_ns > self.start_ns:
            half = max(half, curve.halves_at(from_ns - 1 - self.start_ns) + 1)
        last = None if self.count is None else 2 * (self._first + self.count) - 1
        while last is None or half <= last:
            passed_ns = curve.time_ns(half)
            if passed_ns is None and half % 2:
                passed_ns = curve.peak_ns()  # the train stops within this pulse
            if passed_ns is None or self.start_ns + passed_ns >= before_ns:
                return
            if self.start_ns + passed_ns >= from_ns:
                yield self.start_ns + passed_ns, half % 2 == 0
            half += 1

    def phase_at(self, now_ns: int) -> Exact:
        """Return the part of the period that has passed; 0 at the end, and at the instant of a rising edge."""
        end_ns = self.end_ns
        if now_ns < self.start_ns or (end_ns is not None and now_ns >= end_ns):
            return 0
        risen = self.pulses_at(now_ns)
        if risen and self.rise_ns(risen) == now_ns:
            return 0
        curve, passed_ns = self._curve(), now_ns - self.start_ns
        passed = ((curve.a * passed_ns + curve.b) * passed_ns + curve.c) % curve.d
        return Fraction(min(-(-passed * FINEST_PHASE // curve.d), FINEST_PHASE - 1), FINEST_PHASE)

    def then(
        self,
        start_ns: int,
        frequency: Exact = 0,
        rate: Exact = 0,
        count: int | None = 0,
        *,
        direction: int | None = None,
        phase: Exact = 0,
    ) -> Self:
        """Return the next segment, with the totals of this one up to `start_ns`.  Give `phase_at` to go on smoothly."""
        before_ns = start_ns - 1
        return type(self)(
            self.name,
            self.at(before_ns),
            self.unit,
            start_ns,
            frequency,
            rate,
            count,
            self.direction if direction is None else direction,
            phase,
            self.sent_at(before_ns),
            self.epoch_ns,
        )
