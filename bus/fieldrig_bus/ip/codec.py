"""Messages of a relay as bytes, for other processes and traces.

A byte for the kind of message.  Then for a channel: the opener with its length, the number of the channel and, within
it, a byte for the direction; for a link: the device with its length and, for all but `LinkUp`, the direction.  Then the
rest.
"""

import struct
from ipaddress import IPv4Address
from typing import Final

from fieldrig.faults import note
from fieldrig.faults.note import FaultNote
from fieldrig.outside.untrusted import MalformedError
from fieldrig_bus.ip.message import (
    OF_LINK,
    Closed,
    Consumed,
    Ended,
    IpPacket,
    KernelOffered,
    LinkDown,
    LinkUp,
    Offered,
    OnRelay,
    Opened,
    Portion,
    RelayMessage,
    check_sent,
)

_CODES: Final = {
    Offered: 0,
    Opened: 1,
    Portion: 2,
    Consumed: 3,
    Ended: 4,
    Closed: 5,
    KernelOffered: 6,
    LinkUp: 7,
    LinkDown: 8,
    IpPacket: 9,
}
_NUMBER: Final = struct.Struct("!I")
_LINK: Final = struct.Struct("!4s4sH")


def encode(message: OnRelay) -> bytes:
    return note.encode(message) if isinstance(message, FaultNote) else _encoded(message)


def _encoded(message: RelayMessage) -> bytes:
    code = bytes((_CODES[type(message)],))
    match message:
        case Offered():
            return code + _packed(message.ports)
        case KernelOffered():
            return code
        case LinkUp():
            link = _LINK.pack(message.address.packed, message.peer.packed, message.mtu)
            return code + _named(message.device) + link + _packed(message.ports)
        case LinkDown():
            return code + _named(message.device) + bytes((message.is_answer,)) + message.why.encode()
        case IpPacket():
            return code + _named(message.device) + bytes((message.is_answer,)) + message.data
    head = code + _named(message.opener) + _NUMBER.pack(message.number)
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


def _named(name: str) -> bytes:
    return bytes((len(name.encode()),)) + name.encode()


def _packed(ports: tuple[int, ...]) -> bytes:
    return struct.pack(f"!{len(ports)}H", *ports)


def _unpacked(data: bytes) -> tuple[int, ...]:
    return struct.unpack(f"!{len(data) // 2}H", data)


def decode(data: bytes) -> OnRelay:
    """Return the message of `encode`'s bytes.  ValueError for anything else."""
    if data.startswith(note.LEAD):
        return note.decode(data)
    try:
        message = _decoded(data)
        check_sent(message)
    except (IndexError, struct.error, UnicodeDecodeError) as cause:
        raise MalformedError(f"not a message of a relay: {data[:20].hex()}") from cause
    return message


def _decoded(data: bytes) -> RelayMessage:
    code, rest = data[0], data[1:]
    if code == _CODES[Offered]:
        return Offered(_unpacked(rest))
    if code == _CODES[KernelOffered] and not rest:
        return KernelOffered()
    end = 1 + rest[0]
    name, rest = rest[1:end].decode(), rest[end:]
    if code in (_CODES[LinkUp], _CODES[LinkDown], _CODES[IpPacket]):
        return _of_link(code, name, rest)
    return _of_channel(code, name, _NUMBER.unpack_from(rest)[0], rest[_NUMBER.size :])


def _of_link(code: int, device: str, rest: bytes) -> RelayMessage:
    if code == _CODES[LinkUp]:
        address, peer, mtu = _LINK.unpack_from(rest)
        return LinkUp(device, IPv4Address(address), IPv4Address(peer), mtu, _unpacked(rest[_LINK.size :]))
    is_answer, rest = _direction(rest), rest[1:]
    return LinkDown(device, is_answer, rest.decode()) if code == _CODES[LinkDown] else IpPacket(device, is_answer, rest)


def _direction(rest: bytes) -> bool:
    if rest[0] > 1:
        raise MalformedError(f"a direction of {rest[0]}, expected 0 or 1")
    return bool(rest[0])


def _of_channel(code: int, opener: str, number: int, rest: bytes) -> RelayMessage:
    if code == _CODES[Opened]:
        return Opened(opener, number, *struct.unpack("!H", rest))
    is_answer, rest = _direction(rest), rest[1:]
    match code:
        case 2:
            return Portion(opener, number, is_answer, rest)
        case 3:
            return Consumed(opener, number, is_answer, *_NUMBER.unpack(rest))
        case 4 if not rest:
            return Ended(opener, number, is_answer)
        case 5:
            return Closed(opener, number, is_answer, rest.decode())
    raise MalformedError(f"not a message of a relay: kind {code}")


def show(message: OnRelay) -> str:
    """Return a message as one line."""
    if isinstance(message, FaultNote):
        return note.show(message)
    if isinstance(message, Offered):
        return f"offers port {', '.join(map(str, message.ports))}" if message.ports else "offers no port"
    if isinstance(message, KernelOffered):
        return "offers a kernel as the end of IP"
    if isinstance(message, OF_LINK):
        return _shown_link(message)
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


def _shown_link(message: LinkUp | LinkDown | IpPacket) -> str:
    match message:
        case LinkUp():
            ports = f"{len(message.ports)} ports"
            return f"{message.device} has a link: {message.address}, peer {message.peer}, MTU {message.mtu}, {ports}"
        case LinkDown():
            return f"{message.device} {_arrow(message.is_answer)} no link: {message.why}"
        case IpPacket():
            return f"{message.device} {_arrow(message.is_answer)} packet of {len(message.data)} bytes"


def _arrow(is_answer: bool) -> str:
    return "<-" if is_answer else "->"
