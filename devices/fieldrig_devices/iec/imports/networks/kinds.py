"""Types of what flows through wires, by the declarations of the project; a hidden variable needs one.

Only fan-outs of function results, results of blocks with EN, and loops need such a variable.  Where no declaration
says the type, the import asks for a variable at the wire.
"""

from collections.abc import Mapping, Sequence
from copy import copy
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import standard
from fieldrig_devices.iec.check.constants import narrowed
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.elementary import ALIASES, LONG_ALIASES, Elementary
from fieldrig_devices.iec.imports.networks import functions
from fieldrig_devices.iec.imports.networks.declarations import BOOL, Declarations
from fieldrig_devices.iec.imports.networks.graph import Item, Kind, Pin
from fieldrig_devices.iec.imports.networks.results import Results, result_by_name, type_of
from fieldrig_devices.iec.program import Expression
from fieldrig_devices.iec.types import EnumType, StringType, StructType, Type

_ELEMENTARY: Final[Mapping[str, Elementary]] = {
    **{kind.name: kind for kind in Elementary},
    **ALIASES,
    **LONG_ALIASES,
}


class Kinds(Declarations):
    """The types of the expressions of a POU, by the declarations that it sees."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__(dialect)
        self.narrow: dict[str, tree.TypeSpec] = {}
        """The smaller types of the results that hidden variables hold with 32 bits."""
        self._results = Results(dialect)
        self._stand_ins: dict[str, tuple[Type, tree.TypeSpec]] = {}
        """Stand-ins for the types that the file declares."""

    def of_pou(self, name: str, blocks: Sequence[tree.Variables], result: tree.TypeSpec | None) -> "Kinds":
        """Return what a POU sees: its own variables hide those of the file."""
        own = {v.name.casefold(): v.type for block in blocks for v in block.variables}
        if result is not None:
            own[name.casefold()] = result
        kinds = copy(self)
        kinds.variables = {**self.variables, **own}
        kinds.narrow = {}
        return kinds

    # ---- types

    def of(self, expression: tree.Expression | None, wanted: tree.TypeSpec | None = None) -> tree.TypeSpec | None:
        """Return the type of an expression; a literal has the type that is wanted."""
        value = self.value(expression, wanted)
        return self.spec(type_of(value, self.type(wanted))) if value is not None else self.declared(expression)

    def type(self, spec: tree.TypeSpec | None) -> Type | None:
        """Return the type that a specification means; a stand-in for one that the file declares."""
        resolved = self.resolved(spec)
        match resolved:
            case tree.NamedType(name) if name.upper() in _ELEMENTARY:
                kind = _ELEMENTARY[name.upper()]
                return self.dialect.durations.get(kind, kind)
            case tree.StringSpec(tree.Literal(value=int() as length), is_wide):
                return StringType(length, is_wide)
            case tree.StringSpec(is_wide=is_wide):
                return StringType(is_wide=is_wide)
            case tree.SubrangeSpec(base):
                return self.type(base)
        if spec is None or resolved is None:
            return None
        name = spec.name.casefold() if isinstance(spec, tree.NamedType) else f"{id(resolved)}"
        new: Type = EnumType(name) if isinstance(resolved, tree.EnumSpec) else StructType(name)
        return self._stand_ins.setdefault(name, (new, spec))[0]

    def spec(self, kind: Type) -> tree.TypeSpec | None:
        """Return how a type is written in a declaration; None for one that the file does not declare."""
        if isinstance(kind, Elementary):
            return tree.NamedType(str(kind))
        if isinstance(kind, StringType):
            length = tree.Literal(tree.LiteralKind.INTEGER, kind.length, str(kind.length))
            return tree.StringSpec(None if kind == StringType(is_wide=kind.is_wide) else length, kind.is_wide)
        return next((spec for known, spec in self._stand_ins.values() if known is kind), None)

    # ---- expressions

    def value(self, expression: tree.Expression | None, wanted: tree.TypeSpec | None = None) -> Expression | None:
        """Return a value of the type that the expression has; None for a type that is declared nowhere.

        What is wanted counts inside too, as in a text: for `x := AND(ABS(7), a)`, ABS(7) has the type of x.
        """
        match expression:
            case tree.Literal(type_name="") as literal:
                return self._results.of_literal(literal)
            case tree.Unary(sign, operand):
                kind = self.value(operand, wanted)
                return self._results.unary(sign, kind) if kind is not None else None
            case tree.Binary(sign, left, right):
                first, second = self.value(left, wanted), self.value(right, wanted)
                if first is None or second is None:
                    return self.value_of(BOOL) if sign in functions.COMPARISONS else first or second
                return self._results.binary(sign, first, second, self.type(wanted))
            case tree.Call(tree.Name(name), arguments) if self.pou(name) is None:
                given = [
                    self.value(argument.value, self._wanted_inside(name, wanted, position))
                    for position, argument in enumerate(arguments)
                    if not argument.is_output
                ]
                known = [value for value in given if value is not None]
                if len(known) == len(given):
                    return self.result(name, known, wanted)
        kind = self.value_of(self.declared(expression))
        narrow = self.narrow.get(expression.text.casefold()) if isinstance(expression, tree.Name) else None
        cut_to = self.type(narrow)
        return kind if kind is None or cut_to is None else narrowed(kind, cut_to)

    def _wanted_inside(self, name: str, wanted: tree.TypeSpec | None, position: int) -> tree.TypeSpec | None:
        inner = standard.wanted_inside(name.upper(), self.type(wanted), position)
        return self.spec(inner) if inner is not None else None

    def value_of(self, spec: tree.TypeSpec | None) -> Expression | None:
        kind = self.type(spec)
        return self._results.of_type(kind) if kind is not None else None

    def result(self, name: str, values: Sequence[Expression], wanted: tree.TypeSpec | None = None) -> Expression | None:
        """Return the result of a function or of the operator of a block with these arguments."""
        operator = functions.OPERATORS.get(name.casefold())
        if operator is None:
            known = self.of_function(name)
            return self.value_of(known) if known is not None else self._results.call(name, values, self.type(wanted))
        kind = values[0] if values else None
        if operator in functions.COMPARISONS:
            return self.value_of(BOOL)
        for value in values[1:]:
            kind = self._results.binary(operator, kind, value) if kind is not None else None
        return kind

    def declared(self, expression: tree.Expression | None) -> tree.TypeSpec | None:
        kind = super().declared(expression)
        if kind is None and isinstance(expression, tree.Call) and isinstance(expression.called, tree.Name):
            return self.of_standard(expression.called.text)
        return kind

    def of_standard(self, name: str) -> tree.TypeSpec | None:
        """Return the type that the name of a standard function says, if its arguments are not known."""
        kind = result_by_name(name)
        return self.spec(kind) if kind is not None else None


def consumer_type(kinds: Kinds, item: Item, pin: Pin, operand: tree.Expression | None) -> tree.TypeSpec | None:
    """The type that the consumer of a wire wants."""
    if item.kind in (Kind.SINK, Kind.THROUGH):
        return kinds.of(operand)
    if item.kind is Kind.BLOCK:
        return kinds.parameter(item.text, pin.name)
    return BOOL if item.kind in (Kind.COIL, Kind.CONTACT, Kind.JUMP, Kind.RETURN) else None
