"""Fixed-point numbers of the ARP: signed 32-bit integers that hold a value times 1000, from -999999.999 to 999999.999.

Source: manual 4.1, 5.3; digest chapter 2.  An arithmetic result outside the range causes W02 and is limited to the
range.  Every operation is checked, so that one sum in brackets behaves as two statements do.  Products and quotients
are truncated toward zero.  Bit operations work on the raw 32 bits and never warn: a word whose bit 31 is set is valid,
although it prints outside the range.  The four operations and the remainder are inline in the generated code
(`language.emit`).  This module has the functions that it calls if a result is out of range or a divisor is zero, and
all longer operations.
"""

import math
from collections.abc import Callable
from fractions import Fraction

SCALE = 1_000
LIMIT = 999_999_999  # raw

DIVISION_BY_ZERO = 201  # W01
OUT_OF_RANGE = 202  # W02
WRONG_PARAMETER = 203  # W03
MEMORY_BLANK = 204  # W04


def signed(word: int) -> int:
    """Interpret the low 32 bits as a signed integer."""
    return (word & 0xFFFF_FFFF ^ 0x8000_0000) - 0x8000_0000


def whole(raw: int) -> int:
    """Integer part of a raw value: 856.56 gives 856, -0.5 gives 0."""
    return raw // SCALE if raw >= 0 else -(-raw // SCALE)


def to_text(raw: int) -> str:
    """Format a raw value without trailing zeros: 2.5, -0.001, 5."""
    head, tail = divmod(abs(raw), SCALE)
    fraction = f".{tail:03}".rstrip("0").rstrip(".")
    return f"{'-' if raw < 0 else ''}{head}{fraction}"


def to_raw(value: int | str | Fraction) -> int:
    """Convert a value to its raw integer.  Raises ValueError if it has more than three decimals or is out of range."""
    try:
        raw = Fraction(value) * SCALE
    except ValueError as cause:
        raise ValueError(f"{value} is not a number") from cause
    if raw.denominator != 1:
        raise ValueError(f"{value} has more than three decimals")
    if abs(raw) > LIMIT:
        raise ValueError(f"{value} is out of range; expected -999999.999 to 999999.999")
    return int(raw)


class Arithmetic:
    """The operations that may warn; `warn` is called with 201 to 203."""

    def __init__(self, warn: Callable[[int], None]) -> None:
        self._warn = warn

    def saturated(self, raw: int) -> int:
        """Warn, and return the limit that replaces a result out of range."""
        self._warn(OUT_OF_RANGE)
        return LIMIT if raw > 0 else -LIMIT

    def divided_by_zero(self) -> int:
        """Warn, and return the result of a division by zero, which is also its remainder."""
        self._warn(DIVISION_BY_ZERO)
        return 0

    def shifted_left(self, word: int, count: int) -> int:
        return signed(word << places) if (places := self._places(count)) < 32 else 0

    def shifted_right(self, word: int, count: int) -> int:
        """Logical shift, which fills with zeros from the left."""
        return signed((word & 0xFFFF_FFFF) >> places) if (places := self._places(count)) < 32 else 0

    def _places(self, count: int) -> int:
        places = whole(count)
        if places < 0:
            self._warn(WRONG_PARAMETER)
            return 32
        return places

    def root(self, raw: int) -> int:
        if raw < 0:
            self._warn(WRONG_PARAMETER)
            return 0
        return math.isqrt(raw * SCALE)

    def integer(self, raw: int) -> int:
        return whole(raw) * SCALE

    def sine(self, degrees: int) -> int:
        """Sine to the nearest thousandth: SEN(30) is 0.500, although binary fractions fall just short of it."""
        return round(math.sin(math.radians(degrees % (360 * SCALE) / SCALE)) * SCALE)

    def cosine(self, degrees: int) -> int:
        return round(math.cos(math.radians(degrees % (360 * SCALE) / SCALE)) * SCALE)
