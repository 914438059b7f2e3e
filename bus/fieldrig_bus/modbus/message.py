"""Modbus messages as devices see them: a unit, a protocol data unit, and which exchange it belongs to.

Framing (MBAP, RTU, ASCII) is the affair of the bus.  Source: Modbus application protocol V1.1b3, chapter 4.1.
Nobody changes a message; that they are not `frozen` is because making a frozen one takes 0.5 us instead of 0.15, four
times a request.
"""

from dataclasses import dataclass
from typing import NamedTuple

BROADCAST = 0
"""Unit id of a broadcast on a serial line: every server acts, none answers."""


class LineState(NamedTuple):
    """What the receiver of a serial line has noticed since it was opened, at the time of one request.

    Only the receiver sees what was broken or for others; a server reports it as its diagnostic counters.
    """

    messages: int = 0
    """Frames without error, for whatever unit."""
    errors: int = 0
    """Frames with a wrong checksum, a gap, or characters that may not be there."""
    is_ascii: bool = False


@dataclass(slots=True, unsafe_hash=True)
class ModbusRequest:
    """From a client.  `pdu` is function code and data, 1 to 253 bytes; `exchange` ties the response to it.

    `line` is None where there is no serial line (TCP): unit 0 is then no broadcast.
    """

    unit: int
    pdu: bytes
    exchange: int = 0
    line: LineState | None = None


@dataclass(slots=True, unsafe_hash=True)
class ModbusResponse:
    """From a server, with the `exchange` of the request that it answers."""

    unit: int
    pdu: bytes
    exchange: int = 0


@dataclass(slots=True, unsafe_hash=True)
class ClientConnected:
    """A client outside has opened a TCP connection to this bus.

    Only members hear it that have `CONNECTIONS` in their interest.  A serial line knows no connections.
    """

    peer: str
    """Its IP address."""


CONNECTIONS = "connections"

ModbusMessage = ModbusRequest | ModbusResponse
ModbusEvent = ModbusMessage | ClientConnected
"""All that a Modbus bus carries."""
