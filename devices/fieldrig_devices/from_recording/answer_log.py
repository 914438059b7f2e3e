"""The answers to one kind of requests, in little memory, from the begin of a recording to its end."""

from array import array
from collections.abc import Iterator
from typing import Final

from fieldrig_devices.modbus.answer_times import Answer

NO_ANSWER: Final = -1


class AnswerLog:
    """The times of the answers by the instants of their requests."""

    __slots__ = ("_begins", "_codes", "_every", "_most", "_times", "count", "size")

    def __init__(self, most: int) -> None:
        """`most` requests are kept; of more it is every 2nd, 4th and so on."""
        self._most = most
        self.size = 0
        """Bytes of the PDU of the last answer."""
        self.count = 0
        """Requests, also those that are not kept."""
        self._begins, self._times = array("q"), array("q")
        self._codes = array("B")
        """Exception codes; 0 for a request that was carried out."""
        self._every = 1

    def take(self, begin_ns: int, answer: Answer, size: int = 0) -> None:
        """Take a request at `begin_ns`; `size` is that of its answer."""
        self.size = size or self.size
        if self.count % self._every == 0:
            if len(self._times) == self._most:
                self._every *= 2
                del self._begins[1::2], self._times[1::2], self._codes[1::2]
            self._begins.append(begin_ns)
            self._times.append(NO_ANSWER if answer.after_ns is None else answer.after_ns)
            self._codes.append(answer.exception)
        self.count += 1

    def add(self, other: "AnswerLog") -> None:
        """Take the requests of another log as well."""
        for begin_ns, answer in other.rows():
            self.take(begin_ns, answer)

    def rows(self) -> Iterator[tuple[int, Answer]]:
        """Yield the instants and answers in the order of the requests, in which answers may not have come."""
        for place in sorted(range(len(self._begins)), key=self._begins.__getitem__):
            time_ns = self._times[place]
            yield self._begins[place], Answer(None if time_ns == NO_ANSWER else time_ns, self._codes[place])
