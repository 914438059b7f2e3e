"""Packets of LCP and IPCP, and the options in them (RFC 1661 chapters 5 and 6)."""

import struct
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import ClassVar, NamedTuple, Self


class Code(IntEnum):
    CONFIGURE_REQUEST = 1
    CONFIGURE_ACK = 2
    CONFIGURE_NAK = 3
    CONFIGURE_REJECT = 4
    TERMINATE_REQUEST = 5
    TERMINATE_ACK = 6
    CODE_REJECT = 7
    PROTOCOL_REJECT = 8
    ECHO_REQUEST = 9
    ECHO_REPLY = 10
    DISCARD_REQUEST = 11


@dataclass(frozen=True, slots=True)
class Packet:
    """Code, identifier, length of the whole, data; PAP has the same form (RFC 1334 2.2)."""

    WIRE: ClassVar = struct.Struct(">BBH")

    code: int
    identifier: int
    data: bytes = b""

    def encode(self) -> bytes:
        return self.WIRE.pack(self.code, self.identifier, self.WIRE.size + len(self.data)) + self.data

    def cut_to(self, mru: int) -> Self:
        """Return the packet with as much of its data as fits into `mru` bytes."""
        return replace(self, data=self.data[: mru - self.WIRE.size])

    @classmethod
    def decode(cls, payload: bytes) -> Self:
        """Return the packet without the padding after it.  ValueError if its length is impossible."""
        if len(payload) < cls.WIRE.size:
            raise ValueError(f"{len(payload)} bytes, expected at least {cls.WIRE.size}")
        code, identifier, length = cls.WIRE.unpack_from(payload)
        if not cls.WIRE.size <= length <= len(payload):
            raise ValueError(f"length {length}, expected {cls.WIRE.size} to {len(payload)}")
        return cls(code, identifier, payload[cls.WIRE.size : length])


class Option(NamedTuple):
    """A configuration option; on the line its length, which includes the two bytes of the header, is the second."""

    kind: int
    data: bytes = b""


def encode_options(options: Iterable[Option]) -> bytes:
    return b"".join(bytes((option.kind, 2 + len(option.data))) + option.data for option in options)


def decode_options(data: bytes) -> list[Option]:
    """Return the options in their order.  ValueError if a length is below 2 or leads past the end."""
    options, at = [], 0
    while at < len(data):
        length = data[at + 1] if at + 1 < len(data) else 0
        if length < 2 or at + length > len(data):
            raise ValueError(f"option {data[at]} has length {length}, and {len(data) - at} bytes are left")
        options.append(Option(data[at], data[at + 2 : at + length]))
        at += length
    return options
