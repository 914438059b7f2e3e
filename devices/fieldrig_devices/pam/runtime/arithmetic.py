"""The functions of numbers that generated code calls (chapter 6 of the manual).

An integer result outside 32 bits, or a division of integers by zero, is the fault 02..FFF2.  A domain or range error of
reals is 02..FFF3; the functions of Python's math module raise it as ValueError or OverflowError.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any, Final, NoReturn

from fieldrig_devices.languages.faults import RunError
from fieldrig_devices.pam.runtime.lower.operands import HIGH, LOW

INTEGER_FAULT: Final = "02..FFF2"
REAL_FAULT: Final = "02..FFF3"


def overflow() -> NoReturn:
    raise RunError(INTEGER_FAULT, "an integer overflow")


def invalid() -> NoReturn:
    raise RunError(REAL_FAULT, "an overflow or an invalid operation of reals")


def signed(word: int) -> int:
    """Return a word of 32 bits as the integer that has these bits."""
    return word - 2**32 if word > HIGH else word


def truncated(value: float) -> int:
    """Return a real without its fraction (PAML-227)."""
    whole = int(value)
    if not LOW <= whole <= HIGH:
        overflow()
    return whole


def quotient(left: int, right: int) -> int:
    """Return a quotient of integers, truncated toward zero."""
    if right == 0:
        raise RunError(INTEGER_FAULT, "a division of an integer by zero")
    whole = abs(left) // abs(right)
    whole = whole if (left < 0) is (right < 0) else -whole
    if whole > HIGH:
        overflow()
    return whole


def remainder(left: float, right: float) -> float:
    """Return the remainder with the sign of the first operand; that itself if the second one is 0 (PAMS-006)."""
    if right == 0:
        return left
    rest = math.fmod(left, right)
    return int(rest) if isinstance(left, int) and isinstance(right, int) else rest


def power(base: float, exponent: float) -> float:
    """Return a power.  ValueError, OverflowError or ZeroDivisionError for what has no real value (PAMS-006)."""
    return math.pow(base, exponent)


def _whole(function: Callable[[float], int]) -> Callable[[float], float]:
    """Return ceil or floor, whose results are reals."""
    return lambda value: float(function(value))


_OF_PYTHON: Final = "exp log10 sqrt cos sin tan acos asin atan cosh sinh tanh"
FUNCTIONS: Final[Mapping[str, Callable[..., Any]]] = {
    "overflow": overflow,
    "invalid": invalid,
    "signed": signed,
    "truncated": truncated,
    "quotient": quotient,
    "remainder": remainder,
    "power": power,
    "ceil": _whole(math.ceil),
    "floor": _whole(math.floor),
    "ln": math.log,
    **{name: getattr(math, name) for name in _OF_PYTHON.split()},
}
