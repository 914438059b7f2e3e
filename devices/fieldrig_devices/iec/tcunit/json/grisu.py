"""The decimal digits of an LREAL as the library writes them: those of Grisu2 with 64 bits.

They always give the number again, but for one number in a thousand there are fewer or closer ones.

Source: F. Loitsch, "Printing Floating-Point Numbers Quickly and Accurately with Integers", 2010.  Deviation, as the
library has it: where the digits reach further than nine places behind the scaled point, the last one is not brought
closer, so that the largest REAL of TwinCAT, 3.4028230607370965e38, ends in 7.
"""

import struct
from functools import lru_cache
from math import ceil
from typing import Final, NamedTuple

BITS: Final = 64
MANTISSA_BITS: Final = 52
BIAS: Final = 1075
LOG10_OF_2: Final = 0.30102999566398114
LARGEST_SCALE: Final = -61
"""The binary exponent up to which a scaled number has at most ten digits in front of its point."""
FIRST_POWER, POWER_STEP = -348, 8
"""The powers of ten by which numbers are scaled: the first one, and the distance of two."""
CORRECTED_PLACES: Final = 9


class Scaled(NamedTuple):
    """The number `of * 2**power`."""

    of: int
    power: int

    def full(self) -> "Scaled":
        """Return the same with all bits in use."""
        shift = BITS - self.of.bit_length()
        return Scaled(self.of << shift, self.power - shift)

    def times(self, other: "Scaled") -> "Scaled":
        """Return the upper half of the product, rounded."""
        return Scaled((self.of * other.of + (1 << BITS - 1)) >> BITS, self.power + other.power + BITS)


def digits_of(value: float) -> tuple[str, int]:
    """Return the digits of a finite number above 0, and the power of ten of the last one."""
    bits: int = struct.unpack("<Q", struct.pack("<d", value))[0]
    exponent, fraction = bits >> MANTISSA_BITS, bits & (1 << MANTISSA_BITS) - 1
    number = Scaled(fraction | 1 << MANTISSA_BITS, exponent - BIAS) if exponent else Scaled(fraction, 1 - BIAS)
    above = Scaled(2 * number.of + 1, number.power - 1).full()
    is_edge = number.of == 1 << MANTISSA_BITS  # the number below is nearer
    below = Scaled(4 * number.of - 1, number.power - 2) if is_edge else Scaled(2 * number.of - 1, number.power - 1)
    below = Scaled(below.of << below.power - above.power, above.power)
    index = (ceil((LARGEST_SCALE - above.power) * LOG10_OF_2 - FIRST_POWER - 1) // POWER_STEP) + 1
    power = FIRST_POWER + POWER_STEP * index
    scale = _power_of_ten(power)
    high, low = above.times(scale), below.times(scale)
    digits, place = _generated(high.of - 1, low.of + 1, number.full().times(scale).of, -high.power)
    return str(digits), place - power


def _generated(high: int, low: int, number: int, point: int) -> tuple[int, int]:
    """Return the fewest leading digits of `high` that are above `low`, and the power of ten of the last one.

    All three have `point` bits behind their point.
    """
    one, width, distance = 1 << point, high - low, high - number
    whole, rest = high >> point, high & one - 1
    digits, place = 0, len(str(whole))
    while place > 0:
        place -= 1
        digit, whole = divmod(whole, 10**place)
        digits = 10 * digits + digit
        left = (whole << point) + rest
        if left <= width:
            return _closer(digits, left, width, distance, 10**place << point), place
    while True:
        rest, width, place = 10 * rest, 10 * width, place - 1
        digits, rest = 10 * digits + (rest >> point), rest & one - 1
        if rest < width:
            distance = distance * 10**-place if -place < CORRECTED_PLACES else 0
            return _closer(digits, rest, width, distance, one), place


def _closer(digits: int, left: int, width: int, distance: int, step: int) -> int:
    """Return the digits with the last one lowered as long as they come closer to the number within its width."""
    while left < distance and width - left >= step:
        if left + step >= distance and distance - left <= left + step - distance:
            break
        digits, left = digits - 1, left + step
    return digits


@lru_cache(maxsize=128)
def _power_of_ten(power: int) -> Scaled:
    """Return a power of ten with 64 bits, rounded to the nearest."""
    above, under = (10**power, 1) if power >= 0 else (1, 10**-power)
    two = above.bit_length() - under.bit_length() - BITS
    while True:
        top, bottom = above << max(-two, 0), under << max(two, 0)
        of = (2 * top + bottom) // (2 * bottom)
        if of.bit_length() == BITS:
            return Scaled(of, two)
        two += 1 if of.bit_length() > BITS else -1
