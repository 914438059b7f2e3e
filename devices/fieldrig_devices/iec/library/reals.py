"""Real numbers as the floating-point unit has them: nothing is raised, the results of IEEE 754 come out instead.

SQRT(-1) is not a number, LN(0) is minus infinity, and what is too large becomes infinity.  The manual only makes the
division by zero a fault (PD-368).
"""

import math
import struct
from array import array
from collections.abc import Callable
from typing import Final

_CELL: Final = array("f", [0.0])


def single(value: float) -> float:
    """Round to single precision, half to even; what is too large becomes infinity."""
    _CELL[0] = value
    return _CELL[0]


def swapped_single(value: float) -> float:
    """The REAL whose bytes are those of the value in the opposite order."""
    return float(struct.unpack(">f", struct.pack("<f", value))[0])


def swapped_double(value: float) -> float:
    """The LREAL whose bytes are those of the value in the opposite order."""
    return float(struct.unpack(">d", struct.pack("<d", value))[0])


def total(function: Callable[[float], float]) -> Callable[[float], float]:
    """The function with "not a number" outside its domain, and infinity where the result is too large."""

    def with_ieee_results(value: float) -> float:
        try:
            return function(value)
        except ValueError:
            return math.nan
        except OverflowError:
            return math.inf

    return with_ieee_results


def logarithm(function: Callable[[float], float]) -> Callable[[float], float]:
    def with_ieee_results(value: float) -> float:
        if value > 0:
            return function(value)
        return -math.inf if value == 0 else math.nan

    return with_ieee_results


def power(base: float, exponent: float) -> float:
    """EXPT of real numbers, as pow() of C."""
    try:
        return math.pow(base, exponent)
    except ValueError:
        if base != 0:
            return math.nan  # a negative number to a power that is no integer
    except OverflowError:
        pass
    is_odd = math.fmod(exponent, 2) in (1, -1)
    return math.copysign(math.inf, base) if is_odd else math.inf


SIN: Final = total(math.sin)
COS: Final = total(math.cos)
TAN: Final = total(math.tan)
ASIN: Final = total(math.asin)
ACOS: Final = total(math.acos)
ATAN: Final = total(math.atan)
ATAN2: Final = math.atan2
IS_VALID: Final = math.isfinite
SQRT: Final = total(math.sqrt)
EXP: Final = total(math.exp)
LN: Final = logarithm(math.log)
LOG: Final = logarithm(math.log10)
