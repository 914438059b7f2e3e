"""The bus load over the last second."""


class Load:
    """The busy share of the last second: all of the present second, and the rest of the one before it."""

    __slots__ = ("_before", "_busy", "_now", "_second", "_start")

    def __init__(self, second: int) -> None:
        self._second = second  # ticks
        self._start = self._now = self._busy = self._before = 0

    def add(self, now: int, busy: int) -> None:
        """Add `busy` ticks that ended at tick `now`."""
        if now >= self._start + self._second:
            start = now - now % self._second
            self._before = self._busy if start == self._start + self._second else 0
            self._start, self._busy = start, 0
        self._busy += busy
        self._now = now

    def share(self) -> float:
        """The load, 0 to 1."""
        rest = 1 - (self._now - self._start) / self._second
        return min(1.0, (self._busy + self._before * max(0.0, rest)) / self._second)
