"""The accuracy of the PWM outputs (SCU-072).  The emulated output is exact; a test of a machine may use these bands."""

from typing import Final, NamedTuple


class Band(NamedTuple):
    """A row of the manual's table."""

    upto: int
    """Highest frequency, in 0.1 Hz."""
    lowest_duty: int
    highest_duty: int
    """In %.  Outside these the error is larger, but no duty from 0 to 100 is refused."""
    error: float
    """Largest error of the duty, in per cent of the period."""


BANDS: Final = (
    Band(1_000, 0, 100, 0.1),
    Band(10_000, 1, 99, 1.0),
    Band(200_000, 5, 95, 5.0),
    Band(450_000, 10, 90, 10.0),
    Band(650_000, 15, 85, 15.0),
)


def band(frequency: int) -> Band:
    """Return the band of a frequency from 100 to 650000, in 0.1 Hz."""
    return next(band for band in BANDS if frequency <= band.upto)
