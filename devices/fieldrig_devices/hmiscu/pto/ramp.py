"""A ramp between two frequencies: the pulses under it, its time, and the frequency after each pulse (digest 9.3)."""

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from fieldrig_devices.hmiscu.pto.exact import root


@dataclass(frozen=True)
class Ramp:
    """A ramp with a steady rate, seen from its low end.  Frequencies are in Hz, the rate in Hz/s.

    The square of the high frequency is kept because the peak of a triangle is a root.
    """

    low: Fraction
    high_square: Fraction
    rate: Fraction

    @cached_property
    def high(self) -> Fraction:
        return root(self.high_square)

    @cached_property
    def pulses(self) -> Fraction:
        """The area under the ramp, which need not be a whole number."""
        return (self.high_square - self.low * self.low) / (2 * self.rate)

    @cached_property
    def whole(self) -> int:
        """The whole pulses, counted from the low end."""
        return int(self.pulses)

    @property
    def part(self) -> Fraction:
        """The part of a pulse under the high end, after the whole ones."""
        return self.pulses - self.whole

    @property
    def part_s(self) -> Fraction:
        """The time of that part, in seconds."""
        return (self.high - self.after(self.whole)) / self.rate

    @property
    def seconds(self) -> Fraction:
        return (self.high - self.low) / self.rate

    def after(self, pulses: int) -> Fraction:
        """Return the frequency in Hz this many pulses above the low end."""
        return root(self.low * self.low + 2 * self.rate * pulses) if pulses else self.low

    def seconds_of(self, pulses: int) -> Fraction:
        """Return the time of this many pulses from the low end."""
        return (self.after(pulses) - self.low) / self.rate


def peak_square(start: Fraction, stop: Fraction, up: Fraction, down: Fraction, distance: int) -> Fraction:
    """Return the square of the frequency that a move without a plateau reaches (SCU-044, digest 9.5)."""
    return (2 * up * down * distance + down * start * start + up * stop * stop) / (up + down)
