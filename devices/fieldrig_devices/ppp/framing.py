"""HDLC-like framing on an asynchronous line (RFC 1662): flags, escapes, control character map, check sequence.

A frame that is too short, too long, aborted or has a wrong check sequence is dropped and counted (4.3).  A receiver
takes frames with and without Address and Control field, whatever was negotiated; LCP packets are sent with all fields
and all control characters escaped (RFC 1662 chapter 7, RFC 1661 6.5 and 6.6).
"""

import re
from binascii import crc_hqx
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from fieldrig_devices.ppp.protocols import ProtocolNumber
from fieldrig_devices.ppp.settings import DEFAULT_MRU

_REVERSED: Final = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))
_INITIAL: Final = 0xFFFF
FCS_LENGTH: Final = 2


def fcs16(data: bytes) -> bytes:
    """Return the two bytes of FCS-16 that follow `data` on the line, least significant byte first (RFC 1662 C.1, C.2).

    The RFC computes it with the least significant bit first.  `crc_hqx` has the same polynomial with the most
    significant bit first, so here every byte and the result are reversed, which is much faster than a loop over bytes.
    """
    register = crc_hqx(data.translate(_REVERSED), _INITIAL) ^ 0xFFFF
    return bytes((_REVERSED[register >> 8], _REVERSED[register & 0xFF]))


FLAG: Final = b"\x7e"
ESCAPE: Final = b"\x7d"
FLIPPED: Final = 0x20
ADDRESS_AND_CONTROL: Final = b"\xff\x03"
ALL_CONTROLS: Final = 0xFFFFFFFF
"""The control character map before an agreement: bit n is the character n, 0 to 31 (RFC 1662 7.1)."""
SHORTEST: Final = 4
LONGEST: Final = len(ADDRESS_AND_CONTROL) + 2 + DEFAULT_MRU + FCS_LENGTH

_ESCAPED: Final = {bytes((byte,)): bytes((ESCAPE[0], byte ^ FLIPPED)) for byte in range(256)}
_PLAIN: Final = {escaped: plain for plain, escaped in _ESCAPED.items()}
_ESCAPE_PAIR: Final = re.compile(re.escape(ESCAPE) + b".", re.DOTALL)


@dataclass(slots=True)
class FrameFormat:
    """How this end sends, as the peer has asked for it."""

    accm: int = ALL_CONTROLS
    """The control characters to escape."""
    has_short_header: bool = False
    """True to leave out the Address and Control fields."""
    has_short_protocol: bool = False
    """True to send protocols below 100h in one byte."""


@lru_cache(maxsize=16)
def _to_escape(accm: int) -> re.Pattern[bytes]:
    special = _controls(accm) + ESCAPE + FLAG
    return re.compile(b"[" + re.escape(special) + b"]")


@lru_cache(maxsize=16)
def _controls(accm: int) -> bytes:
    return bytes(character for character in range(32) if accm >> character & 1)


def framed(protocol: int, payload: bytes, form: FrameFormat) -> bytes:
    """Return one frame with a flag at each end."""
    if protocol == ProtocolNumber.LCP:
        form = FrameFormat()
    header = b"" if form.has_short_header else ADDRESS_AND_CONTROL
    is_short = form.has_short_protocol and protocol < 0x100
    content = header + protocol.to_bytes(1 if is_short else 2, "big") + payload
    content += fcs16(content)
    return FLAG + _to_escape(form.accm).sub(lambda match: _ESCAPED[match[0]], content) + FLAG


def unpacked(content: bytes) -> tuple[int, bytes]:
    """Return protocol and payload of a frame's content.  ValueError for another address or without a protocol."""
    if content.startswith(ADDRESS_AND_CONTROL):
        content = content[len(ADDRESS_AND_CONTROL) :]
    elif content.startswith(ADDRESS_AND_CONTROL[:1]):
        raise ValueError("another control field than 03h")
    length = 1 if content and content[0] & 1 else 2  # the last byte of a protocol is odd, the others are even
    if len(content) < length:
        raise ValueError("no protocol field")
    return int.from_bytes(content[:length], "big"), content[length:]


@dataclass(slots=True)
class FrameCounts:
    """The frames that a receiver has found on the line, by their fate."""

    good: int = 0
    too_short: int = 0
    too_long: int = 0
    aborted: int = 0
    wrong_check: int = 0

    @property
    def lost(self) -> int:
        """The frames that did not arrive whole."""
        return self.too_short + self.too_long + self.aborted + self.wrong_check


class Deframer:
    """Finds the frames in received bytes."""

    def __init__(self) -> None:
        self.accm = ALL_CONTROLS
        """Control characters that the peer escapes; where they are plain, a modem has inserted them (RFC 1662 7.1)."""
        self.counts = FrameCounts()
        self._begun = bytearray()
        self._is_skipping = False

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Yield the contents of the frames that are complete, from the Address field to the last byte before the FCS.

        Change `accm` between two frames if a frame says so; the next one is read with the new value.
        """
        *ends, rest = data.split(FLAG)
        for part in ends:
            self._append(part)
            raw, is_whole = bytes(self._begun), not self._is_skipping
            self._begun.clear()
            self._is_skipping = False
            content = self._content(raw) if raw and is_whole else None
            if content is not None:
                yield content
        self._append(rest)

    def _append(self, part: bytes) -> None:
        if self._is_skipping:
            return
        self._begun += part
        if len(self._begun) > 2 * LONGEST + len(_controls(self.accm)):
            self._is_skipping = True
            self._begun.clear()
            self.counts.too_long += 1

    def _content(self, raw: bytes) -> bytes | None:
        counts = self.counts
        if raw.endswith(ESCAPE):
            counts.aborted += 1
            return None
        plain = raw.translate(None, _controls(self.accm))
        if ESCAPE in plain:
            plain = _ESCAPE_PAIR.sub(lambda match: _PLAIN[match[0]], plain)
        if len(plain) < SHORTEST:
            counts.too_short += 1
        elif len(plain) > LONGEST:
            counts.too_long += 1
        elif fcs16(plain[:-FCS_LENGTH]) != plain[-FCS_LENGTH:]:
            counts.wrong_check += 1
        else:
            counts.good += 1
            return plain[:-FCS_LENGTH]
        return None
