"""The types of IEC 61131-3 as a controller of the PacDrive family has them: sizes, and places in memory.

Source: PacDrive manual 640 to 951 and 2564 to 2745 (digest 2.2).  Sizes are in bytes; components follow one another
without gaps, which is our choice because the manual only gives SIZEOF of arrays.  Memory (`layout.py`) has a cell for
each byte, and a value is in the cell of its first byte.
"""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from fieldrig_devices.iec.elementary import Elementary

if TYPE_CHECKING:
    from fieldrig_devices.iec.program import Pou, Variable

STRING_LENGTH: Final = 80
"""Length of a STRING that does not give one (PD-322)."""


@dataclass(frozen=True, slots=True)
class StringType:
    """A STRING of at most `length` characters of Latin-1, or a WSTRING; its memory has a closing zero."""

    length: int = STRING_LENGTH
    is_wide: bool = False
    """True for a WSTRING, whose characters are those of Unicode with 16 bits."""

    @property
    def size(self) -> int:
        return (self.length + 1) * (2 if self.is_wide else 1)

    @property
    def name(self) -> str:
        return "WSTRING" if self.is_wide else "STRING"

    def __str__(self) -> str:
        return self.name if self.length == STRING_LENGTH else f"{self.name}({self.length})"


@dataclass(frozen=True, slots=True)
class ArrayType:
    """One dimension; an array of several dimensions is an array of arrays, the last index next to each other."""

    low: int
    high: int
    element: "Type"

    @property
    def count(self) -> int:
        return self.high - self.low + 1

    @property
    def size(self) -> int:
        return self.count * self.element.size

    def __str__(self) -> str:
        return f"ARRAY[{self.low}..{self.high}] OF {self.element}"


@dataclass(frozen=True, slots=True)
class OpenArrayType:
    """ARRAY[*]: one dimension of an array whose limits are those of the argument.  Its variable is a reference."""

    element: "Type"
    limits: "tuple[Variable, Variable]" = field(compare=False, repr=False)
    """The hidden variables with the lowest and the highest index."""
    size: int = 0

    def __str__(self) -> str:
        return f"ARRAY[*] OF {self.element}"


@dataclass(slots=True, eq=False)
class Field:
    name: str
    type: "Type"
    offset: int = 0
    initial: "InitialValue | None" = None
    comment: str = ""
    bit: int = -1
    """The number of the bit in the byte at `offset`; -1 for a component that is no BIT."""
    bits: "tuple[Field, ...]" = ()
    """The BITs in a byte that stands for them where values are stored."""


@dataclass(slots=True, eq=False)
class StructType:
    """A structure.  Two structures are the same type only if they are the same declaration."""

    name: str
    fields: dict[str, Field] = field(default_factory=dict)
    """Keyed by the name in small letters."""
    size: int = 0
    is_union: bool = False
    """True if all components are at the same address, where the largest one has its value."""
    above: tuple[str, ...] = ()
    """The structures that it extends, in small letters; it begins with the components of each of them."""

    @property
    def stored_fields(self) -> "list[Field]":
        """The components that have cells of their own: of a union the first of the largest ones."""
        fields = [_stored(self, field) for field in self.fields.values() if field.bit <= 0 or self.is_union]
        return [max(fields, key=lambda field: field.type.size)] if self.is_union and fields else fields

    def __str__(self) -> str:
        return self.name


def _stored(kind: StructType, field: Field) -> Field:
    """Return a component, or the byte with it and the BITs behind it."""
    if field.bit < 0:
        return field
    bits = tuple(other for other in kind.fields.values() if other.bit >= 0 and other.offset == field.offset)
    return Field(field.name, Elementary.BYTE, field.offset, bits=bits)


MOST_RANGES: Final = 100
"""In an enumeration of more values, only the first and the last are compared with a number."""


@dataclass(slots=True, eq=False)
class EnumType:
    """An enumeration, stored as an INT unless edition 3 gives it another integer type."""

    name: str
    values: dict[str, int] = field(default_factory=dict)
    """Numbers by the names as they were declared."""
    base: Elementary = Elementary.INT
    is_closed: bool = False
    """True if a number between two values is a fault at run time, like one outside of all."""
    takes_any: bool = False
    """True if it takes every number of the base type: as an input of a library's block, and in CODESYS."""
    is_strict: bool = field(default=False, compare=False)
    """True with the attribute 'strict': it takes its own values and their numbers alone, and computes with none."""

    @property
    def size(self) -> int:
        return self.base.size

    @property
    def ranges(self) -> list[tuple[int, int]]:
        """The ranges of the numbers that a variable may have, the lowest first."""
        if self.takes_any:
            return [(int(self.base.low), int(self.base.high))]
        numbers = sorted(self.values.values())
        if not self.is_closed or len(numbers) > MOST_RANGES:
            return [(numbers[0], numbers[-1])]
        runs: list[tuple[int, int]] = []
        for number in numbers:
            if runs and number <= runs[-1][1] + 1:
                runs[-1] = (runs[-1][0], number)
            else:
                runs.append((number, number))
        return runs

    def as_input(self) -> "EnumType":
        """Return the same enumeration as an input of a library's block, once its numbers are known."""
        return replace(self, takes_any=True)

    def __str__(self) -> str:
        return self.name or f"({', '.join(self.values)})"


@dataclass(frozen=True, slots=True)
class SubrangeType:
    """A part of an integer type; values outside are a fault at run time (PD-359 for enumerations) or taken there."""

    base: Elementary
    low: int
    high: int
    takes_any: bool = False
    """True if at run time it takes every number of the base type, as in CODESYS."""

    @property
    def size(self) -> int:
        return self.base.size

    @property
    def ranges(self) -> list[tuple[int, int]]:
        """The range of the numbers that a variable may have at run time."""
        return [(int(self.base.low), int(self.base.high)) if self.takes_any else (self.low, self.high)]

    def __str__(self) -> str:
        return f"{self.base}({self.low}..{self.high})"


@dataclass(frozen=True, slots=True)
class PointerType:
    """A POINTER TO: the address of a cell, as a DWORD; 0 points to nothing."""

    to: "Type"
    is_reference: bool = False
    """True for a REFERENCE TO, whose name means what it refers to."""
    size: int = 4

    def __str__(self) -> str:
        return f"{'REFERENCE' if self.is_reference else 'POINTER'} TO {self.to}"


@dataclass(frozen=True, slots=True)
class InterfaceType(PointerType):
    """An INTERFACE: the address of an instance that has its methods; 0 is none.

    `to` is a block with the dispatchers of the methods.
    """

    def __str__(self) -> str:
        return str(self.to)


@dataclass(slots=True, eq=False)
class BlockType:
    """A function block or a program, as the type of its instances."""

    name: str
    pou: "Pou | None" = None
    size: int = 0
    open: "BlockType | None" = None
    """The type that instances of this block and of all that extend it have in common; None if nothing extends it."""

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class ObjectType:
    """A configuration object such as MC_4 or D_IN, always passed by reference: its logical address (PD-023)."""

    name: str
    parameters: "tuple[ObjectParameter, ...]" = ()
    size: int = 4

    def parameter(self, name: str) -> "ObjectParameter | None":
        return next((known for known in self.parameters if known.name.casefold() == name.casefold()), None)

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class ObjectParameter:
    """A parameter of a kind of object.  `number` is the part of its logical address within the object."""

    name: str
    number: int
    type: "Elementary | StringType"
    is_writable: bool = False
    is_slow: bool = False
    """True if reading and writing goes through SERCOS and holds the task up (PD-028)."""


Type = (
    Elementary
    | StringType
    | ArrayType
    | OpenArrayType
    | StructType
    | EnumType
    | SubrangeType
    | PointerType
    | BlockType
    | ObjectType
)
SCALAR: Final = (Elementary, StringType, EnumType, SubrangeType)
"""The types whose values are in one cell."""
Value = bool | int | float | str
InitialValue = Value | list["InitialValue"] | dict[str, "InitialValue"]
"""The start value of a variable: a list for an array, fields by small-letter name for a structure or an instance."""
