"""The PPP frames in the traced bytes of a serial line (RFC 1662), for Wireshark.

The line counts as one of PPP from its first LCP frame on.  Before that, and between frames, other bytes are skipped,
such as the conversation with a modem.  Frames with a wrong check sequence are skipped as well.
"""

import re
from binascii import crc_hqx
from collections import defaultdict
from typing import Final

LONGEST: Final = 4096
"""Bytes without a flag that are kept."""
_SHORTEST: Final = 4
_FLAG: Final = b"\x7e"
_ESCAPED: Final = re.compile(rb"\x7d(.)", re.DOTALL)
_LCP: Final = bytes.fromhex("ff03c021")
BITS_REVERSED: Final = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))
_GOOD: Final = 0x1D0F
"""The remainder of a frame with its check sequence: 0xF0B8 of RFC 1662, C.1 with its bits reversed."""


class PppFinder:
    """The frames of one line, separately for each end."""

    def __init__(self) -> None:
        self._open: defaultdict[str, bytearray] = defaultdict(bytearray)
        self._is_ppp = False

    def feed(self, sender: str, data: bytes) -> list[bytes]:
        """Take the next bytes of an end, and return the frames that are complete with them.

        A frame begins with its address field, unless the ends have agreed to leave it out, and has no check sequence.
        """
        *complete, rest = (bytes(self._open[sender]) + data).split(_FLAG)
        self._open[sender] = bytearray(rest[-LONGEST:])
        return [frame for piece in complete if (frame := self._frame(piece)) is not None]

    def _frame(self, piece: bytes) -> bytes | None:
        if piece.endswith(b"\x7d"):  # an abort (RFC 1662, 4.3)
            return None
        frame = _ESCAPED.sub(lambda match: bytes((match[1][0] ^ 0x20,)), piece)
        if len(frame) < _SHORTEST or crc_hqx(frame.translate(BITS_REVERSED), 0xFFFF) != _GOOD:
            return None
        self._is_ppp |= frame.startswith(_LCP)
        return frame[:-2] if self._is_ppp else None
