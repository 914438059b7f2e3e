"""The stream between a hub and a member in another process, over a Unix socket or TCP.

Records both ways: kind (1 byte), instant (8, ns of the sender's clock), length of the body (4), body; little endian.

    kind       member to hub                     hub to member
    CHALLENGE  -                                 JSON {"nonce"}: the first record, another text at every connection
    HELLO      JSON {"bus", "member", "proof"}   JSON {"now_ns"}: welcome, with the hub's clock
    LISTEN     JSON interest or null             -
    POWER      JSON true or false: of its device     -
    NOTE       `faults.note`: a fault of its device     -
    MESSAGE    asked for at the instant          delivered at the instant
    REFUSED    -                                 JSON {"why"}: and the stream ends

Over TCP, where the rig has a token, the hub lets in only those whose `proof` shows that they know it
(`shared_token.proof`, of nonce, bus and member); others may leave it out.
"""

import struct
from collections.abc import Iterator
from enum import IntEnum
from typing import Any, Final, NamedTuple

from fieldrig.bus import Bus
from fieldrig.outside.untrusted import MalformedError

HEADER: Final = struct.Struct("<BqI")
LONGEST_BODY: Final = 1 << 20
LONGEST_HELLO: Final = 4096
"""Longest body before the member has identified itself."""
LONGEST_NAME: Final = 128
"""Longest name of a member, in characters."""


class Kind(IntEnum):
    HELLO = 0
    LISTEN = 1
    MESSAGE = 2
    REFUSED = 3
    CHALLENGE = 4
    POWER = 5
    NOTE = 6


class Record(NamedTuple):
    kind: int
    instant_ns: int
    body: bytes


def pack(kind: int, instant_ns: int, body: bytes) -> bytes:
    return HEADER.pack(kind, instant_ns, len(body)) + body


class Records:
    """Splits a stream into records.  MalformedError from `feed` for a body longer than `longest`."""

    __slots__ = ("_rest", "longest")

    def __init__(self, longest: int = LONGEST_BODY) -> None:
        self._rest = b""
        self.longest = longest

    def feed(self, data: bytes) -> Iterator[Record]:
        if self._rest:
            data = self._rest + data
        start, size, end = 0, HEADER.size, len(data)
        while end - start >= size:
            kind, instant_ns, length = HEADER.unpack_from(data, start)
            if length > self.longest:
                raise MalformedError(f"a record of {length} bytes, expected at most {self.longest}")
            stop = start + size + length
            if stop > end:
                break
            yield Record(kind, instant_ns, data[start + size : stop])
            start = stop
        self._rest = data[start:]


def socket_name(bus: Bus[Any]) -> str:
    """Return the name of the hub's Unix socket in the run folder."""
    return f"{bus.name}.sock"
