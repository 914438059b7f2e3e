"""Set values of an axis that a client moves: to a place, at a speed, to rest, or with a torque.

Source: the closed solution of `motion.profile` (speed, acceleration and deceleration limited, jerk not).  Positions are
sent in all but torque mode, so that a speed is kept over any time without drift.  Whoever takes the axis over while it
moves begins at its present speed.
"""

from typing import Final

from fieldrig.clock import S
from fieldrig_devices.max4.axis import Axis, Mode
from fieldrig_devices.motion.profile import Limits, Profile, brake, change_speed, move

RESTS_BELOW: Final = 1000.0
"""Increments per second: what an axis at rest shows at most; nothing is taken over from that."""


class Positioner:
    """The `SetValues` of one axis.  Places are increments, speeds increments per second."""

    def __init__(self, axis: Axis, cycle_ns: int) -> None:
        self._axis, self._cycle_ns = axis, cycle_ns
        self.mode = Mode.POSITION
        self._origin = self._place = float(axis.position)
        self._speed = 0.0
        self._profile: Profile | None = None
        self._cycles = 0
        self._torque = 0
        self._target: float | None = None
        """Where the profile ends; None if it keeps a speed, or stops."""
        self.has_arrived = False
        """At the place, or the speed, that was asked for last."""

    @property
    def is_moving(self) -> bool:
        """A set position that changes, or a torque."""
        return self._profile is not None or self.mode is Mode.TORQUE

    # ---- what a client wants; only while the axis is under control

    def move_to(self, place: float, limits: Limits) -> None:
        self._take_over()
        self._begin(move(place - self._place, self._speed, limits), place)

    def move_by(self, distance: float, limits: Limits) -> None:
        """From where it is to be now."""
        self._take_over()
        self._begin(move(distance, self._speed, limits), self._place + distance)

    def run(self, speed: float, limits: Limits) -> None:
        """With the sign of the direction, until something else is wanted."""
        self._take_over()
        self._begin(change_speed(self._speed, speed, limits))

    def stop(self, limits: Limits) -> None:
        self._take_over()
        self._begin(brake(self._speed, limits))

    def push(self, torque: int) -> None:
        """0.1 % of the motor's rated torque."""
        self._take_over()
        self._profile, self._torque = None, torque
        self.mode, self.has_arrived = Mode.TORQUE, True

    # ---- by the axis (`SetValues`)

    def begin(self, axis: Axis) -> None:
        self._rest_at(axis.position)

    def next(self) -> float:
        if self.mode is Mode.TORQUE:
            return self._torque
        profile = self._profile
        if profile is not None:
            self._cycles += 1
            self._follow(profile, self._cycles * self._cycle_ns / S)
        return round(self._place)

    def end(self) -> None:
        self._rest_at(self._axis.position)

    def _follow(self, profile: Profile, seconds: float) -> None:
        state = profile.at(seconds)
        self._speed = state.speed
        self._place = self._origin + state.position
        if seconds < profile.duration_s:
            return
        if state.speed:
            self.has_arrived = True
            return
        self._profile = None
        if self._target is not None:
            self._place, self.has_arrived = self._target, True

    def _begin(self, profile: Profile, target: float | None = None) -> None:
        self._profile, self._target = profile, target
        self._origin, self._cycles = self._place, 0
        self.has_arrived = False

    def _rest_at(self, place: float) -> None:
        self.mode, self._profile = Mode.POSITION, None
        self._place, self._speed, self.has_arrived = place, 0.0, False

    def _take_over(self) -> None:
        """The axis may follow somebody else, or a torque."""
        axis = self._axis
        if axis.set_values is self and self.mode is Mode.POSITION:
            return
        place = axis.set_value if axis.mode is Mode.POSITION else axis.position
        if axis.set_values is self:
            self._rest_at(place)
        else:
            axis.follow(self)
            self._place = place
        if abs(axis.velocity) > RESTS_BELOW:
            self._speed = axis.velocity
