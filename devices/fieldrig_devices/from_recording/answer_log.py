"""The answers to one kind of requests, in little memory, from the begin of a recording to its end."""

from array import array
from collections.abc import Iterator
from typing import Final

NO_ANSWER: Final = -1


class AnswerLog:
    """The times of the answers by the instants of their requests."""

    __slots__ = ("_begins", "_every", "_most", "_times", "count", "size")

    def __init__(self, most: int) -> None:
        """`most` requests are kept; of more it is every 2nd, 4th and so on."""
        self._most = most
        self.size = 0
        """Bytes of the PDU of the last answer."""
        self.count = 0
        """Requests, also those that are not kept."""
        self._begins, self._times = array("q"), array("q")
        self._every = 1

    def take(self, begin_ns: int, time_ns: int | None, size: int = 0) -> None:
        """Take a request at `begin_ns`, and the time of its answer, or None for one without an answer."""
        self.size = size or self.size
        if self.count % self._every == 0:
            if len(self._times) == self._most:
                self._every *= 2
                del self._begins[1::2], self._times[1::2]
            self._begins.append(begin_ns)
            self._times.append(NO_ANSWER if time_ns is None else time_ns)
        self.count += 1

    def add(self, other: "AnswerLog") -> None:
        """Take the requests of another log as well."""
        for begin_ns, time_ns in other.rows():
            self.take(begin_ns, time_ns)

    def rows(self) -> Iterator[tuple[int, int | None]]:
        """Yield the instants and times in the order of the requests, in which answers may not have come."""
        for place in sorted(range(len(self._begins)), key=self._begins.__getitem__):
            time_ns = self._times[place]
            yield self._begins[place], None if time_ns == NO_ANSWER else time_ns
