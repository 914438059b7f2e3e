"""Axis and brake under the enable chain: what its stage has them do.

Source: manual chapter 10, 6075 (digest PD-150 to PD-160).
"""

from typing import Final

from fieldrig.clock import MS
from fieldrig_devices.drives.axis import Axis, Mode
from fieldrig_devices.drives.motor import MotorData
from fieldrig_devices.mc4.enable import EnableChain, Stage, Task
from fieldrig_devices.mc4.faults import StuckBrake

MODES: Final = {1: Mode.TORQUE, 2: Mode.SPEED, 3: Mode.POSITION}
"""Mode of the axis by the operation mode, S-0-0032; a drive that the master halts has mode 0, and keeps speed 0."""


class AxisTask:
    """The task that the axis has at present."""

    __slots__ = ("_held_in", "_mode", "_task", "overload_position")

    def __init__(self) -> None:
        self._task = Task.NOTHING
        self._held_in: Stage | None = None
        """The stage for which the axis holds its position; an overload that is held keeps the position of its stop."""
        self._mode = 0
        self.overload_position = 0
        """The position to which the controller has to return after an overload, in increments."""

    def give(self, axis: Axis, chain: EnableChain, mode: int) -> None:
        """Give the axis its task if that has changed; `mode` is the operation mode, 0 while the drive is halted."""
        task = chain.task
        if task is Task.FOLLOW:
            if self._task is not task or mode != self._mode:
                self._mode = mode
                axis.control(MODES.get(mode, Mode.SPEED))
                axis.set_value(0.0)
        elif task is not self._task or (task is Task.HOLD and chain.stage is not self._held_in):
            self._held_in = chain.stage
            if task is Task.HOLD:
                if chain.stage is not Stage.OVERLOAD_HELD:
                    axis.control(Mode.POSITION)
                    axis.hold_here()
                    self.overload_position = axis.set_increments
            else:
                axis.control(Mode.FREE if task is Task.NOTHING else Mode.SPEED)
                axis.set_value(0.0)
        self._task = task


class Brake:
    """The holding brake, which follows its relay with a delay of its own, unless it is stuck."""

    __slots__ = ("_due_ns", "_stuck", "_was_lifted")

    def __init__(self) -> None:
        self._due_ns: int | None = None
        self._was_lifted = False
        self._stuck: StuckBrake | None = None

    def stick(self, stuck: StuckBrake | None, now_ns: int) -> None:
        """Let a fault hold the brake from now on; None ends that."""
        if stuck is not self._stuck:
            self._stuck, self._due_ns = stuck, now_ns

    def move(self, axis: Axis, motor: MotorData, now_ns: int, *, is_lifted: bool) -> None:
        """Follow the relay, which is closed if `is_lifted`."""
        if is_lifted is not self._was_lifted:
            self._was_lifted = is_lifted
            delay_ms = motor.brake_lift_ms if is_lifted else motor.brake_drop_ms
            self._due_ns = now_ns + round(delay_ms * MS)
        if self._due_ns is not None and now_ns >= self._due_ns:
            self._due_ns = None
            stuck = self._stuck
            axis.brake(motor.has_brake and (not is_lifted if stuck is None else stuck.stays == "on"))

    @property
    def is_moving(self) -> bool:
        return self._due_ns is not None
