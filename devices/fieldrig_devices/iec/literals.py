"""The values of constants as they are written: numbers, strings, times and dates.

Source: PacDrive manual 693 to 755 and 2819 to 2936 (PD-L46 to PD-L48), X9 and X14; IEC 61131-3 table 5 to 9.  Times
are in ms, dates in s since 1970-01-01, and a string is Latin-1.  Each function returns the value, and raises
`LiteralError` with what is wrong.
"""

import re
from collections.abc import Mapping
from datetime import date, timedelta
from typing import Final

from fieldrig_devices.iec import characters
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.literal_texts import EPOCH, MS_NS, S_NS, UNITS_NS, long_time_text, time_text


class LiteralError(Exception):
    """A constant that has no value."""

    def __init__(self, what: str, expected: str = "", hint: str = "") -> None:
        super().__init__(what)
        self.what, self.expected, self.hint = what, expected, hint


_LONGEST_NUMBER: Final = 200
"""Characters of a number: 64 binary digits have 63 underscores between them and 2# in front."""
_DIGITS: Final = {2: "0 and 1", 8: "0 to 7", 10: "0 to 9", 16: "0 to 9 and A to F"}
"""The digits by the base.  The standard has no 10, which CODESYS reads."""
_SMALL_UNITS: Final = ("us", "ns")
_ORDER: Final = list(UNITS_NS)
_LIMITS: Final = {"h": 24, "m": 60, "s": 60, "ms": 1_000, "us": 1_000, "ns": 1_000}
_UNSIGNED: Final = "[0-9](?:_?[0-9])*"
"""An Unsigned_Int of annex A, which may have an underscore between two digits wherever it stands."""
_WHOLE: Final = re.compile(_UNSIGNED)
_REAL: Final = re.compile(rf"[-+]?{_UNSIGNED}(?:\.{_UNSIGNED})?(?:E[-+]?{_UNSIGNED})?", re.IGNORECASE)
_FEW: Final = "([0-9](?:_?[0-9]){0,8})"
_PART: Final = re.compile(rf"({_UNSIGNED}(?:\.{_UNSIGNED})?)(ms|us|ns|d|h|m|s)_?", re.IGNORECASE)
_CLOCK: Final = re.compile(rf"{_FEW}:{_FEW}(?::{_FEW}(?:\.{_FEW})?)?")
_DATE: Final = re.compile(f"{_FEW}-{_FEW}-{_FEW}")
_ESCAPES: Final = {"$": "$", "'": "'", "L": "\n", "N": "\n", "P": "\f", "R": "\r", "T": "\t"}
"""Manual 2919 to 2928.  $N is the line feed, as in CoDeSys."""
_ESCAPE: Final = re.compile(r"\$([0-9A-Fa-f]{2}|.?)", re.DOTALL)
_WIDE_ESCAPES: Final = {**_ESCAPES, '"': '"'}
_WIDE_ESCAPE: Final = re.compile(r"\$([0-9A-Fa-f]{4}|.?)", re.DOTALL)
MOST_MILLISECONDS: Final = 2**32 - 1
"""T#49d17h2m47s295ms, the largest TIME."""


def integer(text: str) -> int:
    """Return the value of `14`, `1_000` or `16#FF`."""
    if len(text) > _LONGEST_NUMBER:
        raise LiteralError("the number is too long", "at most 64 bits")
    base_text, mark, digits = text.partition("#")
    if not mark:
        if _WHOLE.fullmatch(text) is None:
            raise LiteralError(f"{text} is not an integer" if text else "the number is missing", "digits")
        value = int(text)
    else:
        base = int(base_text) if base_text.isdecimal() else 0
        if base not in _DIGITS:
            raise LiteralError(f"{text} has base {base_text}", "base 2, 8, 10 or 16")
        try:
            value = _based(digits, base)
        except ValueError:
            raise LiteralError(f"{text} is not a number of base {base}", f"the digits {_DIGITS[base]}") from None
    if value > 2**64 - 1:
        raise LiteralError(f"{text} is too large", "at most 64 bits")
    return value


def _based(digits: str, base: int) -> int:
    if not digits[:1].isalnum() or digits.endswith("_") or "__" in digits:
        raise ValueError(digits)
    return int(digits, base)


def real(text: str) -> float:
    """Return the value of `1000.23` or `1.23e3`."""
    if _REAL.fullmatch(text) is None:
        raise LiteralError(f"{text} is not a number", "a number such as 7.4 or 1.64E9")
    value = float(text) if len(text) <= 400 else float("inf")
    if value in (float("inf"), float("-inf")):
        raise LiteralError("the number is too large", "at most 1.8E308")
    return value


def string(text: str) -> str:
    """Return the characters of a string without its quotes."""
    inner = text[1:-1]
    if "$" in inner:
        inner = _ESCAPE.sub(_escape, inner)
    wrong = characters.first_outside(inner, is_wide=False)
    if wrong is not None:
        raise LiteralError(f"the character {wrong!r} is not in the character set of the controller", "Latin-1")
    return inner


def wide_string(text: str) -> str:
    """Return the characters of a WSTRING without its quotes."""
    inner = _WIDE_ESCAPE.sub(_wide_escape, text[1:-1])
    wrong = characters.first_outside(inner, is_wide=True)
    if wrong is not None:
        raise LiteralError(f"the character {wrong!r} does not have 16 bits", "U+0000 to U+D7FF or U+E000 to U+FFFF")
    return inner


def _escape(match: re.Match[str]) -> str:
    return _unescaped(match[1], 2, _ESCAPES, "$$, $', $L, $N, $P, $R, $T or $ with two digits")


def _wide_escape(match: re.Match[str]) -> str:
    return _unescaped(match[1], 4, _WIDE_ESCAPES, '$$, $", $L, $N, $P, $R, $T or $ with four digits')


def _unescaped(code: str, digits: int, escapes: Mapping[str, str], expected: str) -> str:
    if len(code) == digits:
        return chr(int(code, 16))
    known = escapes.get(code.upper())
    if known is None:
        raise LiteralError(f"${code} means nothing in a string", expected, "A dollar sign in a text is written $$.")
    return known


def time(text: str, dialect: Dialect) -> int:
    """Return the milliseconds of `2d4h12m`, which is the part behind T#."""
    sign, nanoseconds = _signed(text, dialect)
    milliseconds, kind = sign * (nanoseconds // MS_NS), dialect.time
    if not kind.low <= milliseconds <= kind.high:
        least = f"{time_text(kind.low)} to " if kind.is_signed else "at most "
        raise LiteralError(f"T#{text} is too long", f"{least}{time_text(kind.high)}")
    return milliseconds


def long_time(text: str, dialect: Dialect) -> int:
    """Return the nanoseconds of the part behind LTIME#."""
    sign, nanoseconds = _signed(text, dialect)
    kind = dialect.long_time
    if not kind.low <= sign * nanoseconds <= kind.high:
        least = f"{long_time_text(int(kind.low))} to " if kind.is_signed else "at most "
        raise LiteralError(f"LTIME#{text} is too long", f"{least}{long_time_text(int(kind.high))}")
    return sign * nanoseconds


def _signed(text: str, dialect: Dialect) -> tuple[int, int]:
    """Return the sign and the nanoseconds of a time."""
    sign, body = (-1, text[1:]) if text[:1] == "-" else (1, text.removeprefix("+"))
    if sign < 0 and not dialect.allows_negative_times:
        raise LiteralError("a time cannot be negative", "T#0ms or more")
    return sign, _nanoseconds(_parts(body), dialect)


def _parts(text: str) -> list[tuple[str, str]]:
    """Split a time into pairs of number and unit."""
    parts = []
    position = 0
    while position < len(text):
        match = _PART.match(text, position)
        if match is None:
            what = f"T#{text} is not a time"
            raise LiteralError(what, "numbers with the units d, h, m, s and ms, such as T#1m30s")
        parts.append((match[1].replace("_", ""), match[2].lower()))
        position = match.end()
    if not parts:
        raise LiteralError("nothing follows T#", "numbers with the units d, h, m, s and ms, such as T#1m30s")
    return parts


def _nanoseconds(parts: list[tuple[str, str]], dialect: Dialect) -> int:
    total = 0
    last = -1
    for position, (number, unit) in enumerate(parts):
        order = _ORDER.index(unit)
        if order <= last:
            before = _ORDER[last]
            raise LiteralError(f"{unit} follows {before}", "the units in the order d, h, m, s, ms, each once")
        last = order
        if unit in _SMALL_UNITS and not dialect.allows_time_fractions:
            raise LiteralError(f"the unit {unit} is not known here", "d, h, m, s or ms")
        whole, _, fraction = number.partition(".")
        if fraction and not dialect.allows_time_fractions:
            raise LiteralError(f"{number}{unit} has a fraction", "whole numbers", "Write T#1s500ms for 1.5 s.")
        if fraction and position < len(parts) - 1:
            raise LiteralError(f"{number}{unit} has a fraction", "a fraction in the last unit only")
        if len(whole) > 19:  # 2**63 ns have 19 digits, and int() refuses texts of more than 4300
            raise LiteralError(f"{number}{unit} is too long", "at most T#49d17h2m47s295ms")
        if position and not dialect.allows_time_overflow and int(whole) >= _LIMITS[unit]:
            what = f"{number}{unit} overflows"
            raise LiteralError(what, f"less than {_LIMITS[unit]}{unit}; only the highest unit may overflow")
        total += int(whole) * UNITS_NS[unit]
        if fraction:  # in integers: a float of nanoseconds is exact for 104 days only
            total += int(fraction[:9].ljust(9, "0")) * UNITS_NS[unit] // 10**9
    return total


def _clock(text: str) -> int:
    """Return the nanoseconds of `12:00:00.123`."""
    match = _CLOCK.fullmatch(text)
    if match is None:
        raise LiteralError(
            f"{text or 'nothing'} is not a time of day", "hours:minutes:seconds, such as TOD#15:36:30.123"
        )
    hours, minutes, seconds = int(match[1]), int(match[2]), int(match[3] or 0)
    if hours > 23 or minutes > 59 or seconds > 59:
        raise LiteralError(f"{text} is not a time of day", "00:00:00 to 23:59:59.999")
    fraction = int((match[4] or "").replace("_", "").ljust(9, "0"))
    return ((hours * 60 + minutes) * 60 + seconds) * S_NS + fraction


def time_of_day(text: str) -> int:
    return _clock(text) // MS_NS


def long_time_of_day(text: str) -> int:
    """Return the nanoseconds since midnight."""
    return _clock(text)


def day(text: str) -> int:
    """Return the seconds since 1970 at the begin of `1998-12-07`, a year, a month and a day (X14)."""
    return _days(text, MOST_MILLISECONDS // 86_400) * 86_400


def long_day(text: str, dialect: Dialect) -> int:
    """Return the nanoseconds since 1970 at the begin of a day."""
    return _days(text, _most(dialect) // UNITS_NS["d"]) * UNITS_NS["d"]


def _most(dialect: Dialect) -> int:
    """Return the last nanosecond of a long date."""
    return int(dialect.durations[Elementary.LDT].high)


def _days(text: str, most: int) -> int:
    """Return the days since 1970, which are at most `most`."""
    match = _DATE.fullmatch(text)
    if match is None:
        raise LiteralError(f"{text or 'nothing'} is not a date", "year-month-day, such as D#1998-12-07")
    try:
        days = (date(int(match[1]), int(match[2]), int(match[3])) - EPOCH).days
    except (ValueError, OverflowError):
        raise LiteralError(f"there is no day {text}", "year-month-day, such as D#1998-12-07") from None
    if not 0 <= days <= most:
        raise LiteralError(f"{text} is out of range", f"1970-01-01 to {EPOCH + timedelta(days=most)}")
    return days


def date_and_time(text: str) -> int:
    """Return the seconds since 1970 of `1998-02-13-14:20`; fractions of a second are cut off."""
    date_text, clock_text = _date_and_clock(text)
    seconds = day(date_text) + _clock(clock_text) // S_NS
    if seconds > MOST_MILLISECONDS:
        raise LiteralError(f"{text} is out of range", "1970-01-01-00:00:00 to 2106-02-07-06:28:15")
    return seconds


def long_date_and_time(text: str, dialect: Dialect) -> int:
    """Return the nanoseconds since 1970."""
    date_text, clock_text = _date_and_clock(text)
    nanoseconds = long_day(date_text, dialect) + _clock(clock_text)
    if nanoseconds > _most(dialect):
        last = "2262-04-11-23:47:16.854775807" if dialect.has_signed_long_times else "2554-07-21-23:34:33.709551615"
        raise LiteralError(f"{text} is out of range", f"1970-01-01-00:00:00 to {last}")
    return nanoseconds


def _date_and_clock(text: str) -> tuple[str, str]:
    date_text, _, clock_text = text.rpartition("-")
    if text.count("-") != 3:
        raise LiteralError(f"{text or 'nothing'} is not a date with a time", "such as DT#1998-02-13-14:20:00")
    return date_text, clock_text
