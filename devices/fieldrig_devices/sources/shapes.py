"""The courses of values that live by themselves: each gives its value at an age, and the age of its next change.

An age is the time since the power-on of the device, in nanoseconds.  What changes steadily changes in steps of
`every_ns` here, so that a reader within a step gets the same value, and a wire is not sent more often.
"""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from datetime import datetime, timedelta
from fractions import Fraction
from hashlib import blake2b
from math import pi, sin
from typing import Final, Protocol

from fieldrig.clock import NEVER_NS, S

Number = bool | int | float


def is_on(value: Number) -> bool:
    """Return what a bit, a truth or a digital wire shows of a value: true from 0.5 on."""
    return value >= 0.5


class Source(Protocol):
    """A value over time."""

    def at(self, age_ns: int) -> Number:
        """Return the value at an age, which is never lower than in an earlier call."""

    def next_ns(self, age_ns: int) -> int:
        """Return the age of the next change after `age_ns`; `NEVER_NS` if there is none."""


class Constant:
    """The same value at all times."""

    def __init__(self, value: Number) -> None:
        self._value = value

    def at(self, age_ns: int) -> Number:
        return self._value

    def next_ns(self, age_ns: int) -> int:
        return NEVER_NS


class Sine:
    """A sine between two values; at age 0 it has the middle, and rises."""

    def __init__(self, low: float, high: float, period_ns: int, phase_deg: float, every_ns: int) -> None:
        self._middle, self._amplitude = (low + high) / 2, (high - low) / 2
        self._phase = phase_deg / 360
        self._period_ns, self._every_ns = period_ns, every_ns

    def at(self, age_ns: int) -> float:
        turns = age_ns // self._every_ns * self._every_ns % self._period_ns / self._period_ns
        return self._middle + self._amplitude * sin(2 * pi * (turns + self._phase))

    def next_ns(self, age_ns: int) -> int:
        return _after(age_ns, self._every_ns)


class Ramp:
    """A straight way from one value to another, once or again and again."""

    def __init__(self, first: float, last: float, period_ns: int, is_repeated: bool, every_ns: int) -> None:
        self._first, self._way = first, last - first
        self._period_ns, self._is_repeated, self._every_ns = period_ns, is_repeated, every_ns

    def at(self, age_ns: int) -> float:
        age_ns = age_ns // self._every_ns * self._every_ns
        passed_ns = age_ns % self._period_ns if self._is_repeated else min(age_ns, self._period_ns)
        return self._first + self._way * passed_ns / self._period_ns

    def next_ns(self, age_ns: int) -> int:
        is_over = not self._is_repeated and age_ns // self._every_ns * self._every_ns >= self._period_ns
        return NEVER_NS if is_over else _after(age_ns, self._every_ns)


class Square:
    """Two values in turns, the high one first."""

    def __init__(self, low: float, high: float, period_ns: int, high_ns: int) -> None:
        self._low, self._high, self._period_ns, self._high_ns = low, high, period_ns, high_ns

    def at(self, age_ns: int) -> float:
        return self._high if age_ns % self._period_ns < self._high_ns else self._low

    def next_ns(self, age_ns: int) -> int:
        begun_ns = age_ns // self._period_ns * self._period_ns
        return begun_ns + (self._high_ns if age_ns - begun_ns < self._high_ns else self._period_ns)


class RandomWalk:
    """A value that goes up or down by up to a step, again and again, and is held between two limits.

    The same seed gives the same way.
    """

    def __init__(self, low: float, high: float, first: float, step: float, step_ns: int, seed: str) -> None:
        self._low, self._high, self._step, self._step_ns = low, high, step, step_ns
        self._seed = seed
        self._value, self._steps = first, 0

    def at(self, age_ns: int) -> float:
        while self._steps < age_ns // self._step_ns:
            self._steps += 1
            moved = self._value + self._step * _chance(self._seed, self._steps)
            self._value = min(max(moved, self._low), self._high)
        return self._value

    def next_ns(self, age_ns: int) -> int:
        return _after(age_ns, self._step_ns)


class Counter:
    """A count that rises, or falls, at a steady rate by whole steps, and may begin again as a register does.

    Each step is at the end of its time, in both directions: what falls by 1 a second has its first value for a second.
    """

    def __init__(self, first: float, per_s: Fraction, step: Fraction, wraps_at: float | None) -> None:
        """Rate and step are fractions: 7 s at 1e-9 a nanosecond would be 7.000000000000001 steps as floats."""
        self._first, self._wraps_at = first, wraps_at
        self._step = float(step if per_s >= 0 else -step)
        rate = abs(per_s) / step / S
        self._steps, self._ns = rate.numerator, rate.denominator

    def at(self, age_ns: int) -> float:
        count = self._first + age_ns * self._steps // self._ns * self._step
        return count if self._wraps_at is None else count % self._wraps_at

    def next_ns(self, age_ns: int) -> int:
        if self._steps == 0:
            return NEVER_NS
        return -(-(age_ns * self._steps // self._ns + 1) * self._ns // self._steps)


PARTS: Final[dict[str, Callable[[datetime], int]]] = {
    "unix": lambda date: round((date - datetime(1970, 1, 1)).total_seconds()),  # noqa: DTZ001 - UTC, as all here
    "year": lambda date: date.year,
    "month": lambda date: date.month,
    "day": lambda date: date.day,
    "weekday": lambda date: date.isoweekday(),
    "hour": lambda date: date.hour,
    "minute": lambda date: date.minute,
    "second": lambda date: date.second,
}
"""The parts of a date that a source may show; `unix` counts the seconds since 1970, `weekday` is 1 for Monday."""


class DateAndTime:
    """A part of the date and time of a clock that starts at power-on."""

    def __init__(self, first: datetime, part: str) -> None:
        self._first, self._part = first, PARTS[part]

    def at(self, age_ns: int) -> int:
        return self._part(self._first + timedelta(seconds=age_ns // S))

    def next_ns(self, age_ns: int) -> int:
        return _after(age_ns, S)


class Replay:
    """The rows of a recording; each value is held until the next row."""

    def __init__(self, ages_ns: Sequence[int], values: Sequence[Number], period_ns: int | None) -> None:
        """`ages_ns` rise from 0; after `period_ns` the recording begins again, with None its last value stays."""
        self._ages_ns, self._values, self._period_ns = ages_ns, values, period_ns

    def at(self, age_ns: int) -> Number:
        return self._values[self._row(age_ns)]

    def next_ns(self, age_ns: int) -> int:
        row = self._row(age_ns) + 1
        begun_ns = 0 if self._period_ns is None else age_ns // self._period_ns * self._period_ns
        if row < len(self._ages_ns):
            return begun_ns + self._ages_ns[row]
        return NEVER_NS if self._period_ns is None else begun_ns + self._period_ns

    def _row(self, age_ns: int) -> int:
        passed_ns = age_ns if self._period_ns is None else age_ns % self._period_ns
        return bisect_right(self._ages_ns, passed_ns) - 1


def _chance(seed: str, number: int) -> float:
    """Return a number from -1 to 1 that only the seed and the number of the draw determine."""
    digest = blake2b(f"{seed}/{number}".encode(), digest_size=8).digest()
    return int.from_bytes(digest, "big") / (1 << 63) - 1


def _after(age_ns: int, step_ns: int) -> int:
    """Return the next multiple of a step."""
    return (age_ns // step_ns + 1) * step_ns
