"""The words of an axis: the error word of table 12-1 and the status word of table 12-4 (PAMS-049, PAMS-055).

The error word is the status word ABCD of the ST1, of which A is the highest byte and the parameter CMASKS has masked
C and D.  The bits of supplies, resolver and power stage are those of what is there at present; the others are latched
as `Latch` says.
"""

from collections.abc import Mapping
from enum import IntFlag
from typing import Final

from fieldrig.faults import Timed
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


class Error(IntFlag):
    POWER_STAGE_DISABLED = 0x8000_0000
    CHANGE_IN_CD = 0x4000_0000
    SERVO_LAG_ERROR = 0x1000_0000
    RESOLVER_FAILURE = 0x0080_0000
    OVER_VOLTAGE = 0x0040_0000
    POWER_STAGE_OVERLOAD = 0x0020_0000
    INT_SUPPLY_FAILURE = 0x0010_0000
    AUX_SUPPLY_FAILURE = 0x0008_0000
    COMMUNICATION_FAILURE = 0x0000_1000
    MOTOR_TEMPERATURE = 0x0000_0080
    CURRENT_LIMITED = 0x0000_0040
    OUT_OF_LIMITS = 0x0000_0010
    SERVO_RESET = 0x0000_0002


class Status(IntFlag):
    SYNCHRONISED = 1
    """A pipe drives the axis."""
    IN_MOVE = 2
    IN_RUN = 4
    POWER_OFF = 16
    STOPPED = 32
    """Neither an order nor a pipe moves the axis (our reading; a setting has another one)."""


MASK: Final = 0xD0F8_FFFF
"""The bits of ABCD that PAM shows (8786-8823)."""
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
        self._mask = MASK & ~LOW_WORD | MASK & cmasks
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
