"""The error word of an axis (PAMS-049), whose bytes C and D the parameter CMASKS masks.

The bits of supplies, resolver and power stage are those of what is there at present; the others are latched.
"""

from collections.abc import Mapping
from typing import Final

from fieldrig.faults.faults import Timed
from fieldrig_devices.pamring.axis_words import ERROR_MASK, Error
from fieldrig_devices.st1.faults import (
    MotorTemperature,
    Overload,
    OverVoltage,
    PowerStage,
    Resolver,
    ServoReset,
    St1Faults,
    Supply,
)

LOW_WORD: Final = 0xFFFF
"""C and D."""
TRIPS: Final = (
    Error.POWER_STAGE_DISABLED
    | Error.SERVO_LAG_ERROR
    | Error.RESOLVER_FAILURE
    | Error.OVER_VOLTAGE
    | Error.POWER_STAGE_OVERLOAD
    | Error.INT_SUPPLY_FAILURE
    | Error.AUX_SUPPLY_FAILURE
    | Error.SERVO_RESET
)
"""The errors that usually switch the power stage off (our choice; the manual names none, and a setting others)."""
BITS: Final[Mapping[type[Timed], Error]] = {
    PowerStage: Error.POWER_STAGE_DISABLED,
    Resolver: Error.RESOLVER_FAILURE,
    OverVoltage: Error.OVER_VOLTAGE,
    Overload: Error.POWER_STAGE_OVERLOAD,
    MotorTemperature: Error.MOTOR_TEMPERATURE,
    ServoReset: Error.SERVO_RESET,
}
SUPPLIES: Final = {"internal": Error.INT_SUPPLY_FAILURE, "auxiliary": Error.AUX_SUPPLY_FAILURE}


def bits_of(faults: St1Faults) -> int:
    """Return the bits of the faults that are on at present."""
    bits = 0
    for kind, bit in BITS.items():
        if faults.first(kind) is not None:
            bits |= bit
    for supply in faults.active(Supply):
        bits |= SUPPLIES[supply.of]
    return bits


class ErrorWord:
    """The bits that are on, and those that stay on."""

    def __init__(self, cmasks: int) -> None:
        self._mask = ERROR_MASK & ~LOW_WORD | ERROR_MASK & cmasks
        self.present = 0
        """Bits whose causes are there at present."""
        self.shown = 0
        """Bits that are shown without an effect."""
        self._latched = 0

    @property
    def value(self) -> int:
        return int((self.present | self.shown | self._latched) & self._mask)

    def put(self, bits: int) -> None:
        """Take the causes of the present instant; a change of C or D sets its bit until the status is updated."""
        changed = (bits ^ self.present) & self._mask & LOW_WORD
        self.present = bits
        if changed:
            self._latched |= Error.CHANGE_IN_CD

    def latch(self, bits: int) -> None:
        """Set bits that stay until power-on."""
        self._latched |= bits

    def clear(self, bits: int = -1) -> None:
        self._latched &= ~bits
