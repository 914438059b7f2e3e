"""The functions of numbers that generated code calls (chapter 6 of the manual).

An integer result outside 32 bits, or a division of integers by zero, is the fault 02..FFF2.  A domain or range error of
reals is 02..FFF3; the functions of Python's math module raise it as ValueError or OverflowError.
"""

import math
import sys
from collections.abc import Callable, Mapping
from typing import Any, Final, NoReturn

from fieldrig_devices.languages.faults import RunError
from fieldrig_devices.pam.runtime.lower.operands import HIGH, LOW
from fieldrig_devices.pam.runtime.readings import Readings

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
_FUNCTIONS: Final[Mapping[str, Callable[..., Any]]] = {
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


def functions(readings: Readings) -> Mapping[str, Callable[..., Any]]:
    """Return the functions by their names in generated code."""
    by_name = dict(_FUNCTIONS)
    if not readings.math_error_is_fatal:
        by_name |= {name: _going_on(by_name[name], limit) for name, limit in _LIMITS.items()}
    return by_name


def _going_on(function: Callable[..., float], limit: Callable[..., float]) -> Callable[..., float]:
    """Return a function that has a result where the original has none."""

    def going_on(*arguments: float) -> float:
        try:
            return function(*arguments)
        except (ValueError, OverflowError):
            return limit(*arguments)

    return going_on


def _limit_of_power(base: float, exponent: float) -> float:
    if base == 0 or (base < 0 and exponent % 1):
        return 0.0
    return -_LARGEST if base < 0 and exponent % 2 else _LARGEST


_LARGEST: Final = sys.float_info.max
_LIMITS: Final[Mapping[str, Callable[..., float]]] = {
    **dict.fromkeys(("sqrt", "acos", "asin"), lambda _: 0.0),
    **dict.fromkeys(("ln", "log10"), lambda _: -_LARGEST),
    **dict.fromkeys(("exp", "cosh"), lambda _: _LARGEST),
    "sinh": lambda value: math.copysign(_LARGEST, value),
    "power": _limit_of_power,
}
"""Results where an error does not stop the program: 0 outside the domain, and the largest real beyond the range."""
