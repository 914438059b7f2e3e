"""The words that an ST1 sends about its axis, as bits (PAMS-049, PAMS-055).

Errors are those of table 12-1, and the status is that of table 12-4.  The error word is the status word ABCD of the
ST1, of which A is the highest byte.
"""

from enum import IntFlag
from typing import Final


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


ERROR_MASK: Final = 0xD0F8_FFFF
"""The bits of ABCD that PAM shows (8786-8823)."""
