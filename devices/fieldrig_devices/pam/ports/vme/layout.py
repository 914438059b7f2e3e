"""The memory map of the VME DualPort in words, its codes, and the blocks of its FIFOs (sections 11.2 and 11.3).

The manual prints no codes for the classes of variables; those of the settings are ours.
"""

import struct
from collections.abc import Mapping
from enum import IntEnum
from typing import Final

from fieldrig_devices.pam.language.ports import ALL_ITEMS, PortVariable
from fieldrig_devices.pam.ports.options import ClassCodes
from fieldrig_devices.pam.runtime.item import Value

IN_HEADER: Final = 0
OUT_HEADER: Final = 5
"""Headers of the FIFOs: OFFSET, HEAD, TAIL, MAX_BLOC_NUMBER and BLOC_SIZE."""
OFFSET, HEAD, TAIL, MAX_BLOCKS, BLOCK_SIZE = range(5)
WATCHDOG: Final = 10
SYNCHRO: Final = 11
COMMAND: Final = 12
VME_PARAMETERS: Final = 13
ACKNOWLEDGE: Final = 16
PAM_PARAMETERS: Final = 17

BLOCKS: Final = 144
"""Blocks of a FIFO; one of them always stays free (PAMS-080)."""
BLOCK_WORDS: Final = 7
BODIES: Final = {IN_HEADER: 29, OUT_HEADER: 29 + BLOCKS * BLOCK_WORDS}


class Command(IntEnum):
    NOP = 0
    ASK_DEF_IN = 2
    DEF_OUT = 3
    END_DEF_OUT = 4
    INIT_IN = 5
    END_INIT_IN = 6
    START = 7


class Answer(IntEnum):
    """The codes that the PAM writes to ACKNOWLEDGE."""

    NO_ACK = 0
    ACK_OK = 1
    BAD_CDE = 2
    CDE_REJECTED = 3
    END_DEF_IN = 4
    BAD_CRC = 5


DEF_OUT_REPLY: Final = {"as_inputs": PAM_PARAMETERS + 2, "first": PAM_PARAMETERS}
"""The word with the class of an output in the answer to DEF_OUT; the number of items follows it."""


def class_codes(codes: ClassCodes) -> Mapping[str, int]:
    return {"FLAG_VAR": codes.flag, "WORD_VAR": codes.word, "LONG_VAR": codes.long, "REAL_VAR": codes.real}


_WIRE: Final = {
    "FLAG_VAR": struct.Struct("<H"),
    "WORD_VAR": struct.Struct("<h"),
    "LONG_VAR": struct.Struct("<i"),
    "REAL_VAR": struct.Struct("<d"),
}
_VALUE: Final = struct.Struct("<4H")


def value_words(var_class: str, value: Value) -> tuple[int, ...]:
    """Return the last four words of a block, the least significant first (tables 13-8 and 13-9)."""
    return _VALUE.unpack(_WIRE[var_class].pack(value).ljust(_VALUE.size, b"\0"))


def value_of(var_class: str, words: tuple[int, ...]) -> Value:
    """Return the value in the last four words of a block."""
    (value,) = _WIRE[var_class].unpack_from(_VALUE.pack(*words))
    return bool(value) if var_class == "FLAG_VAR" else value


def index_on_wire(variable: PortVariable, item: int, first: int) -> int:
    """Return the index of an item in a block, where `first` is that of the first item of a multiple variable."""
    return item + first if variable.is_multiple and item >= 0 else item


def item_on_wire(variable: PortVariable, index: int, first: int) -> int:
    """Return the item that an index in a block means; `variable.number` or more if there is none."""
    if not variable.is_multiple or index == ALL_ITEMS:
        return index
    return index - first if index >= first else variable.number


def input_block(key: int, index: int, var_class: str, value: Value) -> tuple[int, ...]:
    """Return a block of the input FIFO; `index` is -1 for all items."""
    return key, 0, index & 0xFFFF, *value_words(var_class, value)


def output_block(key: int, index: int, var_class: str, value: Value) -> tuple[int, ...]:
    """Return a block of the output FIFO, with the 32 bits of the master's key."""
    return key & 0xFFFF, key >> 16, index & 0xFFFF, *value_words(var_class, value)
