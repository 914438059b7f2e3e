"""The PMP generator: moves with a limited jerk, also forward and backward without a stop (PAML-600 to PAML-608)."""

import math
from dataclasses import dataclass

from fieldrig_devices.motion.jerk import JerkProfile, largest
from fieldrig_devices.pam.pipes.generator import Generator


@dataclass(frozen=True, slots=True)
class PmpLimits:
    """Limits above 0: speeds in u/s of the way forward and back, acceleration in u/s2, jerk in u/s3."""

    first_speed: float
    last_speed: float
    acceleration: float
    jerk: float


def single(distance: float, limits: PmpLimits) -> JerkProfile:
    """Return the motion over a distance above 0.  A short one does not reach the speed (PAML-604)."""

    def motion(speed: float, cruise_s: float) -> JerkProfile:
        profile = JerkProfile()
        profile.ramp(speed, limits.acceleration, limits.jerk)
        profile.cruise(cruise_s)
        profile.ramp(0.0, limits.acceleration, limits.jerk)
        return profile

    speed = limits.first_speed * largest(lambda share: motion(limits.first_speed * share, 0.0).distance <= distance)
    return motion(speed, (distance - motion(speed, 0.0).distance) / speed)


def forward_backward(forward: float, backward: float, limits: PmpLimits) -> JerkProfile:
    """Return the motion over `forward` and back over `backward`, both above 0, without a stop between them.

    Both speeds are reduced by the same share if the distances are too short for them.
    """

    def motion(share: float, forward_s: float, backward_s: float) -> JerkProfile:
        profile = JerkProfile()
        profile.ramp(limits.first_speed * share, limits.acceleration, limits.jerk)
        profile.cruise(forward_s)
        profile.ramp(-limits.last_speed * share, limits.acceleration, limits.jerk)
        profile.cruise(backward_s)
        profile.ramp(0.0, limits.acceleration, limits.jerk)
        return profile

    def left(share: float) -> tuple[float, float]:
        """Return the distances that are left for both speeds."""
        shortest = motion(share, 0.0, 0.0)
        turning = shortest.turning_position()
        return forward - turning, backward - (turning - shortest.distance)

    share = largest(lambda share: min(left(share)) >= 0)
    first, last = left(share)
    return motion(share, first / (limits.first_speed * share), last / (limits.last_speed * share))


class PmpGenerator(Generator):
    """A command while a motion runs is ignored (PAML-603); one argument is a single move, two go there and back.

    A run changes the speed with the limits of FIRST_TRAVEL_SPEED; a move out of a run stops first, and so does one that
    replaces another motion by the other reading (E-18).
    """

    def __init__(self, limits: PmpLimits, initial_position: float, position_period: float | None) -> None:
        super().__init__(initial_position, position_period)
        self.limits = limits
        self.supersedes = False
        """True if a command replaces a running motion."""
        self._way = JerkProfile()

    @property
    def _is_busy(self) -> bool:
        return self._seconds < self._way.duration_s and not self.supersedes

    @property
    def speed(self) -> float:
        return self._way.values_at(self._seconds)[1] if self.is_active else 0.0

    @property
    def acceleration(self) -> float:
        return self._way.values_at(self._seconds)[2] if self.is_active else 0.0

    def _moved(self, seconds: float) -> float:
        return self._way.values_at(seconds)[0]

    def _rest(self) -> None:
        self._way = JerkProfile()

    def absolute_move(self, first: float, last: float | None = None) -> None:
        """Move to `first`, and then to `last` if it is on the other side of it."""
        self._move(self._way_to(first), None if last is None else last - first, first if last is None else last)

    def relative_move(self, first: float, last: float | None = None) -> None:
        """Move by `first`, and then by `last`, which must have the opposite sign; otherwise nothing moves.

        Without a way for the first, the last is a single move.
        """
        self._move(first, last, self._absolute + first + (last or 0.0))

    def _move(self, first: float, last: float | None, end: float) -> None:
        if not self.is_active or self._is_busy or (last is not None and first * last > 0):
            return
        if not first:
            first, last = last or 0.0, None
        way = self._moving()
        way.ramp(0.0, self.limits.acceleration, self.limits.jerk)
        first -= way.distance
        if first and last is None:
            way.then(single(abs(first), self.limits), math.copysign(1.0, first))
        elif last is not None and first * last < 0:
            way.then(forward_backward(abs(first), abs(last), self.limits), math.copysign(1.0, first))
        elif last is not None:  # it stops behind the point of return
            self._follow(way, None)
            return
        self._follow(way, end)

    def run(self, speed: float) -> None:
        """Go on at a speed; 0 ends the motion."""
        if self.is_active and not self._is_busy:
            way = self._moving()
            way.ramp(speed, self.limits.acceleration, self.limits.jerk)
            self._follow(way, None, self._run_is_ready_s(speed, way.duration_s))

    def _moving(self) -> JerkProfile:
        """Return the beginning of a motion that follows the present one: its acceleration ends."""
        way = JerkProfile(self.speed, self.acceleration)
        way.relax(self.limits.jerk)
        return way

    def _follow(self, way: JerkProfile, end: float | None, ready_s: float | None = None) -> None:
        base, self._way = self._absolute, way
        self._begin(base, way.duration_s, end, ready_s)
