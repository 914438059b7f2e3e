"""One CAN frame: classical and FD (ISO 11898-1).

Left out on purpose: error and overload frames, which are not messages, the ESI bit of an FD frame (always error
active), and classical DLCs of 9 to 15, which mean 8.
"""

from dataclasses import dataclass
from typing import Any

STANDARD_MASK = 0x7FF
EXTENDED_MASK = 0x1FFF_FFFF
CLASSICAL_LENGTHS = frozenset(range(9))
FD_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)
"""Length of the data in bytes, by DLC."""


@dataclass(frozen=True, slots=True)
class CanFrame:
    """A data or remote frame.

    `identifier` has 11 bits, or 29 with `is_extended`.  `data` has 0 to 8 bytes; with `is_fd` it has a length that
    a DLC can encode (0 to 8, 12, 16, 20, 24, 32, 48, 64).  A remote frame has no data and requests `remote_length`
    bytes.
    """

    identifier: int
    data: bytes = b""
    is_extended: bool = False
    is_remote: bool = False
    remote_length: int = 0
    is_fd: bool = False
    is_bit_rate_switched: bool = False


def check_frame(frame: CanFrame) -> None:
    """Raise TypeError or ValueError for a frame that no bus can carry.  Called with every frame that a member sends."""
    identifier, data = frame.identifier, frame.data
    if type(data) is bytes and type(identifier) is int and len(data) <= 8:
        flags = (frame.is_extended, frame.is_remote, frame.is_fd, frame.is_bit_rate_switched)
        if flags == _PLAIN and 0 <= identifier <= STANDARD_MASK and frame.remote_length == 0:
            return  # as most frames are
    _check_type("identifier", identifier, int)
    _check_type("data", data, bytes)
    _check_type("remote_length", frame.remote_length, int)
    for name in ("is_extended", "is_remote", "is_fd", "is_bit_rate_switched"):
        _check_type(name, getattr(frame, name), bool)
    check(frame)


_PLAIN = (False, False, False, False)


def _check_type(name: str, value: Any, kind: type) -> None:
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise TypeError(f"{name}: expected {kind.__name__}, found {type(value).__name__}")


def check(frame: CanFrame) -> CanFrame:
    """Return the frame if a bus can carry it.  ValueError, with what was expected, if not.

    The fields must have their types, as they do when they were read from bytes; `check_frame` checks both.
    """
    widest = EXTENDED_MASK if frame.is_extended else STANDARD_MASK
    if not 0 <= frame.identifier <= widest:
        raise ValueError(f"identifier {frame.identifier:#x}: expected at most {widest:#x}")
    if frame.is_fd and frame.is_remote:
        raise ValueError("CAN FD has no remote frames")
    if frame.is_bit_rate_switched and not frame.is_fd:
        raise ValueError("only an FD frame can switch its bit rate")
    if frame.is_remote and frame.data:
        raise ValueError("a remote frame has no data: it requests remote_length bytes")
    if not 0 <= frame.remote_length <= (8 if frame.is_remote else 0):
        raise ValueError(f"remote_length {frame.remote_length}: expected 0 to 8 in a remote frame, and 0 in any other")
    if len(frame.data) not in (FD_LENGTHS if frame.is_fd else CLASSICAL_LENGTHS):
        raise ValueError(f"{len(frame.data)} bytes of data: expected a length that a DLC can encode")
    return frame
