"""The methods of `Expressions` that the rules of the checker use, as a protocol.

Each rule (a call, a place, a reference, EN and ENO, and so on) checks the trees inside its own, so it calls back.  None
always means that the mistake was reported, so nothing more is said about it.
"""

from typing import Protocol

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.program import Constant, Expression, Operator, Place, Pou
from fieldrig_devices.iec.types import EnumType, Type

Meaning = Place | Constant | Pou | EnumType
"""The meaning of a name or a path."""


class Checker(Protocol):
    """`at` is the tree that messages point to."""

    @property
    def context(self) -> Context: ...

    def expression(self, node: tree.Expression, wanted: Type | None = None) -> Expression | None:
        """`wanted` is the type of the surroundings, for functions such as SQRT whose arguments are literals."""

    def expression_as(self, node: tree.Expression, kind: Type) -> Expression | None:
        """Check an expression and convert it to a type."""

    def convert(self, value: Expression, kind: Type, at: tree.Node) -> Expression | None:
        """Return a checked expression in another type."""

    def operate(self, operator: Operator, left: Expression, right: Expression, at: tree.Node) -> Expression | None:
        """Apply an operator to checked expressions."""

    def negate(self, operator: Operator, operand: Expression, at: tree.Node) -> Expression | None:
        """Apply NEG or NOT."""

    def meaning(self, node: tree.Expression) -> Meaning | None:
        """Return what a name or a path means."""

    def place(self, node: tree.Expression) -> Place | None:
        """Return a place that can be read, for VAR_IN_OUT and ADR."""

    def target(self, node: tree.Expression) -> Place | None:
        """Return a place that may be written, with messages for constants, inputs and so on."""

    def constant_integer(self, node: tree.Expression) -> int | None:
        """Return the value of a constant of any integer type."""


class Types(Protocol):
    """The declared types: `TypeSpecs`."""

    def resolve(self, spec: tree.TypeSpec, context: Context) -> Type:
        """Return the type; UNKNOWN after a message."""
