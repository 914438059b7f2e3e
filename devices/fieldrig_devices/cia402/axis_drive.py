"""The drive function of an axis: moves its motor by a ramp or by the mode of operation.

Source: CiA 402-2.  The owner of the motor calls `step` once per motor cycle, through `Cia402Axis`.
Our choice: a following error beyond 6065h and 6066h is a fault, 8611h.
"""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.axis_objects import AxisObjects
from fieldrig_devices.cia402.behaviour import LimitSwitch
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.limit_switches import LIMITS, NewSwitches
from fieldrig_devices.cia402.modes.cyclic import CyclicPosition, CyclicVelocity
from fieldrig_devices.cia402.modes.homing import Homing
from fieldrig_devices.cia402.modes.interpolated import InterpolatedPosition
from fieldrig_devices.cia402.modes.mode import BIT_13, Mode
from fieldrig_devices.cia402.modes.profile_position import ProfilePosition
from fieldrig_devices.cia402.modes.profile_velocity import ProfileVelocity
from fieldrig_devices.cia402.modes.standing import Standing
from fieldrig_devices.cia402.modes.torque import CyclicTorque, ProfileTorque
from fieldrig_devices.cia402.modes.velocity import Velocity
from fieldrig_devices.cia402.motor import Kind, Motor
from fieldrig_devices.cia402.options import HALT_OPTIONS, Options, Ramp
from fieldrig_devices.cia402.pace import NO_BAND
from fieldrig_devices.cia402.window import Window
from fieldrig_devices.motion.smooth import brake

INTERNAL_LIMIT: Final = 0x0800
"""Bit of the status word."""
NO_MODE: Final = 0
MODES: Final[tuple[type[Mode], ...]] = (
    ProfilePosition, Velocity, ProfileVelocity, ProfileTorque, Homing, InterpolatedPosition,
    CyclicPosition, CyclicVelocity, CyclicTorque,
)  # fmt: skip
REFERENCE_LIMIT: Final = 0x8612
"""Error code in 603Fh."""
LONGEST_OVERRUN_S: Final = 1.0
"""How long an axis that a load turns, against the torque of the drive, has power after the end of its ramp."""
SHOWS_FOLLOWING_ERROR: Final = (ProfilePosition.number, CyclicPosition.number)


class AxisDrive:
    def __init__(self, numbers: AxisObjects, motor: Motor, context: Context) -> None:
        self._numbers, self._motor, self._context = numbers, motor, context
        self._pace, self._motion = context.pace, context.motion
        self.modes = {mode.number: mode for mode in (kind(context) for kind in MODES)}
        for number in (context.behaviour.modes or frozenset()) - self.modes.keys():
            self.modes[number] = Standing(context)
        self.mode: Mode = self.modes[ProfilePosition.number]
        self.shown_mode = NO_MODE
        self.is_moving = False
        """True while the mode gives the set values, and not a ramp."""
        self.is_ramp = False
        """True while a ramp brings the axis to rest and holds it there."""
        self._overrun_s = 0.0
        """Time since the end of the ramp, at which the axis may still turn."""
        self._is_halt_wanted = self._is_halted = False
        self._own_errors: tuple[int, ...] = ()
        """Codes of errors that the motor does not have, such as a following error."""
        self._limit_switch, self._switches = context.behaviour.limit_switch, NewSwitches(motor)
        self._following = Window()
        self.following_error = 0.0
        """Position demand of the previous cycle minus the actual position, in increments."""
        self.kind = Kind.POSITION
        self.set_value: float = 0

    @property
    def supported(self) -> set[int]:
        """Numbers of the modes that the drive has and whose set values the motor can follow."""
        kinds, numbers = self._motor.kinds, self._context.behaviour.modes
        followed = {number for number, mode in self.modes.items() if mode.kind in kinds}
        return followed if numbers is None else followed & numbers

    @property
    def position_demand(self) -> float:
        """Position demand in increments; the actual position while there is no demand."""
        if self.is_moving:
            return self._context.motion.position + self.mode.behind
        return self._context.motion.position if self.is_ramp else self._motor.position

    @property
    def velocity_demand(self) -> float:
        """Velocity demand in increments per second; 0 while there is no demand."""
        return self._context.motion.speed if self.is_moving or self.is_ramp else 0.0

    def restart(self) -> None:
        """Start as after power-on: without a mode and without an error."""
        self.mode.end()
        self.shown_mode = NO_MODE
        self.is_moving = self.is_ramp = self._is_halt_wanted = False
        self._own_errors = ()

    def change_mode(self, number: int) -> None:
        self._pace.leave_band()
        self.mode.end()
        self.mode = self.modes[number]
        self.shown_mode = number
        if self.is_moving:
            self._begin_mode()

    def halt(self, is_wanted: bool) -> None:
        """Take over bit 8 of the control word."""
        self._is_halt_wanted = is_wanted
        if is_wanted is self._is_halted or not self.is_moving:
            return
        self._is_halted = is_wanted
        if is_wanted:
            self.mode.halt(HALT_OPTIONS.get(self._numbers[objects.HALT_OPTION], Ramp.SLOW_DOWN))
        else:
            self.mode.go_on()

    # ---- `drive.Drive`

    @property
    def is_there(self) -> bool:
        return self._motor.is_there

    @property
    def is_ready(self) -> bool:
        return self._motor.is_ready

    @property
    def is_following(self) -> bool:
        return self._motor.is_following

    @property
    def is_moving_by_itself(self) -> bool:
        return self._motor.is_stopping

    @property
    def is_at_rest(self) -> bool:
        context = self._context
        is_over = self.is_ramp and context.motion.is_done
        return is_over and (context.is_standing(self._motor.velocity) or self._overrun_s >= LONGEST_OVERRUN_S)

    @property
    def errors(self) -> tuple[int, ...]:
        return self._motor.errors + self._own_errors

    @property
    def has_own_error(self) -> bool:
        return bool(self._own_errors)

    @property
    def options(self) -> Options:
        numbers = self._numbers
        return Options(
            numbers[objects.QUICK_STOP_OPTION],
            numbers[objects.SHUTDOWN_OPTION],
            numbers[objects.DISABLE_OPTION],
            numbers[objects.FAULT_OPTION],
        )

    def enable(self) -> None:
        self._motor.enable(True)

    def disable(self) -> None:
        self._motor.enable(False)
        if self.is_moving or self.is_ramp:
            self.mode.end()
        self.is_moving = self.is_ramp = self._is_halted = False

    def brake(self, ramp: Ramp) -> None:
        motion = self._context.motion
        if self.is_moving:
            self.mode.end()
            self.mode.is_halted = False
        self.is_moving = self._is_halted = False
        self.is_ramp, self._overrun_s = True, 0.0
        limits = self._context.ramp_limits(ramp) if self.shown_mode == NO_MODE else self.mode.ramp_limits(ramp)
        motion.start(brake(motion.speed, limits, motion.acceleration))

    def go_on(self) -> None:
        was_ramp, self.is_ramp = self.is_ramp, False
        self.is_moving = True
        self._following.reset()
        if not was_ramp:
            self._context.motion.stand(self._motor.position)
        if self.shown_mode != NO_MODE:
            self._begin_mode()

    def fail(self, code: int) -> None:
        """Have an error that the motor does not have."""
        self._pace.wake()
        if code not in self._own_errors:
            self._own_errors += (code,)

    def reset_fault(self, done: Callable[[], None]) -> None:
        self._own_errors = ()
        self._following.reset()
        self._motor.reset(done)

    def _begin_mode(self) -> None:
        self.mode.is_halted = self._is_halted = False
        self._context.travel.release()
        self.mode.begin()
        self.halt(self._is_halt_wanted)

    # ---- once a cycle

    def step(self) -> None:
        """Compute `set_value` from the actual values of this cycle."""
        context, mode = self._context, self.mode
        motion = context.motion
        if self._limit_switch in (LimitSwitch.QUICK_STOP, LimitSwitch.FAULT) and self._switches.is_new():
            self._meet_switch()
        is_guided = self.is_moving and self.kind is Kind.POSITION
        self.following_error = motion.position + mode.behind - self._motor.position if is_guided else 0.0
        if self.is_moving and self.shown_mode != NO_MODE:
            mode.step()
            self.kind = kind = mode.gives
            self.set_value = round(motion.position) if kind is Kind.POSITION else mode.value
            if context.has_following_window:
                self._watch_following()
        elif self.is_moving or self.is_ramp:
            if context.motion.is_done:
                self._overrun_s += context.cycle_s
            context.motion.step(context.cycle_s)
            self.kind, self.set_value = Kind.POSITION, round(context.motion.position)
        else:
            self.kind, self.set_value = Kind.POSITION, self._motor.position

    def _meet_switch(self) -> None:
        if not self.is_moving or self.shown_mode == Homing.number:
            return
        if self._limit_switch is LimitSwitch.QUICK_STOP:
            self._context.on_quick_stop()
        else:
            self.fail(REFERENCE_LIMIT)

    def advance(self) -> None:
        """Do what `step` does, for an axis that moves and is not awake; within the band of its mode that is little."""
        pace, motor = self._pace, self._motor
        if pace.low < motor.velocity < pace.high and not motor.inputs:
            motion = self._motion
            self.following_error = motion.position - motor.position
            motion.step(self._context.cycle_s)
            self.set_value = round(motion.position)
        else:
            self.step()
            pace.low, pace.high = NO_BAND if self._context.has_following_window else self.mode.band

    def _watch_following(self) -> None:
        window = self._numbers[objects.FOLLOWING_WINDOW]
        is_outside = abs(self.following_error) > window * self._context.units.per_unit
        time = self._numbers[objects.FOLLOWING_TIME]
        if self._following.update(is_outside, time, self._context.cycle_ns):
            self.fail(self._context.behaviour.following_error_code)

    @property
    def mode_status(self) -> int:
        """Bits 10 to 13 of the status word of an axis with power."""
        if self.shown_mode == NO_MODE:
            return 0
        is_shown = self._limit_switch is LimitSwitch.SHOWN and self._motor.inputs & LIMITS
        limit = INTERNAL_LIMIT if self._context.travel.is_held_back or is_shown else 0
        return limit | (self.mode.status if self.is_moving else self.mode.halted_status)

    @property
    def following_status(self) -> int:
        """Bit 13 of the status word, which is shown in a fault too."""
        is_lagging = self._following.is_held or self._context.behaviour.following_error_code in self._motor.errors
        return BIT_13 if is_lagging and self.shown_mode in SHOWS_FOLLOWING_ERROR else 0
