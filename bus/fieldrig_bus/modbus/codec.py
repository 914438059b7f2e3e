"""A Modbus message as bytes, for other processes and traces, and as a line of text.

Bytes, little endian: kind (1), unit (1), exchange (4), state of the serial line if there is one (8), PDU.  The PDU is
bytes throughout: the PDU classes of pymodbus would cost 40 us per request and answer wrong quantities with function
code 0x80, so pymodbus is the foreign client of the tests and not the codec.  A connection has unit and exchange 0, and
its address as text.
"""

import ipaddress
import struct
from typing import Final

from fieldrig_bus.modbus.message import (
    LONGEST_PDU,
    ClientConnected,
    LineState,
    ModbusEvent,
    ModbusRequest,
    ModbusResponse,
)

RESPONSE, REQUEST, REQUEST_ON_RTU, REQUEST_ON_ASCII, CONNECTED = range(5)

_HEAD: Final = struct.Struct("<BBI")
_LINE: Final = struct.Struct("<BBIII")
_COUNT_MASK: Final = 0xFFFF_FFFF

FUNCTIONS: Final = {
    1: "read coils",
    2: "read discrete inputs",
    3: "read holding registers",
    4: "read input registers",
    5: "write coil",
    6: "write register",
    7: "read exception status",
    8: "diagnostics",
    15: "write coils",
    16: "write registers",
    17: "report server id",
    22: "mask write register",
    23: "read/write registers",
    24: "read FIFO",
    43: "encapsulated interface",
}

EXCEPTIONS: Final = {
    1: "illegal function",
    2: "illegal data address",
    3: "illegal data value",
    4: "server device failure",
    10: "gateway path unavailable",
    11: "gateway target failed to respond",
}

_LONGEST_SHOWN: Final = 24


def encode(message: ModbusEvent) -> bytes:
    if isinstance(message, ModbusResponse):
        return _HEAD.pack(RESPONSE, message.unit, message.exchange) + message.pdu
    if isinstance(message, ClientConnected):
        return _HEAD.pack(CONNECTED, 0, 0) + message.peer.encode()
    line = message.line
    if line is None:
        return _HEAD.pack(REQUEST, message.unit, message.exchange) + message.pdu
    kind = REQUEST_ON_ASCII if line.is_ascii else REQUEST_ON_RTU
    messages, errors = line.messages & _COUNT_MASK, line.errors & _COUNT_MASK
    return _LINE.pack(kind, message.unit, message.exchange, messages, errors) + message.pdu


def decode(data: bytes) -> ModbusEvent:
    """The inverse of `encode`.  ValueError for anything else."""
    try:
        kind, unit, exchange = _HEAD.unpack_from(data)
        if kind == RESPONSE:
            return ModbusResponse(unit, _pdu(data, _HEAD.size), exchange)
        if kind == REQUEST:
            return ModbusRequest(unit, _pdu(data, _HEAD.size), exchange)
        if kind == CONNECTED and unit == exchange == 0:
            return ClientConnected(_address(data[_HEAD.size :]))
        kind, unit, exchange, messages, errors = _LINE.unpack_from(data)
    except struct.error as cause:
        raise ValueError(f"not a Modbus message: {data.hex(' ')}") from cause
    if kind > REQUEST_ON_ASCII:
        raise ValueError(f"not a Modbus message: {data.hex(' ')}")
    return ModbusRequest(unit, _pdu(data, _LINE.size), exchange, LineState(messages, errors, kind == REQUEST_ON_ASCII))


def show(message: ModbusEvent) -> str:
    """A message as one line, such as `unit 1 ask  read holding registers 03 00 6b 00 03`."""
    if isinstance(message, ClientConnected):
        return f"connection from {message.peer}"
    pdu = message.pdu
    word = "ask" if isinstance(message, ModbusRequest) else "answer"
    function = FUNCTIONS.get(pdu[0] & 0x7F, f"function {pdu[0] & 0x7F}")
    if pdu[0] & 0x80:
        code = pdu[1] if len(pdu) > 1 else 0
        function += f": {EXCEPTIONS.get(code, f'exception {code}')}"
    rest = f" … {len(pdu)} bytes" if len(pdu) > _LONGEST_SHOWN else ""
    return f"unit {message.unit} {word} {function}  {pdu[:_LONGEST_SHOWN].hex(' ')}{rest}"


def _address(data: bytes) -> str:
    address = data.decode("ascii")
    ipaddress.ip_address(address)
    return address


def _pdu(data: bytes, start: int) -> bytes:
    if not 1 <= len(data) - start <= LONGEST_PDU:
        raise ValueError(f"not a Modbus message, because its length is wrong: {data.hex(' ')}")
    return data[start:]
