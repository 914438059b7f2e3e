"""TCP segments in the packets of a capture, over IPv4 (RFC 791) and IPv6 (RFC 8200), whatever link carried them.

Link types are those of tcpdump.org/linktypes.html.  Left out: fragments of IP packets, which Modbus TCP never needs.
"""

import struct
from collections.abc import Callable, Mapping
from ipaddress import IPv6Address
from typing import Final, NamedTuple

NULL, ETHERNET, PPP, PPP_HDLC, RAW, LOOP, SLL = 0, 1, 9, 50, 101, 108, 113
PPP_WITH_DIRECTION, IPV4, IPV6, SLL2, OLD_RAW = 204, 228, 229, 276, 12
_TCP: Final = 6
_EXTENSIONS: Final = frozenset({0, 43, 60})
"""Headers of IPv6 that may come before that of TCP: hop by hop, routing, destination."""
_VLAN: Final = frozenset({0x8100, 0x88A8, 0x9100})
_PPPOE: Final = 0x8864
"""A session of PPP over Ethernet, with a head of 6 bytes (RFC 2516, 4)."""
_MOST_TAGS: Final = 8
_TCP_HEAD: Final = struct.Struct("!HHIIBB")


class Segment(NamedTuple):
    source: str
    target: str
    from_port: int
    to_port: int
    sequence: int
    flags: int
    data: bytes
    missing: int
    """Bytes at the end of the segment that were not captured."""
    acknowledged: int = 0
    """The number of the byte that the sender waits for; 0 without an acknowledgement."""


SYN, FIN, RST, ACK = 0x02, 0x01, 0x04, 0x10


def segment_of(packet: bytes) -> Segment | None:
    """Return the TCP segment in an IP packet; None if it has none, or only a part of one."""
    if len(packet) < 20:
        return None
    if packet[0] >> 4 == 4:
        if packet[9] != _TCP or int.from_bytes(packet[6:8], "big") & 0x3FFF:  # more fragments, or not the first
            return None
        start, end = (packet[0] & 0x0F) * 4, int.from_bytes(packet[2:4], "big")
        source, target = (".".join(map(str, packet[at : at + 4])) for at in (12, 16))
    elif packet[0] >> 4 == 6 and len(packet) >= 40:
        found = _ipv6_start(packet)
        if found is None:
            return None
        start, end = found, 40 + int.from_bytes(packet[4:6], "big")
        source, target = (f"[{IPv6Address(packet[at : at + 16])}]" for at in (8, 24))
    else:
        return None
    end = end or len(packet)  # a host that splits packets in hardware leaves the length out
    if start + 20 > min(end, len(packet)):
        return None
    from_port, to_port, sequence, acknowledged, offset, flags = _TCP_HEAD.unpack_from(packet, start)
    begin = start + (offset >> 4) * 4
    data = packet[begin:end] if start + 20 <= begin <= end else b""
    missing = max(end - max(begin, len(packet)), 0)
    acknowledged = acknowledged if flags & ACK else 0
    return Segment(source, target, from_port, to_port, sequence, flags, data, missing, acknowledged)


def _ipv6_start(packet: bytes) -> int | None:
    kind, at = packet[6], 40
    while kind in _EXTENSIONS and at + 2 <= len(packet):
        kind, at = packet[at], at + 8 * (packet[at + 1] + 1)
    return at if kind == _TCP else None


def _ethernet(packet: bytes) -> bytes | None:
    at = 12
    for _ in range(_MOST_TAGS):
        kind = int.from_bytes(packet[at : at + 2], "big")
        if kind not in _VLAN:
            if kind == _PPPOE and len(packet) >= at + 8:
                return _ppp(packet[at + 8 :])
            return packet[at + 2 :] if kind in (0x0800, 0x86DD) else None
        at += 4
    return None


def _null(packet: bytes) -> bytes | None:
    """The family of addresses in the byte order of the host that captured, then the packet."""
    family = min(int.from_bytes(packet[:4], "big"), int.from_bytes(packet[:4], "little"))
    return packet[4:] if family in (2, 10, 24, 28, 30) else None


def _ppp(packet: bytes) -> bytes | None:
    rest = packet[2:] if packet[:2] == b"\xff\x03" else packet
    kind, size = (rest[0], 1) if rest[:1] and rest[0] & 1 else (int.from_bytes(rest[:2], "big"), 2)
    return rest[size:] if kind in (0x21, 0x57) else None


def _cooked(at: int, size: int) -> Callable[[bytes], bytes | None]:
    def ip(packet: bytes) -> bytes | None:
        return packet[size:] if int.from_bytes(packet[at : at + 2], "big") in (0x0800, 0x86DD) else None

    return ip


IP_OF: Final[Mapping[int, Callable[[bytes], bytes | None]]] = {
    NULL: _null,
    LOOP: _null,
    ETHERNET: _ethernet,
    RAW: lambda packet: packet,
    OLD_RAW: lambda packet: packet,
    IPV4: lambda packet: packet,
    IPV6: lambda packet: packet,
    PPP: _ppp,
    PPP_HDLC: _ppp,
    PPP_WITH_DIRECTION: lambda packet: _ppp(packet[1:]),
    SLL: _cooked(14, 16),
    SLL2: _cooked(0, 20),
}
"""Returns the IP packet in a packet of each link type; None if it has none."""
