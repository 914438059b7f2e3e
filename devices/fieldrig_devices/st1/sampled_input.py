"""A binary input that is sampled every PERIOD and accepted after DEBOUNCE equal samples (PAML-082, PAML-083).

Nothing is done at samples that see nothing new: the instant at which a change will be accepted is computed when the
input changes.
"""

from fieldrig.clock import NEVER_NS


class SampledInput:
    __slots__ = ("_begin_ns", "_first", "_left", "_period_ns", "_raw", "_samples", "changed_ns", "level", "next_ns")

    def __init__(self, now_ns: int, level: bool, period_ns: int, samples: int) -> None:
        """The first sample is taken now; `samples` equal ones make a new level."""
        self._begin_ns, self._period_ns, self._samples = now_ns, period_ns, samples
        self._raw = self.level = level
        self.changed_ns = now_ns
        """The instant at which the input took the level that was accepted, or that will be at `next_ns`."""
        self.next_ns = NEVER_NS
        """The instant at which the level changes if the input holds."""
        self._first = self._left = -1
        """Numbers of the first sample of a change, and of the sample before which the input went back."""

    def put(self, now_ns: int, raw: bool) -> None:
        """Take a change of the input.  A sample at this very instant sees the new value."""
        self.advance(now_ns - 1)
        if raw is self._raw:
            return
        self._raw = raw
        sample = -((self._begin_ns - now_ns) // self._period_ns)  # the next one
        if raw is self.level:
            self._left, self.next_ns = sample, NEVER_NS
            return
        if sample != self._left or self._first < 0:  # the input was seen at the old level meanwhile
            self._first, self.changed_ns = sample, now_ns
        self.next_ns = self._begin_ns + (self._first + self._samples - 1) * self._period_ns

    def advance(self, now_ns: int) -> bool:
        """Accept what is due; True if the level has changed."""
        if self.next_ns > now_ns:
            return False
        self.level, self.next_ns, self._first, self._left = self._raw, NEVER_NS, -1, -1
        return True
