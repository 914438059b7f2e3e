"""The configuration of a PTO channel: its keys in a rig file with their limits and defaults.

Source: manual 415 to 440 (SCU-009 to SCU-027), digest 2.2.  Keys from `hand_over_ms` on choose between readings where
the manual is silent or contradicts itself.
"""

from collections.abc import Iterator
from typing import Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.settings import Settings, WrongKey, refuse_all

HIGHEST_FREQUENCY_HZ: Final = 50_000
LONGEST_RAMP_MS: Final = 49_999
STEEPEST_RAMP_HZ_PER_MS: Final = 50_000
LOWEST_RATE_HZ_PER_S: Final = 1_000
"""Rates that a calculation finds below this are raised to it (SCU-089)."""
LARGEST_DISTANCE: Final = 2**32 - 1
"""Pulses of one move (SCU-035)."""

_RAMPS: Final = ("acceleration_max", "deceleration_max", "fast_stop")
_RAMP_LIMITS: Final = {"ms": LONGEST_RAMP_MS, "Hz/ms": STEEPEST_RAMP_HZ_PER_MS}
_RAMP_DEFAULTS: Final = {"ms": (20, 20, 100), "Hz/ms": (2_500, 2_500, 500)}


class PtoSettings(Settings):
    """A channel that gives a pulse train with a direction.  Only channel 0 can; it uses both fast outputs."""

    mode: Literal["pto"]
    variable: str = Field(
        default="PTO00",
        pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,79}$",
        description="name of the PTOSimple instance, of letters, digits and _",
    )
    output_mode: Literal["pulse/direction", "direction/pulse"] = Field(
        default="pulse/direction", description="signals of output 0 and output 1"
    )
    ramp_unit: Literal["ms", "Hz/ms"] = Field(default="ms", description="unit of accelerations and decelerations")
    acceleration_max: int | None = Field(
        default=None, ge=1, le=50_000, description="shortest time in ms (default 20), or steepest rate in Hz/ms (2500)"
    )
    deceleration_max: int | None = Field(
        default=None, ge=1, le=50_000, description="shortest time in ms (default 20), or steepest rate in Hz/ms (2500)"
    )
    fast_stop: int | None = Field(
        default=None,
        ge=1,
        le=50_000,
        description="time from the maximum frequency in ms (default 100), or rate in Hz/ms (500)",
    )
    start_frequency_hz: int = Field(
        default=0, ge=0, le=HIGHEST_FREQUENCY_HZ, description="0: the mean frequency of the first period from rest"
    )
    stop_frequency_hz: int = Field(
        default=0, ge=0, le=HIGHEST_FREQUENCY_HZ, description="0: the mean frequency of the last period to rest"
    )
    maximum_frequency_hz: int = Field(default=HIGHEST_FREQUENCY_HZ, ge=1, le=HIGHEST_FREQUENCY_HZ)
    aux: Literal["not_used", "drive_ready"] = Field(default="not_used", description="use of input DI2")
    aux_filter_ms: Literal[3, 12] = 3
    hand_over_ms: int | None = Field(
        default=None,
        ge=0,
        le=1_000,
        description="time at the present frequency before an accepted command replaces another; default: a MAST cycle",
    )
    stop_reports: Literal["done", "aborted"] = Field(
        default="done", description="what a PTOMoveRelative reports that PTOStop ends"
    )
    fast_stop_cap: Literal["shutdown", "all"] = Field(
        default="shutdown", description="fast stops that end after 6 s: those of a shutdown only, or all"
    )
    positive_level: bool = Field(default=True, description="level of the direction output in positive direction")
    ramps: Literal["smooth", "periods"] = Field(
        default="periods",
        description="periods: each pulse high for half of its period, with a rounded frequency, as the guide has them; "
        "smooth: a segment per ramp, exact by the formulas",
    )

    @model_validator(mode="after")
    def _fits(self) -> Self:
        refuse_all(self._wrong())
        return self

    def _wrong(self) -> Iterator[WrongKey]:
        for key in _RAMPS:
            value, most = getattr(self, key), _RAMP_LIMITS[self.ramp_unit]
            if value is not None and value > most:
                yield WrongKey((key,), f"{value} is too large", f"expected 1 to {most} {self.ramp_unit}")
        for key in ("start_frequency_hz", "stop_frequency_hz"):
            value = getattr(self, key)
            if value > self.maximum_frequency_hz:
                remedy = f"expected 0 to {self.maximum_frequency_hz} (maximum_frequency_hz)"
                yield WrongKey((key,), f"{value} is too large", remedy)

    @property
    def limits(self) -> tuple[int, int, int]:
        """Return acceleration_max, deceleration_max and fast_stop in the ramp unit, with their defaults."""
        first, second, third = _RAMP_DEFAULTS[self.ramp_unit]
        return (
            first if self.acceleration_max is None else self.acceleration_max,
            second if self.deceleration_max is None else self.deceleration_max,
            third if self.fast_stop is None else self.fast_stop,
        )


def converted(value: int, maximum_frequency_hz: int, most: int) -> int:
    """Return a ramp in the other unit, as the configuration window converts it (SCU-013); at most `most`.

    A time in ms becomes a rate in Hz/ms, and a rate a time, by the ramp from 0 Hz to the maximum frequency.
    """
    return min(max(round(maximum_frequency_hz / value), 1), most)
