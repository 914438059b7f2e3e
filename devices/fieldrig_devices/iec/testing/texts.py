"""Values of a program as its language writes them, for messages about tests."""

from collections.abc import Sequence
from typing import Final

from fieldrig_devices.iec.elementary import Elementary, Family
from fieldrig_devices.iec.layout import members, storage
from fieldrig_devices.iec.library.texts import writer
from fieldrig_devices.iec.literal_texts import real_text, string_text, wide_string_text
from fieldrig_devices.iec.types import ArrayType, BlockType, EnumType, StringType, StructType, Type, Value

LONGEST: Final = 160
"""Characters of a value in a message."""


def value_text(kind: Type, value: Value) -> str:
    """Return the value of a type with one cell, as a constant of the language."""
    if isinstance(kind, EnumType):
        name = next((name for name, number in kind.values.items() if number == value), None)
        return name if name is not None else str(value)
    stored = storage(kind)
    if isinstance(stored, StringType):
        return cut(wide_string_text(str(value)) if stored.is_wide else string_text(str(value)))
    if not isinstance(stored, Elementary) or isinstance(value, str):
        return str(value)
    if stored.family is Family.BITS:
        return f"16#{value:0{2 * stored.size}X}"
    return writer(stored)(value)


def cells_text(kind: Type, cells: Sequence[Value], address: int) -> str:
    """Return the value at an address, also that of a structure, an array or an instance."""
    return cut(_text(kind, cells, address))


def cut(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def _text(kind: Type, cells: Sequence[Value], address: int) -> str:
    match kind:
        case ArrayType(element=element, count=count):
            shown = [_text(element, cells, address + place * element.size) for place in range(min(count, LONGEST))]
            return f"[{', '.join(shown)}]"
        case StructType():
            shown = [f"{part.name} := {_text(part.type, cells, address + part.offset)}" for part in kind.stored_fields]
            return f"({', '.join(shown)})"
        case BlockType():
            parts = [part for part in members(kind) if part.name[:1] != "$" and not part.is_reference]
            return f"({', '.join(f'{one.name} := {_text(one.type, cells, address + one.offset)}' for one in parts)})"
    return value_text(kind, cells[address])


def both_texts(kind: Type, cells: Sequence[Value], actual: int, expected: int) -> tuple[str, str, str]:
    """Return both values and the path to the first part in which they differ, which is empty for single values."""
    path, kind, offset = _difference(kind, cells, actual, expected)
    texts = cells_text(kind, cells, actual + offset), cells_text(kind, cells, expected + offset)
    first, second = cells[actual + offset], cells[expected + offset]
    if texts[0] == texts[1] and isinstance(first, float) and isinstance(second, float):
        texts = real_text(first), real_text(second)  # a REAL has seven digits otherwise
    return *texts, path


def _difference(kind: Type, cells: Sequence[Value], actual: int, expected: int) -> tuple[str, Type, int]:
    path, offset = "", 0
    while True:
        parts: list[tuple[str, Type, int]] = []
        if isinstance(kind, ArrayType):
            parts = [(f"[{kind.low + place}]", kind.element, place * kind.element.size) for place in range(kind.count)]
        elif isinstance(kind, StructType):
            parts = [(f".{part.name}", part.type, part.offset) for part in kind.stored_fields]
        for name, inner, at in parts:
            first, second = actual + offset + at, expected + offset + at
            if cells[first : first + inner.size] != cells[second : second + inner.size]:
                path, kind, offset = f"{path}{name}", inner, offset + at
                break
        else:
            return path.replace("][", ", "), kind, offset
