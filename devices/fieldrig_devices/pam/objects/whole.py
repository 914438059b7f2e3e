"""Whole numbers for frames: values that no frame can carry are limited."""

from typing import Final

LARGEST_UNITS: Final = 1 << 62
"""Resolver units in frames, in both directions."""
LARGEST_COUNT: Final = (1 << 31) - 1
"""Pulses of a DC motor, in both directions."""


def nearest_units(value: float) -> int:
    """Return resolver units, rounded and limited."""
    return round(max(min(value, LARGEST_UNITS), -LARGEST_UNITS))


def whole_count(value: float) -> int:
    """Return pulses, with their fraction dropped, and limited."""
    return int(max(min(value, LARGEST_COUNT), -LARGEST_COUNT))
