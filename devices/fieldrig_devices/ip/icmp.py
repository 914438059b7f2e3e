"""ICMP messages (RFC 792): the answer to an echo, the refusal of a packet, and fragments that did not come in time.

Left out: every message about a packet of ours, such as a redirect or a source quench, which is ignored.
"""

import struct
from ipaddress import IPv4Address
from typing import Final

from fieldrig_devices.ip.checksum import checksum
from fieldrig_devices.ip.ipv4 import Packet, Protocol

ECHO_REPLY: Final = 0
UNREACHABLE: Final = 3
ECHO: Final = 8
PROTOCOL_UNREACHABLE: Final = 2
PORT_UNREACHABLE: Final = 3
TIME_EXCEEDED: Final = 11
REASSEMBLY: Final = 1

_WIRE: Final = struct.Struct("!BBH")
_QUOTED_BYTES: Final = 8


def answer(message: bytes) -> bytes | None:
    """Return the reply to an undamaged echo message, or None for all other bytes."""
    if len(message) < 8 or checksum(message) != 0:
        return None
    message_type, code, _ = _WIRE.unpack_from(message)
    if (message_type, code) != (ECHO, 0):
        return None
    return _message(ECHO_REPLY, 0, message[4:])


def unreachable(code: int, refused: Packet) -> bytes:
    """Return the message that refuses a packet, with its header and its first 8 bytes (RFC 1122, 3.2.2)."""
    return _message(UNREACHABLE, code, bytes(4) + refused.encode()[: 20 + _QUOTED_BYTES])


def not_in_time(first: Packet) -> bytes:
    """Return the message that the rest of this first fragment did not come in time (RFC 1122, 3.3.2)."""
    return _message(TIME_EXCEEDED, REASSEMBLY, bytes(4) + first.encode()[: 20 + _QUOTED_BYTES])


def is_unicast(source: IPv4Address) -> bool:
    """True for an address that a host on a link may have, and to which an answer may go."""
    return not (source.is_multicast or source.is_unspecified or source.is_loopback or source.is_reserved)


def is_refusable(packet: Packet) -> bool:
    """True if an error about the packet may be sent: never about an error of ICMP, nor to many (RFC 1122, 3.2.2)."""
    is_error = packet.protocol == Protocol.ICMP and packet.payload[:1] != bytes((ECHO,))
    return not is_error and is_unicast(packet.source)


def _message(message_type: int, code: int, rest: bytes) -> bytes:
    check = checksum(_WIRE.pack(message_type, code, 0) + rest)
    return _WIRE.pack(message_type, code, check) + rest
