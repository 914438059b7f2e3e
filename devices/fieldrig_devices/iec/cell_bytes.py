"""The bytes of values as the controller has them, which is little-endian, and back."""

import struct
from array import array
from collections.abc import Iterator, Sequence
from typing import Final

from fieldrig_devices.iec import characters
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.layout import INSIDE, STRING_KIND, WIDE_STRING_KIND, kind_number
from fieldrig_devices.iec.types import Value

_LETTERS: Final = {1: "Bb", 2: "Hh", 4: "Ii", 8: "Qq"}
_SINGLE: Final = struct.Struct("<f")
BY_NUMBER: Final = {kind_number(kind): kind for kind in Elementary}
TEXTS: Final = {STRING_KIND: 1, WIDE_STRING_KIND: 2}
"""Bytes of a character by the number of the kind of string."""


def _wire(kind: Elementary) -> struct.Struct:
    if kind.is_real:
        return struct.Struct("<f" if kind is Elementary.REAL else "<d")
    return struct.Struct("<" + _LETTERS[kind.size][kind.is_signed])


_WIRES: Final = {number: _wire(kind) for number, kind in BY_NUMBER.items()}


def encoded(value: Value, number: int) -> bytes:
    """Return the bytes of an elementary value of the kind with this number."""
    if BY_NUMBER[number] is Elementary.REAL:
        cell = array("f", [float(value)])  # unlike struct, this turns what is too large into infinity
        return _SINGLE.pack(cell[0]) if abs(cell[0]) != float("inf") else cell.tobytes()
    return _WIRES[number].pack(value)


def decoded(data: bytes, number: int) -> Value:
    (value,) = _WIRES[number].unpack(data)
    kind = BY_NUMBER[number]
    if kind is Elementary.BOOL:
        return bool(value)
    is_clock = kind in (Elementary.TOD, Elementary.LTOD)
    return value % (kind.high + 1) if is_clock else value  # type: ignore[no-any-return]


def text_bytes(value: str, number: int) -> bytes:
    return characters.encoded(value, is_wide=number == WIDE_STRING_KIND)


def text_in(data: bytes, number: int) -> str:
    return characters.decoded(data, is_wide=number == WIDE_STRING_KIND)


def bytes_of(cells: Sequence[Value], kinds: bytes) -> bytearray:
    """Return the bytes of all values in some cells."""
    whole = bytearray(len(kinds))
    for at, end in _values(kinds):
        number = kinds[at]
        data = text_bytes(str(cells[at]), number) if number in TEXTS else encoded(cells[at], number)
        whole[at : at + len(data)] = data[: end - at]
    return whole


def cells_of(data: bytes, kinds: bytes) -> list[Value]:
    """Return the cells of values with these bytes; a text ends at its first zero."""
    cells: list[Value] = [0] * len(kinds)
    for at, end in _values(kinds):
        number = kinds[at]
        cells[at] = text_in(data[at:end], number) if number in TEXTS else decoded(data[at:end], number)
    return cells


def _values(kinds: bytes) -> Iterator[tuple[int, int]]:
    """Yield where each value begins, and where it ends."""
    begins = [at for at, number in enumerate(kinds) if number != INSIDE[0]]
    return zip(begins, [*begins[1:], len(kinds)], strict=True) if begins else iter(())
