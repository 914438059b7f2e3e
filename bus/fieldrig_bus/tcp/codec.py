"""Messages of TCP as bytes, for other processes and traces, and as a line of text.

The first byte is the place of the message in `KINDS`, and the connection follows in 32 bits, little endian.
"""

import struct
from typing import Any, Final

from fieldrig.faults import note
from fieldrig.faults.note import FaultNote
from fieldrig_bus.tcp.message import (
    KINDS,
    Close,
    Connect,
    Connected,
    Data,
    Ended,
    Listening,
    OnTcp,
    Taken,
    TcpMessage,
    check_sent,
)

_HEAD: Final = struct.Struct("<BI")
_NUMBER: Final = struct.Struct("<I")
_LONGEST_SHOWN: Final = 40
_SEPARATOR: Final = "\n"


def encode(message: OnTcp) -> bytes:
    if isinstance(message, FaultNote):
        return note.encode(message)
    head = _HEAD.pack(KINDS.index(type(message)), message.connection)
    match message:
        case Connected(service=service, peer=peer, local=local, origin=origin):
            return head + _NUMBER.pack(origin) + _SEPARATOR.join((service, peer, local)).encode()
        case Data(data=data):
            return head + data
        case Taken(count=number) | Listening(port=number) | Connect(port=number):
            return head + _NUMBER.pack(number)
        case Ended(is_lost=is_lost):
            return head + bytes((is_lost,))
        case Close(limit=limit):
            return head + limit.encode()
    return head


def decode(data: bytes) -> Any:
    """Return the message of `encode`'s bytes.  ValueError for anything else."""
    if data.startswith(note.LEAD):
        return note.decode(data)
    try:
        message = _decoded(data)
        check_sent(message)
    except (struct.error, LookupError, TypeError, UnicodeDecodeError) as cause:
        raise ValueError(f"not a message of TCP: {data[:_LONGEST_SHOWN].hex(' ')}") from cause
    return message


def _decoded(data: bytes) -> TcpMessage:
    place, connection = _HEAD.unpack_from(data)
    message_class, body = KINDS[place], data[_HEAD.size :]
    if message_class is Connected:
        (origin,) = _NUMBER.unpack_from(body)
        service, peer, local = body[_NUMBER.size :].decode().split(_SEPARATOR)
        return Connected(connection, service, peer, local, origin)
    if message_class is Data:
        return Data(connection, body)
    if message_class in (Taken, Listening, Connect):
        message: TcpMessage = message_class(connection, *_NUMBER.unpack(body))
        return message
    if message_class is Ended:
        return Ended(connection, {b"\0": False, b"\1": True}[body])
    if message_class is Close:
        return Close(connection, body.decode())
    if body:
        raise IndexError(len(body))
    plain: TcpMessage = message_class(connection)
    return plain


def show(message: OnTcp) -> str:
    """Return a message as one line."""
    if isinstance(message, FaultNote):
        return note.show(message)
    place = f"connection {message.connection}"
    match message:
        case Connected(service=service, peer=peer, origin=origin):
            return f"{place}: {peer} connected to {service or f'the extra port of connection {origin}'}"
        case Data(data=data):
            rest = f" … {len(data)} bytes" if len(data) > _LONGEST_SHOWN else ""
            return f"{place}: {repr(data[:_LONGEST_SHOWN])[1:]}{rest}"
        case Taken(count=count):
            return f"{place}: {count} bytes taken"
        case Listening(port=port):
            return f"{place}: listening at port {port}"
        case Connect(port=port):
            return f"{place}: connect to port {port}"
        case Close(limit=limit) if limit:
            return f"{place}: close ({limit})"
    return f"{place}: {type(message).__name__.lower()}"
