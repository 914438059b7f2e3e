"""Plans with a rounded frequency for each pulse, as the manual calculates the periods (SCU-084, digest 9.8 and 14.2).

The period n above the low end of a ramp has the mean of the frequencies at its two ends, rounded up to whole Hz:

    f(n) = ceil((v(n) + v(n + 1)) / 2)      v(n) = sqrt(low^2 + 2 rate n)

The first period from the start frequency, and the last one to the stop frequency, have that frequency itself.
Neighbours with the same frequency are one piece.  Everything is found by comparing whole numbers.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, sqrt

from fieldrig_bus.signals.parabola import Exact
from fieldrig_devices.hmiscu.pto.piece import Piece
from fieldrig_devices.hmiscu.pto.rates import end_frequency

Run = tuple[int, int]
"""A frequency in Hz, and a number of pulses with it."""


@dataclass(frozen=True, slots=True)
class Staircase:
    """A ramp in periods, numbered from 0 at its low end."""

    low: int
    rate: Exact
    is_end: bool = True
    """True if the axis is at rest beyond the low end."""

    def frequency(self, number: int) -> int:
        """Return the rounded frequency of a period in Hz."""
        if number == 0 and self.is_end:
            return end_frequency(self.low, self.rate)
        square = self.low * self.low + 2 * float(self.rate) * number
        frequency = max(ceil((sqrt(square) + sqrt(square + 2 * float(self.rate))) / 2), 1)
        while self.upto(frequency) <= number:
            frequency += 1
        while self.upto(frequency - 1) > number:
            frequency -= 1
        return frequency

    def upto(self, frequency: int) -> int:
        """Return how many periods have an exact frequency of at most this: f(n) <= F means v(n) <= F - rate / 2 F."""
        p, q = self.rate.numerator, self.rate.denominator
        reach = 2 * frequency * frequency * q - p
        if reach < 0:
            return 0
        over = reach * reach - (2 * frequency * q * self.low) ** 2
        return over // (8 * frequency * frequency * q * p) + 1 if over >= 0 else 0

    def within(self, top_hz: int) -> int:
        """Return how many periods are not faster than this, with the first one, which has a frequency of its own."""
        return max(self.upto(top_hz), int(self.is_end and self.frequency(0) <= top_hz))

    def rising(self, count: int) -> Iterator[Run]:
        """Yield the periods 0 to `count` - 1."""
        number = 0
        while number < count:
            frequency = self.frequency(number)
            after = number + 1 if number == 0 and self.is_end else min(max(self.upto(frequency), number + 1), count)
            yield frequency, after - number
            number = after

    def falling(self, count: int) -> Iterator[Run]:
        """Yield the periods `count` - 1 to 0."""
        last = 1 if self.is_end else 0
        while count > last:
            frequency = self.frequency(count - 1)
            before = min(max(self.upto(frequency - 1), last), count - 1)
            yield frequency, count - before
            count = before
        if count:
            yield self.frequency(0), 1


def move(up: Staircase, down: Staircase, top_hz: int, distance: int) -> Iterator[Piece]:
    """Yield a move of `distance` pulses, each with the lowest of the frequencies of both ramps and the top."""
    rise, fall = up.within(top_hz), down.within(top_hz)
    if rise + fall > distance:
        rise = _meeting(up, down, distance)
        fall = distance - rise
    yield from pieces(up.rising(rise))
    if distance > rise + fall:
        yield Piece.constant(top_hz, distance - rise - fall)
    yield from pieces(down.falling(fall))


def _meeting(up: Staircase, down: Staircase, distance: int) -> int:
    """Return how many pulses belong to the ramp upwards of a move that has no plateau."""
    low, high = 0, distance
    while low < high:
        middle = (low + high) // 2
        if up.frequency(middle) < down.frequency(distance - 1 - middle):
            low = middle + 1
        else:
            high = middle
    return low


def approach(from_hz: int, to_hz: int, rate: Exact, is_from_rest: bool) -> Iterator[Piece]:
    """Yield a ramp in either direction, then the new frequency until something else happens."""
    if from_hz < to_hz:
        stairs = Staircase(from_hz, rate, is_from_rest)
        yield from pieces(stairs.rising(stairs.within(to_hz)))
    elif from_hz > to_hz:
        stairs = Staircase(to_hz, rate, is_end=False)
        yield from pieces(stairs.falling(stairs.within(from_hz)))
    yield Piece.constant(to_hz, None)


def pieces(runs: Iterator[Run]) -> Iterator[Piece]:
    return (Piece.constant(frequency, count) for frequency, count in runs)
