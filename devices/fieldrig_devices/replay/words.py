"""Times and contents in words."""

from typing import Final

from fieldrig.clock import MS, S

LONGEST_SHOWN: Final = 24


def late_words(late_ns: int) -> str:
    """Return `14 ms later`, or `0.5 ms earlier`."""
    return f"{time_words(abs(late_ns))} {'later' if late_ns > 0 else 'earlier'}"


def time_words(time_ns: int) -> str:
    """Return `14 ms`, or `1.5 s`."""
    if time_ns < S:
        return f"{time_ns / MS:.4g} ms"
    return f"{time_ns / S:.4g} s" if time_ns < 9_999 * S else f"{time_ns / S:.0f} s"


def hex_words(data: bytes) -> str:
    """Return bytes in hex; only the first ones of many."""
    shown = data[:LONGEST_SHOWN].hex(" ").upper() or "no data"
    return shown if len(data) <= LONGEST_SHOWN else f"{shown} … {len(data)} bytes"
