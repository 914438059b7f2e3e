"""The torque of the motor, and what it gives."""

from math import tau

from fieldrig_devices.st1.settings import MotorSettings
from fieldrig_devices.st1.shaft import TURN


class Torque:
    def __init__(self, motor: MotorSettings) -> None:
        self._motor = motor
        self.limit = 1.0
        """The limit of a pipe in the mode TORQUE, as a part of the largest torque."""
        self.load_nm = 0.0
        """Torque of the load at the motor, which acts like friction."""

    @property
    def _braking_nm(self) -> float:
        return self._motor.friction_nm + abs(self.load_nm)

    @property
    def acceleration(self) -> float:
        """The acceleration in RU/s2 that the load leaves; below 0 the load brakes the motor."""
        return self.rate(self.limit * self._motor.largest_torque_nm - self._braking_nm)

    @property
    def coasting(self) -> float:
        """Deceleration without power, in RU/s2."""
        return self.rate(self._braking_nm)

    def rate(self, torque_nm: float) -> float:
        """Return the acceleration in RU/s2 that a torque gives to a motor without load and friction."""
        return torque_nm / self._motor.inertia_kg_m2 / tau * TURN

    def of_rate(self, rate: float) -> float:
        """Return the torque in N m that gives this acceleration to a motor without load and friction."""
        return rate / TURN * tau * self._motor.inertia_kg_m2
