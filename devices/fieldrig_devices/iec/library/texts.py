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
from typing import Final

from fieldrig_devices.iec.library import reals
from fieldrig_devices.iec.types import Elementary, Value

LONGEST: Final = 40
"""No text of a value is longer."""

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
    Elementary.DATE: _date_text,
    Elementary.TOD: _tod_text,
    Elementary.DT: _dt_text,
}


def writer(kind: Elementary) -> Callable[..., str]:
    return _WRITERS.get(kind, str)


# ---- text to values

_INTEGER: Final = re.compile(r"(?a:[+-]?\d+(?:_\d+)*)")
_BASED: Final = re.compile(r"(?a:(2|8|16)#([0-9a-fA-F]+(?:_[0-9a-fA-F]+)*))")
_REAL: Final = re.compile(r"(?a:[+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d{1,4})?)")
_TIME: Final = re.compile(
    r"(?ai:(?:T|TIME)#(?=\d)(?:(\d+)d_?)?(?:(\d+)h_?)?(?:(\d+)m(?!s)_?)?(?:(\d+)s_?)?(?:(\d+)ms)?)"
)
_DAY: Final = r"(\d{4})-(\d{1,2})-(\d{1,2})"
_CLOCK: Final = r"(\d{1,2}):(\d{1,2})(?::(\d{1,2})(?:\.(\d{1,3}))?)?"
_DATE: Final = re.compile(rf"(?ai:(?:D|DATE)#{_DAY})")
_TOD: Final = re.compile(rf"(?ai:(?:TOD|TIME_OF_DAY)#{_CLOCK})")
_DT: Final = re.compile(rf"(?ai:(?:DT|DATE_AND_TIME)#{_DAY}-{_CLOCK})")
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


def _read_time(text: str) -> int | None:
    """Only the highest component that is given may exceed its unit [X9]."""
    found = _TIME.fullmatch(text.strip())
    if not found:
        return None
    given = [(int(count), size_ms) for count, (_, size_ms) in zip(found.groups(), _UNITS, strict=True) if count]
    limits = {3_600_000: 24, 60_000: 60, 1_000: 60, 1: 1_000}
    if any(count >= limits[size_ms] for count, size_ms in given[1:]):
        return None
    return sum(count * size_ms for count, size_ms in given)


def _day_s(year: str, month: str, day: str) -> int:
    """Seconds from 1970 to the day; ValueError if there is no such day."""
    return (datetime(int(year), int(month), int(day), tzinfo=UTC) - _EPOCH) // timedelta(seconds=1)


def _clock_ms(hour: str, minute: str, second: str | None, fraction: str | None) -> int:
    """Milliseconds since midnight; ValueError if there is no such time."""
    counts = int(hour), int(minute), int(second or 0)
    if counts > (23, 59, 59) or counts[1] > 59 or counts[2] > 59:
        raise ValueError(f"{hour}:{minute}:{second}")
    return ((counts[0] * 60 + counts[1]) * 60 + counts[2]) * 1_000 + int((fraction or "").ljust(3, "0"))


def _read_by(form: re.Pattern[str], value: Callable[..., int]) -> Callable[[str], int | None]:
    def read(text: str) -> int | None:
        found = form.fullmatch(text.strip())
        try:
            return value(*found.groups()) if found else None
        except ValueError:
            return None

    return read


def _dt_s(*parts: str) -> int:
    return _day_s(*parts[:3]) + _clock_ms(*parts[3:]) // 1_000


_READERS: Final[dict[Elementary, Callable[[str], int | None]]] = {
    Elementary.TIME: _read_time,
    Elementary.DATE: _read_by(_DATE, _day_s),
    Elementary.TOD: _read_by(_TOD, _clock_ms),
    Elementary.DT: _read_by(_DT, _dt_s),
}


def reader(kind: Elementary) -> Callable[[str], Value]:
    """Return the function that reads a text as a value of the type; 0 if it is not one."""
    if kind is Elementary.BOOL:
        return _read_bool
    if kind is Elementary.REAL:
        return lambda text: reals.single(_read_real(text))
    if kind is Elementary.LREAL:
        return _read_real
    read = _READERS.get(kind, _read_integer)

    def in_range(text: str) -> int:
        value = read(text)
        return value if value is not None and kind.low <= value <= kind.high else 0

    return in_range
