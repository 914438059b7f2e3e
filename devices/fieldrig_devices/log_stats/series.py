"""The messages of one identifier, or of one sender: how many, how often, and how evenly."""

from typing import Any

from fieldrig_devices.log_stats.spread import Spread


class Series:
    """Messages that belong together, in the order of the log."""

    __slots__ = ("bytes", "count", "first_ns", "gaps", "last_ns")

    def __init__(self) -> None:
        self.count = self.bytes = 0
        self.first_ns = self.last_ns = 0
        self.gaps = Spread()
        """The times between them; where the log jumps back there is none."""

    def add(self, time_ns: int, size: int) -> None:
        """Take a message of this many bytes."""
        if not self.count:
            self.first_ns = time_ns
        elif time_ns >= self.last_ns:
            self.gaps.add(time_ns - self.last_ns)
        self.count += 1
        self.bytes += size
        self.last_ns = time_ns

    @property
    def period_ns(self) -> int:
        """The median of the times between them; 0 for a single message."""
        return self.gaps.quantile(0.5)

    @property
    def jitter_ns(self) -> int:
        """How far 98 of 100 times between them are from the period at most."""
        period_ns = self.period_ns
        return max(self.gaps.quantile(0.99) - period_ns, period_ns - self.gaps.quantile(0.01))

    def as_data(self) -> dict[str, Any]:
        """Return all figures, for JSON."""
        return {
            "count": self.count,
            "bytes": self.bytes,
            "first_ns": self.first_ns,
            "last_ns": self.last_ns,
            "period_ns": self.period_ns,
            "jitter_ns": self.jitter_ns,
            "gaps": self.gaps.as_data(),
        }
