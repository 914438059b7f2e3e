"""Formulas: expressions that the run time evaluates by itself, with what they depend on.

They are the conditions of waits, events, exceptions and actions, boolean equations, and the parts of [all+] and [all*].
A formula is evaluated again when something that it depends on has changed.  One that depends on a COMMON variable, on a
real answer or on a parameter is polled, because these produce no events (PAML-225, G-19), and so is one that needs an
answer over the ring.  In the plain form (`CHANGES`) all of them are polled: a program that waits is served in each of
its cycles.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Protocol

from fieldrig.shortcuts import Shortcut
from fieldrig_devices.pam.language.functions import INQUIRIES, MATHEMATICS, Type
from fieldrig_devices.pam.language.tree import Expression, Inquiry, ParameterOf, Place, Reduction, Reference
from fieldrig_devices.pam.runtime.layout import Layout
from fieldrig_devices.pam.runtime.lower.uses import PENDING
from fieldrig_devices.pam.runtime.walk import nodes

CHANGES: Final = Shortcut(
    "pam.formulas.changes", "a condition of a PAM is evaluated, and its program served, when something has changed"
)


@dataclass(frozen=True, slots=True)
class CellRange:
    """Cells that a formula reads: those of all items, or that of the present one."""

    first: int
    count: int
    is_present: bool

    def of(self, item: int) -> range:
        """Return the cells that the formula reads for an item."""
        return (
            range(self.first + item, self.first + item + 1)
            if self.is_present
            else range(self.first, self.first + self.count)
        )


@dataclass(frozen=True, slots=True)
class Formula:
    number: int
    place: Place
    type: Type
    cells: tuple[CellRange, ...]
    objects: tuple[str, ...]
    """Objects that report their changes to the run time."""
    is_polled: bool
    is_polled_as_event: bool
    """The same without COMMON variables, for the reading in which these never cause an event."""

    @property
    def function(self) -> str:
        return f"formula_{self.number}"


class Kinds(Protocol):
    layout: Layout

    def kind(self, name: str) -> str: ...


@dataclass(slots=True)
class Formulas:
    """All formulas of an application, and their Python text."""

    table: list[Formula] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)

    def add(self, expression: Expression, lines: Sequence[str], value_type: Type, kinds: Kinds) -> Formula:
        cells, objects, asks, has_common = _dependencies(expression, kinds)
        asks = asks or not CHANGES.is_taken
        formula = Formula(len(self.table), expression.place, value_type, cells, objects, asks or has_common, asks)
        self.table.append(formula)
        self.texts.append("".join([f"def {formula.function}(base):\n", *(f"    {line}\n" for line in lines)]))
        return formula

    @property
    def source(self) -> str:
        return "".join(self.texts)


def _dependencies(expression: Expression, kinds: Kinds) -> tuple[tuple[CellRange, ...], tuple[str, ...], bool, bool]:
    """Return the cells and objects, and whether there are answers to ask for and COMMON variables to look at."""
    cells: dict[CellRange, None] = {}
    objects: dict[str, None] = {}
    asks = has_common = False
    reduced = {id(inner) for node in nodes(expression) if isinstance(node, Reduction) for inner in nodes(node.operand)}
    for node in nodes(expression):
        match node:
            case ParameterOf():
                asks = True
            case Inquiry(subject=Reference(name=name), function=function) if function not in MATHEMATICS:
                forms = INQUIRIES[kinds.kind(name)][function]
                asks |= (kinds.kind(name), function) in PENDING or any(form.answer == "real" for form in forms)
                objects[name] = None
            case Reference(name=name, index=index):
                variable = kinds.layout.cells.get(name)
                if variable is None:
                    asks |= kinds.kind(name) == "ENCODER"
                    objects[name] = None
                elif variable.is_common:
                    has_common = True
                else:
                    is_present = index == "i" and id(node) not in reduced
                    cells[CellRange(variable.first, variable.count, is_present)] = None
    return tuple(cells), tuple(objects), asks, has_common
