"""The words of the socketcand protocol as values, and frames as its text.  `socketcand` names the source.

Every function that takes words raises ValueError for invalid ones.  An identifier of eight digits has 29 bits, any
other has 11.
"""

from collections.abc import Sequence
from typing import Final

from fieldrig.clock import US, S
from fieldrig_bus.can.acceptance import received
from fieldrig_bus.can.frame import FD_LENGTHS, CanFrame
from fieldrig_bus.can.linux_flags import BIT_RATE_SWITCH

LONGEST_INTERVAL_NS: Final = 1_000_000_000 * S  # fits every timer
MOST_MASKS: Final = 257


def number(word: bytes, base: int = 10) -> int:
    if not word.isalnum():  # int() would accept signs and underscores
        raise ValueError(f"{word!r} is not a number")
    return int(word, base)


def bytes_of(words: Sequence[bytes]) -> bytes:
    """Bytes from words of one or two hexadecimal digits each."""
    if words and not b"".join(words).isalnum():
        raise ValueError(f"{words!r} are not bytes")
    return bytes([int(word, 16) for word in words])


def interval_ns(seconds: bytes, microseconds: bytes) -> int:
    return min(number(seconds) * S + number(microseconds) * US, LONGEST_INTERVAL_NS)


def key(identifier: bytes) -> int:
    """The identifier as `received` gives it for a data frame."""
    return received(CanFrame(number(identifier, 16), is_extended=len(identifier) == 8))


def data_frame(words: Sequence[bytes]) -> CanFrame:
    """The frame of the words `can_id can_dlc [data]*`."""
    identifier, length, *data = words
    if len(data) != number(length):
        raise ValueError("the length is not the length of the data")
    return CanFrame(number(identifier, 16), bytes_of(data), len(identifier) == 8)


def remote_frame(words: Sequence[bytes]) -> CanFrame:
    """The remote frame of the words `can_id can_dlc`."""
    identifier, length = words
    return CanFrame(number(identifier, 16), b"", len(identifier) == 8, True, number(length))


def fd_frame(words: Sequence[bytes]) -> CanFrame:
    """The FD frame of the words `can_id flags length [data]*`, padded with zeros to a length that a DLC can encode."""
    identifier, flags, length, *data = words
    if len(data) != number(length) or len(data) > FD_LENGTHS[-1]:
        raise ValueError("the length is not the length of the data")
    size = next(each for each in FD_LENGTHS if each >= len(data))
    return CanFrame(
        number(identifier, 16),
        bytes_of(data).ljust(size, b"\0"),
        is_extended=len(identifier) == 8,
        is_fd=True,
        is_bit_rate_switched=bool(number(flags, 16) & BIT_RATE_SWITCH),
    )


def masks(words: Sequence[bytes]) -> list[bytes]:
    """The masks of the words `nframes [data]+`, eight bytes each."""
    count, *data = words
    if not 2 <= number(count) <= MOST_MASKS or len(data) != 8 * number(count):
        raise ValueError(f"expected 2 to {MOST_MASKS} tuples of 8 bytes")
    return [bytes_of(data[start : start + 8]) for start in range(0, len(data), 8)]


def frame_text(frame: CanFrame, time_ns: int, between: str = "") -> bytes:
    """A received frame, with `between` between its data bytes: nothing in raw mode, a space in BCM mode."""
    seconds, microseconds = divmod(time_ns // US, 1_000_000)
    identifier = f"{frame.identifier:08X}" if frame.is_extended else f"{frame.identifier:03X}"
    when = f"{seconds}.{microseconds:06}"
    if frame.is_remote:
        return f"< rtr {identifier} {when} {frame.remote_length} >".encode()
    data = (frame.data.hex(between) if between else frame.data.hex()).upper()
    if frame.is_fd:
        flags = BIT_RATE_SWITCH if frame.is_bit_rate_switched else 0
        return f"< fdframe {identifier} {flags:02X} {when} {data} >".encode()
    return f"< frame {identifier} {when} {data} >".encode()


def error_text(error_class: int, time_ns: int) -> bytes:
    """An error frame with its class; the daemon does not send its data."""
    seconds, microseconds = divmod(time_ns // US, 1_000_000)
    return f"< error {error_class:03X} {seconds}.{microseconds:06} >".encode()
