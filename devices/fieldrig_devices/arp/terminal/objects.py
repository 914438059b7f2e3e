"""The objects through which a card and a terminal communicate (terminal.eds).

The manual says only that the terminal conforms to CANopen; the objects are ours, and docs/devices/arp/arp-terminal.md
has their tables.  Commands are executed when they are written, and again when they are written again.
"""

from dataclasses import dataclass
from enum import IntEnum
from struct import Struct
from typing import ClassVar, Final

from fieldrig_devices.arp.terminal.messages import COUNT

KEYS: Final = 0x2000
LEDS: Final = 0x2001
SCREEN: Final = 0x2010
VALUE: Final = 0x2011
PRINTER: Final = 0x2012
EDITED: Final = 0x2020
MESSAGES: Final = 0x2100
"""Index of messages 1 to 250; the others are in 2101h, because an array has at most 254 elements."""
_MESSAGES_IN_OBJECT: Final = COUNT // 2

# First identifiers of the PDOs; the terminal's node-ID is added.
KEYS_ID, EDITED_ID = 0x180, 0x280  # from the terminal
LEDS_ID, SCREEN_ID, VALUE_ID, PRINTER_ID = 0x200, 0x300, 0x400, 0x500  # to it


class Act(IntEnum):
    """Actions of 2010h sub-index 5; manual 5.12, the forms of TERM."""

    NONE = 0
    CLEAR = 1
    ERASE = 2
    SHOW = 3
    SHOW_VALUE = 4
    EDIT = 5
    EDIT_WITH_PASSWORD = 6


class Print(IntEnum):
    """Actions of 2012h sub-index 3."""

    NONE = 0
    MESSAGE = 1
    """Print a message; message 0 is date and time."""
    MESSAGE_WITH_VALUE = 2


@dataclass(frozen=True, slots=True)
class ScreenCommand:
    """Data of RPDO 2, an action on the screen."""

    WIRE: ClassVar = Struct("<BBBHB")

    act: Act
    line: int = 0
    column: int = 0
    height: int = 1
    message: int = 0

    def encode(self) -> bytes:
        return self.WIRE.pack(self.line, self.column, self.height, self.message, self.act)


@dataclass(frozen=True, slots=True)
class ValueAt:
    """Data of RPDO 3, a value for the text at a place."""

    WIRE: ClassVar = Struct("<BBi")

    line: int
    column: int
    raw: int

    def encode(self) -> bytes:
        return self.WIRE.pack(self.line, self.column, self.raw)


@dataclass(frozen=True, slots=True)
class PrintCommand:
    """Data of RPDO 4, an action of the printer."""

    WIRE: ClassVar = Struct("<iHB")

    act: Print
    message: int
    raw: int = 0

    def encode(self) -> bytes:
        return self.WIRE.pack(self.raw, self.message, self.act)


@dataclass(frozen=True, slots=True)
class Edited:
    """Data of TPDO 2, an edit.  `counter` goes from 1 to 255 and wraps to 1; 0 means that there was no edit yet."""

    WIRE: ClassVar = Struct("<BBBi")

    line: int
    column: int
    counter: int
    raw: int

    @classmethod
    def decode(cls, data: bytes) -> "Edited | None":
        """Decode an edit, or return None if the length is wrong."""
        return cls(*cls.WIRE.unpack(data)) if len(data) == cls.WIRE.size else None


def place_of_message(number: int) -> tuple[int, int]:
    """Index and sub-index of the object for a message."""
    block, offset = divmod(number - 1, _MESSAGES_IN_OBJECT)
    return MESSAGES + block, offset + 1
