"""The names of the objects of I/O modules, for tools that meet one without its EDS.

Source: CiA 401 version 3, chapter 7.  Left out: the objects for single inputs and outputs (6020h and others), which few
modules have.
"""

from functools import lru_cache
from typing import Final

from fieldrig_devices.canopen.datatypes import DATA_TYPES
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.variable import Access, Variable

PROFILE: Final = 401
"""The device profile of I/O modules, in the low word of the device type."""
_BOOLEAN, _I8, _I16, _I32, _U8, _U16, _U32, _FLOAT = 0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x08
_DIGITAL: Final = {
    0x6000: "Read input", 0x6002: "Polarity input", 0x6003: "Filter constant input",
    0x6006: "Interrupt mask any change", 0x6007: "Interrupt mask low to high", 0x6008: "Interrupt mask high to low",
    0x6200: "Write output", 0x6202: "Change polarity output", 0x6206: "Error mode output",
    0x6207: "Error value output", 0x6208: "Filter mask output",
}  # fmt: skip
_WIDTHS: Final = ((0x000, "8-bit", _U8), (0x100, "16-bit", _U16), (0x120, "32-bit", _U32))
"""The number that is added to an index of `_DIGITAL`, the width in words, and the type of an entry."""
_ANALOGUE: Final = {
    0x6400: ("Read analogue input 8-bit", _I8), 0x6401: ("Read analogue input 16-bit", _I16),
    0x6402: ("Read analogue input 32-bit", _I32), 0x6403: ("Read analogue input float", _FLOAT),
    0x6410: ("Write analogue output 8-bit", _I8), 0x6411: ("Write analogue output 16-bit", _I16),
    0x6412: ("Write analogue output 32-bit", _I32), 0x6413: ("Write analogue output float", _FLOAT),
    0x6421: ("Analogue input interrupt trigger selection", _U8), 0x6422: ("Analogue input interrupt source", _U32),
    0x6424: ("Analogue input interrupt upper limit integer", _I32),
    0x6425: ("Analogue input interrupt lower limit integer", _I32),
    0x6426: ("Analogue input interrupt delta unsigned", _U32),
    0x6427: ("Analogue input interrupt negative delta unsigned", _U32),
    0x6428: ("Analogue input interrupt positive delta unsigned", _U32),
    0x6429: ("Analogue input interrupt upper limit float", _FLOAT),
    0x642A: ("Analogue input interrupt lower limit float", _FLOAT),
    0x642B: ("Analogue input interrupt delta float", _FLOAT),
    0x642C: ("Analogue input interrupt negative delta float", _FLOAT),
    0x642D: ("Analogue input interrupt positive delta float", _FLOAT),
    0x642E: ("Analogue input offset float", _FLOAT), 0x642F: ("Analogue input scaling float", _FLOAT),
    0x6430: ("Analogue input SI unit", _U32), 0x6431: ("Analogue input offset integer", _I32),
    0x6432: ("Analogue input scaling integer", _I32), 0x6441: ("Analogue output offset float", _FLOAT),
    0x6442: ("Analogue output scaling float", _FLOAT), 0x6443: ("Analogue output error mode", _U8),
    0x6444: ("Analogue output error value integer", _I32), 0x6445: ("Analogue output error value float", _FLOAT),
    0x6446: ("Analogue output offset integer", _I32), 0x6447: ("Analogue output scaling integer", _I32),
    0x6450: ("Analogue output SI unit", _U32),
}  # fmt: skip
_SINGLE: Final = {
    0x6005: ("Global interrupt enable digital", _BOOLEAN), 0x6423: ("Analogue input global interrupt enable", _BOOLEAN),
}  # fmt: skip
NAMES: Final = _SINGLE | _ANALOGUE | {
    index + added: (f"{name} {width}", kind) for added, width, kind in _WIDTHS for index, name in _DIGITAL.items()
}  # fmt: skip


class IoDictionary(Dictionary):
    """The objects of CiA 401."""

    def __init__(self) -> None:
        super().__init__([])

    def get(self, index: int, subindex: int = 0) -> Variable | None:
        return io_variable(index, subindex)


def io_name(index: int) -> str:
    """Return the name of an object of CiA 401 with all its sub-indices; "" for any other one."""
    return NAMES[index][0] if index in NAMES else ""


@lru_cache(maxsize=1024)
def io_variable(index: int, subindex: int) -> Variable | None:
    """Return an object of CiA 401; None for any other one."""
    if index not in NAMES or (index in _SINGLE and subindex):
        return None
    name, kind = NAMES[index]
    if index not in _SINGLE:
        name, kind = (f"{name}, {subindex}", kind) if subindex else (f"{name}, number of entries", _U8)
    return Variable(index, subindex, name, DATA_TYPES[kind], Access.RW, start=b"")
