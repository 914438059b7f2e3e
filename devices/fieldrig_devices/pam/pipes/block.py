"""The parts that all blocks share: their life, their value, and the arithmetic of periods (section 2.18)."""

import math
from abc import ABC, abstractmethod


class Block(ABC):
    """A transformer or output of a pipe.

    A block lives from the activation of its first pipe to the end of its last (PAML-409).  `start` begins its history
    again, with the values of its declaration.
    """

    def __init__(self) -> None:
        self.value = 0.0
        """The number that leaves the block."""
        self.is_active = False
        self.period_s = 0.0
        """Time between two values of the flow, in seconds."""
        self.period: float | None = None
        """The period of the flow that arrives, from the source or a periodic transformer (PAML-410); None without."""

    @property
    def ready(self) -> bool:
        return True

    @property
    @abstractmethod
    def is_at_rest(self) -> bool:
        """True if the last value of the flow, taken once more, would change neither the block nor its output."""

    @property
    def outgoing_period(self) -> float | None:
        """The period of the flow that leaves the block."""
        return self.period

    def start(self, period_s: float) -> None:
        """The first pipe with this block is activated; `period_s` is its period in seconds."""
        self.period_s = period_s
        self.is_active = True
        self.value = 0.0

    def stop(self) -> None:
        """The last pipe with this block has ended."""
        self.is_active = False

    def pass_on(self, value: float) -> float:
        """Take a value of the flow, and return what leaves the block."""
        self.value = self.transform(value)
        return self.value

    @abstractmethod
    def transform(self, value: float) -> float:
        """Return what the block makes of a value."""


def is_same(value: float, other: float | None) -> bool:
    """Return whether two numbers have the same bits, as 0.0 and -0.0 do not.  A NaN is never the same."""
    return value == other and (value != 0.0 or math.copysign(1.0, value) == math.copysign(1.0, other))


def wrapped(value: float, period: float | None) -> float:
    """Return a value within [0, period), or the value itself in a system without a period (G-14)."""
    if period is None:
        return value
    rest = math.fmod(value, period)
    rest = rest + period if rest < 0 else rest
    return 0.0 if rest >= period else rest


def nearest(difference: float, period: float | None) -> float:
    """Return a difference within half a period around zero, the shortest way in a periodic system (PAML-531)."""
    return difference if period is None else difference - period * round(difference / period)


def effective_period_s(period_s: float, thirds: int) -> float:
    """Return the multiple of the basic cycle that is nearest to a period, at least one cycle (PAML-413).

    `thirds` is BASIC_PAM_CYCLE in thirds of a millisecond.  A value in the middle is rounded up.
    """
    cycles = max(1, math.floor(period_s * 3000 / thirds + 0.5))
    return cycles * thirds / 3000


class Slewed:
    """A parameter that moves to its new value with a limited rate (PAML-431, PAML-584)."""

    def __init__(self, value: float, slope: float | None) -> None:
        """`slope` is the rate in units a second; None changes at once."""
        self.value, self.target, self.slope = value, value, slope
        self._begin, self._moving_s = value, 0.0

    @property
    def is_there(self) -> bool:
        return self.value == self.target

    def set(self, target: float, *, at_once: bool) -> None:
        """Change the parameter; outside an active block it changes at once."""
        self.target = target
        if at_once or self.slope is None:
            self.value = target
        self._begin, self._moving_s = self.value, 0.0

    def finish(self) -> None:
        """Apply what is left of a change, as at the end of a pipe (PAML-433, PAML-587)."""
        self.value = self._begin = self.target

    def step(self, period_s: float) -> float:
        """Go on for a period, and return the instantaneous value."""
        left = self.target - self._begin
        self._moving_s += period_s
        moved = math.inf if self.slope is None else self.slope * self._moving_s
        is_there = moved >= abs(left) * (1 - 1e-9)
        self.value = self.target if is_there else self._begin + math.copysign(moved, left)
        return self.value
