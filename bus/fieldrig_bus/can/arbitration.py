"""Arbitration: the frame with the lowest arbitration field wins, dominant bits being 0.

Source: ISO 11898-1:2015 (medium access).
"""

from fieldrig_bus.can.frame import CanFrame


def priority(frame: CanFrame) -> int:
    """The arbitration field as a number; the lowest one wins.

    Base identifier 11, then RTR or SRR, IDE, identifier extension 18, RTR.  So a data frame beats a remote frame,
    and 11 bits beat 29 bits with the same base.
    """
    identifier = frame.identifier
    if frame.is_extended:
        return identifier >> 18 << 21 | 0b11 << 19 | (identifier & 0x3FFFF) << 1 | frame.is_remote
    return identifier << 21 | frame.is_remote << 20
