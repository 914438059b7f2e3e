"""Motion profiles: change the speed of an axis, or move it over a distance, in closed form, phase by phase.

Source: ASA-RT manual 5.9.3 (ARP digest chapter 12), CiA 402-2 (profile type 0, linear ramp).  Speed, acceleration and
deceleration are limited, jerk is not; acceleration increases the magnitude of the speed, deceleration reduces it.  A
profile may begin at any speed: a speed above the limit is reduced to it, and where the distance is too short to stop,
the axis overshoots and returns.  Positions count from the start of the profile, and so does the time, in seconds; the
unit of length is the caller's.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple


class Limits(NamedTuple):
    """Limits of a profile, each greater than 0."""

    speed: float
    acceleration: float
    deceleration: float
    jerk: float = math.inf
    """The profiles of this module have none; those of `jerk` do."""


class State(NamedTuple):
    """Position, speed and acceleration of a profile at one instant."""

    position: float
    speed: float
    acceleration: float


class Phase(NamedTuple):
    """A phase of constant acceleration; `position` and `speed` are those at its start."""

    begin_s: float
    end_s: float
    position: float
    speed: float
    acceleration: float


class Profile:
    """Consecutive phases; after the last one the axis keeps its end speed forever."""

    __slots__ = ("_phases", "distance", "duration_s", "end_speed")

    def __init__(self, speed: float, steps: Iterable[tuple[float, float]], end_speed: float) -> None:
        """`steps` are pairs of a duration in seconds and an acceleration."""
        self._phases: list[Phase] = []
        begin_s = position = 0.0
        for seconds, acceleration in steps:
            if seconds > 0:
                self._phases.append(Phase(begin_s, begin_s + seconds, position, speed, acceleration))
                position += (speed + acceleration / 2 * seconds) * seconds
                speed += acceleration * seconds
                begin_s += seconds
        self.duration_s, self.end_speed = begin_s, end_speed
        self.distance = position
        """To where the end speed begins."""
        self._phases.append(Phase(begin_s, math.inf, position, end_speed, 0.0))

    def at(self, seconds: float) -> State:
        return State(*self.values_at(seconds))

    def values_at(self, seconds: float) -> tuple[float, float, float]:
        """Return position, speed and acceleration as a plain tuple, for use in every cycle; cheap at the end speed."""
        passed = seconds - self.duration_s
        if passed >= 0:
            return self.distance + self.end_speed * passed, self.end_speed, 0.0
        for phase in self._phases:
            if seconds < phase[1]:
                break
        begin_s, _, position, speed, acceleration = phase
        passed = seconds - begin_s
        return position + (speed + acceleration / 2 * passed) * passed, speed + acceleration * passed, acceleration

    def phase_end_s(self, seconds: float) -> float:
        """Return the end of the phase at an instant; infinite after the last ramp."""
        return next(phase.end_s for phase in self._phases if seconds < phase.end_s)


def keep(speed: float) -> Profile:
    return Profile(speed, (), speed)


def change_speed(speed: float, wanted: float, limits: Limits) -> Profile:
    """Return the profile from one speed to another; it passes through standstill if the sign changes."""
    steps = []
    if speed * wanted < 0:
        steps.append(_step(speed, 0.0, limits))
        steps.append(_step(0.0, wanted, limits))
    else:
        steps.append(_step(speed, wanted, limits))
    return Profile(speed, steps, wanted)


def brake(speed: float, limits: Limits) -> Profile:
    return change_speed(speed, 0.0, limits)


def move(distance: float, speed: float, limits: Limits) -> Profile:
    """Return the profile that ends at rest at `distance`."""
    stopping = speed * abs(speed) / (2 * limits.deceleration)
    if (distance - stopping) * speed < 0:  # too short to stop, or behind the axis: stop, then return
        steps = [_step(speed, 0.0, limits), *_straight(distance - stopping, 0.0, limits)]
    else:
        steps = _straight(distance, abs(speed), limits)
    return Profile(speed, steps, 0.0)


def pass_through(distance: float, speed: float, limits: Limits) -> Profile:
    """Return the profile over `distance` that keeps its speed at the end.  `distance` must lie ahead of the axis."""
    top = math.copysign(limits.speed, distance)
    seconds, rate = _step(speed, top, limits)
    ways = (speed + top) / 2 * seconds
    if abs(ways) >= abs(distance):
        seconds = abs(_root(speed, rate, distance))
        return Profile(speed, [(seconds, rate)], speed + rate * seconds)
    return Profile(speed, [(seconds, rate), ((distance - ways) / top, 0.0)], top)


def _root(speed: float, rate: float, distance: float) -> float:
    """Return the time in seconds in which a motion with constant acceleration covers `distance`."""
    return 2 * distance / (speed + math.copysign(math.sqrt(speed * speed + 2 * rate * distance), distance))


def _step(speed: float, wanted: float, limits: Limits) -> tuple[float, float]:
    """Return duration and acceleration of a change of speed that doesn't change the sign."""
    if abs(wanted) > abs(speed):
        return abs(wanted - speed) / limits.acceleration, math.copysign(limits.acceleration, wanted)
    return abs(speed - wanted) / limits.deceleration, -math.copysign(limits.deceleration, speed)


def _straight(distance: float, speed: float, limits: Limits) -> list[tuple[float, float]]:
    """Return the steps of a trapezoid or triangle.  `speed` is a magnitude; the distance must suffice for stopping."""
    top, a, d, _ = limits
    length = abs(distance)
    if speed > top:
        before = (speed - top) / d, -d
        cruise_s = (length - speed * speed / (2 * d)) / top
        peak = top
    else:
        peak = min(top, max(speed, math.sqrt((2 * a * d * length + d * speed * speed) / (a + d))))
        before = (peak - speed) / a, a
        ways = (peak * peak - speed * speed) / (2 * a) + peak * peak / (2 * d)
        cruise_s = (length - ways) / peak if peak == top else 0.0
    sign = math.copysign(1.0, distance)
    return [(before[0], sign * before[1]), (cruise_s, 0.0), (peak / d, -sign * d)]
