"""How a number is spread, in bounded memory: exact for the first values, and within one percent for more.

Many values are counted in classes whose bounds are two percent apart, as in HdrHistogram, so a quantile is off by one
percent at most.
"""

from array import array
from collections import Counter
from math import exp, log
from typing import Any, Final

MOST_EXACT: Final = 1_000
"""Values up to which quantiles are exact."""
_STEP: Final = log(1.02)


class Spread:
    """The spread of durations in nanoseconds, 0 or more."""

    __slots__ = ("_classes", "_values", "count", "highest", "lowest", "total")

    def __init__(self) -> None:
        self.count = self.total = self.lowest = self.highest = 0
        self._values: array[int] | None = array("q")
        """All values, as long as they are few."""
        self._classes: Counter[int] = Counter()

    def add(self, value: int) -> None:
        if not self.count or value < self.lowest:
            self.lowest = value
        if value > self.highest:
            self.highest = value
        self.count += 1
        self.total += value
        if self._values is None:
            self._classes[_class_of(value)] += 1
            return
        self._values.append(value)
        if len(self._values) > MOST_EXACT:
            self._classes.update(map(_class_of, self._values))
            self._values = None

    @property
    def is_exact(self) -> bool:
        """True if quantiles are exact."""
        return self._values is not None

    def quantile(self, part: float) -> int:
        """Return the value below which this part of all values is, from 0 to 1; 0 if there are none."""
        if not self.count:
            return 0
        rank = max(1, -int(-part * self.count // 1))
        if self._values is not None:
            return sorted(self._values)[rank - 1]
        for number in sorted(self._classes):
            rank -= self._classes[number]
            if rank <= 0:
                return min(max(_middle_of(number), self.lowest), self.highest)
        return self.highest

    def as_data(self) -> dict[str, Any]:
        """Return count, bounds and quantiles, for JSON."""
        return {
            "count": self.count,
            "min_ns": self.lowest,
            "p50_ns": self.quantile(0.5),
            "p99_ns": self.quantile(0.99),
            "max_ns": self.highest,
            "is_exact": self.is_exact,
        }


def _class_of(value: int) -> int:
    return 0 if value < 1 else 1 + int(log(value) / _STEP)


def _middle_of(number: int) -> int:
    return 0 if number == 0 else round(exp((number - 0.5) * _STEP))
