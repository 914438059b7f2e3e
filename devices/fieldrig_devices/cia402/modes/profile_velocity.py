"""Profile velocity: changes to a speed with the accelerations of 6083h and 6084h.

Source: CiA 402-2, chapter 'profile velocity mode'.  Set values are positions, so that the axis holds its position after
a stop; it stops at a software limit (607Dh).  Bit 13 (slippage) is for asynchronous motors and stays 0.
"""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.modes.mode import BIT_12, TARGET_REACHED, Mode
from fieldrig_devices.cia402.options import Ramp
from fieldrig_devices.cia402.pace import NO_BAND
from fieldrig_devices.cia402.window import Window
from fieldrig_devices.motion.profile import change_speed

SPEED_IS_0: Final = BIT_12
_WINDOW_TIME: Final = (objects.VELOCITY_TIME, 0)
_THRESHOLD_TIME: Final = (objects.THRESHOLD_TIME, 0)


class ProfileVelocity(Mode):
    number = 3

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._is_active = False
        self._is_ending = False
        """True while the axis stops at a software limit."""
        self._wanted = 0.0
        self._is_stopped = False
        """True if a limit switch has stopped the axis."""
        self._asked = 0.0
        """The requested speed before limits apply."""
        self._reached, self._faster = Window(), Window()

    def begin(self) -> None:
        self._is_active = True
        self._reached.reset()
        self._faster.reset()
        self._asked = self.context.units.speed(self.context.objects[objects.TARGET_VELOCITY])
        self._run()

    def end(self) -> None:
        self._is_active = False

    def writers(self) -> dict[tuple[int, int], Callable[[int], None]]:
        return {(objects.TARGET_VELOCITY, 0): self._on_target}

    def _on_target(self, velocity: int) -> None:
        self.context.pace.leave_band()
        self._asked = self.context.units.speed(velocity)
        if self._is_active and not self.is_halted:
            self._run()

    def _run(self) -> None:
        context = self.context
        self._is_ending = self._is_stopped = False
        limits = context.profile_limits(context.objects[objects.MAX_VELOCITY])
        context.travel.is_limited = abs(self._asked) > limits.speed
        self._wanted = min(max(self._asked, -limits.speed), limits.speed)
        context.motion.start(change_speed(context.motion.speed, self._wanted, limits))

    def go_on(self) -> None:
        super().go_on()
        self._run()

    def step(self) -> None:
        context = self.context
        motion, travel, motor = context.motion, context.travel, context.motor
        is_limited = motor.inputs or travel.held or travel.range is not None or self._is_stopped
        if is_limited and not self.is_halted:
            self._watch_switches()
        motion.step(context.cycle_s)
        velocity = motor.velocity
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

    def _watch_switches(self) -> None:
        context = self.context
        if not context.travel.bars(context.motion.speed or self._wanted):
            if self._is_stopped:
                self._run()
            if context.travel.range is not None and not self._is_ending:
                self._watch_limits()
        elif not self._is_stopped:
            self._is_stopped = True
            self.brake(Ramp.QUICK_STOP)

    def _watch_limits(self) -> None:
        """Start the stop at a software limit in time."""
        context, motion = self.context, self.context.motion
        limits = context.profile_limits(context.objects[objects.MAX_VELOCITY])
        way = context.travel.stop_ahead(motion.position, motion.speed, self._wanted, limits, context.cycle_s)
        if way is not None:
            self._is_ending = True
            motion.start(way)

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
