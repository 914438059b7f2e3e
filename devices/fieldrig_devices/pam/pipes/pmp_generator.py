"""The PMP generator: moves with a limited jerk, also forward and backward without a stop (PAML-600 to PAML-608)."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.pam.pipes.generator import Generator

_HALVINGS: Final = 80
"""Steps of the searches by halving, beyond the digits of a float."""


@dataclass(frozen=True, slots=True)
class PmpLimits:
    """Limits above 0: speeds in u/s of the way forward and back, acceleration in u/s2, jerk in u/s3."""

    first_speed: float
    last_speed: float
    acceleration: float
    jerk: float


@dataclass(frozen=True, slots=True)
class _Piece:
    seconds: float
    position: float
    speed: float
    acceleration: float
    jerk: float

    def at(self, t: float) -> tuple[float, float, float]:
        speed = self.speed + (self.acceleration + self.jerk * t / 2) * t
        position = self.position + (self.speed + (self.acceleration / 2 + self.jerk * t / 6) * t) * t
        return position, speed, self.acceleration + self.jerk * t


class JerkProfile:
    """Pieces of constant jerk from position 0, at rest or in motion; behind them the speed remains."""

    def __init__(self, speed: float = 0.0, acceleration: float = 0.0) -> None:
        self.pieces: list[_Piece] = []
        self.duration_s = 0.0
        self._end = (0.0, speed, acceleration)

    @property
    def distance(self) -> float:
        return self._end[0]

    def relax(self, jerk: float) -> None:
        """Bring the acceleration to 0."""
        acceleration = self._end[2]
        self._add(abs(acceleration) / jerk, -math.copysign(jerk, acceleration))
        self._end = (*self._end[:2], 0.0)

    def ramp(self, speed: float, acceleration: float, jerk: float) -> None:
        """Go from the present speed to another with an acceleration that is a trapezoid, or a triangle if short."""
        change = speed - self._end[1]
        sign = 1.0 if change >= 0 else -1.0
        rise_s = min(acceleration / jerk, (abs(change) / jerk) ** 0.5)
        hold_s = abs(change) / (rise_s * jerk) - rise_s if rise_s > 0 else 0.0
        self._add(rise_s, sign * jerk)
        self._add(max(hold_s, 0.0), 0.0)
        self._add(rise_s, -sign * jerk)
        self._end = (self._end[0], speed, 0.0)

    def cruise(self, seconds: float) -> None:
        self._add(seconds, 0.0)

    def then(self, pieces: "JerkProfile", sign: float) -> None:
        """Add another motion that ends at rest, mirrored if the sign is negative."""
        for piece in pieces.pieces:
            self._add(piece.seconds, sign * piece.jerk)
        self._end = (self._end[0], 0.0, 0.0)

    def _add(self, seconds: float, jerk: float) -> None:
        if seconds > 0:
            piece = _Piece(seconds, *self._end, jerk)
            self.pieces.append(piece)
            self.duration_s += seconds
            self._end = piece.at(seconds)

    def at(self, seconds: float) -> tuple[float, float, float]:
        """Return position, speed and acceleration."""
        for piece in self.pieces:
            if seconds < piece.seconds:
                return piece.at(max(seconds, 0.0))
            seconds -= piece.seconds
        return self._end[0] + self._end[1] * seconds, self._end[1], 0.0

    def turning_position(self) -> float:
        """Return the position at which the speed passes through zero."""
        for piece in self.pieces:
            if piece.speed > 0 and piece.at(piece.seconds)[1] <= 0:
                low, high = 0.0, piece.seconds
                for _ in range(_HALVINGS):
                    middle = (low + high) / 2
                    low, high = (middle, high) if piece.at(middle)[1] > 0 else (low, middle)
                return piece.at(low)[0]
        return self._end[0]


def single(distance: float, limits: PmpLimits) -> JerkProfile:
    """Return the motion over a distance above 0.  A short one does not reach the speed (PAML-604)."""

    def motion(speed: float, cruise_s: float) -> JerkProfile:
        profile = JerkProfile()
        profile.ramp(speed, limits.acceleration, limits.jerk)
        profile.cruise(cruise_s)
        profile.ramp(0.0, limits.acceleration, limits.jerk)
        return profile

    speed = limits.first_speed * _largest(lambda share: motion(limits.first_speed * share, 0.0).distance <= distance)
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

    share = _largest(lambda share: min(left(share)) >= 0)
    first, last = left(share)
    return motion(share, first / (limits.first_speed * share), last / (limits.last_speed * share))


def _largest(fits: Callable[[float], bool]) -> float:
    """Return the largest share from 0 to 1 that fits."""
    if fits(1.0):
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low or high


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
        return self._way.at(self._seconds)[1] if self.is_active else 0.0

    @property
    def acceleration(self) -> float:
        return self._way.at(self._seconds)[2] if self.is_active else 0.0

    def _moved(self, seconds: float) -> float:
        return self._way.at(seconds)[0]

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
