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
LONGEST_NS: Final = 146 * 365 * 24 * UNITS_NS["h"]
"""Longest duration: a clock never reaches an instant that is later."""


def duration_ns(text: str) -> int:
    """Return a duration in nanoseconds.  ValueError for anything but a number from 0 to `LONGEST_NS` with a unit."""
    digits = text.rstrip("abcdefghijklmnopqrstuvwxyz")
    try:
        ns = round(float(digits) * UNITS_NS[text[len(digits) :]])
    except (KeyError, ValueError, OverflowError):
        ns = -1
    if ns < 0:
        raise ValueError(f"{text!r} is not a duration; expected a number with a unit, such as 10ms or 1.5s")
    if ns > LONGEST_NS:
        raise ValueError(f"{text!r} is too long; expected at most {LONGEST_NS // UNITS_NS['h']}h, which is 146 years")
    return ns
