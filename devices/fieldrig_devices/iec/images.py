"""The start values of variables, as cells of the memory."""

from collections.abc import Mapping
from typing import Final

from fieldrig_devices.iec.cell_bytes import bytes_of, cells_of
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.layout import INSIDE, KINDS, REFERENCE_SIZE, kind_number, members, storage
from fieldrig_devices.iec.program import Variable
from fieldrig_devices.iec.types import (
    ArrayType,
    BlockType,
    EnumType,
    Field,
    InitialValue,
    StringType,
    StructType,
    SubrangeType,
    Type,
    Value,
)


class Images:
    """The start values of variables, cell by cell, and the kinds of their cells."""

    def __init__(self) -> None:
        self._cells: dict[Type, list[Value]] = {}
        self._kinds: dict[Type, bytes] = {}
        self._starting: dict[Type, bool] = {}
        """The structures, and whether there are start values in them."""

    def cells(self, kind: Type, initial: InitialValue | None = None) -> list[Value]:
        if initial is None:
            if kind not in self._cells:
                self._cells[kind] = self._made(kind, None)
            return self._cells[kind]
        return self._made(kind, initial)

    def _made(self, kind: Type, initial: InitialValue | None) -> list[Value]:
        match kind:
            case ArrayType(element=element, count=count):
                given = initial if isinstance(initial, list) else []
                cells = [cell for value in given for cell in self.cells(element, value)]
                return cells + self.cells(element) * (count - len(given))
            case StructType(is_union=True):
                return self._union(kind, initial if isinstance(initial, dict) else {})
            case StructType():
                own = initial if isinstance(initial, dict) else {}
                parts = [(part.type, _started(part, own)) for part in kind.stored_fields]
                return [cell for part, start in parts for cell in self.cells(part, start)]
            case BlockType():
                own = initial if isinstance(initial, dict) else {}
                return [
                    cell for member in members(kind) for cell in self.variable(member, own.get(member.name.lower()))
                ]
        padding: list[Value] = [0] * (kind.size - 1)
        return [start_value(kind, initial), *padding]

    def _union(self, kind: StructType, own: Mapping[str, InitialValue]) -> list[Value]:
        """Return the cells of a UNION, whose components get their start values in turn, at the same address."""
        cells = [cell for part in kind.stored_fields for cell in self.cells(part.type)]
        parts = kind.fields.items()
        declared = {
            name: part.initial for name, part in parts if part.initial is not None or self._has_starts(part.type)
        }
        if not declared and not own:
            return cells
        whole = bytes_of(cells, self.kinds(kind))
        for name, start in [*declared.items(), *own.items()]:
            part = kind.fields[name]
            if part.bit >= 0:
                whole[0] = whole[0] & ~1 | bool(start)
            else:
                data = bytes_of(self.cells(part.type, start), self.kinds(part.type))
                whole[: len(data)] = data
        return cells_of(bytes(whole), self.kinds(kind))

    def _has_starts(self, kind: Type) -> bool:
        """True for a structure with a declared start value in it, at any level."""
        while isinstance(kind, ArrayType):
            kind = kind.element
        if not isinstance(kind, StructType):
            return False
        if kind not in self._starting:
            parts = kind.fields.values()
            self._starting[kind] = any(part.initial is not None or self._has_starts(part.type) for part in parts)
        return self._starting[kind]

    def variable(self, variable: Variable, initial: InitialValue | None = None) -> list[Value]:
        """Return the cells of a variable; `initial` is from the declaration of its instance."""
        if variable.is_reference:
            return [0] * REFERENCE_SIZE
        return self.cells(variable.type, variable.initial if initial is None else initial)

    def kinds(self, kind: Type) -> bytes:
        if kind not in self._kinds:
            self._kinds[kind] = self._kinds_of(kind)
        return self._kinds[kind]

    def _kinds_of(self, kind: Type) -> bytes:
        match kind:
            case ArrayType(element=element, count=count):
                return self.kinds(element) * count
            case StructType():
                return b"".join(self.kinds(field.type) for field in kind.stored_fields)
            case BlockType():
                return b"".join(
                    _REFERENCE if member.is_reference else self.kinds(member.type) for member in members(kind)
                )
        stored = storage(kind)
        assert stored is not None, kind
        return bytes([kind_number(stored)]).ljust(kind.size, INSIDE)


def _started(part: Field, own: Mapping[str, InitialValue]) -> InitialValue | None:
    """Return the start value of a component, or of the byte with some BITs."""
    if not part.bits:
        return own.get(part.name.lower(), part.initial)
    return sum(bool(own.get(one.name.lower(), one.initial)) << one.bit for one in part.bits)


_REFERENCE: Final = bytes([KINDS[Elementary.DWORD]]).ljust(REFERENCE_SIZE, INSIDE)


def start_value(kind: Type, initial: InitialValue | None) -> Value:
    """Return the start value of a type with one cell.

    Without a declared one it is 0 (PD-056); the first value of an enumeration (manual 850), and what is nearest to 0
    in a subrange.
    """
    if initial is not None:
        assert not isinstance(initial, list | dict)
        return initial[: kind.length] if isinstance(kind, StringType) and isinstance(initial, str) else initial
    match kind:
        case Elementary():
            return kind.initial
        case StringType():
            return ""
        case SubrangeType(low=low, high=high):
            return min(max(low, 0), high)
        case EnumType(values=values):
            return next(iter(values.values()), 0)
    return 0
