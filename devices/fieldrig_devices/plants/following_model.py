"""A position loop that follows a parabola: the exact following error, and the instants at which it reaches a level.

The loop asks for a speed proportional to the following error, up to the highest speed of the motor.  While it is below
that, e' = v + a t - k e, so the error is a line plus an exponential; at the highest speed it is a parabola.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import exp, inf, log
from typing import Final

_LONGEST_S: Final = 1e6
_HALVINGS: Final = 60


@dataclass(frozen=True, slots=True)
class Following:
    """A motion from an instant on: the error then, speed and acceleration of the command, gain in 1/s, highest speed.

    A highest speed of 0 is a motor that is blocked.
    """

    error: float
    speed: float
    acceleration: float
    gain: float
    highest: float

    @property
    def limited(self) -> int:
        """1 or -1 while the motor turns as fast as it can in that direction, otherwise 0."""
        wanted = self.gain * self.error
        if not self.highest:
            return 1
        if abs(wanted) < self.highest:
            return 0
        sign = 1 if wanted > 0 else -1
        if abs(wanted) == self.highest and (self.speed - sign * self.highest) * sign <= 0:
            return 0
        return sign

    @property
    def _begin(self) -> float:
        """The part of the error that dies away."""
        return self.error - self.speed / self.gain + self.acceleration / self.gain**2

    def error_at(self, seconds: float) -> float:
        if self.limited:
            return self.error + (self.speed - self.limited * self.highest + self.acceleration / 2 * seconds) * seconds
        steady = (self.speed + self.acceleration * seconds) / self.gain - self.acceleration / self.gain**2
        return steady + self._begin * exp(-self.gain * seconds)

    def motion_at(self, seconds: float) -> tuple[float, float]:
        """Return speed and acceleration of the motor."""
        if self.limited:
            return self.limited * self.highest, 0.0
        error = self.error_at(seconds)
        slope = self.speed + self.acceleration * seconds - self.gain * error
        return self.gain * error, self.gain * slope

    def seconds_within(self, tolerance: float) -> float:
        """Return how long the motor's motion is a parabola within this tolerance."""
        third = 0.0 if self.limited else abs(self._begin) * self.gain**3
        return float((6 * tolerance / third) ** (1 / 3)) if third else inf

    def seconds_to_change(self, within: float) -> float:
        """Return when the motor reaches or leaves its highest speed; infinite if not within this time."""
        if self.limited:
            return self._first(self.limited * self.highest / self.gain, within)
        return min(self._first(side * self.highest / self.gain, within) for side in (1, -1))

    def seconds_to(self, level: float, within: float) -> float:
        """Return when the error goes beyond a level of either sign; infinite if not within this time."""
        return min(self._first(side * level, within) for side in (1, -1))

    def _first(self, level: float, within: float) -> float:
        """Return the first instant after the beginning at which the error is at a level."""
        limit = min(within, _LONGEST_S)
        for begin, end in self._monotone(limit):
            low, high = self.error_at(begin) - level, self.error_at(end) - level
            if high == 0 or ((low < 0) is not (high < 0) and low != 0):
                return self._halve(begin, end, level)
        return inf

    def _halve(self, begin: float, end: float, level: float) -> float:
        is_below = self.error_at(begin) < level
        for _ in range(_HALVINGS):
            middle = (begin + end) / 2
            if (self.error_at(middle) < level) is is_below:
                begin = middle
            else:
                end = middle
        return end

    def _monotone(self, limit: float) -> Iterator[tuple[float, float]]:
        """Yield the times between which the error only rises or only falls."""
        turn = self._turn()
        if 0 < turn < limit:
            yield 0.0, turn
            yield turn, limit
        else:
            yield 0.0, limit

    def _turn(self) -> float:
        """The instant at which the slope of the error is zero; -1 if there is none."""
        if self.limited:
            return -(self.speed - self.limited * self.highest) / self.acceleration if self.acceleration else -1.0
        ratio = self.acceleration / self.gain / (self.gain * self._begin) if self._begin else 0.0
        return -log(ratio) / self.gain if ratio > 0 else -1.0
