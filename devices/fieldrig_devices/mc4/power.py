"""The DC circuit of one drive: rectified mains, a capacitor, a ballast resistor.

Source: manual 6598-6624 (each amplifier has its own supply; rectified and smoothed), 6075 (charged before torque), 365
(5 minutes from mains off to a safe voltage).  The rectifier charges the capacitor through a resistor, and
supplies the motor.  Energy from a braking motor raises the voltage, until the ballast resistor dissipates it.  Our
values: 400 V mains, 1 mF, below 50 V after less than five minutes.
"""

from dataclasses import dataclass
from math import exp, sqrt
from typing import Final

RECTIFIED: Final = sqrt(2)
CHARGED_SHARE: Final = 0.9
UNDER_SHARE: Final = 0.7
OVER_V: Final = 850.0
BALLAST_V: Final = 760.0


@dataclass
class DcCircuit:
    """The state of the DC circuit, in volts."""

    mains_v: float = 400.0
    capacity_f: float = 1e-3
    charge_s: float = 0.15
    discharge_s: float = 110.0
    ballast_ohm: float = 30.0
    is_mains_on: bool = True
    volt: float = 0.0

    @property
    def full_v(self) -> float:
        return self.mains_v * RECTIFIED

    @property
    def is_charged(self) -> bool:
        return self.volt >= CHARGED_SHARE * self.full_v

    @property
    def is_under(self) -> bool:
        return self.volt < UNDER_SHARE * self.full_v

    @property
    def is_over(self) -> bool:
        return self.volt > OVER_V

    def go(self, seconds: float, work_j: float) -> None:
        """Advance by a time in which the motor took `work_j`; a negative value is energy given back."""
        full_v = self.full_v
        self._exchange(work_j, full_v)
        if self.is_mains_on and self.volt < full_v:
            self.volt += (full_v - self.volt) * -_expm1(seconds / self.charge_s)
        elif not self.is_mains_on or self.volt > full_v:
            self.volt *= exp(-seconds / self.discharge_s)
        if self.volt > BALLAST_V:
            burnt = self.volt * exp(-seconds / (self.ballast_ohm * self.capacity_f))
            self.volt = max(burnt, BALLAST_V)

    def _exchange(self, work_j: float, full_v: float) -> None:
        if self.is_mains_on and self.volt >= full_v * CHARGED_SHARE and work_j > 0:
            surplus = self.capacity_f / 2 * (self.volt**2 - full_v**2)
            work_j = min(work_j, max(surplus, 0.0))  # the rest comes from the mains
        if work_j:
            self.volt = sqrt(max(0.0, self.volt**2 - 2 * work_j / self.capacity_f))


def _expm1(ratio: float) -> float:
    return exp(-ratio) - 1.0
