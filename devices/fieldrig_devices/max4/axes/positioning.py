"""Set values of an axis that a client moves to a position, at a speed, to rest, or with a torque.

Source: the closed solution of `motion.profile` (speed, acceleration and deceleration limited, jerk not).  The set
values are positions in all modes but torque, so that a speed is kept without drift.  A client that takes the axis over
while it moves starts at its present speed.  Limits apply as for a CiA 402 axis: a limit switch stops the axis with the
deceleration of the command and cancels it; a target beyond a software limit becomes the limit, where a speed ends too.
"""

from typing import Final

from fieldrig.clock import S
from fieldrig_devices.max4.axes.axis import Axis, Mode
from fieldrig_devices.motion.profile import Limits, Profile, brake, change_speed, move
from fieldrig_devices.motion.travel import Travel

RESTS_BELOW: Final = 1000.0
"""Largest velocity of an axis at rest, in increments per second; a lower velocity is not taken over."""


class Positioner:
    """The `SetValues` of one axis.  Positions are in increments, speeds in increments per second."""

    def __init__(self, axis: Axis, cycle_ns: int, travel: Travel) -> None:
        self._axis, self._cycle_ns, self._cycle_s = axis, cycle_ns, cycle_ns / S
        self.travel = travel
        self.mode = Mode.POSITION
        self._origin = self._position = float(axis.position)
        self._speed = 0.0
        self._profile: Profile | None = None
        self._cycles = 0
        self._torque = 0
        self._target: float | None = None
        """Position at the end of the profile, or None if the profile ends at a speed or at rest."""
        self._wanted = 0.0
        """Speed to keep, or 0."""
        self._is_ending = False
        """True while the axis stops at a software limit."""
        self.is_moving = False
        """True while the set position changes, or the set value is a torque."""
        self._limits = Limits(1.0, 1.0, 1.0)
        """Limits of the last command."""
        self.has_arrived = False
        """True once the last target position or speed is reached."""

    # ---- commands of a client, only while the axis is under control

    def move_to(self, position: float, limits: Limits) -> None:
        self._take_over(limits)
        self._go_to(position)

    def move_by(self, distance: float, limits: Limits) -> None:
        """Move relative to the present set position."""
        self._take_over(limits)
        self._go_to(self._position + distance)

    def run(self, speed: float, limits: Limits) -> None:
        """Run at a speed, whose sign is the direction, until the next command."""
        self._take_over(limits)
        self._wanted = speed
        self._begin(change_speed(self._speed, speed, limits))

    def stop(self, limits: Limits) -> None:
        self._take_over(limits)
        self._begin(brake(self._speed, limits))

    def push(self, torque: int, limits: Limits) -> None:
        """Apply a torque in 0.1 % of the rated torque of the motor; `limits` are for the stop at a switch."""
        self._take_over(limits)
        self._profile, self._torque = None, torque
        self.mode, self.has_arrived, self.is_moving = Mode.TORQUE, True, True

    # ---- once per cycle, before the axis calls `next`

    def watch(self) -> None:
        """Apply the limits; needed only while the axis moves and has limits."""
        if self.mode is Mode.TORQUE:
            self._watch_torque()
        else:
            self._watch_profile()

    def _watch_torque(self) -> None:
        """Stop at a limit by position, because a torque cannot hold an axis at a position."""
        velocity, position = self._axis.velocity, self._axis.position
        speed = velocity if abs(velocity) > RESTS_BELOW else 0.0
        if self.travel.is_barred(speed or self._torque, position):
            self._rest_at(position + velocity * self._cycle_s)
            self._speed = velocity
            self._begin(brake(velocity, self._limits))

    def _watch_profile(self) -> None:
        direction = self._wanted if self._target is None else self._target - self._position
        if direction and self.travel.bars(direction):
            self._wanted = 0.0
            self._begin(brake(self._speed, self._limits))
        elif self._wanted and not self._is_ending:
            way = self.travel.stop_ahead(self._position, self._speed, self._wanted, self._limits, self._cycle_s)
            if way is not None:
                self._is_ending = True
                self._begin(way)

    # ---- for the axis (`SetValues`)

    def begin(self, axis: Axis) -> None:
        self.travel.release()
        self._rest_at(axis.position)

    def next(self) -> float:
        if self.mode is Mode.TORQUE:
            return self._torque
        profile = self._profile
        if profile is not None:
            self._cycles += 1
            seconds = self._cycles * self._cycle_ns / S
            way, self._speed, _ = profile.values_at(seconds)
            self._position = self._origin + way
            if seconds >= profile.duration_s and not (self._speed and self.has_arrived):
                self._arrive()
        return round(self._position)

    def end(self) -> None:
        self.travel.release()
        self._rest_at(self._axis.position)

    def _arrive(self) -> None:
        """Finish a profile that has ended."""
        if self._speed:
            self.has_arrived = True
            return
        self._profile, self.is_moving = None, False
        if self._target is not None:
            self._position, self.has_arrived = self._target, True

    def _go_to(self, position: float) -> None:
        target = self.travel.within(position)
        self._begin(move(target - self._position, self._speed, self._limits), target)

    def _begin(self, profile: Profile, target: float | None = None) -> None:
        self._profile, self._target = profile, target
        self._origin, self._cycles = self._position, 0
        self.has_arrived, self.is_moving = False, True

    def _rest_at(self, position: float) -> None:
        self.mode, self._profile, self.is_moving = Mode.POSITION, None, False
        self._position, self._speed, self.has_arrived = position, 0.0, False

    def _take_over(self, limits: Limits) -> None:
        """Start a command at the present state of the axis, which may follow another source or a torque."""
        axis = self._axis
        self._limits, self._wanted, self._is_ending, self.travel.is_limited = limits, 0.0, False, False
        if axis.set_values is self and self.mode is Mode.POSITION:
            return
        position = axis.set_value if axis.mode is Mode.POSITION else axis.position
        if axis.set_values is self:
            self._rest_at(position)
        else:
            axis.follow(self)
            self._position = position
        if abs(axis.velocity) > RESTS_BELOW:
            self._speed = axis.velocity
