"""The framing of fieldrig's own RS422 protocol; another one replaces `FramedCodec`.

A frame is START, its content with the CRC, and END.  The content is the code of the message and its values.  The CRC is
CRC-16/CCITT-FALSE over the content, high byte first.  A byte of content or CRC that is START, END or ESCAPE is sent as
ESCAPE and the byte with bit 5 inverted.
"""

from binascii import crc_hqx
from collections.abc import Iterator
from enum import IntEnum
from typing import Final, Protocol

from fieldrig_devices.pam.ports.rs422.messages import FIELDS, Message

START: Final = 0x02
END: Final = 0x03
ESCAPE: Final = 0x10
INVERTED: Final = 0x20
LONGEST: Final = 64
"""Bytes between START and END that a receiver takes."""


class LineFault(IntEnum):
    """The causes that 07..E03A names in D1."""

    CRC = 3
    END_CHARACTER = 4
    START_CHARACTER = 5
    BUFFER_FULL = 6


class Codec(Protocol):
    """Turns messages into bytes and back, for one line."""

    def encode(self, message: Message) -> bytes: ...

    def decode(self, data: bytes) -> Iterator[Message | LineFault]:
        """Yield what the next bytes of the line complete."""


class FramedCodec:
    def __init__(self) -> None:
        self._content: bytearray | None = None
        """The present frame; None outside of a frame."""
        self._is_escaped = False
        self._is_noise = False

    def encode(self, message: Message) -> bytes:
        content = bytes((message.code,)) + FIELDS[message.code].pack(*message.values)
        content += crc_hqx(content, 0xFFFF).to_bytes(2, "big")
        frame = bytearray((START,))
        for byte in content:
            frame += bytes((ESCAPE, byte ^ INVERTED)) if byte in (START, END, ESCAPE) else bytes((byte,))
        frame.append(END)
        return bytes(frame)

    def decode(self, data: bytes) -> Iterator[Message | LineFault]:
        for byte in data:
            event = self._take(byte)
            if event is not None:
                yield event

    def _take(self, byte: int) -> Message | LineFault | None:
        content = self._content
        if byte == START:
            self._content, self._is_escaped, self._is_noise = bytearray(), False, False
            return None if content is None else LineFault.END_CHARACTER
        if content is None:
            return self._outside()
        if byte == END:
            self._content = None
            return _message(bytes(content))
        if byte == ESCAPE:
            self._is_escaped = True
            return None
        if len(content) == LONGEST:
            self._content, self._is_noise = None, True
            return LineFault.END_CHARACTER
        content.append(byte ^ INVERTED if self._is_escaped else byte)
        self._is_escaped = False
        return None

    def _outside(self) -> LineFault | None:
        """Report bytes between two frames once."""
        is_known, self._is_noise = self._is_noise, True
        return None if is_known else LineFault.START_CHARACTER


def _message(content: bytes) -> Message | LineFault:
    """Return the message of a frame; one with a wrong length has a code that does not exist."""
    if len(content) < 3 or crc_hqx(content, 0xFFFF) != 0:
        return LineFault.CRC
    code, values = content[0], content[1:-2]
    fields = FIELDS.get(code)
    if fields is None or fields.size != len(values):
        return Message(code if fields is None else 0)
    return Message(code, fields.unpack(values))
