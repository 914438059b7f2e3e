"""The phase of a pulse train as an exact function of time: whole numbers only, and nothing is rounded but an instant.

The phase counts periods: N(t) = phase + frequency t + rate t^2 / 2, up to the instant at which the frequency is zero.
Over the common denominator of the three, and with t in nanoseconds, it is (a t^2 + b t + c) / d.  Half periods are
the unit of the targets, because a train has an edge at each of them.
"""

from dataclasses import dataclass
from fractions import Fraction
from math import isqrt, lcm
from typing import Self

from fieldrig.clock import S

Exact = int | Fraction
"""A rational number.  A float is refused on a wire, as its last digit would decide where an edge is."""


@dataclass(frozen=True, slots=True)
class Parabola:
    """Times are in nanoseconds from the beginning."""

    a: int
    b: int
    c: int
    d: int  # even

    @classmethod
    def of(cls, phase: Exact, frequency: Exact, rate: Exact) -> Self:
        """Return the parabola of a phase in periods, a frequency in Hz from 0, and a rate in Hz/s."""
        common = lcm(phase.denominator, frequency.denominator, rate.denominator)

        def over(number: Exact, factor: int) -> int:
            return number.numerator * (common // number.denominator) * factor

        return cls(over(rate, 1), over(frequency, 2 * S), over(phase, 2 * S * S), 2 * S * S * common)

    def halves_at(self, time_ns: int) -> int:
        """Return the whole half periods that have passed at `time_ns`, from 0."""
        if self.a < 0 and -2 * self.a * time_ns >= self.b:  # the frequency has reached zero
            return 2 * (self.b * self.b - 4 * self.a * self.c) // (-4 * self.a * self.d)
        return 2 * ((self.a * time_ns + self.b) * time_ns + self.c) // self.d

    def time_ns(self, halves: int) -> int | None:
        """Return the first instant at which this many half periods have passed; None if they never pass."""
        ahead = halves * (self.d // 2) - self.c
        if ahead <= 0:
            return 0
        if not self.a:
            return -(-ahead // self.b) if self.b else None
        square = self.b * self.b + 4 * self.a * ahead
        if square < 0:
            return None
        root = isqrt(square)
        if self.a < 0:
            return -(-(self.b - root) // (-2 * self.a))
        root += root * root < square
        return -(-(root - self.b) // (2 * self.a))

    def peak_ns(self) -> int | None:
        """Return the first instant at which the frequency is zero; None if it is never zero after the beginning."""
        return -(self.b // (2 * self.a)) if self.a < 0 else None
