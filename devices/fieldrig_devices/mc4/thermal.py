"""How warm motor and amplifier get, and how long they may be overloaded.

Source: manual 6959 (rated torque warms the casing by 40 K), 7097 (thermo contact in the winding), 525 and 534 (250 % of
the amplifier, 4-fold of the motor); digest PD-176.  Losses go with the square of the current.  The overload model is an
I2t: a first-order mean of the squared load, 1 where it switches off; the winding is another one upon the casing.  The
time constants that the manual doesn't give are chosen so that the amplifier holds 250 % for one second, and the motor
its 4-fold for about four.
"""

from dataclasses import dataclass
from math import exp
from typing import Final

AMBIENT_C: Final = 25.0
CASING_RISE_K: Final = 40.0
WINDING_RISE_K: Final = 40.0
"""Of the winding over the casing, at rated torque."""
WINDING_S: Final = 60.0
AMPLIFIER_RISE_K: Final = 35.0
"""At the continuous current."""
AMPLIFIER_S: Final = 240.0
AMPLIFIER_LIMIT_C: Final = 80.0
AMPLIFIER_OVERLOAD_S: Final = 5.73
MOTOR_OVERLOAD_S: Final = 62.0
WARNING_SHARE: Final = 0.9
"""Of the way to a limit, from where on it is a warning (S-0-0012)."""


@dataclass
class Mean:
    """Goes to what it is given, with its time constant."""

    time_s: float
    value: float = 0.0
    seconds: float = 0.0
    decay: float = 1.0
    """Over `seconds`."""

    def go(self, seconds: float, goal: float) -> None:
        if seconds != self.seconds:
            self.seconds, self.decay = seconds, exp(-seconds / self.time_s)
        self.value = goal + (self.value - goal) * self.decay


class Thermal:
    def __init__(self, continuous_nm: float, amplifier_nm: float, winding_limit_c: float, casing_s: float) -> None:
        """The motor's continuous torque, and that at the amplifier's continuous current."""
        self._continuous, self._amplifier = continuous_nm**2, amplifier_nm**2
        self.winding_limit_c = winding_limit_c
        self.ambient_c = AMBIENT_C
        self._casing, self._winding = Mean(casing_s), Mean(WINDING_S)
        self._heatsink = Mean(AMPLIFIER_S)
        self._motor_load, self._amplifier_load = Mean(MOTOR_OVERLOAD_S), Mean(AMPLIFIER_OVERLOAD_S)

    def go(self, seconds: float, torque_squared: float) -> None:
        """Some time further, with this mean of the squared torque."""
        motor, amplifier = torque_squared / self._continuous, torque_squared / self._amplifier
        self._casing.go(seconds, CASING_RISE_K * motor)
        self._winding.go(seconds, WINDING_RISE_K * motor)
        self._heatsink.go(seconds, AMPLIFIER_RISE_K * amplifier)
        self._motor_load.go(seconds, motor)
        self._amplifier_load.go(seconds, amplifier)

    @property
    def casing_c(self) -> float:
        return self.ambient_c + self._casing.value

    @property
    def motor_c(self) -> float:
        """Of the winding."""
        return self.casing_c + self._winding.value

    @property
    def amplifier_c(self) -> float:
        return self.ambient_c + self._heatsink.value

    @property
    def overload(self) -> float:
        """1: switch off."""
        return max(self._motor_load.value, self._amplifier_load.value)

    @property
    def motor_load(self) -> float:
        return self._motor_load.value

    @property
    def amplifier_load(self) -> float:
        return self._amplifier_load.value

    @property
    def is_motor_hot(self) -> bool:
        return self.motor_c >= self.winding_limit_c

    @property
    def is_amplifier_hot(self) -> bool:
        return self.amplifier_c >= AMPLIFIER_LIMIT_C

    @property
    def warnings(self) -> int:
        """S-0-0012: bit 0 overload, 1 amplifier, 2 motor."""
        motor = self.motor_c >= AMBIENT_C + WARNING_SHARE * (self.winding_limit_c - AMBIENT_C)
        amplifier = self.amplifier_c >= AMBIENT_C + WARNING_SHARE * (AMPLIFIER_LIMIT_C - AMBIENT_C)
        return (self.overload >= WARNING_SHARE) | amplifier << 1 | motor << 2
