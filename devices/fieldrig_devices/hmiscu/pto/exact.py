"""Square roots and times as exact as the nanosecond of every edge needs, without floats."""

from fractions import Fraction
from math import isqrt
from typing import Final

from fieldrig_bus.signals.parabola import Exact

ATTOSECONDS: Final = 10**18
"""In a second.  Times of a plan are added up in this unit, so that no sum is off by a nanosecond."""
_FINE: Final = 64
_ON_WIRE: Final = 40


def root(square: Fraction) -> Fraction:
    """Return the square root, exact if it is a whole number, otherwise rounded down to a multiple of 2^-64."""
    return Fraction(isqrt((square.numerator << 2 * _FINE) // square.denominator), 1 << _FINE)


def sendable(value: Fraction) -> Exact:
    """Return a frequency or rate as a wire carries it: an int, or rounded down to a multiple of 2^-40 if it must be."""
    if value.denominator == 1:
        return int(value)
    return value if value.denominator < 1 << _ON_WIRE else Fraction(int(value * (1 << _ON_WIRE)), 1 << _ON_WIRE)
