"""The acceptance filter of the SJA1000, as adapters with this controller offer it to their users.

Source: Philips SJA1000 data sheet (2000 Jan 04), 6.4.15, PeliCAN mode.  The registers ACR0 to ACR3 form one number
here, with ACR0 highest; so do AMR0 to AMR3, where a bit of 1 means "don't care".
"""

from dataclasses import dataclass
from typing import Final

from fieldrig_bus.can.frame import CanFrame

EVERYTHING: Final = 0xFFFF_FFFF

Image = tuple[int, int]
"""A frame as the registers see it, and the bits of it that are compared."""


@dataclass(slots=True)
class AcceptanceFilter:
    is_single: bool = False
    """True if a frame passes: one filter of four bytes, or otherwise either of two filters of two bytes."""
    code: int = 0
    mask: int = EVERYTHING

    def passes(self, frame: CanFrame) -> bool:
        if self.mask == EVERYTHING:
            return True
        images = single_image(frame) if self.is_single else dual_images(frame)
        return any((image ^ self.code) & ~self.mask & there == 0 for image, there in images)


def single_image(frame: CanFrame) -> tuple[Image]:
    """Bits for a single filter (figures 9, 10).

    Standard: ID.28-18, RTR, 4 unused, data bytes 1 and 2.  Extended: ID.28-0, RTR, 2 unused.
    """
    remote, data = int(frame.is_remote), frame.data[:2]
    if frame.is_extended:
        return ((frame.identifier << 3 | remote << 2, 0xFFFF_FFFC),)
    there = 0xFFF0_0000 | (0, 0xFF00, 0xFFFF)[len(data)]
    return ((frame.identifier << 21 | remote << 20 | int.from_bytes(data.ljust(2, b"\0"), "big"), there),)


def dual_images(frame: CanFrame) -> tuple[Image, Image]:
    """Bits for two filters (figures 11, 12).

    Standard: ID.28-18 and RTR for each, data byte 1 for the first one.  Extended: ID.28-13 for each.
    """
    if frame.is_extended:
        high = frame.identifier >> 13
        return (high << 16, 0xFFFF_0000), (high, 0x0000_FFFF)
    head, data = frame.identifier << 5 | int(frame.is_remote) << 4, frame.data[:1]
    high_nibble, low_nibble = divmod(data[0], 16) if data else (0, 0)
    there = 0xFFF0_0000 | (0x000F_000F if data else 0)
    return (head << 16 | high_nibble << 16 | low_nibble, there), (head, 0x0000_FFF0)
