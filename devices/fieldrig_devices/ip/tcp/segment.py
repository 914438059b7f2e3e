"""TCP segments (RFC 9293, 3.1): the header, the checksum over the pseudo-header, and the option of the segment size.

Left out: all other options, which are skipped, and the urgent pointer, which is ignored.
"""

import struct
from dataclasses import dataclass
from enum import IntFlag
from ipaddress import IPv4Address
from typing import ClassVar, Final, Self

from fieldrig_devices.ip.checksum import checksum
from fieldrig_devices.ip.ipv4 import Protocol, pseudo_header

HEADER_BYTES: Final = 20
DEFAULT_MSS: Final = 536
"""The segment size of a peer that sends no option (RFC 9293, 3.7.1)."""

_END, _NO_OPERATION, _MSS = 0, 1, 2


class Flags(IntFlag):
    """The control bits."""

    FIN = 0x01
    SYN = 0x02
    RST = 0x04
    PSH = 0x08
    ACK = 0x10


FIN, SYN, RST, PSH, ACK = Flags
_KNOWN: Final = 0x1F


@dataclass(frozen=True, slots=True)
class Segment:
    """A TCP segment.  Sequence numbers are those on the wire, modulo 2 ** 32."""

    WIRE: ClassVar = struct.Struct("!HHIIBBHHH")

    source_port: int
    destination_port: int
    sequence: int
    acknowledgment: int
    flags: Flags
    window: int
    data: bytes = b""
    mss: int | None = None
    """The largest segment that the sender accepts, in bytes of data; only in a SYN."""

    @property
    def length(self) -> int:
        """The sequence numbers that the segment takes (SEG.LEN), in which SYN and FIN count as well."""
        flags = int(self.flags)
        return len(self.data) + (flags >> 1 & 1) + (flags & 1)

    def encode(self, source: IPv4Address, destination: IPv4Address) -> bytes:
        """Return the segment as bytes, for a packet with these addresses."""
        options = b"" if self.mss is None else struct.pack("!BBH", _MSS, 4, self.mss)
        words = (HEADER_BYTES + len(options)) // 4
        header = [self.source_port, self.destination_port, self.sequence, self.acknowledgment]
        header += [words << 4, int(self.flags), self.window]
        rest = options + self.data
        length = HEADER_BYTES + len(rest)
        covered = pseudo_header(source, destination, Protocol.TCP, length) + self.WIRE.pack(*header, 0, 0) + rest
        return self.WIRE.pack(*header, checksum(covered), 0) + rest

    @classmethod
    def decode(cls, data: bytes, source: IPv4Address, destination: IPv4Address) -> Self:
        """Return the segment in the payload of a packet.  ValueError for damaged bytes."""
        if len(data) < HEADER_BYTES:
            raise ValueError(f"{len(data)} bytes, expected a header of {HEADER_BYTES}")
        if checksum(pseudo_header(source, destination, Protocol.TCP, len(data)) + data) != 0:
            raise ValueError("a wrong checksum of the segment")
        source_port, destination_port, sequence, acknowledgment, words, flags, window, _, _ = cls.WIRE.unpack_from(data)
        header_bytes = (words >> 4) * 4
        if not HEADER_BYTES <= header_bytes <= len(data):
            raise ValueError(f"a header of {header_bytes} bytes, expected {HEADER_BYTES} to {len(data)}")
        mss = _mss(data[HEADER_BYTES:header_bytes]) if flags & SYN else None
        known = Flags(flags & _KNOWN)
        return cls(source_port, destination_port, sequence, acknowledgment, known, window, data[header_bytes:], mss)


def _mss(options: bytes) -> int | None:
    """Return the segment size in the options; None where there is none before their end or the first damaged one."""
    offset = 0
    while offset < len(options) and options[offset] != _END:
        if options[offset] == _NO_OPERATION:
            offset += 1
            continue
        length = options[offset + 1] if offset + 1 < len(options) else 0
        if length < 2 or offset + length > len(options):
            return None
        if options[offset] == _MSS and length == 4:
            return int.from_bytes(options[offset + 2 : offset + 4], "big")
        offset += length
    return None
