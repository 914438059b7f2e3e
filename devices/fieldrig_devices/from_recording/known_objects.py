"""Names, types and access of the objects that the standards define, and the type of any other one by its bytes.

Source: CiA 301 for the communication objects and CiA 402 for drives, as our own drive's EDS has them; CiA 401 for
analog inputs and outputs.
"""

from functools import cache
from typing import Final

from fieldrig_devices.canopen import standard
from fieldrig_devices.canopen.datatypes import DATA_TYPES
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds import reader
from fieldrig_devices.canopen.eds.source import EdsSource
from fieldrig_devices.canopen.variable import FIRST_APPLICATION_INDEX, Variable
from fieldrig_devices.cia402.single.own_objects import EDS

TEXT, OCTETS, DOMAIN, BOOLEAN, U8, U16, U32 = 0x09, 0x0A, 0x0F, 0x01, 0x05, 0x06, 0x07
UNSIGNED: Final = {1: U8, 2: U16, 3: 0x16, 4: U32, 5: 0x18, 6: 0x19, 7: 0x1A, 8: 0x1B}
"""Data types by the size in bytes."""
I16: Final = 0x03
ANALOG: Final = frozenset({0x6401, 0x6411})
"""Analog inputs and outputs of 16 bits (CiA 401)."""
TEXTS: Final = frozenset({0x1008, 0x1009, 0x100A})
SHORTEST_TEXT: Final = 5
"""Shorter bytes of letters are as likely to be a number."""


@cache
def of_drives() -> Dictionary:
    """The objects of our own drive, which has all of CiA 402 and the usual ones of CiA 301."""
    return Dictionary(reader.describe(EDS, reader.CHECKED_AS).variables)


@cache
def names_of_drives() -> dict[int, str]:
    """Names of the objects with sub-indices."""
    return {index: section.get("ParameterName") for index, sub, section in EdsSource(EDS).objects() if sub is None}


def standard_variable(index: int, subindex: int, is_drive: bool) -> Variable | None:
    """The object as a standard defines it; None if it is one of the maker, or of a profile that is not known here."""
    is_known = index < FIRST_APPLICATION_INDEX or is_drive
    return of_drives().get(index, subindex) if is_known else None


def type_number(index: int, subindex: int, size: int | None, sample: bytes, is_drive: bool) -> int:
    """Return the number of the data type; `size` is the only size that was seen, or None for several."""
    if index in TEXTS and subindex == 0:
        return TEXT
    needed, variable = standard.wanted(index, subindex), standard_variable(index, subindex, is_drive)
    wanted = needed or (None if variable is None else variable.type)
    if wanted is not None:
        fits = wanted.size is None or size is None or size == wanted.size or size == 4 > wanted.size
        if fits or needed is not None:  # the services of a node need the types of CiA 301
            return next(number for number, known in DATA_TYPES.items() if known is wanted)
    if index in ANALOG and subindex and size == 2:
        return I16
    if size is None or size not in UNSIGNED or (size >= SHORTEST_TEXT and _is_text(sample)):
        return TEXT if _is_text(sample) else OCTETS
    return UNSIGNED[size]


def _is_text(data: bytes) -> bool:
    letters = data.rstrip(b"\0")
    return bool(letters) and all(0x20 <= byte < 0x7F for byte in letters)
