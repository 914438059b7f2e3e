"""Switches along an axis: whether they are closed at a position, and their next change."""

import math
from math import inf
from typing import NamedTuple


class Switch(NamedTuple):
    """A switch that is closed from `low` to `high`, repeated with the period `every` unless that is infinite."""

    wire: str
    low: float
    high: float
    every: float = inf

    def is_closed(self, position: float) -> bool:
        if self.every < inf:
            return (position - self.low) % self.every < self.high - self.low
        return self.low <= position < self.high

    def next_change(self, position: float, direction: int) -> float:
        """Return the nearest edge ahead, at infinity if there is none."""
        edges = [self._ahead(edge, position, direction) for edge in (self.low, self.high)]
        return min(edges) if direction > 0 else max(edges)

    def _ahead(self, edge: float, position: float, direction: int) -> float:
        if self.every < inf:
            turns = (position - edge) / self.every
            edge += self.every * (math.floor(turns) + 1 if direction > 0 else math.ceil(turns) - 1)
        return edge if (edge - position) * direction > 0 else direction * inf
