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
    bytes.  TypeError or ValueError, saying what was expected, for a frame that no bus can carry.
    """

    identifier: int
    data: bytes = b""
    is_extended: bool = False
    is_remote: bool = False
    remote_length: int = 0
    is_fd: bool = False
    is_bit_rate_switched: bool = False

    def __post_init__(self) -> None:
        identifier, data = self.identifier, self.data
        if type(data) is bytes and type(identifier) is int and len(data) <= 8:
            flags = (self.is_extended, self.is_remote, self.is_fd, self.is_bit_rate_switched)
            if flags == _PLAIN and 0 <= identifier <= STANDARD_MASK and self.remote_length == 0:
                return  # as most frames are; it costs a fifth of making the frame, which sending it saves
        _check_types(self)
        _check_values(self)


_PLAIN = (False, False, False, False)


def _check_types(frame: CanFrame) -> None:
    _check_type("identifier", frame.identifier, int)
    _check_type("data", frame.data, bytes)
    _check_type("remote_length", frame.remote_length, int)
    for name in ("is_extended", "is_remote", "is_fd", "is_bit_rate_switched"):
        _check_type(name, getattr(frame, name), bool)


def _check_type(name: str, value: Any, expected: type) -> None:
    if not isinstance(value, expected) or (expected is int and isinstance(value, bool)):
        raise TypeError(f"{name}: expected {expected.__name__}, found {type(value).__name__}")


def _check_values(frame: CanFrame) -> None:
    widest = EXTENDED_MASK if frame.is_extended else STANDARD_MASK
    if not 0 <= frame.identifier <= widest:
        hint = "" if frame.is_extended or not 0 <= frame.identifier <= EXTENDED_MASK else ", or is_extended=True"
        raise ValueError(f"identifier {frame.identifier:#x}: expected at most {widest:#x}{hint}")
    if frame.is_fd and frame.is_remote:
        raise ValueError("CAN FD has no remote frames")
    if frame.is_bit_rate_switched and not frame.is_fd:
        raise ValueError("only an FD frame can switch its bit rate")
    if frame.is_remote and frame.data:
        raise ValueError("a remote frame has no data: it requests remote_length bytes")
    if not 0 <= frame.remote_length <= (8 if frame.is_remote else 0):
        raise ValueError(f"remote_length {frame.remote_length}: expected 0 to 8 in a remote frame, and 0 in any other")
    if len(frame.data) not in (FD_LENGTHS if frame.is_fd else CLASSICAL_LENGTHS):
        fd = "" if frame.is_fd or len(frame.data) not in FD_LENGTHS else ", or is_fd=True"
        raise ValueError(f"{len(frame.data)} bytes of data: expected a length that a DLC can encode{fd}")
