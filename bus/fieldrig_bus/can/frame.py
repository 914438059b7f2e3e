"""One CAN frame: classical and FD (ISO 11898-1)."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CanFrame:
    """A data or remote frame.

    `identifier` has 11 bits, or 29 with `is_extended`; `data` 0 to 8 bytes, with `is_fd` a length that a DLC
    can say (0 to 8, 12, 16, 20, 24, 32, 48, 64).  A remote frame has no data but asks for `remote_length` bytes.
    """

    identifier: int
    data: bytes = b""
    is_extended: bool = False
    is_remote: bool = False
    remote_length: int = 0
    is_fd: bool = False
    is_bit_rate_switched: bool = False
