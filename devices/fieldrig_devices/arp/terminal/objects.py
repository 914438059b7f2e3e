"""The objects by which a card and a terminal understand each other (terminal.eds).

The manual says only that the terminal conforms to CANopen; the objects are ours, and docs/arp-terminal.md has their
tables.  Commands are carried out when they are written, and repeat when they are written again.
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
"""1 to 250; the others are in 2101h, for an array has no more than 254."""
_MESSAGES_IN_OBJECT: Final = COUNT // 2

# The first identifiers of the PDOs, to which the terminal's node-ID is added.
KEYS_ID, EDITED_ID = 0x180, 0x280  # from the terminal
LEDS_ID, SCREEN_ID, VALUE_ID, PRINTER_ID = 0x200, 0x300, 0x400, 0x500  # to it


class Act(IntEnum):
    """2010h sub-index 5; manual 5.12, the forms of TERM."""

    NONE = 0
    CLEAR = 1
    ERASE = 2
    SHOW = 3
    SHOW_VALUE = 4
    EDIT = 5
    EDIT_WITH_PASSWORD = 6


class Print(IntEnum):
    """2012h sub-index 3."""

    NONE = 0
    MESSAGE = 1
    """Message 0 is date and time."""
    MESSAGE_WITH_VALUE = 2


@dataclass(frozen=True, slots=True)
class ScreenCommand:
    """RPDO 2."""

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
    """RPDO 3."""

    WIRE: ClassVar = Struct("<BBi")

    line: int
    column: int
    raw: int

    def encode(self) -> bytes:
        return self.WIRE.pack(self.line, self.column, self.raw)


@dataclass(frozen=True, slots=True)
class PrintCommand:
    """RPDO 4."""

    WIRE: ClassVar = Struct("<iHB")

    act: Print
    message: int
    raw: int = 0

    def encode(self) -> bytes:
        return self.WIRE.pack(self.raw, self.message, self.act)


@dataclass(frozen=True, slots=True)
class Edited:
    """TPDO 2; `counter` goes from 1 to 255 and round again, 0 says that there was no edit yet."""

    WIRE: ClassVar = Struct("<BBBi")

    line: int
    column: int
    counter: int
    raw: int

    @classmethod
    def decode(cls, data: bytes) -> "Edited | None":
        """None for what has another length."""
        return cls(*cls.WIRE.unpack(data)) if len(data) == cls.WIRE.size else None


def place_of_message(number: int) -> tuple[int, int]:
    """Index and sub-index."""
    block, offset = divmod(number - 1, _MESSAGES_IN_OBJECT)
    return MESSAGES + block, offset + 1
