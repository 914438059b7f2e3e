"""A CAN message of a trace as SocketCAN has it: the identifier with its flags, and the data.

All formats of CAN logs are written from this and read into it.  A plain data frame goes from bytes to bytes without a
`CanFrame` in between, which takes a third of the time; everything else goes through the codec of the bus.
"""

import struct
from typing import Final, NamedTuple

from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.codec import decode, encode
from fieldrig_bus.can.frame import EXTENDED_MASK, STANDARD_MASK, CanFrame
from fieldrig_bus.can.linux_flags import ERROR
from fieldrig_bus.can.notices import BusState, CanError
from fieldrig_bus.can.socketcan_errors import error_frame, notice_of

_HEAD: Final = struct.Struct("<IB")  # as in can/codec.py
_HEAD_SIZE: Final = _HEAD.size
_LARGEST: Final = 0xFFFF_FFFF
_PLAIN_EXTENDED: Final = EXTENDED >> 29
_pack, _unpack = _HEAD.pack, _HEAD.unpack_from
_new = tuple.__new__  # takes a third of the time of calling a named tuple


class Fields(NamedTuple):
    word: int
    """The identifier, with the flags CAN_EFF_FLAG, CAN_RTR_FLAG and CAN_ERR_FLAG of linux/can.h."""
    data: bytes
    length: int
    """Number of bytes of the data, or that a remote frame requests."""
    is_fd: bool = False
    is_switched: bool = False
    """True for an FD frame that switches its bit rate."""


def fields_of(message: bytes) -> Fields | None:
    """Return the fields of an encoded message; None for a notice that SocketCAN does not have.

    None also for bytes of a file that are no message.
    """
    if len(message) >= _HEAD_SIZE:
        word, length = _unpack(message)
        if length == len(message) - _HEAD_SIZE <= 8 and (word <= STANDARD_MASK or word >> 29 == _PLAIN_EXTENDED):
            return _new(Fields, (word, message[_HEAD_SIZE:], length, False, False))
    try:
        decoded = decode(message)
    except ValueError:
        return None
    if isinstance(decoded, CanError | BusState):
        error_class, data = error_frame(decoded)
        return Fields(error_class | ERROR, data, len(data))
    if not isinstance(decoded, CanFrame):
        return None
    word = decoded.identifier | decoded.is_extended * EXTENDED | decoded.is_remote * REMOTE
    length = decoded.remote_length if decoded.is_remote else len(decoded.data)
    return Fields(word, decoded.data, length, decoded.is_fd, decoded.is_bit_rate_switched)


def plain_message(word: int, data: bytes) -> bytes:
    """Return the encoded message of a classical data frame, whose fields the caller has checked."""
    return _pack(word, len(data)) + data


def message_of(
    word: int, data: bytes, length: int | None = None, is_fd: bool = False, is_switched: bool = False
) -> bytes | None:
    """Return the encoded message of these fields; None for an error frame that no notice stands for.

    `length` is that of a remote frame; any other has that of its data.  ValueError for a frame that no bus can carry.
    """
    size = len(data)
    if size <= 8 and not is_fd and (0 <= word <= STANDARD_MASK or word >> 29 == _PLAIN_EXTENDED):
        return _pack(word, size) + data
    if not 0 <= word <= _LARGEST:
        raise ValueError(f"identifier {word:#x}: expected at most {EXTENDED_MASK:#x}")
    if word & ERROR:
        notice = notice_of(word & EXTENDED_MASK, data)
        return None if notice is None else encode(notice)
    is_remote = bool(word & REMOTE)
    return encode(
        CanFrame(
            word & EXTENDED_MASK,
            b"" if is_remote else data,
            is_extended=bool(word & EXTENDED),
            is_remote=is_remote,
            remote_length=min(length or 0, 8) if is_remote else 0,
            is_fd=is_fd,
            is_bit_rate_switched=is_switched,
        )
    )
