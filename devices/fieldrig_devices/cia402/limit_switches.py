"""The effect of limit switches outside of homing, as far as it differs among drives.

Source: CiA 402-2, 60FDh bits 0 and 1, whose effect is left to the drive; `motion.travel` has the usual one.
"""

from fieldrig_devices.cia402.behaviour import LimitSwitch
from fieldrig_devices.cia402.motor import Motor, Switch

LIMITS = Switch.NEGATIVE_LIMIT | Switch.POSITIVE_LIMIT


class BarringSwitches:
    """The inputs that bar a direction: those of the motor, or none for a drive whose switches bar nothing."""

    def __init__(self, motor: Motor, effect: LimitSwitch) -> None:
        self._motor, self._is_barring = motor, effect not in (LimitSwitch.SHOWN, LimitSwitch.IGNORED)

    @property
    def inputs(self) -> int:
        """Active switches as bits, as in 60FDh."""
        return self._motor.inputs if self._is_barring else 0


class NewSwitches:
    """Tells when a limit switch becomes active."""

    def __init__(self, motor: Motor) -> None:
        self._motor = motor
        self._before = 0

    def is_new(self) -> bool:
        """True if a limit switch has become active since the last call."""
        now = self._motor.inputs & LIMITS
        new, self._before = now & ~self._before, now
        return new != 0
