"""The content of communication parameters in words: which object a mapping names, and what a COB-ID says.

Source: CiA 301 version 4.2, 7.5.2.33, 7.5.2.35 and 7.5.2.36.
"""

from typing import Final

from fieldrig_devices.canopen.cob_id import BIT_30, EXTENDED, INVALID

COMMUNICATION: Final = frozenset({*range(0x1400, 0x1600), *range(0x1800, 0x1A00)})
TRANSMITTED: Final = range(0x1800, 0x1A00)
CHANNELS: Final = range(0x1200, 0x1300)
MAPPINGS: Final = (range(0x1600, 0x1800), range(0x1A00, 0x1C00))
NUMBER: Final = 4
"""Bytes of a COB-ID, and of an entry of a mapping."""


def parameter_words(index: int, subindex: int, data: bytes) -> str:
    """Return `6401:01, 16 bits` or `185h, not valid`; empty for any other object."""
    if len(data) != NUMBER or subindex == 0:
        return ""
    number = int.from_bytes(data, "little")
    if any(index in indices for indices in MAPPINGS):
        return f"{number >> 16:04X}:{number >> 8 & 0xFF:02X}, {number & 0xFF} bits"
    is_cob_id = (index in COMMUNICATION and subindex == 1) or (index in CHANNELS and subindex in (1, 2))
    return _cob_id(index, number) if is_cob_id else ""


def _cob_id(index: int, number: int) -> str:
    identifier = number & 0x1FFF_FFFF if number & EXTENDED else number & 0x7FF
    no_remote = ", no remote requests" if index in TRANSMITTED and number & BIT_30 else ""
    return f"{identifier:X}h{no_remote}{', not valid' if number & INVALID else ''}"
