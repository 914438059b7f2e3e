"""An input with a filter: a level counts once it has held for the time of the filter (SCU-024, SCU-073)."""

from fieldrig.clock import NEVER_NS


class FilteredInput:
    def __init__(self, hold_ns: int) -> None:
        self._hold_ns = hold_ns
        self._raw = False
        self.level = False
        """The level after the filter."""
        self.next_ns = NEVER_NS
        """The instant at which the level changes if the input holds."""

    def put(self, now_ns: int, raw: bool) -> None:
        """Take a new level of the input."""
        self.advance(now_ns)
        if raw != self._raw:
            self._raw = raw
            self.next_ns = NEVER_NS if raw == self.level else now_ns + self._hold_ns

    def advance(self, now_ns: int) -> None:
        if self.next_ns <= now_ns:
            self.level, self.next_ns = self._raw, NEVER_NS
