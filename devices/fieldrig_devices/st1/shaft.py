"""The shaft of an ST1's own motor: it is exactly at the set position for as long as the torque suffices.

When a set position jumps or runs away, the shaft follows with the largest acceleration that its torque gives, and
never faster than CKV, until it has caught up (PAML-405: the axis jumps at maximum torque).  Meanwhile the motion is
planned again every millisecond, relative to the motion of the set position.  Without power the shaft coasts to rest.
The load acts like friction: it brakes, but it does not drive.
"""

from math import ceil, copysign, inf
from typing import Final

from fieldrig.clock import MS, NEVER_NS, S
from fieldrig_bus.wires import Signal
from fieldrig_devices.motion.profile import Limits, Profile, brake, change_speed, keep, move
from fieldrig_devices.st1.set_position import SetPosition

LOOP_NS: Final = MS
"""Time between two plans of a shaft that does not follow."""
SHORTEST_NS: Final = LOOP_NS // 8
"""Shortest time between two plans; a motion that ends earlier has caught up until then."""
TURN: Final = 1 << 32
"""RU to a turn of the motor."""
NEAR: Final = TURN / 1e6
"""RU from the set position within which the shaft has caught up."""
_SLACK: Final = TURN / 1e6
"""RU/s by which set-points that are rounded may miss a speed; a limit is not below it either."""


class Shaft:
    __slots__ = (
        "_frame", "_is_powered", "_place", "_rel", "_set", "_since_ns", "_speed_limit", "acceleration", "friction",
        "is_blocked", "is_following", "next_ns",
    )  # fmt: skip

    def __init__(self, set_position: SetPosition, speed_limit: float, acceleration: float, friction: float) -> None:
        """Limits in RU/s and RU/s2; `friction` is the deceleration without power."""
        self._set, self._speed_limit = set_position, speed_limit
        self.acceleration, self.friction = acceleration, friction
        """The acceleration that torque and load give at present, and the deceleration without power."""
        self.is_blocked = False
        self.is_following = self._is_powered = False
        """True if the shaft is at the set position."""
        self._place, self._since_ns, self._frame, self._rel = 0, 0, 0.0, keep(0.0)
        self.next_ns = NEVER_NS
        """The instant at which `look` has to be called again."""

    # ---- where it is

    def position_at(self, now_ns: int) -> int:
        if self.is_following:
            return self._set.motor_at(now_ns)
        seconds = (now_ns - self._since_ns) / S
        return self._place + round(self._frame * seconds + self._rel.values_at(seconds)[0])

    def speed_at(self, now_ns: int) -> float:
        if self.is_following:
            return self._set.speed_at(now_ns)
        return self._frame + self._rel.values_at((now_ns - self._since_ns) / S)[1]

    def acceleration_at(self, now_ns: int) -> float:
        if self.is_following:
            return self._set.acceleration_at(now_ns)
        return self._rel.values_at((now_ns - self._since_ns) / S)[2]

    def effort_at(self, now_ns: int) -> float:
        """Return the torque of the motor, as the acceleration in RU/s2 that it would give without load and friction.

        A motor that cannot move its load pushes with everything that it has.
        """
        if not self._is_powered:
            return 0.0
        if self.is_blocked or self.acceleration <= 0:
            lag = self.lag_at(now_ns)
            return copysign(self.acceleration + self.friction, lag) if lag else 0.0
        speed, rate = self.speed_at(now_ns), self.acceleration_at(now_ns)
        return rate + copysign(self.friction, speed or rate) if speed or rate else 0.0

    def lag_at(self, now_ns: int) -> int:
        """Return the distance from the shaft to the set position."""
        return self._set.motor_at(now_ns) - self.position_at(now_ns) if self._is_powered else 0

    def is_limited_at(self, now_ns: int) -> bool:
        """True if the shaft follows as fast as its torque allows, and is behind all the same."""
        lost = self.acceleration / 2 * (LOOP_NS / S) ** 2  # by planning with a steady set position
        return self._is_powered and not self.is_following and abs(self.lag_at(now_ns)) > lost + NEAR

    # ---- events

    def place(self, now_ns: int, position: int) -> None:
        """Put the shaft at a position, at rest."""
        self._place, self._since_ns, self._frame, self._rel = position, now_ns, 0.0, keep(0.0)

    def measure(self, encoder: Signal) -> None:
        """Do nothing: this shaft has its own resolver."""

    def power(self, now_ns: int, is_on: bool) -> None:
        position, speed = self.position_at(now_ns), self.speed_at(now_ns)
        self._is_powered, self.is_following = is_on, is_on and not speed
        self._begin(now_ns, position, speed)

    def block(self, now_ns: int, is_on: bool) -> None:
        """Jam the shaft, or release it."""
        position, speed = self.position_at(now_ns), self.speed_at(now_ns)
        self.is_blocked = is_on
        self.is_following = False
        self._begin(now_ns, position, 0.0 if is_on else speed)

    def leave(self, now_ns: int) -> None:
        """Go on without the set position, which is about to jump."""
        self._place, self._frame, self._rel = self.position_at(now_ns), self.speed_at(now_ns), keep(0.0)
        self._since_ns, self.is_following = now_ns, False

    def look(self, now_ns: int, speed_before: float | None = None) -> None:
        """Look whether the shaft can follow the set position from now on; its speed was `speed_before` until now."""
        if self.is_following:
            speed = self._set.speed_at(now_ns) if speed_before is None else speed_before
            if not self._can_follow(now_ns, speed):
                position = self._set.motor_at(now_ns)
                self.is_following = False
                self._begin(now_ns, position, speed)
            return
        position, speed = self.position_at(now_ns), self.speed_at(now_ns)
        if self._is_powered and abs(self._set.motor_at(now_ns) - position) <= NEAR and self._can_follow(now_ns, speed):
            self.is_following, self.next_ns = True, NEVER_NS
        else:
            self._begin(now_ns, position, speed)

    def keeps_up(self, before: float, speed: float, interval_ns: int) -> bool:
        """True if a shaft that follows can take this step of the speed between two set-points, with no other motion."""
        is_slow = -self._speed_limit - _SLACK <= speed <= self._speed_limit + _SLACK
        return is_slow and abs(speed - before) <= self.acceleration * interval_ns / S and not self.is_blocked

    def _can_follow(self, now_ns: int, speed: float) -> bool:
        """True if the set position can be followed from this speed on, up to its next change."""
        wanted, rate = self._set.speed_at(now_ns), self._set.acceleration_at(now_ns)
        if self.is_blocked:
            return not wanted and not rate and not speed
        step = self.acceleration * self._set.pipe.interval_ns / S
        if abs(rate) > self.acceleration or abs(wanted - speed) > max(step, _SLACK):
            return False
        later = wanted + rate * (self._set.next_change_ns(now_ns) - now_ns) / S if rate else wanted
        return max(abs(wanted), abs(later)) <= self._speed_limit + _SLACK

    def _begin(self, now_ns: int, position: int, speed: float) -> None:
        self._since_ns, self._place = now_ns, position
        self._frame, self._rel = self._plan(now_ns, position, speed)
        self.next_ns = NEVER_NS
        if self.is_following:
            return
        seconds = self._rel.phase_end_s(0.0)
        end_ns = now_ns + max(SHORTEST_NS, ceil(seconds * S)) if seconds < inf else NEVER_NS
        self.next_ns = min(now_ns + LOOP_NS, end_ns) if self._is_powered else end_ns

    def _plan(self, now_ns: int, position: int, speed: float) -> tuple[float, Profile]:
        """Return the speed of the frame in which the motion is planned, and the motion within it."""
        rate, highest = self.acceleration, self._speed_limit
        if self.is_blocked:
            return 0.0, keep(0.0)
        if not self._is_powered or rate <= 0:  # below 0, the load takes more than the torque, and brakes the shaft
            rate = self.friction if not self._is_powered else max(-rate, _SLACK)
            return 0.0, brake(speed, Limits(highest, rate, rate))
        wanted = self._set.speed_at(now_ns)
        if abs(wanted) >= highest:
            return 0.0, change_speed(speed, copysign(highest, wanted), Limits(highest, rate, rate))
        # In the frame of the set position, which stands still there, so that the shaft reaches it with its speed.
        distance = float(self._set.motor_at(now_ns) - position)
        return wanted, move(distance, speed - wanted, Limits(max(highest - abs(wanted), _SLACK), rate, rate))
