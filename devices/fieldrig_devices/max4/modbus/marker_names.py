"""The markers %M in Modbus messages by the names of the program's variables (the map is that of `markers`).

The declarations are read without compiling the program: global variables and those of programs with an address AT.  A
variable of a type that the program declares itself has the value of the bits of its address; registers below the
markers and addresses of several levels have their numbers.
"""

import struct
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

from fieldrig.points.values import show_number
from fieldrig.traces.names import listed
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.located import SIZES, bit_place
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.imports import read_sources
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.max4.modbus.markers import FIRST

MOST_ADDRESSES: Final = 2_000
"""The most bits that one message can have (V1.1b3, 6.1); a wrong request can ask for more."""
FORMS: Final = {
    "BYTE": "B", "WORD": "H", "DWORD": "I", "LWORD": "Q", "SINT": "b", "INT": "h", "DINT": "i", "LINT": "q",
    "USINT": "B", "UINT": "H", "UDINT": "I", "ULINT": "Q", "REAL": "f", "LREAL": "d", "TIME": "I", "DATE": "I",
    "TOD": "I", "DT": "I", "TIME_OF_DAY": "I", "DATE_AND_TIME": "I",
}  # fmt: skip
UNITS: Final = {"TIME": " ms"}
OF_SIZE: Final = {1: "B", 2: "H", 4: "I", 8: "Q"}


class Marker(NamedTuple):
    """A variable of the program in the area %M."""

    name: str
    byte: int
    bit: int
    """-1 for a variable that is no single bit."""
    size: int
    """In bytes."""
    type: str


def markers_in(sources: Sequence[SourceFile], dialect: Dialect) -> list[Marker]:
    """Return the variables of a program that have an address in %M."""
    return [
        marker
        for unit, _ in read_sources(sources, dialect)
        for declaration in unit.declarations
        for marker in _of_declaration(declaration)
    ]


def _of_declaration(declaration: tree.Declaration) -> Iterator[Marker]:
    match declaration:
        case tree.Variables():
            yield from _of_block(declaration, "")
        case tree.Pou(kind=tree.PouKind.PROGRAM):
            for block in declaration.blocks:
                yield from _of_block(block, f"{declaration.name}.")


def _of_block(block: tree.Variables, lead: str) -> Iterator[Marker]:
    for variable in block.variables:
        node = variable.location
        if node is None or node.area.upper() != "M":
            continue
        size = SIZES.get(node.size)
        if not 1 <= len(node.numbers) <= (2 if size is None else 1):
            continue
        byte, bit = bit_place(node.numbers) if size is None else (node.numbers[0] * size, -1)
        kind = variable.type.name.upper() if isinstance(variable.type, tree.NamedType) else ""
        yield Marker(lead + variable.name, byte, bit, size or 1, kind)


class MarkerNames:
    """The registers and coils of one controller.  Implements `RegisterNames`."""

    def __init__(self, markers: Sequence[Marker]) -> None:
        self._values: dict[int, list[Marker]] = {}
        """Variables by the word in which they begin."""
        self._bits: dict[int, str] = {}
        """Single bits, counted from %MX0.0."""
        for marker in markers:
            self._values.setdefault(marker.byte // 2, []).append(marker)
            if marker.bit >= 0:
                self._bits[8 * marker.byte + marker.bit] = marker.name

    def names(self, space: str, address: int, count: int) -> str:
        end = address + min(count, MOST_ADDRESSES)
        if space in ("coils", "discrete_inputs"):
            return listed([self._bit_name(space, at) for at in range(address, end)])
        return listed([name for _, _, names in self._pieces(address, end) for name in names])

    def registers(self, space: str, address: int, data: bytes) -> str:
        return listed(
            [
                text
                for at, found, _ in self._pieces(address, address + len(data) // 2)
                for text in _with_values(at, found, data[2 * (at - address) :])
            ]
        )

    def bits(self, space: str, address: int, count: int, data: bytes) -> str:
        number = int.from_bytes(data, "little")
        bits = range(min(count, 8 * len(data)))
        return listed([f"{self._bit_name(space, address + at)} {'on' if number >> at & 1 else 'off'}" for at in bits])

    def _bit_name(self, space: str, address: int) -> str:
        if space != "coils" or address < FIRST:
            return str(address)
        word, bit = divmod(address - FIRST, 16)
        return self._bits.get(address - FIRST, f"%MX{word}.{bit}")

    def _pieces(self, address: int, end: int) -> Iterator[tuple[int, list[Marker], list[str]]]:
        """Yield the registers at which variables begin, with these variables and names."""
        while address < end:
            found = self._values.get(address - FIRST, []) if address >= FIRST else []
            fallback = f"%MW{address - FIRST}" if address >= FIRST else str(address)
            yield address, found, [marker.name for marker in found] or [fallback]
            address += max([1, *((marker.size + 1) // 2 for marker in found)])


def _with_values(address: int, found: Sequence[Marker], data: bytes) -> Iterator[str]:
    area = b"".join(data[at + 1 : at + 2] + data[at : at + 1] for at in range(0, len(data) - 1, 2))
    for marker in found:
        own = area[marker.byte % 2 :][: marker.size]
        yield f"{marker.name} {_value(marker, own) if len(own) == marker.size else '(a part)'}"
    if not found:
        yield f"{f'%MW{address - FIRST}' if address >= FIRST else address} {data[:2].hex().upper()}h"


def _value(marker: Marker, data: bytes) -> str:
    if marker.bit >= 0:
        return "on" if data[0] >> marker.bit & 1 else "off"
    form = FORMS.get(marker.type, OF_SIZE[marker.size])
    (number,) = struct.unpack("<" + (form if struct.calcsize(form) == marker.size else OF_SIZE[marker.size]), data)
    value: float = float(f"{number:.7g}") if form == "f" else number
    return show_number(value) + UNITS.get(marker.type, "")
