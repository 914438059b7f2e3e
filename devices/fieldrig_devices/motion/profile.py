"""How an axis gets from one speed to another, or over a distance to rest: the closed solution, phase by phase.

Source: ASA-RT manual 5.9.3 (ARP digest chapter 12), CiA 402-2 (profile type 0, linear ramp).  Speed, acceleration and
deceleration are limited, jerk is not; acceleration is what makes the speed's amount grow, deceleration what makes it
fall.  A profile begins at any speed: one above the limit is brought down to it, and where the distance is too short to
stop in, the axis overshoots and comes back.  Positions are counted from where the profile begins, time in seconds from
its start; the unit of length is the caller's.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple


class Limits(NamedTuple):
    """Each greater than 0."""

    speed: float
    acceleration: float
    deceleration: float


class State(NamedTuple):
    """Where a profile is at one instant."""

    position: float
    speed: float
    acceleration: float


class Phase(NamedTuple):
    """Constant acceleration, from the state that it begins with."""

    begin_s: float
    end_s: float
    position: float
    speed: float
    acceleration: float


class Profile:
    """Phases in a row; after the last one the end speed is kept for ever."""

    __slots__ = ("_phases", "distance", "duration_s", "end_speed")

    def __init__(self, speed: float, steps: Iterable[tuple[float, float]], end_speed: float) -> None:
        """`steps` are seconds and an acceleration."""
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
        return State(*self.course(seconds))

    def course(self, seconds: float) -> tuple[float, float, float]:
        """As `at`, without names, for callers that ask in every cycle; at its end speed it costs a multiplication."""
        passed = seconds - self.duration_s
        if passed >= 0:
            return self.distance + self.end_speed * passed, self.end_speed, 0.0
        for phase in self._phases:
            if seconds < phase[1]:
                break
        begin_s, _, position, speed, acceleration = phase
        passed = seconds - begin_s
        return position + (speed + acceleration / 2 * passed) * passed, speed + acceleration * passed, acceleration


def keep(speed: float) -> Profile:
    return Profile(speed, (), speed)


def change_speed(speed: float, wanted: float, limits: Limits) -> Profile:
    """Through rest if the sign changes."""
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
    """To rest at `distance`."""
    stopping = speed * abs(speed) / (2 * limits.deceleration)
    if (distance - stopping) * speed < 0:  # too near to stop in, or behind: stop, then come back
        steps = [_step(speed, 0.0, limits), *_straight(distance - stopping, 0.0, limits)]
    else:
        steps = _straight(distance, abs(speed), limits)
    return Profile(speed, steps, 0.0)


def pass_through(distance: float, speed: float, limits: Limits) -> Profile:
    """Over `distance` without a stop: at its end the speed is kept.  Not for a distance behind."""
    top = math.copysign(limits.speed, distance)
    seconds, rate = _step(speed, top, limits)
    ways = (speed + top) / 2 * seconds
    if abs(ways) >= abs(distance):
        seconds = abs(_root(speed, rate, distance))
        return Profile(speed, [(seconds, rate)], speed + rate * seconds)
    return Profile(speed, [(seconds, rate), ((distance - ways) / top, 0.0)], top)


def _root(speed: float, rate: float, distance: float) -> float:
    """When a motion with constant acceleration has covered `distance`."""
    return 2 * distance / (speed + math.copysign(math.sqrt(speed * speed + 2 * rate * distance), distance))


def _step(speed: float, wanted: float, limits: Limits) -> tuple[float, float]:
    """From one speed to another of the same sign, or from or to rest."""
    if abs(wanted) > abs(speed):
        return abs(wanted - speed) / limits.acceleration, math.copysign(limits.acceleration, wanted)
    return abs(speed - wanted) / limits.deceleration, -math.copysign(limits.deceleration, speed)


def _straight(distance: float, speed: float, limits: Limits) -> list[tuple[float, float]]:
    """Trapezoid or triangle without a turn; `speed` is its amount, and the distance is long enough to stop in."""
    top, a, d = limits
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
