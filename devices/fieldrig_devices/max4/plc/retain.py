"""RETAIN variables: where they are in the memory of a program, how large they are, and their values as bytes.

Source: PacDrive manual 990-1003, 6031-6034 (digest PD-048 to PD-056, PD-315).  The buffered memory contains the values
only, as on the controller; names and types are in a list on the flash disk (`RetainMap`), by which the values find
their variables again after the program has changed.  A pointer is never retained, because addresses may change.
A variable at an address of %M is retained like any other; its value is in the area instead of a cell.
"""

import json
import re
import struct
from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from typing import Final, NamedTuple, Self

from fieldrig.outside.untrusted import MalformedError, items, read_json, typed
from fieldrig_devices.iec import characters
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.layout import AREA_SIZE, AREAS
from fieldrig_devices.iec.program import Program, Variable
from fieldrig_devices.iec.types import ArrayType, BlockType, EnumType, StringType, StructType, SubrangeType, Type, Value
from fieldrig_devices.max4.storage.retained import MARK_BYTES, Values

CODES: Final[Mapping[str, str]] = {
    "BOOL": "?", "BYTE": "B", "WORD": "H", "DWORD": "I", "LWORD": "Q",
    "SINT": "b", "INT": "h", "DINT": "i", "LINT": "q", "USINT": "B", "UINT": "H", "UDINT": "I", "ULINT": "Q",
    "REAL": "f", "LREAL": "d", "TIME": "I", "DATE": "I", "TOD": "I", "DT": "I",
    "LTIME": "q", "LDATE": "q", "LTOD": "Q", "LDT": "q", "CHAR": "B", "WCHAR": "H", "SIGNED_TIME": "i",
    "UNSIGNED_LTIME": "Q",
}  # fmt: skip
"""Format characters of `struct` by elementary type."""
LONGEST_MAP: Final = 16 << 20
_TEXT: Final = re.compile(r"(W?)STRING\(([0-9]{1,3})\)")


class Leaf(NamedTuple):
    """One elementary value of a RETAIN variable."""

    path: str
    address: int
    type: str
    """An elementary type, or STRING(80), or WSTRING(80)."""
    variable: Variable | None = None
    """The variable that it is, or is part of."""
    bit: int = -1
    """The bit of a BOOL at an address such as %MX3.0."""

    @property
    def marker(self) -> int | None:
        """The first byte in %M; None for a value in a cell."""
        is_inside = AREAS["M"] <= self.address < AREAS["M"] + AREA_SIZE
        return self.address - AREAS["M"] if is_inside else None

    @property
    def size(self) -> int:
        return struct.calcsize("<" + self.code)

    @property
    def code(self) -> str:
        text = self.text
        return f"{text.size}s" if text is not None else CODES[self.type]

    @property
    def text(self) -> StringType | None:
        """The type if it is that of a text."""
        match = _TEXT.fullmatch(self.type)
        return None if match is None else StringType(int(match[2]), bool(match[1]))


def leaves_of(program: Program) -> list[Leaf]:
    """All retained values of a program, by ascending address."""
    leaves = (
        leaf
        for variable in program.globals.values()
        if _is_kept(variable)
        for leaf in _leaves(variable, variable.name, _address(variable, 0), variable.type, variable.is_retain)
    )
    return sorted(leaves, key=lambda leaf: leaf.address)


def _is_kept(variable: Variable) -> bool:
    if variable.is_constant or variable.is_reference:
        return False
    return variable.location.area == "M" if variable.location is not None else variable.offset >= 0


def _address(variable: Variable, start: int) -> int:
    """Return the address of a variable; `start` is that of the instance that it is in."""
    where = variable.location
    return start + variable.offset if where is None else AREAS[where.area] + where.byte


def _leaves(source: Variable, path: str, address: int, type: Type, is_retain: bool) -> Iterator[Leaf]:
    match type:
        case BlockType(pou=pou) if pou is not None:
            for variable in pou.variables.values():
                if _is_kept(variable):
                    inner = is_retain or variable.is_retain
                    name = f"{path}.{variable.name}"
                    yield from _leaves(variable, name, _address(variable, address), variable.type, inner)
        case ArrayType():
            if is_retain or _has_blocks(type.element):
                for index in range(type.count):
                    name = f"{path}[{type.low + index}]"
                    yield from _leaves(source, name, address + index * type.element.size, type.element, is_retain)
        case StructType():
            for field in type.stored_fields:
                yield from _leaves(source, f"{path}.{field.name}", address + field.offset, field.type, is_retain)
        case Elementary() if is_retain:
            yield Leaf(path, address, type.value, source, -1 if source.location is None else source.location.bit)
        case EnumType() | SubrangeType() if is_retain:
            yield Leaf(path, address, type.base.value, source)
        case StringType() if is_retain:
            yield Leaf(path, address, f"{type.name}({type.length})", source)


def _has_blocks(type: Type) -> bool:
    """True if there may be instances in the type, which may have RETAIN variables of their own."""
    match type:
        case ArrayType():
            return _has_blocks(type.element)
        case StructType():
            return any(_has_blocks(field.type) for field in type.fields.values())
    return isinstance(type, BlockType)


class RetainMap:
    """The retained values of one program, in the order in which they are stored."""

    def __init__(self, leaves: Sequence[Leaf]) -> None:
        self.leaves = tuple(leaves)
        self._format = struct.Struct("<" + "".join(leaf.code for leaf in self.leaves))
        texts = ((number, leaf.text) for number, leaf in enumerate(self.leaves))
        self._texts = [(number, text.is_wide) for number, text in texts if text is not None]
        self.mark = sha256(self.encode()).digest()[:MARK_BYTES]
        """The mark that distinguishes the values of this program from those of another one."""

    @property
    def size(self) -> int:
        """The memory that the values need, in bytes."""
        return self._format.size

    def pack(self, values: Sequence[Value]) -> Values:
        """The values of all leaves as bytes."""
        packed: list[Value | bytes] = list(values)
        for number, is_wide in self._texts:
            packed[number] = characters.encoded(str(values[number]), is_wide=is_wide)
        return Values(self.mark, self._format.pack(*packed))

    def unpack(self, data: bytes) -> dict[tuple[str, str], Value]:
        """The values by path and type; none if the data are not of this program."""
        if len(data) != self.size:
            return {}
        values = list(self._format.unpack(data))
        for number, is_wide in self._texts:
            values[number] = characters.decoded(values[number], is_wide=is_wide)
        keys = ((leaf.path.casefold(), leaf.type) for leaf in self.leaves)
        return dict(zip(keys, values, strict=True))

    def encode(self) -> bytes:
        return json.dumps([[leaf.path, leaf.type] for leaf in self.leaves]).encode()

    @classmethod
    def decode(cls, data: bytes) -> Self:
        """The map in a file.  ValueError if it is not valid."""
        leaves = []
        for row in items(read_json(data, longest=LONGEST_MAP, deepest=3), list, LONGEST_MAP):
            if len(row) != 2:
                raise MalformedError("expected a name and a type")
            path, type = typed(row[0], str), typed(row[1], str)
            leaf = Leaf(path, 0, type)
            if type not in CODES and leaf.text is None:
                raise MalformedError("expected an elementary type")
            leaves.append(leaf)
        return cls(leaves)
