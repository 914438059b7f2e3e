"""Durations as people write them: `10ms`, `1.5 s`, `2min`, `8h`."""

from typing import Final

UNITS_NS: Final = {
    "ns": 1,
    "us": 1_000,
    "ms": 1_000_000,
    "s": 1_000_000_000,
    "min": 60_000_000_000,
    "h": 3_600_000_000_000,
}


def duration_ns(text: str) -> int:
    """Return a duration in nanoseconds.  ValueError for anything but a number of at least 0 with a unit."""
    digits = text.rstrip("abcdefghijklmnopqrstuvwxyz")
    try:
        ns = round(float(digits) * UNITS_NS[text[len(digits) :]])
    except (KeyError, ValueError, OverflowError):
        ns = -1
    if ns < 0:
        raise ValueError(f"{text!r} is not a duration; expected a number with a unit, such as 10ms or 1.5s")
    return ns
