"""The last messages of one bus, in constant memory, with the gaps in what arrived counted."""

from collections import deque
from collections.abc import Iterator
from itertools import islice
from typing import Any, Final, NamedTuple

from fieldrig.bus import Bus
from fieldrig.traces.names import Named, Namer
from fieldrig.traces.trace import TraceEntry

MOST_MESSAGES: Final = 20_000
MOST_SORTS: Final = 4_096
"""Sorts of messages, such as identifiers, whose last instants are remembered."""


class Message(NamedTuple):
    number: int
    """Counts the messages of the bus since a page has looked at it."""
    time_ns: int
    """Time of day, or of the rig in virtual time."""
    sender: str
    data: bytes


class Row(NamedTuple):
    """A message as the page shows it."""

    message: Message
    named: Named
    raw: str
    """The message as the bus itself shows it, such as `705 [1] 05`."""
    since_ns: int | None
    """Time since the last message of the same sort; None for the first one."""
    first: int
    """The number of the message since which all messages of this sort say the same."""

    @property
    def searched(self) -> str:
        """The text in which words are searched, in small letters: everything that the page shows of the message."""
        named = self.named
        return f"{named.kind} {named.node} {self.message.sender} {named.text} {self.raw}".lower()


class BusRecord:
    """The last messages of one bus."""

    def __init__(self, bus: Bus[Any], namer: Namer) -> None:
        self.bus, self._namer = bus, namer
        self._rows: deque[Row] = deque(maxlen=MOST_MESSAGES)
        self._expected: dict[str, int] = {}
        self._backs = 0
        """How often the rig had gone back at the last batch."""
        self._last_ns: dict[tuple[str, str, int | str], int] = {}
        self._said: dict[tuple[str, ...], tuple[str, int]] = {}
        """The text of the last message of each sort and sender, and the number of the message since which it is so."""
        self.next = 0
        """The number of the next message."""
        self.lost = 0
        """Messages that the bus published and that did not arrive here."""

    @property
    def first(self) -> int:
        """The number of the oldest message that is still there."""
        return self.next - len(self._rows)

    def take(self, batch: dict[str, Any]) -> None:
        """Take a batch of `hub/bus_stream.py`.  ValueError for messages that are not of this bus."""
        if batch.get("backs", 0) > self._backs:
            self._go_back(batch["backs"], batch["back_ns"])
        process = batch["process"]
        expected = self._expected.get(process, batch["first"])
        self.lost += max(batch["first"] - expected, 0)  # a process that was restarted counts from 0 again
        self._expected[process] = batch["first"] + len(batch["entries"])
        for time_ns, sender, data in batch["entries"]:
            message = Message(self.next, time_ns + batch["epoch_ns"], sender, bytes.fromhex(data))
            self._rows.append(self._row(message))
            self.next += 1

    def _go_back(self, backs: int, back_ns: int) -> None:
        """Drop what came after the instant to which a rig in virtual time went back; the rest has later numbers."""
        self._backs = backs
        self._expected.clear()
        self._last_ns.clear()
        self._said.clear()
        while self._rows and self._rows[-1].message.time_ns > back_ns:
            self._rows.pop()

    def rows(self, start: int, most: int) -> Iterator[Row]:
        """Yield up to `most` messages from number `start` on, or from the oldest one that is still there."""
        skipped = max(start - self.first, 0)
        yield from islice(self._rows, skipped, skipped + most)

    def entries(self) -> Iterator[TraceEntry]:
        """Yield the messages as entries of a trace."""
        for row in self._rows:
            message = row.message
            yield TraceEntry(message.time_ns, self.bus.name, self.bus.family, message.sender, message.data)

    def _row(self, message: Message) -> Row:
        named, raw, sort = self._named(message)
        key = (named.kind, named.node, sort)
        before_ns = self._last_ns.pop(key, None)
        self._last_ns[key] = message.time_ns
        if len(self._last_ns) > MOST_SORTS:
            del self._last_ns[next(iter(self._last_ns))]
        since_ns = None if before_ns is None else message.time_ns - before_ns
        return Row(message, named, raw, since_ns, self._said_since(message, named, str(sort)))

    def _said_since(self, message: Message, named: Named, sort: str) -> int:
        """Return the number of the first message of this sort, in a row, that says the same."""
        key = (message.sender, named.kind, named.node, sort, named.aside)
        text, first = self._said.pop(key, ("", message.number))
        if text != named.text:
            first = message.number
        self._said[key] = (named.text, first)
        if len(self._said) > MOST_SORTS:
            del self._said[next(iter(self._said))]
        return first

    def _named(self, message: Message) -> tuple[Named, str, int | str]:
        """Return name and usual text of a message, and what sets its sort apart: an identifier, or a name."""
        try:
            decoded = self.bus.decode(message.data)
        except ValueError:
            text = message.data.hex(" ").upper()
            return Named("", "", text), text, 0
        sort = getattr(decoded, "identifier", None) or getattr(decoded, "name", 0)
        return self._namer(decoded, message.sender), self.bus.show(decoded), sort if isinstance(sort, int | str) else 0
