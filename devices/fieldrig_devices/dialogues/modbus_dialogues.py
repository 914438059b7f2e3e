"""Modbus exchanges of a log: each request with its response.

Source: Modbus messaging on TCP/IP implementation guide V1.0b, 4.2.1.7 (a response has the transaction of its request),
and Modbus over serial line V1.02, 2.4 (one exchange at a time; unit 0 is a broadcast).  A log names the client of a
request, but not that of a response.  So where several clients use the same unit and transaction, the response belongs
to the oldest of their requests that it can answer.  In a trace of a rig, the bus gives requests new numbers for their
servers, and its responses name the request; in one of an older version they don't, and the unit alone decides.
"""

from collections import OrderedDict
from collections.abc import Sequence
from itertools import islice
from typing import Final

from fieldrig.clock import MS
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.codec import decode
from fieldrig_bus.modbus.message import BROADCAST, DamagedAnswer, ModbusRequest, ModbusResponse
from fieldrig_devices.dialogues.dialogue import Dialogue, Stray
from fieldrig_devices.dialogues.modbus_exchange import ModbusExchange

MOST_OPEN: Final = 4_096
"""Requests that wait for a response at the same time."""
EXCEPTION: Final = 0x80
TOGETHER_NS: Final = 50 * MS
"""Requests of a client with the same transaction wait together if they follow each other by less.

Some clients send several requests at once with one number; a client that has given one up has waited longer.
"""
BITS, REGISTERS, READ_WRITE = (1, 2), (3, 4), 23
ECHOED: Final = {5: 5, 6: 5, 15: 5, 16: 5, 22: 7}
"""Bytes of a request that its response repeats, by function."""

MOST_TRIED: Final = 16
"""The oldest requests of a unit among which that of a response is looked for."""

Key = tuple[str, int, int]
"""Bus, unit, and exchange."""


class _Open:
    """A request without a response."""

    __slots__ = ("client", "key", "number", "request", "time_ns")

    def __init__(self, key: Key, number: int, entry: TraceEntry, request: ModbusRequest) -> None:
        self.key, self.number, self.time_ns, self.client, self.request = (
            key, number, entry.time_ns, entry.sender, request,
        )  # fmt: skip

    def ended(self, wrong: str, *numbers: int) -> ModbusExchange:
        """Return the exchange without a response; `numbers` are the messages that belong to it besides."""
        bus, unit, _ = self.key
        is_broadcast = self.request.line is not None and unit == BROADCAST
        return ModbusExchange(
            self.time_ns, None, bus, (self.number, *numbers), unit, self.client, self.request.pdu, None,
            is_broadcast=is_broadcast, wrong=wrong,
        )  # fmt: skip

    def answered(self, number: int, entry: TraceEntry, pdu: bytes) -> ModbusExchange:
        return ModbusExchange(
            self.time_ns, entry.time_ns, entry.bus, (self.number, number), self.key[1], self.client, self.request.pdu,
            pdu, entry.sender,
        )  # fmt: skip


class ModbusDialogues:
    """The exchanges of all buses of a log."""

    def __init__(self) -> None:
        self._open: OrderedDict[int, _Open] = OrderedDict()
        """All open requests, by their numbers in the log."""
        self._by_key: dict[Key, list[_Open]] = {}
        self._by_unit: dict[tuple[str, int], OrderedDict[int, _Open]] = {}
        self._on_line: dict[str, _Open] = {}
        """The request of each serial line."""
        self.is_concerned = False
        """True if the last message was a request or an answer, so that it belongs to an exchange or is a `Stray`."""
        self.request: ModbusRequest | None = None
        """The last message, if it was a request."""

    def take(self, number: int, entry: TraceEntry) -> Sequence[Dialogue]:
        """Take a message, and return the exchanges that it ends; a response without a request is a `Stray`."""
        self.is_concerned, self.request = False, None
        if entry.family != "modbus":
            return ()
        try:
            message = decode(entry.data)
        except ValueError:
            return ()
        self.is_concerned = isinstance(message, ModbusRequest | ModbusResponse | DamagedAnswer)
        if isinstance(message, ModbusRequest):
            self.request = message
            return self._asked(number, entry, message)
        if isinstance(message, ModbusResponse):
            return self._answered(number, entry, message)
        return self._damaged(number, entry, message) if isinstance(message, DamagedAnswer) else ()

    def unfinished(self) -> Sequence[Dialogue]:
        """Return the requests that have no response, the oldest first, and forget them."""
        left = [open_.ended("the log ends before the answer") for open_ in self._open.values()]
        for waiting in (self._open, self._by_key, self._by_unit, self._on_line):
            waiting.clear()
        return left

    def _asked(self, number: int, entry: TraceEntry, request: ModbusRequest) -> Sequence[Dialogue]:
        open_ = _Open((entry.bus, request.unit, request.exchange), number, entry, request)
        ended = self._given_up(open_)
        if request.line is not None and request.unit == BROADCAST:
            return [*ended, open_.ended("")]
        self._open[number] = open_
        self._by_key.setdefault(open_.key, []).append(open_)
        self._by_unit.setdefault(open_.key[:2], OrderedDict())[number] = open_
        if request.line is not None:
            self._on_line[entry.bus] = open_
        if len(self._open) > MOST_OPEN:
            oldest = next(iter(self._open.values()))
            self._close(oldest)
            ended.append(oldest.ended("no answer"))
        return ended

    def _given_up(self, new: _Open) -> list[Dialogue]:
        """Return the requests that a new one shows to be given up: of the line, or with the same transaction."""
        latest_ns = new.time_ns - TOGETHER_NS
        before = [
            open_
            for open_ in self._by_key.get(new.key, ())
            if open_.client == new.client and open_.time_ns <= latest_ns
        ]
        if new.request.line is not None and (on_line := self._on_line.get(new.key[0])) is not None:
            before = [on_line]
        for open_ in before:
            self._close(open_)
        return [open_.ended("no answer") for open_ in before]

    def _answered(self, number: int, entry: TraceEntry, response: ModbusResponse) -> Sequence[Dialogue]:
        waiting = self._waiting(entry, response)
        fitting = next((open_ for open_ in waiting if is_answer(open_.request.pdu, response.pdu)), None)
        if fitting is None:
            why = "an answer that does not fit its request" if waiting else "an answer without its request"
            return (Stray(entry.time_ns, entry.time_ns, entry.bus, (number,), why),)
        self._close(fitting)
        return (fitting.answered(number, entry, response.pdu),)

    def _damaged(self, number: int, entry: TraceEntry, answer: DamagedAnswer) -> Sequence[Dialogue]:
        """End the exchange whose answer a fault has damaged, so that its client has not got it."""
        waiting = self._waiting(entry, answer)
        if not waiting:
            return (Stray(entry.time_ns, entry.time_ns, entry.bus, (number,), "a damaged answer without its request"),)
        open_ = waiting[0]
        self._close(open_)
        return (open_.ended("the answer was damaged", number),)

    def _waiting(self, entry: TraceEntry, response: ModbusResponse | DamagedAnswer) -> Sequence[_Open]:
        """Return the requests that a response may answer, the oldest first."""
        same = self._by_key.get((entry.bus, *response.request))
        if same is not None or response.asked is not None or is_address(entry.sender):
            return same or ()
        return list(islice(self._by_unit.get((entry.bus, response.unit), {}).values(), MOST_TRIED))

    def _close(self, open_: _Open) -> None:
        del self._open[open_.number]
        waiting = self._by_key[open_.key]
        waiting.remove(open_)
        if not waiting:
            del self._by_key[open_.key]
        of_unit = self._by_unit[open_.key[:2]]
        del of_unit[open_.number]
        if not of_unit:
            del self._by_unit[open_.key[:2]]
        if self._on_line.get(open_.key[0]) is open_:
            del self._on_line[open_.key[0]]


def is_address(sender: str) -> bool:
    """Return whether a sender is an IP address with a port, as in a capture of a network, and no member of a rig."""
    host, _, port = sender.rpartition(":")
    return port.isdigit() and ("." in host or ":" in host)


def is_answer(request: bytes, response: bytes) -> bool:
    """Return whether a response can answer a request, by function, and by length or address where it has them."""
    function = request[0]
    if response[0] & ~EXCEPTION != function:
        return False
    if response[0] & EXCEPTION:
        return True
    if function in ECHOED:
        return response[1 : ECHOED[function]] == request[1 : ECHOED[function]]
    if len(request) < 5 or len(response) < 2:
        return True
    count = int.from_bytes(request[3:5], "big")
    if function in BITS:
        return response[1] == (count + 7) // 8
    return response[1] == 2 * count if function in (*REGISTERS, READ_WRITE) else True
