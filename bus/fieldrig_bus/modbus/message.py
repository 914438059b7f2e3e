"""Modbus messages as devices see them: a unit, a protocol data unit, and which exchange it belongs to.

Framing (MBAP, RTU, ASCII) is the affair of the bus.  Source: Modbus application protocol V1.1b3, chapter 4.1.
"""

from dataclasses import dataclass

BROADCAST = 0
"""Unit id of a broadcast on a serial line: every server acts, none answers."""


@dataclass(frozen=True, slots=True)
class ModbusRequest:
    """From a client.  `pdu` is function code and data, 1 to 253 bytes; `exchange` ties the response to it."""

    unit: int
    pdu: bytes
    exchange: int = 0


@dataclass(frozen=True, slots=True)
class ModbusResponse:
    """From a server, with the `exchange` of the request that it answers."""

    unit: int
    pdu: bytes
    exchange: int = 0
