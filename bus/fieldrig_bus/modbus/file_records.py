"""Functions 20 and 21: records of files, which are registers beyond the 65,536 addresses.

Source: Modbus application protocol V1.1b3, 6.14 and 6.15.  A request has several sub-requests; all of them are checked
before anything is written.
"""

import struct
from collections.abc import Callable, Iterator, Mapping
from typing import Final, NamedTuple, Protocol

from fieldrig_bus.modbus.errors import ILLEGAL_DATA_ADDRESS, ILLEGAL_DATA_VALUE, ModbusError

REFERENCE_TYPE: Final = 6
LAST_RECORD: Final = 9_999
_HEAD: Final = struct.Struct(">BHHH")
"""Reference type, file, record and number of registers."""
SHORTEST_READ, LONGEST_READ = 7, 0xF5
SHORTEST_WRITE, LONGEST_WRITE = 9, 0xFB


class File(Protocol):
    """The registers of one file.  Both methods raise ModbusError 02 for records that are not there."""

    def read(self, address: int, quantity: int) -> bytes: ...

    def write(self, address: int, data: bytes) -> None: ...


class _Part(NamedTuple):
    """One sub-request."""

    file: File
    record: int
    quantity: int
    data: bytes


def reader(files: Mapping[int, File]) -> Callable[[bytes], bytes]:
    """Return the function that answers function 20."""

    def answer(pdu: bytes) -> bytes:
        _check_value(SHORTEST_READ <= len(pdu) - 2 <= LONGEST_READ and pdu[1] == len(pdu) - 2)
        _check_value((len(pdu) - 2) % _HEAD.size == 0)
        parts = b""
        for part in _parts(files, pdu, with_data=False):
            data = part.file.read(part.record, part.quantity)
            parts += bytes((len(data) + 1 & 0xFF, REFERENCE_TYPE)) + data
            _check_value(len(parts) <= LONGEST_READ)
        return bytes((0x14, len(parts))) + parts

    return answer


def writer(files: Mapping[int, File]) -> Callable[[bytes], bytes]:
    """Return the function that answers function 21."""

    def answer(pdu: bytes) -> bytes:
        _check_value(SHORTEST_WRITE <= len(pdu) - 2 <= LONGEST_WRITE and pdu[1] == len(pdu) - 2)
        parts = list(_parts(files, pdu, with_data=True))
        before = [(part, part.file.read(part.record, part.quantity)) for part in parts]
        written = []
        try:
            for part, old in before:
                part.file.write(part.record, part.data)
                written.append((part, old))
        except ModbusError:
            for part, old in reversed(written):
                part.file.write(part.record, old)
            raise
        return pdu

    return answer


def _parts(files: Mapping[int, File], pdu: bytes, with_data: bool) -> Iterator[_Part]:
    at = 2
    while at < len(pdu):
        _check_value(at + _HEAD.size <= len(pdu))
        kind, number, record, quantity = _HEAD.unpack_from(pdu, at)
        at += _HEAD.size
        size = 2 * quantity if with_data else 0
        _check_value(quantity >= 1 and at + size <= len(pdu))
        if kind != REFERENCE_TYPE or number not in files or record + quantity - 1 > LAST_RECORD:
            raise ModbusError(ILLEGAL_DATA_ADDRESS)
        yield _Part(files[number], record, quantity, pdu[at : at + size])
        at += size


def _check_value(is_right: bool) -> None:
    if not is_right:
        raise ModbusError(ILLEGAL_DATA_VALUE)
