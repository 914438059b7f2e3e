"""Numbers for people: with the digits that their type and unit bear.  Scripts get all digits, by --json.

A value that 32 bits hold has the shortest text that is read back as the same 32 bits: 229.9, where a double would have
229.89999389648438.  Any other value has seven significant digits, as many as such a type holds, and all those before
the point.  A unit sets the last place that is worth reading, well below what a sensor of the trade resolves.
"""

import re
import struct
from math import floor, isfinite, log10
from typing import Any, Final

from fieldrig.text.one_line import without_controls

SIGNIFICANT: Final = 7
LONGEST: Final = 17
"""Significant digits that always tell two doubles apart."""
SMALLEST_PLAIN: Final = 1e-6
"""Smaller numbers have an exponent."""
PLACES: Final = {
    "%": 4,
    "1/min": 4,
    "A": 5,
    "Hz": 5,
    "N": 4,
    "N m": 5,
    "Nm": 5,
    "V": 5,
    "W": 4,
    "bar": 5,
    "degC": 4,
    "kg": 5,
    "m": 6,
    "m/s": 6,
    "mm": 4,
    "ms": 6,
    "rad": 6,
    "rpm": 4,
    "s": 9,
    "turn": 6,
}
"""The last decimal place that is shown, by unit; a unit that is not here has no limit."""
DECIMAL: Final = re.compile(r"(?<![\w.#])(-?\d+\.\d+(?:e[+-]?\d+)?)(?![\w.])(?: ([^\s,]+))?")


def show_value(value: Any, unit: str = "") -> str:
    """Return a value as text for a person."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return without_controls(value)
    return _number(value, unit) if isinstance(value, float) else str(value)


def show_with_unit(value: Any, unit: str) -> str:
    """Return a value with its unit as text for a person, such as `4000 x 0.1 %` where the unit has a number."""
    times = " x" if unit[:1].isdigit() else ""
    return f"{show_value(value, unit)}{times} {unit}".rstrip()


def with_fewer_digits(text: str) -> str:
    """Return the text of a message with the decimal numbers in it as people read them; a unit may follow each.

    A short number without a unit stays as it is, as it may be a part of a text: version 1.20, or 12:30:07.500.
    """
    if "." not in text:
        return text

    def shorter(match: re.Match[str]) -> str:
        unit = f" {match[2]}" if match[2] else ""
        if match[2] not in PLACES and "e" not in match[1] and sum(map(str.isdigit, match[1])) <= SIGNIFICANT:
            return match[0]
        return f"{_number(float(match[1]), match[2] or '')}{unit}"

    return DECIMAL.sub(shorter, text)


def _number(value: float, unit: str) -> str:
    if not isfinite(value) or value.is_integer():
        return "0" if value == 0 else str(value).removesuffix(".0")
    limit = PLACES.get(unit)
    if limit is not None and round(value, limit) == 0:
        return "0"
    text = _shortest_single(value) or _text(value, SIGNIFICANT)
    if "e" in text or "." not in text:
        return text
    is_finer = limit is not None and len(text.partition(".")[2]) > limit
    return _without_zeros(f"{value:.{limit}f}" if is_finer else text)


def _shortest_single(value: float) -> str | None:
    """Return the shortest text of a value that 32 bits hold exactly; None for any other value."""
    if _single(value) != value:
        return None
    return next(text for digits in range(1, LONGEST + 1) if _single(float(text := _text(value, digits))) == value)


def _text(value: float, digits: int) -> str:
    """Return the value with this number of significant digits, and without an exponent unless it is very small."""
    if abs(value) < SMALLEST_PLAIN:
        return f"{value:.{digits}g}"
    return f"{value:.{max(digits - 1 - floor(log10(abs(value))), 0)}f}"


def _without_zeros(text: str) -> str:
    return text.rstrip("0").rstrip(".")


def _single(value: float) -> float | None:
    """Return the value as 32 bits hold it; None if it is beyond their range."""
    try:
        return float(struct.unpack("<f", struct.pack("<f", value))[0])
    except OverflowError:
        return None
