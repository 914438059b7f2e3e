"""One axis: inertia, viscous and dry friction, hard stops, and a torque that follows its reference with a lag.

    J dw/dt = T + L - b w - Tc sign(w)        T = reference + (T0 - reference) exp(-t / lag)

While the direction of travel is constant, this is linear, and a `Segment` is its exact solution.  A segment ends where
the axis comes to a standstill, reaches a stop, or breaks away.  At standstill the axis holds while |T + L| is within
the breakaway torque, so it does not creep through zero.  `after` goes from segment to segment over any length of time.
SI units at the shaft of the motor.  Left out: elasticity, backlash, elastic stops, the Stribeck curve.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from typing import NamedTuple

NO_TORQUE = 1e-12
"""Rest of a lag, in N m, that is treated as 0, because it would never vanish in floating point."""


@dataclass(frozen=True, slots=True)
class Mechanics:
    """The constants of an axis."""

    inertia: float
    viscous: float = 0.0
    coulomb: float = 0.0
    breakaway: float = 0.0
    """Torque to start from standstill; at least `coulomb`."""
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
            rate = decay * 1.0001  # equal rates would need another solution; 0.01 % of a lag is negligible
        object.__setattr__(self, "breakaway", max(self.breakaway, self.coulomb))
        object.__setattr__(self, "decay", decay)
        object.__setattr__(self, "rate", rate)


class State(NamedTuple):
    """An axis at one instant."""

    position: float
    speed: float = 0.0
    torque: float = 0.0
    """Torque of the motor; without a lag it is the reference."""


class End(NamedTuple):
    """The end of a segment, and the direction after it, or None if the torque determines it."""

    seconds: float
    state: State
    direction: int | None = None


class Tangent(NamedTuple):
    """A parabola from the start of a segment, and the time for which it is accurate."""

    speed: float
    acceleration: float
    seconds: float


def after(mechanics: Mechanics, state: State, reference: float, load: float, seconds: float) -> State:
    """Return the axis some time later, under constant reference and external torque."""
    direction: int | None = None
    while True:
        segment = Segment(mechanics, state, reference, load, direction)
        end = segment.end(seconds)
        if end is None:
            return segment.state(seconds)
        seconds -= end.seconds
        state, direction = end.state, end.direction


class Segment:
    """The exact solution from a state, in one direction of travel: 1, -1, or 0 while the axis holds."""

    __slots__ = ("_fade", "_mechanics", "_net", "_position", "_pull", "_reference", "_speed", "direction")

    def __init__(
        self, mechanics: Mechanics, state: State, reference: float, load: float, direction: int | None = None
    ) -> None:
        """`direction` is that of an axis that has just broken away."""
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
        # accelerations: by the final torque, and by the part that decays with the lag
        self._pull = (self._net - direction * mechanics.coulomb) / mechanics.inertia - mechanics.decay * speed
        self._fade = fade / mechanics.inertia

    def at(self, seconds: float) -> tuple[float, float]:
        """Return position and speed after a time."""
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
        """Return the end of the segment, or None if it continues beyond this time."""
        if not self.direction:
            return self._breakaway(within)
        position, speed = self.at(within)
        standstill = self._standstill(within, speed)
        if standstill is None and speed * self.direction < 0:  # rounding has started it in the wrong direction
            return End(0.0, self.state(0.0), 0)
        if standstill is not None:
            within, (position, _) = standstill, self.at(standstill)
        stop = self._mechanics.high if self.direction > 0 else self._mechanics.low
        if (position - stop) * self.direction >= 0:
            met = self.seconds_to(stop, within)
            return End(met, State(stop, 0.0, self.state(met).torque))
        if standstill is None:
            return None
        position = min(
            max(position, self._mechanics.low), self._mechanics.high
        )  # rounding at the stop where it started
        return End(within, State(position, 0.0, self.state(within).torque))

    def seconds_to(self, position: float, within: float) -> float:
        """Return when the axis reaches a position that it passes in this time."""
        way = (position - self._position) * self.direction
        if way <= 0:
            return 0.0
        return _root(lambda t: self._lead(position, t), within)

    def tangent(self, tolerance: float) -> Tangent:
        """Return a parabola that is accurate to `tolerance` for its time."""
        if not self.direction:
            return Tangent(0.0, 0.0, inf)
        decay, rate, pull, fade = self._mechanics.decay, self._mechanics.rate, self._pull, self._fade
        if decay and (abs(pull) + abs(fade)) <= tolerance * decay * min(decay, rate or decay):
            return Tangent(self._speed + pull / decay, 0.0, inf)  # the difference to the final speed stays below it
        if fade and not decay and abs(fade) <= tolerance * rate * rate:
            return Tangent(self._speed + fade / rate, pull, inf)
        jerk = decay * (abs(pull) + 2 * abs(fade)) + rate * abs(fade)  # upper bound from here on
        return Tangent(self._speed, pull + fade, (6 * tolerance / jerk) ** (1 / 3) if jerk else inf)

    def _lead(self, position: float, seconds: float) -> tuple[float, float]:
        """Return the distance to a position ahead, and its rate of change."""
        at, speed = self.at(seconds)
        return (position - at) * self.direction, -speed * self.direction

    def _pace(self, seconds: float) -> tuple[float, float]:
        """Return the speed in the direction of travel, and its rate of change."""
        return self.at(seconds)[1] * self.direction, self._acceleration(seconds) * self.direction

    def _acceleration(self, seconds: float) -> float:
        decay, rate = self._mechanics.decay, self._mechanics.rate
        slow = math.exp(-decay * seconds)
        if not self._fade:
            return self._pull * slow
        return self._pull * slow + self._fade * (rate * math.exp(-rate * seconds) - decay * slow) / (rate - decay)

    def _standstill(self, within: float, speed_then: float) -> float | None:
        """Return when the speed reaches 0 in this time, or None."""
        direction, pace = self.direction, self._speed * self.direction
        if not self._fade:
            if speed_then * direction > 0 or self._pull * direction >= 0:
                return None
            return min(within, _seconds_to_lose(pace, -self._pull * direction, self._mechanics.decay))
        if speed_then * direction > 0 and pace > (abs(self._pull) + 2 * abs(self._fade)) * within:
            return None  # it cannot lose that much speed
        turn = self._turn()  # the acceleration changes sign once at most
        begins_slower = (self._pull + self._fade) * direction < 0
        if turn is None or turn >= within:
            return _root(self._pace, within) if pace > 0 and speed_then * direction <= 0 else None
        if not begins_slower:
            return _root(self._pace, within, turn) if speed_then * direction <= 0 else None
        if pace > 0 and self._pace(turn)[0] <= 0:
            return _root(self._pace, turn)
        return None

    def _turn(self) -> float | None:
        """Return when the acceleration is 0, or None."""
        decay, rate = self._mechanics.decay, self._mechanics.rate
        apart = rate - decay
        share = (decay * self._fade - apart * self._pull) / (rate * self._fade)  # exp(-apart * t)
        if share <= 0 or (seconds := -math.log(share) / apart) <= 0:
            return None
        return seconds

    def _breakaway(self, within: float) -> End | None:
        """Return the end of a standstill, where the torque on its way to the reference reaches the breakaway torque."""
        mechanics, fade = self._mechanics, self._fade * self._mechanics.inertia
        if not fade:
            return None
        direction = -1 if fade > 0 else 1  # the torque changes against its decaying part
        is_at_stop = self._position >= mechanics.high if direction > 0 else self._position <= mechanics.low
        excess = self._net * direction - mechanics.breakaway  # final value
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
    """Return the single and double integral of exp(-decay * t), in a form without cancellation."""
    z = decay * seconds
    if z > 0.02:
        once = -math.expm1(-z) / decay
        return once, (seconds - once) / decay
    once = seconds * (1 - z / 2 * (1 - z / 3 * (1 - z / 4 * (1 - z / 5 * (1 - z / 6)))))
    twice = seconds * seconds / 2 * (1 - z / 3 * (1 - z / 4 * (1 - z / 5 * (1 - z / 6 * (1 - z / 7)))))
    return once, twice


def _seconds_to_lose(speed: float, deceleration: float, decay: float) -> float:
    """Return when a speed that falls with `deceleration` at first reaches 0."""
    z = decay * speed / deceleration
    if z >= 1:  # because of rounding
        return inf
    return -math.log1p(-z) / decay if z > 1e-12 else speed / deceleration


def _root(function: Callable[[float], tuple[float, float]], high: float, low: float = 0.0) -> float:
    """Return where a function, given with its slope, falls through 0: Newton's method, with bisection as a fallback."""
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
