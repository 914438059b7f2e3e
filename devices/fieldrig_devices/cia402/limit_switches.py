"""Limit switches: which direction of an axis is barred.

Source: CiA 402-2, 60FDh bits 0 and 1; what they do outside of homing is left to the drive.  Ours: an axis that goes
onto one is stopped with the quick stop deceleration (6085h) in 'operation enabled'; the direction stays barred, also
when the switch was overrun, until the axis is to go the other way or nowhere.
"""

from typing import Final

from fieldrig_devices.cia402.motor import Motor, Switch

POSITIVE, NEGATIVE = int(Switch.POSITIVE_LIMIT), int(Switch.NEGATIVE_LIMIT)
_SWITCHES: Final = POSITIVE | NEGATIVE


class LimitSwitches:
    def __init__(self, motor: Motor) -> None:
        self._motor = motor
        self.held = 0
        """The bit of the switch that holds the axis."""

    def bars(self, direction: float, others: int = 0) -> bool:
        """Whether the axis may not go on; its sign counts.  `others` bar like active switches."""
        active = self._motor.inputs & _SWITCHES | self.held | others
        if not active:
            return False
        self.held = active & (POSITIVE if direction > 0 else NEGATIVE if direction < 0 else 0)
        return bool(self.held)

    def release(self) -> None:
        """Another mode begins."""
        self.held = 0
