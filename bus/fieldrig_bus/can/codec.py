"""A CAN frame or notice as bytes, for other processes and traces, and as a line of text.

Bytes, little endian: the identifier with its flags (4), the length (1), the data.  The length is that of the data, or
the number of bytes that a remote frame requests; its top bit says that an FD frame switches its bit rate.
A notice begins with flags that no frame has (see `notices`).
"""

import struct
from typing import Any, Final

from fieldrig_bus.can import notices
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.frame import EXTENDED_MASK, STANDARD_MASK, CanFrame
from fieldrig_bus.can.notices import NOTICE, Notice

CanMessage = CanFrame | Notice
"""Every message that a CAN bus carries."""

_HEAD: Final = struct.Struct("<IB")
_FD: Final = 0x2000_0000
_SWITCHED: Final = 0x80
_PLAIN_EXTENDED: Final = EXTENDED >> 29

_pack, _unpack, _HEAD_SIZE = _HEAD.pack, _HEAD.unpack_from, _HEAD.size


def encode(message: CanMessage) -> bytes:
    if not isinstance(message, CanFrame):
        return notices.encode(message)
    word, data = message.identifier, message.data
    length = len(data)
    if message.is_extended:
        word |= EXTENDED
    if message.is_fd:
        word |= _FD
        if message.is_bit_rate_switched:
            length |= _SWITCHED
    elif message.is_remote:
        word |= REMOTE
        length = message.remote_length
    return _pack(word, length) + data


def decode(data: bytes) -> CanMessage:
    """The inverse of `encode`.  ValueError for anything else."""
    try:
        word, length = _unpack(data)
    except struct.error as cause:
        raise ValueError(f"not a CAN frame: {data.hex(' ')}") from cause
    payload = data[_HEAD_SIZE:]
    if length == len(payload) <= 8:  # most frames are classical data frames
        if word <= STANDARD_MASK:
            return CanFrame(word, payload)
        if word >> 29 == _PLAIN_EXTENDED:
            return CanFrame(word & EXTENDED_MASK, payload, True)
    if word & ~EXTENDED_MASK == NOTICE:
        return notices.decode(data)
    is_remote = bool(word & REMOTE)
    if not is_remote and length & ~_SWITCHED != len(payload):
        raise ValueError(f"not a CAN frame, because its length is wrong: {data.hex(' ')}")
    return CanFrame(
        word & EXTENDED_MASK,
        payload,
        is_extended=bool(word & EXTENDED),
        is_remote=is_remote,
        remote_length=length if is_remote else 0,
        is_fd=bool(word & _FD),
        is_bit_rate_switched=length >= _SWITCHED,
    )


def check_sent(message: Any) -> None:
    """Raise TypeError or ValueError for what a member cannot send, such as a notice that only its controller sends."""
    if type(message) is not CanFrame:  # a frame is right since it was made
        notices.check_sent(message)


def show(message: CanMessage) -> str:
    """A message as candump shows it, `123 [3] 01 02 03`: an identifier of 3 digits has 11 bits, of 8 digits 29."""
    if not isinstance(message, CanFrame):
        return notices.show(message)
    identifier = f"{message.identifier:08X}" if message.is_extended else f"{message.identifier:03X}"
    if message.is_remote:
        return f"{identifier} [{message.remote_length}] remote request"
    length = f"{len(message.data):02}" if message.is_fd else str(len(message.data))
    return f"{identifier} [{length}] {message.data.hex(' ').upper()}".rstrip()
