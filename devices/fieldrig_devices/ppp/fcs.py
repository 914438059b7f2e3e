"""FCS-16, the check sequence of a frame (RFC 1662 C.1 and C.2).

The RFC computes it with the least significant bit first.  `binascii.crc_hqx` has the same polynomial with the most
significant bit first, so here every byte and the result are reversed, which is much faster than a loop over the bytes.
"""

from binascii import crc_hqx
from typing import Final

_REVERSED: Final = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))
_INITIAL: Final = 0xFFFF
LENGTH: Final = 2


def fcs16(data: bytes) -> bytes:
    """Return the two bytes that follow `data` on the line, least significant byte first."""
    register = crc_hqx(data.translate(_REVERSED), _INITIAL) ^ 0xFFFF
    return bytes((_REVERSED[register >> 8], _REVERSED[register & 0xFF]))
