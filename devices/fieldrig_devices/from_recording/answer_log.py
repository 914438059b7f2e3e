"""The times of the answers to one kind of requests, in little memory, from the begin of a recording to its end."""

from array import array
from collections.abc import Sequence
from typing import Final

MOST: Final = 1_024
"""Times that are kept; of more answers it is every 2nd, 4th and so on."""


class AnswerLog:
    """The times by the instants of their requests."""

    __slots__ = ("_begins", "_every", "_times", "count", "size")

    def __init__(self, size: int) -> None:
        """`size` is that of the first answer: bytes of its PDU."""
        self.size = size
        self.count = 0
        """Answers, also those whose times are not kept."""
        self._begins, self._times = array("q"), array("q")
        self._every = 1

    def take(self, begin_ns: int, time_ns: int) -> None:
        """Take the time of an answer, by the instant of its request."""
        if self.count % self._every == 0:
            if len(self._times) == MOST:
                self._every *= 2
                del self._begins[1::2], self._times[1::2]
            self._begins.append(begin_ns)
            self._times.append(time_ns)
        self.count += 1

    @property
    def times_ns(self) -> Sequence[int]:
        """The times in the order of their requests, which may be another one than that of the answers."""
        order = sorted(range(len(self._begins)), key=self._begins.__getitem__)
        return [self._times[place] for place in order]
