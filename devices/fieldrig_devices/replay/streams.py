"""The streams of a log: the messages of one identifier, unit or sender, which come one after the other.

Two logs are compared stream by stream, because the order of messages of different senders depends on the medium.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import Final, NamedTuple

from fieldrig.clock import MS
from fieldrig.faults import note
from fieldrig.traces.order import in_order
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.frame import EXTENDED_MASK
from fieldrig_bus.can.notices import NOTICE
from fieldrig_bus.modbus import codec as modbus_codec
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_bus.serial import codec as serial_codec
from fieldrig_devices.replay.inner_streams import PLACES

PAUSE_NS: Final = 10 * MS
"""Silence of a sender after which its next bytes on a serial line are another telegram."""
LONGEST_TELEGRAM: Final = 4_096
"""Bytes of one telegram; a sender that never pauses fills no memory."""
MOST_OPEN: Final = 1_024
"""Requests without a response that are remembered."""


class Stream(NamedTuple):
    """The messages of one sort on one bus."""

    bus: str
    family: str
    key: str | int
    """The identifier with its flags on CAN, and a text elsewhere."""

    @property
    def text(self) -> str:
        """The stream in the words of its bus: an identifier of CAN as candump shows it."""
        if isinstance(self.key, str):
            return self.key
        remote = " remote request" if self.key & REMOTE else ""
        if self.key & EXTENDED:
            return f"{self.key & EXTENDED_MASK:08X}{remote}"
        return f"{self.key & EXTENDED_MASK:03X}{remote}"


class Item(NamedTuple):
    """One message of a stream."""

    time_ns: int
    content: bytes
    """The bytes that are compared: all but those of one log only, such as the number of an exchange."""
    number: int
    """Its place in the log, from 0."""
    entry: TraceEntry
    request: bytes = b""
    """The PDU of the request that a Modbus response answers; empty if the log does not have it."""


class Streams:
    """Divides a log into streams, message by message.  Its memory is bounded."""

    def __init__(self) -> None:
        self._open: dict[tuple[str, int, int], bytes] = {}
        self._of: dict[str, Callable[[int, TraceEntry], tuple[str | int, Item]]] = {
            "can": _can,
            "modbus": self._modbus,
            "serial": _serial,
            **dict.fromkeys(PLACES, _inner),
        }

    def place(self, number: int, entry: TraceEntry) -> tuple[Stream, Item]:
        """Return the stream of a message, and the message as a part of it."""
        key, item = self._of.get(entry.family, _other)(number, entry)
        return Stream(entry.bus, entry.family, key), item

    def _modbus(self, number: int, entry: TraceEntry) -> tuple[str | int, Item]:
        try:
            message = modbus_codec.decode(entry.data)
        except ValueError:
            return _other(number, entry)
        if isinstance(message, ModbusRequest):
            self._open[entry.bus, message.unit, message.exchange] = message.pdu
            if len(self._open) > MOST_OPEN:
                del self._open[next(iter(self._open))]
            return f"unit {message.unit} request", Item(entry.time_ns, message.pdu, number, entry)
        if isinstance(message, ModbusResponse):
            request = self._open.pop((entry.bus, *message.request), b"")
            return f"unit {message.request.unit} response", Item(entry.time_ns, message.pdu, number, entry, request)
        return _other(number, entry)


def _can(number: int, entry: TraceEntry) -> tuple[str | int, Item]:
    data = entry.data
    word = int.from_bytes(data[:4], "little")
    if word & ~EXTENDED_MASK == NOTICE:
        return "errors and states", Item(entry.time_ns, data, number, entry)
    return word & (EXTENDED | REMOTE | EXTENDED_MASK), Item(entry.time_ns, data[3:], number, entry)


def _serial(number: int, entry: TraceEntry) -> tuple[str | int, Item]:
    if entry.data.startswith(note.LEAD):
        return "faults", Item(entry.time_ns, entry.data, number, entry)
    kind = "bytes" if entry.data[:1] == bytes((serial_codec.DATA,)) else "lines and format"
    return f"{_who(entry.sender) or 'line'} {kind}", Item(entry.time_ns, entry.data, number, entry)


def _inner(number: int, entry: TraceEntry) -> tuple[str | int, Item]:
    placed = PLACES[entry.family](entry.data)
    if placed is None:
        return _other(number, entry)
    return placed[0], Item(entry.time_ns, placed[1], number, entry)


def _who(sender: str) -> str:
    """Return a sender without the number of its connection, which differs from log to log: `tcp` for `tcp:3`."""
    name, colon, number = sender.rpartition(":")
    return name if colon and number.isdigit() else sender


def _other(number: int, entry: TraceEntry) -> tuple[str | int, Item]:
    key = "faults" if entry.data.startswith(note.LEAD) else _who(entry.sender) or "messages"
    return key, Item(entry.time_ns, entry.data, number, entry)


Numbered = tuple[int, TraceEntry]


def in_time(entries: Iterable[TraceEntry]) -> Iterator[Numbered]:
    """Yield the messages with their numbers in the order of time."""
    return enumerate(in_order(entries))


class Telegrams:
    """Puts together the bytes that one sender sent on a serial line without a pause.

    The chunks of a recording depend on the host: the same telegram is one message of one log, and three of another.
    """

    def __init__(self) -> None:
        self._speaking: dict[str, tuple[int, TraceEntry, int]] = {}
        """Number, bytes so far, and the instant of the last ones, by bus."""

    def take(self, number: int, entry: TraceEntry) -> Iterator[Numbered]:
        """Take a message, and yield what is complete."""
        if entry.family != "serial":
            if self._speaking:
                yield from self.ended_by(entry.time_ns)
            yield number, entry
            return
        yield from self.ended_by(entry.time_ns)
        before = self._speaking.get(entry.bus)
        is_data = entry.data[:1] == bytes((serial_codec.DATA,))
        if before is not None and is_data and self._goes_on(before[1], entry):
            first, told, _ = before
            whole = TraceEntry(told.time_ns, told.bus, told.family, told.sender, told.data + entry.data[1:])
            self._speaking[entry.bus] = first, whole, entry.time_ns
            return
        if before is not None:
            del self._speaking[entry.bus]
            yield before[0], before[1]
        if is_data:
            self._speaking[entry.bus] = number, entry, entry.time_ns
        else:
            yield number, entry

    def _goes_on(self, before: TraceEntry, entry: TraceEntry) -> bool:
        return before.sender == entry.sender and len(before.data) < LONGEST_TELEGRAM

    def ended_by(self, now_ns: int) -> Iterator[Numbered]:
        """Yield the telegrams whose senders have been silent for long enough."""
        for bus in [bus for bus, (_, _, last_ns) in self._speaking.items() if now_ns - last_ns > PAUSE_NS]:
            number, entry, _ = self._speaking.pop(bus)
            yield number, entry

    def rest(self) -> Iterator[Numbered]:
        """Yield what is left at the end of a log."""
        for number, entry, _ in self._speaking.values():
            yield number, entry
        self._speaking.clear()


def telegrams(numbered: Iterable[Numbered]) -> Iterator[Numbered]:
    """Yield the messages of a log, with the bytes of serial lines put together."""
    speaking = Telegrams()
    for number, entry in numbered:
        yield from speaking.take(number, entry)
    yield from speaking.rest()
