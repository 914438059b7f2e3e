"""The times between the messages of one sort, of a log and of a rig: a period, and the places where one is missing."""

from dataclasses import dataclass, field
from typing import Final

FIRST: Final = 15
"""Times from whose median a period is estimated, so that a few lost messages do not change it."""
FEWEST: Final = 3
UNEVEN: Final = 0.5
"""Part of a period by which the times between cyclic messages may differ; the medium and the node delay some."""
MOST_UNEVEN: Final = 0.1
"""Part of the times of a cyclic stream that may be shorter or longer, as a capture loses messages."""


@dataclass(slots=True)
class Gaps:
    """The times between the messages of one side."""

    last_ns: int | None = None
    count: int = 0
    sum_ns: int = 0
    longest_ns: int = 0
    longest_at_ns: int = 0
    """The instant of the message before the longest time."""
    usual_ns: int = 0
    """An estimate of the period."""
    short: int = 0
    long: int = 0
    """Times that are much shorter or longer than usual."""
    _first: list[int] = field(default_factory=list)

    def take(self, time_ns: int, own_ns: int) -> None:
        """Take a message; `own_ns` is its instant by the clock of its own side, by which times are measured."""
        if self.last_ns is not None:
            self._take(own_ns - self.last_ns, time_ns)
        self.last_ns = own_ns

    def _take(self, gap_ns: int, time_ns: int) -> None:
        self.count, self.sum_ns = self.count + 1, self.sum_ns + gap_ns
        if gap_ns > self.longest_ns:
            self.longest_ns, self.longest_at_ns = gap_ns, time_ns - gap_ns
        if len(self._first) >= FIRST:
            self.short, self.long = self.short + self._is_short(gap_ns), self.long + self._is_long(gap_ns)
            return
        self._first.append(gap_ns)
        self.usual_ns = sorted(self._first)[len(self._first) // 2]
        self.short, self.long = sum(map(self._is_short, self._first)), sum(map(self._is_long, self._first))

    def _is_short(self, gap_ns: int) -> bool:
        return gap_ns < self.usual_ns * (1 - UNEVEN)

    def _is_long(self, gap_ns: int) -> bool:
        return gap_ns > self.usual_ns * (1 + UNEVEN)

    @property
    def period_ns(self) -> int:
        """The mean time between two messages; 0 without two."""
        return self.sum_ns // self.count if self.count else 0

    @property
    def is_cyclic(self) -> bool:
        """True if a timer sends the messages, as far as their times show it."""
        return self.count >= FEWEST and self.short + self.long <= MOST_UNEVEN * self.count
