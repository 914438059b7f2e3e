"""Passages of the manual about the ST1 that can be read in two ways, and facts of a machine that it leaves out."""

from typing import Final, Literal, get_args

from pydantic import Field

from fieldrig.settings import Settings
from fieldrig_devices.pamring.axis_words import Error
from fieldrig_devices.st1.status import TRIPS

Trip = Literal[
    "SERVO_LAG_ERROR",
    "RESOLVER_FAILURE",
    "OVER_VOLTAGE",
    "POWER_STAGE_OVERLOAD",
    "INT_SUPPLY_FAILURE",
    "AUX_SUPPLY_FAILURE",
    "COMMUNICATION_FAILURE",
    "MOTOR_TEMPERATURE",
    "CURRENT_LIMITED",
    "OUT_OF_LIMITS",
    "SERVO_RESET",
]
"""The errors that may switch the power stage off; one that is disabled is off in any case."""
USUAL: Final[list[Trip]] = [name for name in get_args(Trip) if Error[name] & TRIPS]


class St1Readings(Settings):
    """The defaults are the likelier readings."""

    trips: list[Trip] = Field(
        default_factory=lambda: list(USUAL), description="errors that switch the power stage off, by their names"
    )
    power_stage_disabled: Literal["refused", "off"] = Field(
        default="refused",
        description="error bit POWER_STAGE_DISABLED of an axis without power: from the first order that is refused on, "
        "or as long as the power is off",
    )
    stopped: Literal["at_rest", "after_stop"] = Field(
        default="at_rest",
        description="status bit STOPPED: as long as neither an order nor a pipe moves the axis, or only after a stop",
    )
    on_pam_reset: Literal["stop_and_power_off", "stop"] = Field(
        default="stop_and_power_off", description="an axis with power when the PAM configures its node again"
    )
    time_stamps: Literal["IN16", "all"] = Field(
        default="all", description="inputs whose reports say how long ago the level changed"
    )

    @property
    def tripping(self) -> int:
        """The bits of the errors that switch the power stage off."""
        bits = int(Error.POWER_STAGE_DISABLED)
        for name in self.trips:
            bits |= Error[name]
        return bits
