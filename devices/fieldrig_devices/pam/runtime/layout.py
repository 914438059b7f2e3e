"""The places of the variables of an application, and the number of items of each object.

All variables and the values of boolean equations are cells of one list.  An item of an object with several items is the
first cell plus the number of the item, from 0.  Behind them are the formal parameters of the routines that run.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

from fieldrig_devices.pam.language.check.symbols import ITEMS_FROM
from fieldrig_devices.pam.language.functions import VALUES, Type
from fieldrig_devices.pam.language.items import (
    Actions,
    BooleanEquation,
    Declaration,
    Parameter,
    Program,
    Sequence,
    Task,
)
from fieldrig_devices.pam.language.tree import Node, Number, Reference
from fieldrig_devices.pam.runtime.item import Value
from fieldrig_devices.pam.runtime.walk import nodes

VARIABLES: Final = ("FLAG_VAR", "WORD_VAR", "REAL_VAR")
START: Final[Mapping[Type, Value]] = {"flag": False, "integer": 0, "real": 0.0}
"""Values of variables after power-on (G-13)."""


@dataclass(frozen=True, slots=True)
class Cells:
    """The cells of a variable or of an equation."""

    name: str
    first: int
    count: int
    type: Type
    is_common: bool
    """True for a COMMON variable, which produces no events (PAML-225)."""
    is_multiple: bool = False
    is_equation: bool = False


@dataclass(slots=True)
class Layout:
    counts: dict[str, int] = field(default_factory=dict)
    """Items of each object, task, equation and group of actions."""
    groups: dict[str, str] = field(default_factory=dict)
    """The NODES_GROUP of each object that has one, by which it has its items."""
    kinds: dict[str, str] = field(default_factory=dict)
    """The kinds of all objects, without INTERNAL and COMMON."""
    cells: dict[str, Cells] = field(default_factory=dict)
    size: int = 0
    """Number of cells without the formal parameters."""

    def start_values(self) -> Iterator[Value]:
        for cells in self.cells.values():
            yield from (START[cells.type] for _ in range(cells.count))


def layout_of(program: Program) -> Layout:
    """Return the layout of a checked application."""
    layout = Layout()
    for item in program.items:
        match item:
            case Declaration():
                _declare(item, layout)
            case BooleanEquation():
                _count(item.name, (), item.equation if item.is_multiple else None, layout)
                layout.kinds[item.name] = "BOOLEAN"
                _add_cells(item.name, "flag", item.is_multiple, layout, is_equation=True)
            case Actions():
                _count(item.name, item.specs, None, layout)
                layout.kinds[item.name] = "ACTIONS"
            case Task():
                is_multiple = any(sequence.is_multiple for sequence in item.sequences)
                _count(item.name, item.specs, item if is_multiple else None, layout)
                layout.kinds[item.name] = "TASK"
    return layout


def number_of(parameters: tuple[Parameter, ...], name: str) -> int | None:
    """Return the value of a parameter that is a whole number; None if it is not there."""
    for parameter in parameters:
        if parameter.name == name and isinstance(value := parameter.values[0], Number):
            return int(value.value)
    return None


def reference_of(parameters: tuple[Parameter, ...], name: str) -> str | None:
    """Return the name of the object that a parameter refers to; None if it is not there."""
    for parameter in parameters:
        if parameter.name == name and isinstance(value := parameter.values[0], Reference):
            return value.name
    return None


def _declare(item: Declaration, layout: Layout) -> None:
    scope, _, object_class = item.kind.rpartition(" ")
    layout.kinds[item.name] = object_class
    if object_class == "NODES_GROUP":
        layout.counts[item.name] = number_of(item.parameters, "NUMBER") or 1
        layout.groups[item.name] = item.name
        return
    _count(item.name, item.parameters, None, layout)
    if object_class in VARIABLES and scope in ("INTERNAL", "COMMON"):
        is_multiple = any(parameter.name in ("NUMBER", "NODES_GROUP") for parameter in item.parameters)
        _add_cells(item.name, VALUES[object_class], is_multiple, layout, is_common=scope == "COMMON")
    for part in item.parts:
        _declare(part, layout)


def _add_cells(
    name: str,
    value_type: Type,
    is_multiple: bool,
    layout: Layout,
    *,
    is_common: bool = False,
    is_equation: bool = False,
) -> None:
    count = layout.counts[name]
    layout.cells[name] = Cells(name, layout.size, count, value_type, is_common, is_multiple, is_equation)
    layout.size += count


def _count(name: str, parameters: tuple[Parameter, ...], uses: Node | None, layout: Layout) -> None:
    """Find the number of items of an object: its own, that of its group or node, or that of what it uses with [i]."""
    if (number := number_of(parameters, "NUMBER")) is not None:
        layout.counts[name] = number
        return
    owners = [reference_of(parameters, parameter) for parameter in ("NODES_GROUP", *ITEMS_FROM)]
    if uses is not None:
        owners += [node.name for node in nodes(uses) if isinstance(node, Reference) and node.index == "i"]
    owner = next((owner for owner in owners if owner in layout.counts), None)
    layout.counts[name] = 1 if owner is None else layout.counts[owner]
    if owner in layout.groups:
        layout.groups[name] = layout.groups[owner]


def is_per_item(sequence: Sequence | tuple[Node, ...]) -> bool:
    """True if statements use the present item, [i]."""
    body = sequence.body if isinstance(sequence, Sequence) else sequence
    return any(getattr(node, "index", None) == "i" or getattr(node, "is_indexed", False) for node in nodes(*body))
