"""Values as text and back: *_TO_STRING and STRING_TO_*.

A text that is not a value of the target type gives 0 (PacDrive manual 2710 to 2724), also if the value is out of range.
Times are written like their literals, from the first component that is not 0 to the last, since the manual writes
DT#1998-02-13-14:20 without seconds; a duration of 0 is T#0ms.  A REAL has seven significant digits and always a point
or an exponent, as in the watch window of CoDeSys V2.3.
"""

import math
import re
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from functools import partial
from typing import Final

from fieldrig_devices.iec import characters, literal_texts, literals
from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4
from fieldrig_devices.iec.elementary import LONG_TIMES, Elementary, Family
from fieldrig_devices.iec.library import reals
from fieldrig_devices.iec.types import Value

LONGEST: Final = 40
"""No text of a value is longer."""

_E: Final = Elementary
_EPOCH: Final = datetime(1970, 1, 1, tzinfo=UTC)
_UNITS: Final = (("d", 86_400_000), ("h", 3_600_000), ("m", 60_000), ("s", 1_000), ("ms", 1))
"""The components of a duration, in ms."""


# ---- values to text


def _bool_text(value: bool) -> str:
    return "TRUE" if value else "FALSE"


def _real_text(digits: int) -> Callable[[float], str]:
    def text(value: float) -> str:
        if not math.isfinite(value):
            return "1.#QNAN" if math.isnan(value) else "1.#INF" if value > 0 else "-1.#INF"
        short = f"{value:.{digits}g}"
        return short if "." in short or "e" in short else f"{short}.0"

    return text


def time_text(value_ms: int) -> str:
    parts: list[str] = []
    rest = value_ms
    for unit, size_ms in _UNITS:
        count, rest = divmod(rest, size_ms)
        if count or parts:
            parts.append(f"{count}{unit}")
        if parts and not rest:
            break
    return f"T#{''.join(parts) or '0ms'}"


def _signed_time_text(value_ms: int) -> str:
    return time_text(value_ms) if value_ms >= 0 else time_text(-value_ms).replace("#", "#-")


def _date_text(value_s: int) -> str:
    return f"D#{_EPOCH + timedelta(seconds=value_s):%Y-%m-%d}"


def _tod_text(value_ms: int) -> str:
    return f"TOD#{_clock_text(value_ms)}"


def _dt_text(value_s: int) -> str:
    days, seconds = divmod(value_s, 86_400)
    return f"DT#{_EPOCH + timedelta(days=days):%Y-%m-%d}-{_clock_text(seconds * 1_000)}"


def _clock_text(value_ms: int) -> str:
    minutes, milliseconds = divmod(value_ms, 60_000)
    text = f"{minutes // 60:02}:{minutes % 60:02}"
    if milliseconds:
        text += f":{milliseconds // 1_000:02}"
    return f"{text}.{milliseconds % 1_000:03}" if milliseconds % 1_000 else text


_WRITERS: Final[dict[Elementary, Callable[..., str]]] = {
    Elementary.BOOL: _bool_text,
    Elementary.REAL: _real_text(7),
    Elementary.LREAL: _real_text(15),
    Elementary.TIME: time_text,
    Elementary.SIGNED_TIME: _signed_time_text,
    Elementary.DATE: _date_text,
    Elementary.TOD: _tod_text,
    Elementary.DT: _dt_text,
    **dict.fromkeys(LONG_TIMES, literal_texts.long_time_text),
    **{
        kind: partial(literal_texts.date_text, str(kind), unit_ns=1)
        for kind in (_E.LDATE, _E.LTOD, _E.LDT, _E.UNSIGNED_LDATE, _E.UNSIGNED_LDT)
    },
    Elementary.CHAR: chr,
    Elementary.WCHAR: characters.of_code,
}


def todays_real_text(kind: Elementary, value: float) -> str:
    """Return a number as CODESYS V3 and TwinCAT write it, 3.402823E38."""
    mantissa, mark, exponent = _WRITERS[kind](value).partition("e")
    return f"{mantissa if '.' in mantissa else mantissa + '.0'}E{int(exponent)}" if mark else mantissa


def todays_dt_text(value_s: int) -> str:
    """Return a date as they write it, with its seconds."""
    return literal_texts.date_text("DT", value_s, literal_texts.S_NS)


def writer(kind: Elementary) -> Callable[..., str]:
    return _WRITERS.get(kind, str)


# ---- text to values

_INTEGER: Final = re.compile(r"(?a:[+-]?\d+(?:_\d+)*)")
_BASED: Final = re.compile(r"(?a:(2|8|16)#([0-9a-fA-F]+(?:_[0-9a-fA-F]+)*))")
_REAL: Final = re.compile(r"(?a:[+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d{1,4})?)")
_TIMES: Final[dict[Elementary, tuple[tuple[str, str], Callable[[str], int]]]] = {
    Elementary.TIME: (("T", "TIME"), lambda text: literals.time(text, EPAS_4)),
    Elementary.SIGNED_TIME: (("T", "TIME"), lambda text: literals.time(text, EDITION_3)),
    Elementary.DATE: (("D", "DATE"), literals.day),
    Elementary.TOD: (("TOD", "TIME_OF_DAY"), literals.time_of_day),
    Elementary.DT: (("DT", "DATE_AND_TIME"), literals.date_and_time),
    Elementary.LTIME: (("LT", "LTIME"), lambda text: literals.long_time(text, EDITION_3)),
    Elementary.UNSIGNED_LTIME: (("LT", "LTIME"), lambda text: literals.long_time(text, CODESYS)),
    Elementary.LDATE: (("LD", "LDATE"), lambda text: literals.long_day(text, EDITION_3)),
    Elementary.UNSIGNED_LDATE: (("LD", "LDATE"), lambda text: literals.long_day(text, CODESYS)),
    Elementary.LTOD: (("LTOD", "LTIME_OF_DAY"), literals.long_time_of_day),
    Elementary.LDT: (("LDT", "LDATE_AND_TIME"), lambda text: literals.long_date_and_time(text, EDITION_3)),
    Elementary.UNSIGNED_LDT: (
        ("LDT", "LDATE_AND_TIME"),
        lambda text: literals.long_date_and_time(text, CODESYS),
    ),
}
"""The words in front of # in a literal, and the function that reads the part behind it."""
_LONGEST_NUMBER: Final = 100
"""Longer digits are no value of any type."""


def _read_bool(text: str) -> bool:
    return text.strip().upper() == "TRUE"


def _read_integer(text: str) -> int | None:
    number = text.strip()
    if len(number) > _LONGEST_NUMBER:
        return None
    if _INTEGER.fullmatch(number):
        return int(number)
    based = _BASED.fullmatch(number)
    try:
        return int(based[2], int(based[1])) if based else None
    except ValueError:
        return None  # such as 2#3


def _read_real(text: str) -> float:
    return float(text) if _REAL.fullmatch(text := text.strip()) else 0.0


def _time_reader(kind: Elementary, of: Callable[[str], int] | None = None) -> Callable[[str], int | None]:
    """Return the reader of texts of a type; `of` reads what is behind # in another way."""
    prefixes, usual = _TIMES[kind]
    value_of = of or usual

    def read(text: str) -> int | None:
        prefix, _, value = text.strip().partition("#")
        try:
            return value_of(value) if prefix.upper() in prefixes else None
        except literals.LiteralError:
            return None

    return read


def _first_code(most: int, text: str) -> int:
    """Return the code of the first character; 0 if there is none, and that of ? if the type does not have it."""
    code = ord(text[0]) if text else 0
    return code if code <= most else ord("?")


def reader(kind: Elementary) -> Callable[[str], Value]:
    """Return the function that reads a text as a value of the type; 0 if it is not one."""
    if kind is Elementary.BOOL:
        return _read_bool
    if kind.family is Family.CHARACTER:
        return partial(_first_code, kind.high)
    if kind is Elementary.REAL:
        return lambda text: reals.single(_read_real(text))
    if kind is Elementary.LREAL:
        return _read_real
    return _in_range(kind, _time_reader(kind) if kind in _TIMES else _read_integer)


def _in_range(kind: Elementary, read: Callable[[str], int | None]) -> Callable[[str], int]:
    def in_range(text: str) -> int:
        value = read(text)
        return value if value is not None and kind.low <= value <= kind.high else 0

    return in_range


todays_time: Final = _in_range(_E.TIME, _time_reader(_E.TIME, lambda text: literals.time(text, CODESYS)))
"""Read a TIME as CODESYS V3 and TwinCAT know it, with fractions and with units that overflow."""
