"""A Modbus message as bytes, for other processes and traces, and as a line of text.

Bytes, little endian: kind (1), unit (1), exchange (4), state of the serial line if there is one (8), PDU.  An answer
that the bus has carried has unit (1) and exchange (4) of its request before the PDU.  The PDU is bytes throughout: the
PDU classes of pymodbus would cost 40 us per request and answer wrong quantities with function code 0x80, so pymodbus is
the foreign client of the tests and not the codec.  A connection has unit and exchange 0, and its address as text.  A
damaged answer has, after the exchange, bits (1; bit 0: the connection is cut, bit 1: unit and exchange of its request
follow), the size of the PDU (1), what bit 1 says, and the PDU, then for each of its pieces the delay in ns (8), the
size (2) and the bytes.
"""

import ipaddress
import struct
from typing import Final

from fieldrig.faults import note
from fieldrig.faults.note import FaultNote
from fieldrig_bus.modbus.message import (
    LONGEST_PDU,
    Asked,
    ClientConnected,
    DamagedAnswer,
    LineState,
    ModbusRequest,
    ModbusResponse,
    OnModbus,
)

RESPONSE, REQUEST, REQUEST_ON_RTU, REQUEST_ON_ASCII, CONNECTED, DAMAGED, ANSWER = range(7)

_RESPONSES: Final = (bytes((RESPONSE,)), bytes((ANSWER,)))
"""The first byte of a response, before and after the bus has carried it."""

_HEAD: Final = struct.Struct("<BBI")
_LINE: Final = struct.Struct("<BBIII")
_ASKED: Final = struct.Struct("<BI")
_ANSWER: Final = struct.Struct("<BBIBI")
_DAMAGED: Final = struct.Struct("<BB")
_IS_CUT, _HAS_ASKED = 1, 2
_PIECE: Final = struct.Struct("<QH")
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
    11: "event counter",
    12: "event log",
    15: "write coils",
    16: "write registers",
    17: "report server id",
    20: "read file records",
    21: "write file records",
    22: "mask write register",
    23: "read/write registers",
    24: "read FIFO",
    43: "encapsulated interface",
}

EXCEPTIONS: Final = {  # V1.1b3, chapter 7; 07h is that of the Modicon protocol (PI-MBUS-300), and still in use
    1: "illegal function",
    2: "illegal data address",
    3: "illegal data value",
    4: "server device failure",
    5: "acknowledge",
    6: "server device busy",
    7: "negative acknowledge",
    8: "memory parity error",
    10: "gateway path unavailable",
    11: "gateway target failed to respond",
}

_LONGEST_SHOWN: Final = 24


def encode(message: OnModbus) -> bytes:
    if isinstance(message, ModbusResponse):
        if message.asked is not None:
            return _ANSWER.pack(ANSWER, message.unit, message.exchange, *message.asked) + message.pdu
        return _HEAD.pack(RESPONSE, message.unit, message.exchange) + message.pdu
    if isinstance(message, ClientConnected):
        return _HEAD.pack(CONNECTED, 0, 0) + message.peer.encode()
    if isinstance(message, DamagedAnswer):
        return _encode_damaged(message)
    if isinstance(message, FaultNote):
        return note.encode(message)
    line = message.line
    if line is None:
        return _HEAD.pack(REQUEST, message.unit, message.exchange) + message.pdu
    tag = REQUEST_ON_ASCII if line.is_ascii else REQUEST_ON_RTU
    messages, errors = line.messages & _COUNT_MASK, line.errors & _COUNT_MASK
    return _LINE.pack(tag, message.unit, message.exchange, messages, errors) + message.pdu


def decode(data: bytes) -> OnModbus:
    """The inverse of `encode`.  ValueError for anything else."""
    try:
        tag, unit, exchange = _HEAD.unpack_from(data)
        if tag == RESPONSE:
            return ModbusResponse(unit, _pdu(data, _HEAD.size), exchange)
        if tag == ANSWER:
            asked = Asked._make(_ASKED.unpack_from(data, _HEAD.size))
            return ModbusResponse(unit, _pdu(data, _ANSWER.size), exchange, asked)
        if tag == REQUEST:
            return ModbusRequest(unit, _pdu(data, _HEAD.size), exchange)
        if tag == CONNECTED and unit == exchange == 0:
            return ClientConnected(_address(data[_HEAD.size :]))
        if tag == DAMAGED:
            return _decode_damaged(unit, exchange, data[_HEAD.size :])
        if data.startswith(note.LEAD):
            return note.decode(data)
        tag, unit, exchange, messages, errors = _LINE.unpack_from(data)
    except struct.error as cause:
        raise ValueError(f"not a Modbus message: {data.hex(' ')}") from cause
    if tag > REQUEST_ON_ASCII:
        raise ValueError(f"not a Modbus message: {data.hex(' ')}")
    return ModbusRequest(unit, _pdu(data, _LINE.size), exchange, LineState(messages, errors, tag == REQUEST_ON_ASCII))


def is_response(data: bytes) -> bool:
    """Return whether an encoded message is a response."""
    return data[:1] in _RESPONSES


def unit_in(data: bytes) -> int:
    """Return the unit of an encoded request, or of the request that an encoded response answers."""
    return data[_HEAD.size] if data[0] == ANSWER and len(data) > _HEAD.size else data[1]


def show(message: OnModbus) -> str:
    """A message as one line, such as `unit 1 ask  read holding registers 03 00 6b 00 03`."""
    if isinstance(message, ClientConnected):
        return f"connection from {message.peer}"
    if isinstance(message, FaultNote):
        return note.show(message)
    if isinstance(message, DamagedAnswer):
        pieces = " | ".join(piece[:_LONGEST_SHOWN].hex(" ") for _, piece in message.pieces)
        return f"unit {message.unit} answers in wrong bytes  {pieces or 'none'}{', cut' if message.is_cut else ''}"
    pdu = message.pdu
    word = "ask" if isinstance(message, ModbusRequest) else "answer"
    function = FUNCTIONS.get(pdu[0] & 0x7F, f"function {pdu[0] & 0x7F}")
    if pdu[0] & 0x80:
        code = pdu[1] if len(pdu) > 1 else 0
        function += f": {EXCEPTIONS.get(code, f'exception {code}')}"
    rest = f" … {len(pdu)} bytes" if len(pdu) > _LONGEST_SHOWN else ""
    return f"unit {message.unit} {word} {function}  {pdu[:_LONGEST_SHOWN].hex(' ')}{rest}"


def _encode_damaged(message: DamagedAnswer) -> bytes:
    asked = b"" if message.asked is None else _ASKED.pack(*message.asked)
    bits = _IS_CUT * message.is_cut | _HAS_ASKED * bool(asked)
    head = _HEAD.pack(DAMAGED, message.unit, message.exchange) + _DAMAGED.pack(bits, len(message.pdu)) + asked
    return head + message.pdu + b"".join(_PIECE.pack(after_ns, len(data)) + data for after_ns, data in message.pieces)


def _decode_damaged(unit: int, exchange: int, body: bytes) -> DamagedAnswer:
    (bits, size), begin, asked = _DAMAGED.unpack_from(body), _DAMAGED.size, None
    if bits & _HAS_ASKED:
        asked = Asked._make(_ASKED.unpack_from(body, begin))
        begin += _ASKED.size
    at, pieces = begin + size, list[tuple[int, bytes]]()
    pdu = body[begin:at]
    while at < len(body):
        after_ns, length = _PIECE.unpack_from(body, at)
        at += _PIECE.size
        pieces.append((after_ns, body[at : at + length]))
        at += length
    if at != len(body) or bits > _IS_CUT | _HAS_ASKED or size > LONGEST_PDU:
        raise ValueError(f"not a damaged answer: {body[:_LONGEST_SHOWN].hex(' ')}")
    return DamagedAnswer(unit, pdu, exchange, tuple(pieces), bool(bits & _IS_CUT), asked=asked)


def _address(data: bytes) -> str:
    address = data.decode("ascii")
    ipaddress.ip_address(address)
    return address


def _pdu(data: bytes, start: int) -> bytes:
    if not 1 <= len(data) - start <= LONGEST_PDU:
        raise ValueError(f"not a Modbus message, because its length is wrong: {data.hex(' ')}")
    return data[start:]
