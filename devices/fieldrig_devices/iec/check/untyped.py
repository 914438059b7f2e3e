"""Constants without a type of their own: literals, and what is computed from literals alone.

Such a constant is computed exactly (integers without limits, real numbers in double precision) and takes the type that
it is needed in if its value fits.
"""

from dataclasses import dataclass
from typing import Final

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.library.arguments import INTEGERS, smallest
from fieldrig_devices.iec.library.arguments import Untyped as UntypedArgument
from fieldrig_devices.iec.program import Constant


@dataclass(slots=True)
class Untyped(Constant):
    """A constant whose type is provisional."""

    is_pattern: bool = False
    """True for a number in base 2, 8 or 16, which may fill the sign bit: INT#16#FFFF is -1, as in CoDeSys V2.3."""

    @property
    def is_real(self) -> bool:
        return isinstance(self.value, float)

    @property
    def argument(self) -> UntypedArgument:
        assert not isinstance(self.value, str)
        return UntypedArgument(self.value)


def integer(value: int, is_pattern: bool = False) -> Untyped:
    return Untyped(value, smallest(value, INTEGERS) or Elementary.LINT, is_pattern)


def real(value: float) -> Untyped:
    return Untyped(value, Elementary.REAL)


PATTERNS: Final = (Elementary.BYTE, Elementary.WORD, Elementary.DWORD, Elementary.LWORD)


def bit_string(value: int) -> Elementary | None:
    """Return the smallest bit string that the number fits in, for NOT; None if it is negative or too large."""
    return smallest(value, PATTERNS)
