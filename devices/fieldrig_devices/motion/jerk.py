"""Motion profiles with a limited jerk, in pieces of constant jerk.

Source: CiA 402-2, 6086h, jerk-limited ramp; PAML-600 to PAML-608.  Each change of the speed has an acceleration that
is a trapezoid over time, or a triangle if the change is small.  A profile may begin at any speed and acceleration: one
that does not help is taken back first, as fast as the jerk permits.  Where the distance is too short to stop, the axis
overshoots and returns.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.motion.profile import Limits, Profile

_HALVINGS: Final = 80
"""Steps of the searches by halving, beyond the digits of a float."""
ROUNDING: Final = 1e-12
"""Share of a distance or an acceleration that is nothing."""


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


class JerkProfile(Profile):
    """Pieces of constant jerk from position 0, at rest or in motion; behind them the speed remains."""

    __slots__ = ("_end", "pieces")

    def __init__(self, speed: float = 0.0, acceleration: float = 0.0) -> None:
        super().__init__(speed, (), speed)
        self.pieces: list[_Piece] = []
        self._end = (0.0, speed, acceleration)

    def relax(self, jerk: float) -> None:
        """Bring the acceleration to 0."""
        acceleration = self._end[2]
        self._add(abs(acceleration) / jerk, -math.copysign(jerk, acceleration))
        self._stop_at(self.distance, self.end_speed)

    def ramp(self, speed: float, acceleration: float, jerk: float) -> None:
        """Go from the present speed to another with an acceleration that is a trapezoid, or a triangle if short.

        A present acceleration that goes the right way, and is not too high, is the rise that has passed already.
        """
        begun, first = self._end[2], self.end_speed
        passed_s = 0.0
        if begun and (speed - self.relaxed(jerk)) * begun > 0 and abs(begun) <= acceleration * (1 + ROUNDING):
            passed_s = abs(begun) / jerk
            first -= begun * passed_s / 2
        elif begun:
            self.relax(jerk)
            first = self.end_speed
        change = speed - first
        sign = 1.0 if change >= 0 else -1.0
        rise_s = min(acceleration / jerk, (abs(change) / jerk) ** 0.5)
        hold_s = abs(change) / (rise_s * jerk) - rise_s if rise_s > 0 else 0.0
        self._add(rise_s - passed_s, sign * jerk)
        self._add(max(hold_s, 0.0), 0.0)
        self._add(rise_s, -sign * jerk)
        self._stop_at(self.distance, speed)

    def cruise(self, seconds: float) -> None:
        self._add(seconds, 0.0)

    def then(self, pieces: "JerkProfile", sign: float) -> None:
        """Add another motion that ends at rest, mirrored if the sign is negative."""
        for piece in pieces.pieces:
            self._add(piece.seconds, sign * piece.jerk)
        self._stop_at(self.distance, 0.0)

    def end_at(self, distance: float) -> None:
        """Say where the profile ends, without the rounding of its pieces."""
        self._end = distance, *self._end[1:]
        self.distance = distance

    def cut(self, distance: float) -> None:
        """End the profile, with its acceleration, where it first reaches a distance ahead."""
        ends = [abs(piece.at(piece.seconds)[0]) for piece in self.pieces]
        place = next(place for place, end in enumerate(ends) if end >= abs(distance))
        piece = self.pieces[place]
        share = largest(lambda share: abs(piece.at(share * piece.seconds)[0]) <= abs(distance))
        del self.pieces[place:]
        self.duration_s = sum(before.seconds for before in self.pieces)
        self._end = piece.position, piece.speed, piece.acceleration
        self._add(share * piece.seconds, piece.jerk)

    def relaxed(self, jerk: float) -> float:
        """The speed once the present acceleration is taken back."""
        _, speed, acceleration = self._end
        return speed + acceleration * abs(acceleration) / (2 * jerk)

    def _stop_at(self, distance: float, speed: float) -> None:
        self._end = distance, speed, 0.0
        self.distance, self.end_speed = distance, speed

    def _add(self, seconds: float, jerk: float) -> None:
        if seconds > 0:
            piece = _Piece(seconds, *self._end, jerk)
            self.pieces.append(piece)
            self.duration_s += seconds
            self._end = piece.at(seconds)
            self.distance, self.end_speed, _ = self._end

    def values_at(self, seconds: float) -> tuple[float, float, float]:
        """Return position, speed and acceleration."""
        for piece in self.pieces:
            if seconds < piece.seconds:
                return piece.at(max(seconds, 0.0))
            seconds -= piece.seconds
        return self.distance + self.end_speed * seconds, self.end_speed, self._end[2]

    def phase_end_s(self, seconds: float) -> float:
        """Return the end of the piece at an instant; infinite after the last one."""
        end_s = 0.0
        for piece in self.pieces:
            end_s += piece.seconds
            if seconds < end_s:
                return end_s
        return math.inf

    def turning_position(self) -> float:
        """Return the position at which the speed passes through zero."""
        for piece in self.pieces:
            if piece.speed > 0 and piece.at(piece.seconds)[1] <= 0:
                low, high = 0.0, piece.seconds
                for _ in range(_HALVINGS):
                    middle = (low + high) / 2
                    low, high = (middle, high) if piece.at(middle)[1] > 0 else (low, middle)
                return piece.at(low)[0]
        return self.distance


def change_speed(speed: float, wanted: float, limits: Limits, acceleration: float = 0.0) -> JerkProfile:
    """Return the profile from one speed to another; if its sign changes, the axis comes to rest between them."""
    profile = JerkProfile(speed, acceleration)
    if profile.relaxed(limits.jerk) * wanted < 0:
        profile.ramp(0.0, limits.deceleration, limits.jerk)
    rate = limits.acceleration if abs(wanted) > abs(profile.relaxed(limits.jerk)) else limits.deceleration
    if speed * wanted < 0:
        rate = min(limits.acceleration, limits.deceleration)
    profile.ramp(wanted, rate, limits.jerk)
    return profile


def move(distance: float, speed: float, limits: Limits, acceleration: float = 0.0) -> JerkProfile:
    """Return the profile that ends at rest at `distance`."""
    stop = change_speed(speed, 0.0, limits, acceleration)
    left = distance - stop.distance
    if abs(left) <= ROUNDING * abs(distance):  # a rest of rounding would be crawled
        stop.end_at(distance)
        return stop
    if left * (speed or acceleration or left) < 0:  # too short to stop, or behind the axis: stop, then return
        stop.then(move(left, 0.0, limits), 1.0)
        stop.end_at(distance)
        return stop
    sign = math.copysign(1.0, speed or acceleration or left)

    def motion(share: float) -> JerkProfile:
        profile = change_speed(speed, sign * share * limits.speed, limits, acceleration)
        profile.ramp(0.0, limits.deceleration, limits.jerk)
        return profile

    way = sign * distance
    share = largest(lambda share: sign * motion(share).distance <= way)
    profile = change_speed(speed, sign * share * limits.speed, limits, acceleration)
    profile.cruise((way - sign * motion(share).distance) / (share * limits.speed))
    profile.ramp(0.0, limits.deceleration, limits.jerk)
    profile.end_at(distance)
    return profile


def pass_through(distance: float, speed: float, limits: Limits, acceleration: float = 0.0) -> JerkProfile:
    """Return the profile over `distance` that keeps its speed at the end.  `distance` must lie ahead of the axis."""
    top = math.copysign(limits.speed, distance)
    profile = change_speed(speed, top, limits, acceleration)
    left = (distance - profile.distance) / top
    if left < 0:
        profile.cut(distance)
    else:
        profile.cruise(left)
    profile.end_at(distance)
    return profile


def largest(fits: Callable[[float], bool]) -> float:
    """Return the largest share from 0 to 1 that fits."""
    if fits(1.0):
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low or high
