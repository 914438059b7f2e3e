"""Identification numbers (IDNs), and the elements and attributes of operation data.

Source: IEC 61491 by its public facts (structure of IDNs, attribute, service channel error messages).  Bit 15 marks
a manufacturer's IDN (P), bits 12 to 14 are the parameter set.
"""

import re
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

MANUFACTURER: Final = 0x8000
ALL_PHASES: Final = (2, 3, 4)


def s(number: int) -> int:
    """Return the standard IDN S-0-`number`."""
    return number


def p(number: int) -> int:
    """Return the manufacturer's IDN P-0-`number`."""
    return MANUFACTURER | number


def idn_text(idn: int) -> str:
    return f"{'P' if idn & MANUFACTURER else 'S'}-{idn >> 12 & 7}-{idn & 0xFFF:04}"


def idn_of(text: str) -> int:
    """Return the IDN of a text such as S-0-0047, the inverse of `idn_text`.  Raises ValueError for other texts."""
    match = re.fullmatch(r"([SP])-([0-7])-(\d{1,4})", text.upper(), re.ASCII)
    if match is None or int(match[3]) > 0xFFF:
        raise ValueError(f"{text!r} is not an IDN; expected, for example, S-0-0047 or P-0-0010")
    return (MANUFACTURER if match[1] == "P" else 0) | int(match[2]) << 12 | int(match[3])


class Element(IntEnum):
    """The elements of an operation datum, as the control word numbers them."""

    CLOSED = 0
    IDN = 1
    NAME = 2
    ATTRIBUTE = 3
    UNIT = 4
    MINIMUM = 5
    MAXIMUM = 6
    DATA = 7


class Code(IntEnum):
    """Service channel error messages."""

    CHANNEL_CLOSED = 0x0001
    NO_IDN = 0x1001
    WRONG_ACCESS = 0x1009
    NO_NAME = 0x2001
    NAME_READ_ONLY = 0x2004
    ATTRIBUTE_READ_ONLY = 0x3004
    NO_UNIT = 0x4001
    UNIT_READ_ONLY = 0x4004
    NO_MINIMUM = 0x5001
    MINIMUM_READ_ONLY = 0x5004
    NO_MAXIMUM = 0x6001
    MAXIMUM_READ_ONLY = 0x6004
    TOO_SHORT = 0x7002
    TOO_LONG = 0x7003
    READ_ONLY = 0x7004
    PROTECTED_NOW = 0x7005
    BELOW_MINIMUM = 0x7006
    ABOVE_MAXIMUM = 0x7007
    INVALID = 0x7008
    CYCLIC = 0x700A
    """The datum is transmitted in the cyclic telegrams."""
    COMMAND_ACTIVE = 0x7010


class ServiceError(Exception):
    """An error message that a drive sends instead of data."""

    def __init__(self, code: int) -> None:
        super().__init__(f"service channel error {code:04X}h")
        self.code = code


class Length(IntEnum):
    """Data length, as the attribute encodes it."""

    TWO = 1
    FOUR = 2
    EIGHT = 3
    LIST_OF_BYTES = 4
    LIST_OF_WORDS = 5
    LIST_OF_DOUBLE_WORDS = 6
    LIST_OF_QUADRUPLE_WORDS = 7

    @property
    def is_list(self) -> bool:
        return self >= Length.LIST_OF_BYTES

    @property
    def bytes(self) -> int:
        """Size of a number, in bytes."""
        return (0, 2, 4, 8, 1, 2, 4, 8)[self]


class Format(IntEnum):
    """Display format of the data."""

    BINARY = 0
    UNSIGNED = 1
    SIGNED = 2
    HEX = 3
    TEXT = 4
    IDN = 5
    FLOAT = 6


@dataclass(frozen=True, slots=True)
class Attribute:
    """The attribute of a datum, its third element."""

    length: Length
    format: Format = Format.UNSIGNED
    decimals: int = 0
    factor: int = 1
    is_command: bool = False
    protected: tuple[int, ...] = ()
    """Phases in which the data are write-protected."""

    @property
    def word(self) -> int:
        word = self.factor | self.length << 16 | self.is_command << 19 | self.format << 20 | self.decimals << 24
        for phase in self.protected:
            word |= 1 << 26 + phase
        return word

    @classmethod
    def of(cls, word: int) -> "Attribute":
        """Decode an attribute read from a drive.  Raises ValueError for lengths and formats outside the standard."""
        return cls(
            Length(word >> 16 & 7),
            Format(word >> 20 & 7),
            word >> 24 & 15,
            word & 0xFFFF,
            bool(word >> 19 & 1),
            tuple(phase for phase in ALL_PHASES if word >> 26 + phase & 1),
        )


READ_ONLY: Final = ALL_PHASES
