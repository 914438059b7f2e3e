"""Conversion of 32 bits to one number; the first is bit 0 (digest chapter 7)."""

from collections.abc import Sequence

from fieldrig_devices.arp.fixed import signed

_TO_ASCII = bytes.maketrans(b"\x00\x01", b"01")


def packed(bits: Sequence[int]) -> int:
    """Pack 32 bits into a raw number."""
    return signed(int(bytes(bits[::-1]).translate(_TO_ASCII), 2))


def unpacked(raw: int) -> list[int]:
    return [raw >> bit & 1 for bit in range(32)]
