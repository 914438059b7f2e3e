"""Identification numbers, and what the elements of the operation datum behind each may be.

Source: IEC 61491 by its public facts (structure of IDNs, attribute, service channel error messages).  A number with bit
15 is a manufacturer's (P), bits 12 to 14 are the parameter set.
"""

import re
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

MANUFACTURER: Final = 0x8000
ALL_PHASES: Final = (2, 3, 4)


def s(number: int) -> int:
    """A standard IDN, S-0-`number`."""
    return number


def p(number: int) -> int:
    """A manufacturer's IDN, P-0-`number`."""
    return MANUFACTURER | number


def idn_text(idn: int) -> str:
    return f"{'P' if idn & MANUFACTURER else 'S'}-{idn >> 12 & 7}-{idn & 0xFFF:04}"


def idn_of(text: str) -> int:
    """The inverse of `idn_text`; ValueError for anything else."""
    found = re.fullmatch(r"([SP])-([0-7])-(\d{1,4})", text.upper(), re.ASCII)
    if found is None or int(found[3]) > 0xFFF:
        raise ValueError(f"{text!r} is no IDN: write it like S-0-0047 or P-0-0010")
    return (MANUFACTURER if found[1] == "P" else 0) | int(found[2]) << 12 | int(found[3])


class Element(IntEnum):
    """Of an operation datum, as the control word names it."""

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
    """It comes with the telegrams."""
    COMMAND_ACTIVE = 0x7010


class ServiceError(Exception):
    """What a drive answers in place of data."""

    def __init__(self, code: int) -> None:
        super().__init__(f"service channel error {code:04X}h")
        self.code = code


class Length(IntEnum):
    """Of the data, as the attribute has it."""

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
        """Of one number."""
        return (0, 2, 4, 8, 1, 2, 4, 8)[self]


class Format(IntEnum):
    """How data is shown."""

    BINARY = 0
    UNSIGNED = 1
    SIGNED = 2
    HEX = 3
    TEXT = 4
    IDN = 5
    FLOAT = 6


@dataclass(frozen=True, slots=True)
class Attribute:
    """The third element."""

    length: Length
    format: Format = Format.UNSIGNED
    decimals: int = 0
    factor: int = 1
    is_command: bool = False
    protected: tuple[int, ...] = ()
    """The phases in which the data can't be written; all of them: never."""

    @property
    def word(self) -> int:
        word = self.factor | self.length << 16 | self.is_command << 19 | self.format << 20 | self.decimals << 24
        for phase in self.protected:
            word |= 1 << 26 + phase
        return word

    @classmethod
    def of(cls, word: int) -> "Attribute":
        """Of what was read from a drive.  ValueError for lengths and formats that the standard doesn't know."""
        return cls(
            Length(word >> 16 & 7),
            Format(word >> 20 & 7),
            word >> 24 & 15,
            word & 0xFFFF,
            bool(word >> 19 & 1),
            tuple(phase for phase in ALL_PHASES if word >> 26 + phase & 1),
        )


READ_ONLY: Final = ALL_PHASES
