"""The messages of an RS422 session (section 13.1).

The manual leaves the messages to another document, which is not public.  These follow the definition sequence of the
VME DualPort; XNG is the manual's word for a command that exchanges a value.
"""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from fieldrig_devices.pam.runtime.item import Value


class Code(IntEnum):
    REQUEST = 0x01
    """The master asks for a session."""
    ASK_DEF_IN = 0x02
    DEF_OUT = 0x03
    END_DEF_OUT = 0x04
    INIT_IN = 0x05
    END_INIT_IN = 0x06
    START = 0x07
    ALIVE = 0x08
    """A side is there, and has nothing else to say."""
    XNG_FLAG = 0x11
    XNG_WORD = 0x12
    XNG_LONG = 0x13
    XNG_REAL = 0x14
    ACK = 0x20
    """The PAM has carried a command of the configuration out, or says why not."""
    DEF_IN = 0x21
    """The definition of an input, as the answer to ASK_DEF_IN."""


class Result(IntEnum):
    """The result in an ACK."""

    OK = 1
    BAD_COMMAND = 2
    REJECTED = 3
    """The command does not belong to this phase."""
    END_DEF_IN = 4
    BAD_CRC = 5
    BAD_KEY = 6
    BAD_CLASS = 7


FIELDS: Final[Mapping[int, struct.Struct]] = {
    Code.REQUEST: struct.Struct(">"),
    Code.ASK_DEF_IN: struct.Struct(">"),
    Code.DEF_OUT: struct.Struct(">HI"),  # CRC, key of the master
    Code.END_DEF_OUT: struct.Struct(">"),
    Code.INIT_IN: struct.Struct(">"),
    Code.END_INIT_IN: struct.Struct(">"),
    Code.START: struct.Struct(">"),
    Code.ALIVE: struct.Struct(">"),
    Code.XNG_FLAG: struct.Struct(">IHB"),  # key, item index, value
    Code.XNG_WORD: struct.Struct(">IHh"),
    Code.XNG_LONG: struct.Struct(">IHi"),
    Code.XNG_REAL: struct.Struct(">IHd"),
    Code.ACK: struct.Struct(">BBHH"),  # command, result, class and number of items of an output
    Code.DEF_IN: struct.Struct(">HIHHH"),  # CRC, PAM key, class, number of items, period in ms
}
"""The values of each message, big endian."""

XNG: Final = {
    "FLAG_VAR": Code.XNG_FLAG,
    "WORD_VAR": Code.XNG_WORD,
    "LONG_VAR": Code.XNG_LONG,
    "REAL_VAR": Code.XNG_REAL,
}
CLASS_OF: Final[Mapping[int, str]] = {code: kind for kind, code in XNG.items()}
CLASS_NUMBERS: Final = {"FLAG_VAR": 1, "WORD_VAR": 2, "LONG_VAR": 3, "REAL_VAR": 4}


@dataclass(frozen=True, slots=True)
class Message:
    code: int
    """A `Code`, or a number that is none."""
    values: tuple[int | float, ...] = ()


def exchange(var_class: str, key: int, index: int, value: Value) -> Message:
    return Message(XNG[var_class], (key, index & 0xFFFF, value))
