"""Values of one message of a field bus: their types, and their bytes in PDOs, coils and registers.

Source: CiA 301, 7.5.2.36, and Modbus application protocol V1.1b3, 6.1, for values that fill a message from the lowest
bit; registers have the high word of a value first.
"""

import struct
from collections.abc import Iterator, Sequence
from math import isnan
from typing import Annotated, Final, Literal, NamedTuple, Protocol

from pydantic import Field

from fieldrig.device import Value
from fieldrig.settings import Settings
from fieldrig_devices.registers.form import LARGEST_F32
from fieldrig_devices.registers.type_names import naming

CellName = Annotated[
    str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*(\.[A-Za-z0-9_]+)*$", max_length=200, examples=["Main.speed"])
]


class Form(NamedTuple):
    """The form of a type in a message."""

    bits: int
    code: str = ""
    """Format character of `struct`, or an empty string for a single bit."""
    low: int = 0
    high: int = 0
    """Range of an integer."""


FORMS: Final = {
    "bool": Form(1),
    "u8": Form(8, "B", 0, 0xFF),
    "s8": Form(8, "b", -0x80, 0x7F),
    "u16": Form(16, "H", 0, 0xFFFF),
    "s16": Form(16, "h", -0x8000, 0x7FFF),
    "u32": Form(32, "I", 0, 0xFFFF_FFFF),
    "s32": Form(32, "i", -0x8000_0000, 0x7FFF_FFFF),
    "f32": Form(32, "f"),
}


class Element(Settings):
    """One value in a message."""

    name: CellName = Field(description="name of the value in the controller")
    type: Annotated[Literal["bool", "u8", "s8", "u16", "s16", "u32", "s32", "f32"], naming(*FORMS)] = Field(
        default="u16", description="type in the message"
    )

    @property
    def form(self) -> Form:
        return FORMS[self.type]

    @property
    def words(self) -> int:
        """Number of registers."""
        return (self.form.bits + 15) // 16


class Cell(Protocol):
    """The place of a value in the controller."""

    @property
    def value(self) -> Value: ...

    def put(self, value: Value) -> None: ...


class Packed:
    """The values of one message."""

    def __init__(self, elements: Sequence[Element], cells: Sequence[Cell]) -> None:
        self._pairs = [(element.form, cell) for element, cell in zip(elements, cells, strict=True)]

    def clear(self) -> None:
        for form, cell in self._pairs:
            cell.put(_value("<", form, bytes((form.bits + 7) // 8)))

    def packed(self) -> bytes:
        """The values packed bit by bit for a PDO or coils, the first value in the lowest bits."""
        word = at = 0
        for form, cell in self._pairs:
            word |= int.from_bytes(_raw("<", form, cell.value), "little") << at
            at += form.bits
        return word.to_bytes((at + 7) // 8, "little")

    def unpack(self, data: bytes) -> None:
        """Take the values from packed bits; values that `data` does not contain completely keep theirs."""
        word, size, at = int.from_bytes(data, "little"), 8 * len(data), 0
        for form, cell in self._pairs:
            if at + form.bits > size:
                return
            raw = word >> at & (1 << form.bits) - 1
            cell.put(_value("<", form, raw.to_bytes((form.bits + 7) // 8, "little")))
            at += form.bits

    def registers(self) -> bytes:
        """The values in one or two registers each, the high word first."""
        return b"".join(
            _raw(">", form, cell.value).rjust((form.bits + 15) // 16 * 2, b"\x00") for form, cell in self._pairs
        )

    def unpack_registers(self, data: bytes) -> None:
        """Take the values from registers; values that `data` does not contain completely keep theirs."""
        at = 0
        for form, cell in self._pairs:
            end = at + (form.bits + 15) // 16 * 2
            if end > len(data):
                return
            cell.put(_value(">", form, data[end - max(form.bits // 8, 1) : end]))
            at = end


def names_of(elements: Sequence[Element]) -> Iterator[str]:
    """Yield the names of values in the form in which they are compared."""
    yield from (element.name.casefold() for element in elements)


def _raw(order: str, form: Form, value: Value) -> bytes:
    """The bytes of a value, limited to the range of its form."""
    if not form.code:
        return bytes((bool(value),))
    if form.code == "f":
        return struct.pack(order + "f", min(max(float(value), -LARGEST_F32), LARGEST_F32))
    return struct.pack(order + form.code, min(max(int(value), form.low), form.high))


def _value(order: str, form: Form, raw: bytes) -> Value:
    if not form.code:
        return any(raw)
    value: int | float = struct.unpack(order + form.code, raw)[0]
    if form.code != "f":
        return value
    return 0.0 if isnan(value) else min(max(value, -LARGEST_F32), LARGEST_F32)  # a value is never infinite
