"""The memory as one data block of an S7 controller, read and written by any S7 client.

The protocol is not published by its maker; this follows the clients that read and write variables (S7ANY addresses).
A word that a client writes as a whole changes at once.  Left out: blocks, clock, passwords and all that is not a
variable, which are refused.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.connections.connection import Connection, Serve
from fieldrig_devices.pam.ports.access.iso import IsoSession
from fieldrig_devices.pam.ports.memory import ByteOrder, Memory

_JOB_HEAD: Final = struct.Struct(">BBHHHH")
_ACK_HEAD: Final = struct.Struct(">BBHHHHBB")
_ADDRESS: Final = struct.Struct(">BBBBHHB3s")
_ITEM: Final = struct.Struct(">BBH")
_SETUP: Final = struct.Struct(">BBHHH")
PROTOCOL: Final = 0x32
JOB, ACK_DATA, USER_DATA = 0x01, 0x03, 0x07
SETUP, READ, WRITE = 0xF0, 0x04, 0x05
DATA_BLOCKS: Final = 0x84
BIT: Final = 0x01
SIZES: Final = {BIT: 1, 0x02: 1, 0x03: 1, 0x04: 2, 0x05: 2, 0x06: 4, 0x07: 4, 0x08: 4}
"""Bytes of an element: BIT, BYTE, CHAR, WORD, INT, DWORD, DINT and REAL."""
DONE, WRONG_ADDRESS, WRONG_TYPE, NO_SUCH_BLOCK = 0xFF, 0x05, 0x06, 0x0A
LONGEST_PDU: Final = 480
NOT_SUPPORTED: Final = (0x81, 0x04)
WRONG_SIZE: Final = (0x85, 0x00)
_IN_BITS: Final = (0x03, 0x04, 0x05)
"""Transport sizes of data whose length is counted in bits; 3 is a single bit."""


class AddressError(Exception):
    """An item cannot be read or written; `code` says why."""

    def __init__(self, code: int) -> None:
        super().__init__(f"return code {code:#04x}")
        self.code = code


@dataclass(frozen=True, slots=True)
class Item:
    """The address of a variable: bytes from `address` on, or one bit of a byte."""

    address: int
    size: int
    bit: int | None = None


def serving_s7(memory: Memory, data_block: int, order: ByteOrder) -> Serve:
    def session(connection: Connection) -> IsoSession:
        return IsoSession(connection, S7Server(memory, data_block, order).answer)

    return session


class S7Server:
    """Answers the PDUs of one client."""

    def __init__(self, memory: Memory, data_block: int, order: ByteOrder) -> None:
        self._memory, self._data_block, self._order = memory, data_block, order
        self._pdu = LONGEST_PDU

    def answer(self, pdu: bytes) -> bytes | None:
        """Return the answer to a PDU; None for one that asks nothing or makes no sense."""
        if len(pdu) < _JOB_HEAD.size:
            return None
        protocol, message_type, _, reference, parameter_size, data_size = _JOB_HEAD.unpack_from(pdu)
        body = pdu[_JOB_HEAD.size :]
        if protocol != PROTOCOL or message_type not in (JOB, USER_DATA) or len(body) != parameter_size + data_size:
            return None
        parameters, data = body[:parameter_size], body[parameter_size:]
        function = parameters[0] if parameters and message_type == JOB else None
        try:
            if function == SETUP:
                return _reply(reference, self._set_up(parameters), b"")
            if function in (READ, WRITE) and len(parameters) >= 2:
                results = self._read(parameters) if function == READ else self._write(parameters, data)
                if len(results) + _ACK_HEAD.size + 2 > self._pdu:
                    return _reply(reference, b"", b"", WRONG_SIZE)
                return _reply(reference, parameters[:2], results)
        except (struct.error, IndexError):
            return _reply(reference, b"", b"", WRONG_SIZE)
        return _reply(reference, b"", b"", NOT_SUPPORTED)

    def _set_up(self, parameters: bytes) -> bytes:
        *_, wanted = _SETUP.unpack(parameters)
        self._pdu = min(max(wanted, 64), LONGEST_PDU)
        return _SETUP.pack(SETUP, 0, 1, 1, self._pdu)

    def _read(self, parameters: bytes) -> bytes:
        answer = bytearray()
        for address in _addresses(parameters):
            answer += bytes(len(answer) % 2)  # each item begins at an even byte
            try:
                answer += self._read_item(self._item(address))
            except AddressError as wrong:
                answer += _ITEM.pack(wrong.code, 0, 0)
        return bytes(answer)

    def _read_item(self, item: Item) -> bytes:
        try:
            data = self._memory.read_bytes(item.address, item.size, self._order)
        except IndexError as cause:
            raise AddressError(WRONG_ADDRESS) from cause
        if item.bit is not None:
            return _ITEM.pack(DONE, 0x03, 1) + bytes((data[0] >> item.bit & 1,))
        return _ITEM.pack(DONE, 0x04, 8 * len(data)) + data

    def _write(self, parameters: bytes, data: bytes) -> bytes:
        codes = bytearray()
        at = 0
        for address in _addresses(parameters):
            _, transport, length = _ITEM.unpack_from(data, at)
            size = (length + 7) // 8 if transport in _IN_BITS else length
            value = data[at + _ITEM.size : at + _ITEM.size + size]
            at += _ITEM.size + size + size % 2
            try:
                self._write_item(self._item(address), value)
                codes.append(DONE)
            except AddressError as wrong:
                codes.append(wrong.code)
        return bytes(codes)

    def _write_item(self, item: Item, value: bytes) -> None:
        if len(value) != item.size:
            raise AddressError(WRONG_TYPE)
        try:
            if item.bit is not None:
                (present,) = self._memory.read_bytes(item.address, 1, self._order)
                mask = 1 << item.bit
                value = bytes((present | mask if value[0] & 1 else present & ~mask,))
            self._memory.write_bytes(item.address, value, self._order)
        except IndexError as cause:
            raise AddressError(WRONG_ADDRESS) from cause

    def _item(self, address: bytes) -> Item:
        specification, length, syntax, size, count, block, area, place = _ADDRESS.unpack(address)
        if (specification, length, syntax) != (0x12, 0x0A, 0x10) or size not in SIZES:
            raise AddressError(WRONG_TYPE)
        if area != DATA_BLOCKS or block != self._data_block:
            raise AddressError(NO_SUCH_BLOCK)
        bits = int.from_bytes(place, "big")
        if size == BIT:
            if count != 1:
                raise AddressError(WRONG_TYPE)
            return Item(bits // 8, 1, bits % 8)
        if bits % 8 or count == 0:
            raise AddressError(WRONG_ADDRESS)
        return Item(bits // 8, count * SIZES[size])


def _addresses(parameters: bytes) -> Iterator[bytes]:
    """Yield the addresses of a request.  IndexError if there are fewer than it says."""
    for number in range(parameters[1]):
        first = 2 + number * _ADDRESS.size
        if first + _ADDRESS.size > len(parameters):
            raise IndexError(number)
        yield parameters[first : first + _ADDRESS.size]


def _reply(reference: int, parameters: bytes, data: bytes, error: tuple[int, int] = (0, 0)) -> bytes:
    head = _ACK_HEAD.pack(PROTOCOL, ACK_DATA, 0, reference, len(parameters), len(data), *error)
    return head + parameters + data
