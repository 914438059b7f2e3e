"""Frames on a serial line: HDLC-like framing as in PPP, with its FCS-16.

Source: RFC 1662, 3.1, 4 and appendix C.  A frame is a body, its FCS (least significant octet first), and a flag at each
end; two frames may share the flag between them.  Flag and escape within a frame are escaped, and so may be any other
octet.  Left out: address and control fields of RFC 1662 (the body has its own, see `messages`), and the map of control
characters, since these lines carry every octet unchanged.
"""

from collections.abc import Iterator
from typing import Final

FLAG: Final = 0x7E
ESCAPE: Final = 0x7D
FLIP: Final = 0x20
GOOD_FCS: Final = 0xF0B8  # RFC 1662, C.2: checksum over a body and its FCS
SHORTEST_BODY: Final = 4
LONGEST_BODY: Final = 260

_FLAG, _ESCAPE = bytes((FLAG,)), bytes((ESCAPE,))
_ESCAPED_FLAG, _ESCAPED_ESCAPE = bytes((ESCAPE, FLAG ^ FLIP)), bytes((ESCAPE, ESCAPE ^ FLIP))
_LONGEST_WIRE: Final = 2 * (LONGEST_BODY + 2)  # every octet escaped


def _table() -> Iterator[int]:
    """RFC 1662, C.2: x**0 + x**5 + x**12 + x**16, least significant bit first."""
    for octet in range(256):
        value = octet
        for _ in range(8):
            value = value >> 1 ^ 0x8408 if value & 1 else value >> 1
        yield value


_TABLE: Final = tuple(_table())


def fcs16(data: bytes) -> int:
    """Checksum of the data, before the complement that makes it the FCS."""
    value = 0xFFFF
    for octet in data:
        value = value >> 8 ^ _TABLE[(value ^ octet) & 0xFF]
    return value


def encode(body: bytes) -> bytes:
    """Encode a body as a frame for the line."""
    checked = body + (fcs16(body) ^ 0xFFFF).to_bytes(2, "little")
    return _FLAG + checked.replace(_ESCAPE, _ESCAPED_ESCAPE).replace(_FLAG, _ESCAPED_FLAG) + _FLAG


class Deframer:
    """Accepts data in pieces of any size and returns the bodies of valid frames; everything else is dropped."""

    def __init__(self) -> None:
        self._held = b""  # since the last flag
        self._is_skipping = True  # until the next flag: line noise, or a frame that is too long

    def feed(self, data: bytes) -> list[bytes]:
        *frames, rest = (self._held + data).split(_FLAG)
        if frames and self._is_skipping:
            del frames[0]
            self._is_skipping = False
        self._is_skipping |= len(rest) > _LONGEST_WIRE
        self._held = b"" if self._is_skipping else rest
        return [body for wire in frames if (body := _body(wire)) is not None]


def _body(wire: bytes) -> bytes | None:
    """Body of a frame, or None if it is damaged or not a frame, or ends in an escape (RFC 1662, 4.3: aborted)."""
    if ESCAPE in wire:
        first, *parts = wire.split(_ESCAPE)
        if not all(parts):
            return None
        wire = first + b"".join(bytes((part[0] ^ FLIP,)) + part[1:] for part in parts)
    if not SHORTEST_BODY <= len(wire) - 2 <= LONGEST_BODY or fcs16(wire) != GOOD_FCS:
        return None
    return wire[:-2]
