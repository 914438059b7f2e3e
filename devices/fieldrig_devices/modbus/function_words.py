"""Modbus functions without registers in words: diagnostics, counters, identity, file records and the FIFO.

Source: Modbus application protocol V1.1b3, 6.7 to 6.10, 6.13 to 6.15, 6.18 and 6.21.
"""

import struct
from collections.abc import Callable, Mapping
from typing import Final

from fieldrig.traces.names import MOST_LISTED

DIAGNOSTICS: Final[Mapping[int, str]] = {
    0: "return query data",
    1: "restart communications",
    2: "return diagnostic register",
    3: "change ASCII input delimiter",
    4: "force listen only mode",
    10: "clear counters and diagnostic register",
    11: "bus message count",
    12: "bus communication error count",
    13: "bus exception error count",
    14: "server message count",
    15: "server no response count",
    16: "server NAK count",
    17: "server busy count",
    18: "bus character overrun count",
    20: "clear overrun counter and flag",
}
LEVELS: Final[Mapping[int, str]] = {1: "basic", 2: "regular", 3: "extended", 4: "one object"}
OBJECTS: Final = ("VendorName", "ProductCode", "Revision", "VendorUrl", "ProductName", "ModelName", "ApplicationName")
IDENTIFICATION, REFERENCE = 0x0E, 6
BUSY: Final = 0xFFFF
FILE_RECORD: Final = struct.Struct(">BHHH")


def request_of(pdu: bytes) -> str:
    """Return the data of a request in words; of another function, or one that breaks its form, in hexadecimal."""
    return _said(REQUESTS, pdu)


def response_of(pdu: bytes) -> str:
    """Return the data of a response that is no exception in words; otherwise in hexadecimal."""
    return _said(RESPONSES, pdu)


def words(data: bytes) -> str:
    """Return registers in hexadecimal, the first of many."""
    shown = [f"{data[at : at + 2].hex().upper()}h" for at in range(0, min(len(data), 2 * MOST_LISTED), 2)]
    rest = (len(data) + 1) // 2 - MOST_LISTED
    return " ".join(shown) + (f" and {rest} more" if rest > 0 else "")


def _said(functions: Mapping[int, Callable[[bytes], str]], pdu: bytes) -> str:
    data = pdu[1:]
    try:
        return functions[pdu[0]](data) or "nothing"
    except (KeyError, ValueError, IndexError, struct.error):
        return data.hex(" ").upper()


def _diagnostics(data: bytes) -> str:
    code, rest = int.from_bytes(data[:2], "big"), data[2:]
    name = DIAGNOSTICS[code]
    return f"{name} {words(rest)}" if any(rest) or code in (0, 2) else name


def _diagnosed(data: bytes) -> str:
    code, rest = int.from_bytes(data[:2], "big"), data[2:]
    is_count = 10 < code < 20
    return str(struct.unpack(">H", rest)[0]) if is_count else words(rest)


def _event_counter(data: bytes) -> str:
    status, events = struct.unpack(">HH", data)
    return f"{_status(status)}, {events} events"


def _event_log(data: bytes) -> str:
    length, status, events, messages = struct.unpack_from(">BHHH", data)
    log = _whole(data[7:], length - 6)
    return f"{_status(status)}, {events} events, {messages} messages, the last events {log.hex(' ').upper()}".rstrip()


def _status(status: int) -> str:
    return "busy" if status == BUSY else "ready" if status == 0 else f"status {status:04X}h"


def _server_id(data: bytes) -> str:
    identity = _whole(data[1:], data[0])
    text = _text(identity.rstrip(b"\x00\xff"))
    return f"{text}, {identity.hex(' ').upper()}" if text else identity.hex(" ").upper()


def _text(data: bytes) -> str:
    """Return characters in quotation marks, or "" if one of them cannot be shown."""
    text = data.decode("ascii", "replace")
    return f'"{text}"' if text.isprintable() and text.isascii() and text else ""


def _read_records(data: bytes) -> str:
    rest = _whole(data[1:], data[0])
    return ", ".join(_record(rest[at : at + FILE_RECORD.size]) for at in range(0, len(rest), FILE_RECORD.size))


def _record(head: bytes) -> str:
    """Return the file and records of a sub-request."""
    reference, file, record, length = FILE_RECORD.unpack(head)
    if reference != REFERENCE:
        raise ValueError(f"reference type {reference}")
    return f"file {file} record {record}" if length == 1 else f"file {file} records {record}-{record + length - 1}"


def _written_records(data: bytes) -> str:
    rest, found = _whole(data[1:], data[0]), []
    while rest:
        head, rest = rest[: FILE_RECORD.size], rest[FILE_RECORD.size :]
        size = 2 * int.from_bytes(head[5:], "big")
        found.append(f"{_record(head)} = {words(_whole(rest[:size], size))}")
        rest = rest[size:]
    return ", ".join(found)


def _records_read(data: bytes) -> str:
    rest, found = _whole(data[1:], data[0]), []
    while rest:
        length, reference = rest[0], rest[1]
        if reference != REFERENCE:
            raise ValueError(f"reference type {reference}")
        found.append(words(_whole(rest[2 : 1 + length], length - 1)))
        rest = rest[1 + length :]
    return ", ".join(found)


def _fifo(data: bytes) -> str:
    size, count = struct.unpack_from(">HH", data)
    return words(_whole(data[4:], 2 * count)) if size == 2 * count + 2 else data.hex(" ").upper()


def _identify(data: bytes) -> str:
    kind, level, first = data
    if kind != IDENTIFICATION:
        raise ValueError(f"interface type {kind}")
    name = LEVELS[level]
    return f"device identification, {name}" + (f" from {_object(first)}" if first or level not in (1, 2, 3) else "")


def _identified(data: bytes) -> str:
    if data[0] != IDENTIFICATION:
        raise ValueError(f"interface type {data[0]}")
    more, following, count = data[3], data[4], data[5]
    rest, found = data[6:], []
    for _ in range(count):
        number, size = rest[0], rest[1]
        value = _whole(rest[2 : 2 + size], size)
        found.append(f"{_object(number)} {_text(value) or value.hex(' ').upper()}".rstrip())
        rest = rest[2 + size :]
    return ", ".join(found) + (f", more from {_object(following)}" if more else "")


def _object(number: int) -> str:
    return OBJECTS[number] if number < len(OBJECTS) else f"object {number:02X}h"


def _whole(data: bytes, size: int) -> bytes:
    """Return the data; ValueError if it has another size than it says."""
    if len(data) != size:
        raise ValueError(f"{len(data)} bytes where {size} were announced")
    return data


REQUESTS: Final[Mapping[int, Callable[[bytes], str]]] = {
    8: _diagnostics,
    20: _read_records,
    21: _written_records,
    24: lambda data: str(struct.unpack(">H", data)[0]),
    43: _identify,
}
RESPONSES: Final[Mapping[int, Callable[[bytes], str]]] = {
    7: lambda data: f"{data[0]:02X}h",
    8: _diagnosed,
    11: _event_counter,
    12: _event_log,
    17: _server_id,
    20: _records_read,
    21: _written_records,
    24: _fifo,
    43: _identified,
}
