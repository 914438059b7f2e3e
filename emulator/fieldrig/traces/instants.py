"""Instants and spans of a trace in words, for people."""

import time
from functools import lru_cache

from fieldrig.clock import MS, US, S
from fieldrig.traces.trace import is_time_of_day


def instant(time_ns: int) -> str:
    """Return the time of day, or seconds for virtual time, which starts at 0."""
    return instant_in_column(time_ns).strip() + ("" if is_time_of_day(time_ns) else " s")


def instant_in_column(time_ns: int) -> str:
    """Return the same without the unit, and of one width."""
    seconds, fraction_ns = divmod(time_ns, S)
    clock = _clock(seconds) if is_time_of_day(time_ns) else f"{seconds:8}"
    return f"{clock}.{fraction_ns // 1000:06}"


@lru_cache(maxsize=16)
def _clock(seconds: int) -> str:
    try:
        return time.strftime("%H:%M:%S", time.localtime(seconds))
    except (ValueError, OverflowError, OSError):  # a damaged log has years beyond every calendar
        return f"{seconds:8}"


def span(duration_ns: int) -> str:
    """Return `850 us`, `12.3 ms` or `1.25 s`: three digits in the unit that suits the span, and six of seconds."""
    for unit_ns, unit, digits in ((S, "s", 6), (MS, "ms", 3), (US, "us", 3)):
        if abs(duration_ns) >= 0.9995 * unit_ns:  # 999.6 us are 1 ms, as 1000 has four digits
            return f"{_plain(duration_ns / unit_ns, digits)} {unit}"
    return f"{duration_ns} ns"


def _plain(value: float, digits: int) -> str:
    """Return a number with its first `digits` digits, or all of those before its point; never in powers of ten."""
    return f"{value:.{digits}g}" if abs(value) < 10**digits - 0.5 else f"{value:.0f}"
