"""Frames of the Linux kernel's CAN: struct can_frame and canfd_frame, filters, and error frames as notices.

Source: Linux, Documentation/networking/can.rst, 4.1 (raw sockets), and include/uapi/linux/can.h.
"""

import struct
from typing import Final

from fieldrig_bus.can import socketcan_errors
from fieldrig_bus.can.acceptance import ERRORS, EXTENDED, REMOTE, STATE, Filters
from fieldrig_bus.can.frame import EXTENDED_MASK, FD_LENGTHS, STANDARD_MASK, CanFrame
from fieldrig_bus.can.linux_flags import BIT_RATE_SWITCH, ERROR
from fieldrig_bus.can.notices import BusState, CanError

CLASSICAL: Final = struct.Struct("=IB3x8s")  # struct can_frame
FD: Final = struct.Struct("=IBB2x64s")  # struct canfd_frame
HEAD: Final = struct.Struct("=IBB2x")
FILTER: Final = struct.Struct("=II")  # struct can_filter

NO_SOCKETCAN: Final = "this system has no SocketCAN"
NO_CAN: Final = "on Linux load it with `sudo modprobe can-raw vcan`; kind: can.hub needs no kernel support"


def to_wire(frame: CanFrame) -> bytes:
    """A frame as struct can_frame, or canfd_frame."""
    word, data = frame.identifier, frame.data
    if frame.is_extended:
        word |= EXTENDED
    if frame.is_fd:
        return FD.pack(word, len(data), BIT_RATE_SWITCH * frame.is_bit_rate_switched, data)
    if frame.is_remote:
        return CLASSICAL.pack(word | REMOTE, frame.remote_length, b"")
    return CLASSICAL.pack(word, len(data), data)


def from_wire(data: bytes) -> CanFrame | None:
    """The inverse of `encode`; None for an error frame.

    The kernel hands over unchanged what a program sent to a vcan.  A controller would send something that a bus can
    carry, and so it is decoded: an identifier of 11 or 29 bits, an FD frame padded with zeros to the next length that
    a DLC can encode (as drivers do by `can_fd_len2dlc`), and at most 8 bytes requested.
    """
    word, length, flags = HEAD.unpack_from(data)
    payload = data[HEAD.size : HEAD.size + length]
    is_fd = len(data) == FD.size
    if word <= STANDARD_MASK and not is_fd:  # as most frames are
        return CanFrame(word, payload)
    if word & ERROR:
        return None
    is_extended = bool(word & EXTENDED)
    identifier = word & (EXTENDED_MASK if is_extended else STANDARD_MASK)
    if is_fd:
        full = next(length for length in FD_LENGTHS if length >= len(payload))
        is_switched = bool(flags & BIT_RATE_SWITCH)
        return CanFrame(identifier, payload.ljust(full, b"\0"), is_extended, False, 0, True, is_switched)
    if word & REMOTE:
        return CanFrame(identifier, b"", is_extended, True, min(length, CLASSICAL.size - HEAD.size))
    return CanFrame(identifier, payload, is_extended)


def kernel_filters(filters: Filters | None) -> bytes:
    """Filters as an array of struct can_filter.  Bit 29 means something else there; no identifier here contains it."""
    if filters is None:
        return FILTER.pack(0, 0)
    return b"".join(FILTER.pack(wanted, mask & ~ERROR) for wanted, mask in filters if not wanted & ERROR)


def error_mask(notices: frozenset[str]) -> int:
    """Classes of error frames that the kernel passes."""
    mask = (socketcan_errors.ERRORS if ERRORS in notices else 0) | (socketcan_errors.STATES if STATE in notices else 0)
    return int(mask)


def notice_from_wire(data: bytes) -> CanError | BusState | None:
    """The notice that corresponds to an error frame; None if there is none."""
    word, _, _ = HEAD.unpack_from(data)
    return socketcan_errors.notice_of(word & EXTENDED_MASK, data[HEAD.size :])
