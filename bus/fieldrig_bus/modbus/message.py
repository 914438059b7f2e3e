"""Modbus messages as devices see them: a unit, a protocol data unit, and the exchange that it belongs to.

The bus handles the framing (MBAP, RTU, ASCII).  Source: Modbus application protocol V1.1b3, chapter 4.1.  Messages are
never changed.  They are not `frozen` because creating a frozen one takes 0.5 us instead of 0.15, four times a request.
"""

import ipaddress
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from fieldrig.bus import words_of
from fieldrig.faults.note import FaultNote

BROADCAST = 0
"""Unit id of a broadcast on a serial line: every server executes it and none answers."""


class LineState(NamedTuple):
    """Counters of a serial line's receiver since it was opened, at the time of one request.

    Only the receiver sees frames that were damaged or for others; a server reports them as its diagnostic counters.
    """

    messages: int = 0
    """Frames without error, for any unit."""
    errors: int = 0
    """Frames with a wrong checksum, a gap, or invalid characters."""
    is_ascii: bool = False


@dataclass(slots=True, unsafe_hash=True)
class ModbusRequest:
    """A request of a client.  `pdu` is function code and data, 1 to 253 bytes; the response has the same `exchange`.

    `line` is None where there is no serial line (TCP); then unit 0 is not a broadcast.
    """

    unit: int
    pdu: bytes
    exchange: int = 0
    line: LineState | None = None


class Asked(NamedTuple):
    """A request as its servers see it, and as a trace has it: the bus gives it a number, and 255 may mean unit 1."""

    unit: int
    exchange: int


@dataclass(slots=True, unsafe_hash=True)
class ModbusResponse:
    """A response of a server, with the `exchange` of the request that it answers.

    The bus sets `asked` when it carries the response, because unit and exchange are those of the client from there on.
    """

    unit: int
    pdu: bytes
    exchange: int = 0
    asked: Asked | None = field(default=None, compare=False)

    @property
    def request(self) -> Asked:
        """The unit and exchange of its request in a trace."""
        return self.asked or Asked(self.unit, self.exchange)


@dataclass(slots=True, unsafe_hash=True)
class ClientConnected:
    """An outside client has opened a TCP connection to this bus.

    It is delivered only to members with `CONNECTIONS` in their interest.  A serial line has no connections.
    """

    peer: str
    """IP address of the client."""


@dataclass(slots=True, unsafe_hash=True)
class DamagedAnswer:
    """The bytes of an answer that an injected fault has damaged, for a client outside.

    `pdu` is what the device has answered, and empty if nothing was asked.  `pieces` are the bytes that come instead,
    each with its delay after the first one in nanoseconds; with `is_cut` the connection is closed after them.
    """

    unit: int
    pdu: bytes
    exchange: int
    asked: Asked | None = field(default=None, compare=False, kw_only=True)
    pieces: tuple[tuple[int, bytes], ...] = ()
    is_cut: bool = False

    @property
    def request(self) -> Asked:
        """The unit and exchange of its request in a trace."""
        return self.asked or Asked(self.unit, self.exchange)


CONNECTIONS = "connections"
"""The word in the interest of a member that wants to know of TCP connections."""

LONGEST_PDU = 253
"""Longest PDU, in bytes (application protocol V1.1b3, chapter 4.1)."""
_HIGHEST_EXCHANGE = 0xFFFF_FFFF

ModbusMessage = ModbusRequest | ModbusResponse
"""A request or a response."""
ModbusEvent = ModbusMessage | ClientConnected
"""Every message that a device may get from a Modbus bus."""
OnModbus = ModbusEvent | DamagedAnswer | FaultNote
"""Every message of a Modbus bus, also those that only clients outside and the trace get."""


def check_sent(message: Any) -> None:
    """Raise TypeError or ValueError for a message that cannot be on a Modbus bus."""
    if isinstance(message, ClientConnected):
        if type(message.peer) is not str:
            raise TypeError(f"peer: expected str, found {type(message.peer).__name__}")
        ipaddress.ip_address(message.peer)
        return
    if not isinstance(message, ModbusRequest | ModbusResponse):
        raise TypeError(f"expected a ModbusRequest, ModbusResponse or ClientConnected, found {type(message).__name__}")
    unit, pdu, exchange = message.unit, message.pdu, message.exchange
    if type(pdu) is not bytes:
        raise TypeError(f"pdu: expected bytes, found {type(pdu).__name__}")
    if type(unit) is not int or type(exchange) is not int:
        raise TypeError(f"expected int for unit and exchange, found {unit!r} and {exchange!r}")
    if not 0 <= unit <= 255:
        raise ValueError(f"unit {unit}: expected 0 to 255")
    if not 1 <= len(pdu) <= LONGEST_PDU:
        raise ValueError(f"a PDU of {len(pdu)} bytes: expected 1 to {LONGEST_PDU}")
    if not 0 <= exchange <= _HIGHEST_EXCHANGE:
        raise ValueError(f"exchange {exchange}: expected 0 to {_HIGHEST_EXCHANGE}")
    line = message.line if isinstance(message, ModbusRequest) else None
    if line is not None and not isinstance(line, LineState):
        raise TypeError(f"line: expected a LineState or None, found {type(line).__name__}")


def check_interest(interest: Any) -> None:
    """Raise TypeError or ValueError for an interest in anything but unit ids and the word `CONNECTIONS`."""
    for word in words_of(interest):
        if word != CONNECTIONS and not (type(word) is int and 0 <= word <= 255):
            raise ValueError(f'{word!r}: expected a unit id, 0 to 255, or "{CONNECTIONS}"')
