"""The places of all variables in memory, and what they contain at first.

Memory is a list with a cell for each byte; a value is in the cell of its first byte.  From the bottom: a page that
nothing is in, so that 0 points to nothing; the addresses of %I, %Q and %M, whose contents are elsewhere; the stacks of
the tasks; and the data area with the global variables, among them all instances.

In an online change a variable of the same name and type keeps its address.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Final

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import Pou, Program, Space, Variable
from fieldrig_devices.iec.types import (
    ArrayType,
    BlockType,
    EnumType,
    ObjectType,
    PointerType,
    StringType,
    StructType,
    SubrangeType,
    Type,
)

AREA_SIZE: Final = 0x10000  # PD-314
AREAS: Final = {"I": 0x10000, "Q": 0x20000, "M": 0x30000}
"""The addresses of the areas, as ADR gives them."""
STACKS: Final = 0x40000
STACK_SIZE: Final = 10_240  # PD-317
MOST_STACKS: Final = 65  # PD-310, and one for a program that runs by itself
DATA: Final = STACKS + MOST_STACKS * STACK_SIZE
REFERENCE_SIZE: Final = 4
CALL_SIZE: Final = 20
"""Bytes on the stack for each call: return address, frame, instance, and two saved registers."""

KINDS: Final = {kind: number for number, kind in enumerate(Elementary, 1)}
"""Numbers of the elementary types in the table of kinds, which has a byte per cell.  0 is no known value."""
STRING_KIND: Final = 62
WIDE_STRING_KIND: Final = 63
INSIDE: Final = b"\xff"
"""The kind of all cells of a value but the first one."""


def storage(kind: Type) -> Elementary | StringType | None:
    """The type whose values are in a cell of this type; None for a type with several cells."""
    match kind:
        case Elementary() | StringType():
            return kind
        case EnumType(base=base) | SubrangeType(base=base):
            return base
        case PointerType():
            return Elementary.DWORD
        case ObjectType():
            return Elementary.DINT
    return None


def kind_number(kind: Elementary | StringType) -> int:
    if isinstance(kind, StringType):
        return WIDE_STRING_KIND if kind.is_wide else STRING_KIND
    return KINDS[kind]


def variable_size(variable: Variable) -> int:
    if variable.location is not None:
        return 0
    return REFERENCE_SIZE if variable.is_reference else variable.type.size


def members(kind: BlockType) -> list[Variable]:
    """The variables of an instance that have a cell."""
    variables = kind.pou.variables.values() if kind.pou is not None else ()
    return [variable for variable in variables if variable.space is Space.INSTANCE and variable.location is None]


@dataclass(slots=True)
class Slot:
    """The place of one global variable."""

    address: int
    size: int
    form: str
    """The form that a variable must have to keep the place in an online change."""


@dataclass(slots=True)
class Layout:
    slots: dict[str, Slot] = field(default_factory=dict)
    """The slots by the name of the global variable in small letters."""
    end: int = DATA

    @property
    def data_size(self) -> int:
        return sum(slot.size for slot in self.slots.values())


def place(program: Program, previous: Layout | None = None) -> Layout:
    """Set the offsets of all variables and the sizes of frames and instances."""
    for pou in program.pous.values():
        _place_locals(pou)
    forms = Forms()
    placed = [item for item in program.globals.items() if item[1].location is None]
    layout = Layout()
    for name, variable in placed:
        form = forms.of(variable.type)
        slot = previous.slots.get(name) if previous is not None else None
        if slot is not None and slot.form == form:
            layout.slots[name] = slot
    gaps = _Gaps(layout.slots.values())
    for name, variable in placed:
        if name not in layout.slots:
            layout.slots[name] = Slot(gaps.take(variable.type.size), variable.type.size, forms.of(variable.type))
        variable.offset = layout.slots[name].address
    layout.end = max([DATA, *(slot.address + slot.size for slot in layout.slots.values())])
    return layout


def _place_locals(pou: Pou) -> None:
    offset, frame = 0, 0
    if pou.result is not None:
        pou.result.offset, frame = 0, variable_size(pou.result)
    for variable in pou.variables.values():
        if variable.location is not None or variable is pou.result:
            continue
        if variable.space is Space.INSTANCE:
            variable.offset = offset
            offset += variable_size(variable)
        elif variable.space is Space.FRAME:
            variable.offset = frame
            frame += variable_size(variable)
    pou.frame_size = frame
    if pou.type is not None:
        pou.type.size = offset
    for action in pou.actions.values():
        action.frame_size = frame


class _Gaps:
    """Free places between the variables that stay where they are."""

    def __init__(self, kept: Iterable[Slot]) -> None:
        self._free: list[tuple[int, int]] = []
        self._end = DATA
        for slot in sorted(kept, key=lambda slot: slot.address):
            if slot.address > self._end:
                self._free.append((self._end, slot.address))
            self._end = max(self._end, slot.address + slot.size)

    def take(self, size: int) -> int:
        for number, (start, end) in enumerate(self._free):
            if end - start >= size:
                self._free[number] = (start + size, end)
                return start
        start, self._end = self._end, self._end + size
        return start


class Forms:
    """The forms of types as text: equal for types of two compilations that have the same cells with the same names.

    A structure or a function block has a digest of its components, as their texts, each within the other, would grow
    exponentially.
    """

    def __init__(self) -> None:
        self._known: dict[StructType | BlockType, str] = {}

    def of(self, kind: Type) -> str:
        match kind:
            case ArrayType(low=low, high=high, element=element):
                return f"[{low}..{high}]{self.of(element)}"
            case StructType() | BlockType():
                if kind not in self._known:
                    members = sha256(",".join(self._members(kind)).encode()).hexdigest()
                    self._known[kind] = f"{_union(kind)}{kind.name}{{{members}}}"
                return self._known[kind]
            case EnumType():
                return f"{kind.name}({kind.values}){kind.base}"
            case PointerType(to=to):
                return f"^{to}"
        return f"{kind}:{kind.size}"

    def _members(self, kind: StructType | BlockType) -> list[str]:
        if isinstance(kind, StructType):
            return [f"{name}:{self.of(one.type)}" for name, one in kind.fields.items()]
        return [f"{member.name.lower()}:{self._member(member)}" for member in members(kind)]

    def _member(self, member: Variable) -> str:
        """Return the form of a variable; a reference leads to another cell, which may be of this type too."""
        return f"&{member.type}" if member.is_reference else self.of(member.type)


def _union(kind: StructType | BlockType) -> str:
    return "UNION " if isinstance(kind, StructType) and kind.is_union else ""


def stack_of(task_number: int) -> int:
    """Return where the stack of a task begins."""
    return STACKS + task_number * STACK_SIZE
