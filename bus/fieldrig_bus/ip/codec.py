"""Messages of a relay as bytes, for other processes and traces.

A byte for the kind of message; then for all but `Offered` the opener with its length, the number of the channel and,
within a channel, a byte for the direction; then the rest.
"""

import struct
from typing import Final

from fieldrig.untrusted import MalformedError
from fieldrig_bus.ip.message import Closed, Consumed, Ended, Offered, Opened, Portion, RelayMessage, check_sent

_CODES: Final = {Offered: 0, Opened: 1, Portion: 2, Consumed: 3, Ended: 4, Closed: 5}
_NUMBER: Final = struct.Struct("!I")


def encode(message: RelayMessage) -> bytes:
    code = bytes((_CODES[type(message)],))
    if isinstance(message, Offered):
        return code + struct.pack(f"!{len(message.ports)}H", *message.ports)
    opener = message.opener.encode()
    head = code + bytes((len(opener),)) + opener + _NUMBER.pack(message.number)
    if isinstance(message, Opened):
        return head + struct.pack("!H", message.port)
    head += bytes((message.is_answer,))
    match message:
        case Portion():
            return head + message.data
        case Consumed():
            return head + _NUMBER.pack(message.size)
        case Closed():
            return head + message.why.encode()
        case Ended():
            return head


def decode(data: bytes) -> RelayMessage:
    """Return the message of `encode`'s bytes.  ValueError for anything else."""
    try:
        message = _decoded(data)
        check_sent(message)
    except (IndexError, struct.error, UnicodeDecodeError) as cause:
        raise MalformedError(f"not a message of a relay: {data[:20].hex()}") from cause
    return message


def _decoded(data: bytes) -> RelayMessage:
    code, rest = data[0], data[1:]
    if code == _CODES[Offered]:
        return Offered(struct.unpack(f"!{len(rest) // 2}H", rest))
    end = 1 + rest[0]
    opener, number, rest = rest[1:end].decode(), _NUMBER.unpack_from(rest, end)[0], rest[end + _NUMBER.size :]
    if code == _CODES[Opened]:
        return Opened(opener, number, *struct.unpack("!H", rest))
    if rest[0] > 1:
        raise MalformedError(f"a direction of {rest[0]}, expected 0 or 1")
    is_answer, rest = bool(rest[0]), rest[1:]
    match code:
        case 2:
            return Portion(opener, number, is_answer, rest)
        case 3:
            return Consumed(opener, number, is_answer, *_NUMBER.unpack(rest))
        case 4 if not rest:
            return Ended(opener, number, is_answer)
        case 5:
            return Closed(opener, number, is_answer, rest.decode())
    raise MalformedError(f"not a message of a relay: {data[:20].hex()}")


def show(message: RelayMessage) -> str:
    """Return a message as one line."""
    if isinstance(message, Offered):
        return f"offers port {', '.join(map(str, message.ports))}" if message.ports else "offers no port"
    channel = f"{message.opener}#{message.number}"
    match message:
        case Opened():
            return f"{channel} opens port {message.port}"
        case Portion():
            return f"{channel} {_arrow(message.is_answer)} {len(message.data)} bytes"
        case Consumed():
            return f"{channel} {_arrow(message.is_answer)} {message.size} bytes consumed"
        case Ended():
            return f"{channel} {_arrow(message.is_answer)} end"
        case Closed():
            return f"{channel} {_arrow(message.is_answer)} closed: {message.why}"


def _arrow(is_answer: bool) -> str:
    return "<-" if is_answer else "->"
