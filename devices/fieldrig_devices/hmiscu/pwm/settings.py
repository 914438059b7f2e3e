"""The configuration of a PWM channel (SCU-073, digest 2.3)."""

from typing import Final, Literal

from pydantic import Field

from fieldrig.settings import Settings

LOWEST_FREQUENCY: Final = 100
HIGHEST_FREQUENCY: Final = 650_000
"""Limits of the pin Frequency, in 0.1 Hz (SCU-070)."""


class PwmSettings(Settings):
    """A channel that gives a PWM signal on its own fast output."""

    mode: Literal["pwm"]
    variable: str | None = Field(
        default=None,
        pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,79}$",
        description="name of the PWM instance, of letters, digits and _; default: PWM00 or PWM01",
    )
    enable_input: bool = Field(default=False, description="whether the input IN_EN is used")
    enable_filter_ms: Literal[3, 12] = 3
    sync_input: bool = Field(default=False, description="whether the input IN_SYNC is used")
    sync_filter_ms: Literal[3, 12] = 3
    sync_edge: Literal["rising", "falling", "both"] = "rising"
