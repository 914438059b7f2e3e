"""IPv4 packets (RFC 791): the header, its checksum and its length.

A packet may be a fragment, for which `fragments` is.  Left out: the meaning of options, which are skipped.
"""

import struct
from dataclasses import dataclass
from enum import IntEnum
from ipaddress import IPv4Address
from typing import ClassVar, Final, Self

from fieldrig_devices.ip.checksum import checksum

HEADER_BYTES: Final = 20
MOST_BYTES: Final = 0xFFFF
TIME_TO_LIVE: Final = 64
"""RFC 1700: the default for a packet that a host sends."""

_DONT_FRAGMENT: Final = 0x4000
_MORE_FRAGMENTS: Final = 0x2000
_OFFSET: Final = 0x1FFF


class Protocol(IntEnum):
    """The protocols of the stack, by their numbers in the header."""

    ICMP = 1
    TCP = 6
    UDP = 17


@dataclass(frozen=True, slots=True)
class Packet:
    """An IPv4 packet without options (RFC 791, 3.1)."""

    WIRE: ClassVar = struct.Struct("!BBHHHBBH4s4s")

    source: IPv4Address
    destination: IPv4Address
    protocol: int
    payload: bytes
    identification: int = 0
    time_to_live: int = TIME_TO_LIVE
    offset: int = 0
    """The place of the payload in that of the whole packet, in bytes: a multiple of 8."""
    has_more: bool = False
    """True if further fragments follow."""

    @property
    def is_fragment(self) -> bool:
        return self.has_more or self.offset > 0

    def encode(self) -> bytes:
        """Return the packet as bytes.  ValueError for a payload that no packet has room for."""
        length = HEADER_BYTES + len(self.payload)
        if length > MOST_BYTES:
            raise ValueError(f"a packet of {length} bytes, expected at most {MOST_BYTES}")
        fragment = self.offset // 8 | (_MORE_FRAGMENTS if self.has_more else 0) if self.is_fragment else _DONT_FRAGMENT
        fields = (0x45, 0, length, self.identification, fragment, self.time_to_live, self.protocol)
        addresses = self.source.packed, self.destination.packed
        check = checksum(self.WIRE.pack(*fields, 0, *addresses))
        return self.WIRE.pack(*fields, check, *addresses) + self.payload

    @classmethod
    def decode(cls, data: bytes) -> Self:
        """Return the packet in `data`, which may be padded at its end.

        ValueError for anything but an undamaged packet of version 4.
        """
        if len(data) < HEADER_BYTES:
            raise ValueError(f"{len(data)} bytes, expected a header of {HEADER_BYTES}")
        first, _, length, identification, fragment, time_to_live, protocol, _, source, destination = (
            cls.WIRE.unpack_from(data)
        )
        header_bytes = (first & 0x0F) * 4
        if first >> 4 != 4 or header_bytes < HEADER_BYTES:
            raise ValueError(f"a packet that begins with {first:#04x}, expected version 4 and at least 5 words")
        if not header_bytes <= length <= len(data):
            raise ValueError(f"a length of {length}, expected {header_bytes} to {len(data)}")
        if checksum(data[:header_bytes]) != 0:
            raise ValueError("a wrong checksum of the header")
        return cls(
            IPv4Address(source),
            IPv4Address(destination),
            protocol,
            data[header_bytes:length],
            identification,
            time_to_live,
            (fragment & _OFFSET) * 8,
            bool(fragment & _MORE_FRAGMENTS),
        )


def pseudo_header(source: IPv4Address, destination: IPv4Address, protocol: int, length: int) -> bytes:
    """Return the bytes that the checksums of TCP and UDP also cover (RFC 9293, 3.1)."""
    return source.packed + destination.packed + struct.pack("!HH", protocol, length)
