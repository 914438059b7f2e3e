"""Profile velocity: changes to a speed with the accelerations of 6083h and 6084h.

Source: CiA 402-2, chapter 'profile velocity mode'.  The axis stops at a software limit (607Dh).  Bit 13 (slippage) is
for asynchronous motors and stays 0.
"""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.modes.mode import BIT_12, TARGET_REACHED
from fieldrig_devices.cia402.modes.speed import SpeedMode
from fieldrig_devices.cia402.pace import NO_BAND
from fieldrig_devices.cia402.window import Window
from fieldrig_devices.motion.profile import Limits

SPEED_IS_0: Final = BIT_12
_WINDOW_TIME: Final = (objects.VELOCITY_TIME, 0)
_THRESHOLD_TIME: Final = (objects.THRESHOLD_TIME, 0)


class ProfileVelocity(SpeedMode):
    number = 3

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._reached, self._faster = Window(), Window()

    def limits(self) -> Limits:
        return self.context.profile_limits(self.context.objects[objects.MAX_VELOCITY])

    def begin(self) -> None:
        self._reached.reset()
        self._faster.reset()
        self._asked = self.context.units.speed(self.context.objects[objects.TARGET_VELOCITY])
        super().begin()

    def writers(self) -> dict[tuple[int, int], Callable[[int], None]]:
        return {(objects.TARGET_VELOCITY, 0): self._on_target}

    def _on_target(self, velocity: int) -> None:
        self.context.pace.leave_band()
        self._asked = self.context.units.speed(velocity)
        if self._is_active and not self.is_halted:
            self.run()

    def step(self) -> None:
        super().step()
        context = self.context
        velocity = context.motor.velocity
        is_near = abs(velocity - self._asked) <= context.velocity_window
        is_fast = abs(velocity) > context.threshold
        if not (is_near and is_fast and self._reached.is_held and self._faster.is_held):
            self._compare(is_near=is_near, is_fast=is_fast)

    @property
    def band(self) -> tuple[float, float]:
        """The inner half of the velocity window, so that rounding at its ends has no effect.

        The band is empty unless the speed is reached and above the threshold, both for long enough, without software
        limits.  A halt, and a switch that holds the axis, only follow their ramp.
        """
        context = self.context
        if not (self._reached.is_held and self._faster.is_held) or context.travel.range is not None:
            return NO_BAND
        low, high = self._asked - context.velocity_window / 2, self._asked + context.velocity_window / 2
        return (max(low, context.threshold), high) if self._asked > 0 else (low, min(high, -context.threshold))

    def _compare(self, *, is_near: bool, is_fast: bool) -> None:
        """Compare the velocity with 606Dh to 6070h.  A condition that has held long enough is not counted further."""
        context = self.context
        if not (is_near and self._reached.is_held):
            self._reached.update(is_near, context.objects.numbers[_WINDOW_TIME], context.cycle_ns)
        if not (is_fast and self._faster.is_held):
            self._faster.update(is_fast, context.objects.numbers[_THRESHOLD_TIME], context.cycle_ns)

    @property
    def status(self) -> int:
        speed = 0 if self._faster.is_held else SPEED_IS_0
        if self.is_halted:
            return speed | self.halted_status
        return speed | (TARGET_REACHED if self._reached.is_held else 0)
