"""The temperatures of motor and amplifier, and their overload models.

Source: manual 6959 (rated torque warms the casing by 40 K), 7097 (thermo contact in the winding), 525 and 534 (250 % of
the amplifier, 4-fold of the motor); digest PD-176.  Losses are proportional to the square of the current.  The
overload model is an I2t model: a first-order mean of the squared load, which switches off at 1.  Casing and winding are
first-order models too.  Time constants that the manual does not give are chosen so that the amplifier withstands 250 %
for one second, and the motor its 4-fold torque for about four.
"""

from math import exp
from typing import Final

AMBIENT_C: Final = 25.0
CASING_RISE_K: Final = 40.0
WINDING_RISE_K: Final = 40.0
"""Temperature rise of the winding above the casing, at rated torque."""
WINDING_S: Final = 60.0
AMPLIFIER_RISE_K: Final = 35.0
"""Temperature rise at the continuous current."""
AMPLIFIER_S: Final = 240.0
AMPLIFIER_LIMIT_C: Final = 80.0
AMPLIFIER_OVERLOAD_S: Final = 5.73
MOTOR_OVERLOAD_S: Final = 62.0
WARNING_SHARE: Final = 0.9
"""Fraction of a limit at which a warning begins (S-0-0012)."""


class Thermal:
    """The temperatures and loads of a drive."""

    def __init__(self, continuous_nm: float, amplifier_nm: float, winding_limit_c: float, casing_s: float) -> None:
        """`continuous_nm` is for the motor; `amplifier_nm` is the torque at the amplifier's continuous current."""
        self._continuous, self._amplifier = continuous_nm**2, amplifier_nm**2
        self.winding_limit_c = winding_limit_c
        self.ambient_c = AMBIENT_C
        self._times_s = (casing_s, WINDING_S, AMPLIFIER_S, MOTOR_OVERLOAD_S, AMPLIFIER_OVERLOAD_S)
        self._casing_k = self._winding_k = self._heatsink_k = 0.0
        """Temperature rises: casing above ambient, winding above casing, heat sink above ambient."""
        self.motor_load = self.amplifier_load = 0.0
        """Overload; 1 switches off."""
        self._seconds = 0.0
        self._decays = (1.0,) * len(self._times_s)
        """Decay of each model over `_seconds`."""

    def go(self, seconds: float, torque_squared: float) -> None:
        """Advance by a time with this mean of the squared torque."""
        if seconds != self._seconds:
            self._seconds, self._decays = seconds, tuple(exp(-seconds / time_s) for time_s in self._times_s)
        casing, winding, heatsink, motor, amplifier = self._decays
        goal = torque_squared / self._continuous
        self._casing_k = CASING_RISE_K * goal + (self._casing_k - CASING_RISE_K * goal) * casing
        self._winding_k = WINDING_RISE_K * goal + (self._winding_k - WINDING_RISE_K * goal) * winding
        self.motor_load = goal + (self.motor_load - goal) * motor
        goal = torque_squared / self._amplifier
        self._heatsink_k = AMPLIFIER_RISE_K * goal + (self._heatsink_k - AMPLIFIER_RISE_K * goal) * heatsink
        self.amplifier_load = goal + (self.amplifier_load - goal) * amplifier

    @property
    def casing_c(self) -> float:
        return self.ambient_c + self._casing_k

    @property
    def motor_c(self) -> float:
        """Temperature of the winding."""
        return self.ambient_c + self._casing_k + self._winding_k

    @property
    def amplifier_c(self) -> float:
        return self.ambient_c + self._heatsink_k

    @property
    def overload(self) -> float:
        """The larger of both overloads; 1 switches off."""
        return max(self.motor_load, self.amplifier_load)

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
