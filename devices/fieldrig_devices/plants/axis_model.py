"""One axis: inertia, viscous and dry friction, hard stops, and a torque that follows its reference with a lag.

    J dw/dt = T + L - b w - Tc sign(w)        T = reference + (T0 - reference) exp(-t / lag)

As long as the direction of travel stays, this is linear, and `Course` is its exact solution; a course ends where the
axis comes to a standstill, meets a stop, or breaks away.  At a standstill it holds while |T + L| is within the
breakaway torque, so nothing creeps through zero.  `after` walks from course to course: time steps may be of any length.
SI units at the shaft of the motor.  Left out: elasticity, backlash, a stop that springs back, Stribeck's curve.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from typing import NamedTuple

NO_TORQUE = 1e-12
"""What is left of a lag and no longer felt: else it would outlast the figures of a float."""


@dataclass(frozen=True, slots=True)
class Mechanics:
    """What doesn't change while the axis moves."""

    inertia: float
    viscous: float = 0.0
    coulomb: float = 0.0
    breakaway: float = 0.0
    """Torque to start from a standstill; at least `coulomb`."""
    low: float = -inf
    high: float = inf
    lag_s: float = 0.0
    decay: float = field(init=False)
    """b / J, per second."""
    rate: float = field(init=False)
    """1 / lag, per second; 0 without a lag."""

    def __post_init__(self) -> None:
        decay = self.viscous / self.inertia
        rate = 1 / self.lag_s if self.lag_s > 0 else 0.0
        if rate and abs(rate - decay) < 1e-4 * decay:
            rate = decay * 1.0001  # the solution for equal rates is another one; nobody sees 0.01 % of a lag
        object.__setattr__(self, "breakaway", max(self.breakaway, self.coulomb))
        object.__setattr__(self, "decay", decay)
        object.__setattr__(self, "rate", rate)


class State(NamedTuple):
    """An axis at one instant."""

    position: float
    speed: float = 0.0
    torque: float = 0.0
    """Of the motor; without a lag it is the reference."""


class End(NamedTuple):
    """Where a course ends, and which way the axis goes on; None: as its torque says."""

    seconds: float
    state: State
    direction: int | None = None


class Tangent(NamedTuple):
    """A parabola from the beginning of a course on, and how long it is good."""

    speed: float
    acceleration: float
    seconds: float


def after(mechanics: Mechanics, state: State, reference: float, load: float, seconds: float) -> State:
    """The axis some time later, under a steady reference and external torque."""
    direction: int | None = None
    while True:
        course = Course(mechanics, state, reference, load, direction)
        end = course.end(seconds)
        if end is None:
            return course.state(seconds)
        seconds -= end.seconds
        state, direction = end.state, end.direction


class Course:
    """The exact solution from one state on, in one direction of travel: 1, -1, or 0 while the axis holds."""

    __slots__ = ("_fade", "_mechanics", "_net", "_position", "_pull", "_reference", "_speed", "direction")

    def __init__(
        self, mechanics: Mechanics, state: State, reference: float, load: float, direction: int | None = None
    ) -> None:
        """`direction` says which way an axis goes that has just broken away."""
        position, speed, torque = state
        self._mechanics, self._reference = mechanics, reference
        self._position, self._speed = position, speed
        self._net = reference + load
        fade = torque - reference if mechanics.rate else 0.0
        if abs(fade) < NO_TORQUE:
            fade = 0.0
        if direction is None:
            direction = _direction(mechanics, position, speed, self._net + fade)
        self.direction = direction
        # accelerations: towards the final torque, and of what fades with the lag
        self._pull = (self._net - direction * mechanics.coulomb) / mechanics.inertia - mechanics.decay * speed
        self._fade = fade / mechanics.inertia

    def at(self, seconds: float) -> tuple[float, float]:
        """Position and speed."""
        if not self.direction:
            return self._position, 0.0
        mechanics = self._mechanics
        once, twice = _integrals(mechanics.decay, seconds)
        speed = self._speed
        position = self._position + speed * seconds + self._pull * twice
        speed += self._pull * once
        if self._fade:
            rate, decay = mechanics.rate, mechanics.decay
            faded = -math.expm1(-rate * seconds) / rate
            weight = self._fade / (rate - decay)
            speed += weight * (rate * faded - decay * once)
            position += weight * (once - faded)
        return position, speed

    def state(self, seconds: float) -> State:
        position, speed = self.at(seconds)
        torque = self._reference
        if self._fade:
            mechanics = self._mechanics
            torque += self._fade * mechanics.inertia * math.exp(-mechanics.rate * seconds)
        return State(position, speed, torque)

    def end(self, within: float) -> End | None:
        """Where the course ends, if it does in this time."""
        if not self.direction:
            return self._breakaway(within)
        position, speed = self.at(within)
        standstill = self._standstill(within, speed)
        if standstill is None and speed * self.direction < 0:  # by rounding it has set out the wrong way
            return End(0.0, self.state(0.0), 0)
        if standstill is not None:
            within, (position, _) = standstill, self.at(standstill)
        stop = self._mechanics.high if self.direction > 0 else self._mechanics.low
        if (position - stop) * self.direction >= 0:
            met = self.seconds_to(stop, within)
            return End(met, State(stop, 0.0, self.state(met).torque))
        if standstill is None:
            return None
        position = min(max(position, self._mechanics.low), self._mechanics.high)  # rounding at the stop it came from
        return End(within, State(position, 0.0, self.state(within).torque))

    def seconds_to(self, position: float, within: float) -> float:
        """When the axis is at a position that it passes in this time."""
        way = (position - self._position) * self.direction
        if way <= 0:
            return 0.0
        return _root(lambda t: self._lead(position, t), within)

    def tangent(self, tolerance: float) -> Tangent:
        """The parabola that departs by less than `tolerance` for as long as it says."""
        if not self.direction:
            return Tangent(0.0, 0.0, inf)
        decay, rate, pull, fade = self._mechanics.decay, self._mechanics.rate, self._pull, self._fade
        if decay and (abs(pull) + abs(fade)) <= tolerance * decay * min(decay, rate or decay):
            return Tangent(self._speed + pull / decay, 0.0, inf)  # what is missing at the final speed stays below
        if fade and not decay and abs(fade) <= tolerance * rate * rate:
            return Tangent(self._speed + fade / rate, pull, inf)
        jerk = decay * (abs(pull) + 2 * abs(fade)) + rate * abs(fade)  # at most, from here on
        return Tangent(self._speed, pull + fade, (6 * tolerance / jerk) ** (1 / 3) if jerk else inf)

    def _lead(self, position: float, seconds: float) -> tuple[float, float]:
        """How far a position lies ahead, and how that changes: what `_root` brings to 0."""
        at, speed = self.at(seconds)
        return (position - at) * self.direction, -speed * self.direction

    def _pace(self, seconds: float) -> tuple[float, float]:
        """Speed in the direction of travel, and how that changes."""
        return self.at(seconds)[1] * self.direction, self._acceleration(seconds) * self.direction

    def _acceleration(self, seconds: float) -> float:
        decay, rate = self._mechanics.decay, self._mechanics.rate
        slow = math.exp(-decay * seconds)
        if not self._fade:
            return self._pull * slow
        return self._pull * slow + self._fade * (rate * math.exp(-rate * seconds) - decay * slow) / (rate - decay)

    def _standstill(self, within: float, speed_then: float) -> float | None:
        """When the speed comes to 0 in this time."""
        direction, pace = self.direction, self._speed * self.direction
        if not self._fade:
            if speed_then * direction > 0 or self._pull * direction >= 0:
                return None
            return min(within, _seconds_to_lose(pace, -self._pull * direction, self._mechanics.decay))
        if speed_then * direction > 0 and pace > (abs(self._pull) + 2 * abs(self._fade)) * within:
            return None  # it can't lose so much
        turn = self._turn()  # the acceleration changes its sign once at most
        begins_slower = (self._pull + self._fade) * direction < 0
        if turn is None or turn >= within:
            return _root(self._pace, within) if pace > 0 and speed_then * direction <= 0 else None
        if not begins_slower:
            return _root(self._pace, within, turn) if speed_then * direction <= 0 else None
        if pace > 0 and self._pace(turn)[0] <= 0:
            return _root(self._pace, turn)
        return None

    def _turn(self) -> float | None:
        """When the acceleration is 0."""
        decay, rate = self._mechanics.decay, self._mechanics.rate
        apart = rate - decay
        share = (decay * self._fade - apart * self._pull) / (rate * self._fade)  # exp(-apart * t)
        if share <= 0 or (seconds := -math.log(share) / apart) <= 0:
            return None
        return seconds

    def _breakaway(self, within: float) -> End | None:
        """When the torque, on its way to the reference, has grown enough to move an axis that holds."""
        mechanics, fade = self._mechanics, self._fade * self._mechanics.inertia
        if not fade:
            return None
        direction = -1 if fade > 0 else 1  # the torque runs against what fades
        is_at_stop = self._position >= mechanics.high if direction > 0 else self._position <= mechanics.low
        excess = self._net * direction - mechanics.breakaway  # in the end
        if is_at_stop or excess <= 0:
            return None
        seconds = max(0.0, math.log(abs(fade) / excess) / mechanics.rate)
        return End(seconds, self.state(seconds), direction) if seconds < within else None


def _direction(mechanics: Mechanics, position: float, speed: float, torque: float) -> int:
    if speed:
        return 1 if speed > 0 else -1
    if torque > mechanics.breakaway and position < mechanics.high:
        return 1
    if torque < -mechanics.breakaway and position > mechanics.low:
        return -1
    return 0


def _integrals(decay: float, seconds: float) -> tuple[float, float]:
    """Of exp(-decay * t), once and twice, in the form in which no terms cancel."""
    z = decay * seconds
    if z > 0.02:
        once = -math.expm1(-z) / decay
        return once, (seconds - once) / decay
    once = seconds * (1 - z / 2 * (1 - z / 3 * (1 - z / 4 * (1 - z / 5 * (1 - z / 6)))))
    twice = seconds * seconds / 2 * (1 - z / 3 * (1 - z / 4 * (1 - z / 5 * (1 - z / 6 * (1 - z / 7)))))
    return once, twice


def _seconds_to_lose(speed: float, deceleration: float, decay: float) -> float:
    """When a speed is 0 that begins to fall by `deceleration`, which it does."""
    z = decay * speed / deceleration
    if z >= 1:  # by rounding
        return inf
    return -math.log1p(-z) / decay if z > 1e-12 else speed / deceleration


def _root(function: Callable[[float], tuple[float, float]], high: float, low: float = 0.0) -> float:
    """Where a function, given with its slope, falls through 0: Newton's steps, halving where they lead out."""
    guess = high
    for _ in range(100):
        value, slope = function(guess)
        low, high = (guess, high) if value > 0 else (low, guess)
        following = guess - value / slope if slope < 0 else -1.0
        if not low <= following <= high:
            following = (low + high) / 2
        if abs(following - guess) <= 1e-14 * guess:
            return following
        guess = following
    return guess
