"""Types of what flows through wires, as far as one file declares them; a hidden variable needs one.

Only fan-outs of function results, results of blocks with EN, and loops need such a variable.  Where the file does not
say the type, the import asks for a variable at the wire.
"""

from collections.abc import Mapping, Sequence
from copy import copy
from functools import cache
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import calls
from fieldrig_devices.iec.check.constants import narrowed
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.elementary import ALIASES, LONG_ALIASES, Elementary
from fieldrig_devices.iec.imports.networks import functions
from fieldrig_devices.iec.imports.networks.graph import Item, Kind, Pin
from fieldrig_devices.iec.imports.networks.results import Results, result_by_name, type_of
from fieldrig_devices.iec.library.sources import parsed, sources
from fieldrig_devices.iec.program import Expression
from fieldrig_devices.iec.types import EnumType, StringType, StructType, Type

BOOL = tree.NamedType("BOOL")
_ELEMENTARY: Final[Mapping[str, Elementary]] = {**{str(kind): kind for kind in Elementary}, **ALIASES, **LONG_ALIASES}


@cache
def library_pous(dialect: Dialect) -> Mapping[str, tree.Pou]:
    """Return the functions and blocks of the libraries of the dialect, by their names in small letters."""
    units = [parsed(text, name, dialect) for name, text in sources(dialect.name)]
    found = (node for unit in units for node in unit.declarations if isinstance(node, tree.Pou))
    return {pou.name.casefold(): pou for pou in found}


class Kinds:
    """The declarations that a POU sees in its own file, and those of the libraries."""

    def __init__(self, dialect: Dialect) -> None:
        self.dialect = dialect
        self.variables: dict[str, tree.TypeSpec] = {}
        self.narrow: dict[str, tree.TypeSpec] = {}
        """The smaller types of the results that hidden variables hold with 32 bits."""
        self.pous: dict[str, tree.Pou] = {}
        self.types: dict[str, tree.TypeSpec] = {}
        self._results = Results(dialect)
        self._named: dict[str, tuple[Type, tree.TypeSpec]] = {}
        """Stand-ins for the types that the file declares."""

    def of_pou(self, name: str, blocks: Sequence[tree.Variables], result: tree.TypeSpec | None) -> "Kinds":
        """Return what a POU sees: its own variables hide those of the file."""
        own = {v.name.casefold(): v.type for block in blocks for v in block.variables}
        if result is not None:
            own[name.casefold()] = result
        found = copy(self)
        found.variables = {**self.variables, **own}
        found.narrow = {}
        return found

    # ---- types

    def of(self, expression: tree.Expression | None, wanted: tree.TypeSpec | None = None) -> tree.TypeSpec | None:
        """Return the type of an expression; a literal has the type that is wanted."""
        value = self.value(expression, wanted)
        return self.spec(type_of(value, self.type(wanted))) if value is not None else self._declared(expression)

    def type(self, spec: tree.TypeSpec | None) -> Type | None:
        """Return the type that a specification means; a stand-in for one that the file declares."""
        resolved = self._resolved(spec)
        match resolved:
            case tree.NamedType(name) if name.upper() in _ELEMENTARY:
                kind = _ELEMENTARY[name.upper()]
                return self.dialect.time if kind is Elementary.TIME else kind
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
        return self._named.setdefault(name, (new, spec))[0]

    def spec(self, kind: Type) -> tree.TypeSpec | None:
        """Return how a type is written in a declaration; None for one that the file does not declare."""
        if isinstance(kind, Elementary):
            return tree.NamedType(str(kind))
        if isinstance(kind, StringType):
            length = tree.Literal(tree.LiteralKind.INTEGER, kind.length, str(kind.length))
            return tree.StringSpec(None if kind == StringType(is_wide=kind.is_wide) else length, kind.is_wide)
        return next((spec for known, spec in self._named.values() if known is kind), None)

    # ---- expressions

    def value(self, expression: tree.Expression | None, wanted: tree.TypeSpec | None = None) -> Expression | None:
        """Return a value of the type that the expression has; None for a type that is declared nowhere.

        What is wanted counts inside too, as in a text: for `x := AND(ABS(7), a)`, ABS(7) has the type of x.
        """
        match expression:
            case tree.Literal(type_name="") as literal:
                return self._results.of_literal(literal)
            case tree.Unary(sign, operand):
                found = self.value(operand, wanted)
                return self._results.unary(sign, found) if found is not None else None
            case tree.Binary(sign, left, right):
                first, second = self.value(left, wanted), self.value(right, wanted)
                if first is None or second is None:
                    return self.value_of(BOOL) if sign in functions.COMPARISONS else first or second
                return self._results.binary(sign, first, second, self.type(wanted))
            case tree.Call(tree.Name(name), arguments) if self._pou(name) is None:
                inner = self._wanted_inside(name, wanted)
                given = [self.value(argument.value, inner) for argument in arguments if not argument.is_output]
                known = [value for value in given if value is not None]
                if len(known) == len(given):
                    return self.result(name, known, wanted)
        found = self.value_of(self._declared(expression))
        narrow = self.narrow.get(expression.text.casefold()) if isinstance(expression, tree.Name) else None
        cut_to = self.type(narrow)
        return found if found is None or cut_to is None else narrowed(found, cut_to)

    def _wanted_inside(self, name: str, wanted: tree.TypeSpec | None) -> tree.TypeSpec | None:
        inner = calls.wanted_inside(name.upper(), self.type(wanted))
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
        found = values[0] if values else None
        if operator in functions.COMPARISONS:
            return self.value_of(BOOL)
        for value in values[1:]:
            found = self._results.binary(operator, found, value) if found is not None else None
        return found

    def _declared(self, expression: tree.Expression | None) -> tree.TypeSpec | None:
        """Return the type that a declaration gives to a variable, a part of it, or a function."""
        match expression:
            case tree.Literal(type_name=name) if name:
                return tree.NamedType(name)
            case tree.Name(text):
                return self.variables.get(text.casefold())
            case tree.Member(of, name):
                return self._member(self._declared(of), name)
            case tree.Index(of, indices):
                return self._element(self._declared(of), len(indices))
            case tree.BitOf(size="") | tree.Direct(size="X" | ""):
                return BOOL
            case tree.Direct(size=size):
                return tree.NamedType({"B": "BYTE", "W": "WORD", "D": "DWORD", "L": "LWORD"}[size])
            case tree.Call(tree.Name(text)):
                return self.of_function(text) or self.of_standard(text)
        return None

    # ---- POUs

    def _pou(self, name: str) -> tree.Pou | None:
        key = name.casefold()
        return self.pous.get(key) or library_pous(self.dialect).get(key)

    def is_library_block(self, name: str) -> bool:
        return name.casefold() not in self.pous and name.casefold() in library_pous(self.dialect)

    def of_function(self, name: str) -> tree.TypeSpec | None:
        """Return the type of the result if it does not depend on the arguments."""
        known = self._pou(name)
        return known.result if known is not None else functions.result_of(name)

    def of_standard(self, name: str) -> tree.TypeSpec | None:
        """Return the type that the name of a standard function says, if its arguments are not known."""
        kind = result_by_name(name)
        return self.spec(kind) if kind is not None else None

    def parameter(self, pou: str, pin: str) -> tree.TypeSpec | None:
        """The type of a pin of a POU of this file, or of a library."""
        known = self._pou(pou)
        if known is None:
            return None
        found = (v for block in known.blocks for v in block.variables if v.name.casefold() == pin.casefold())
        return next((variable.type for variable in found), None)

    def _resolved(self, spec: tree.TypeSpec | None) -> tree.TypeSpec | None:
        seen = set[str]()
        while isinstance(spec, tree.NamedType) and spec.name.casefold() in self.types and spec.name not in seen:
            seen.add(spec.name)
            spec = self.types[spec.name.casefold()]
        return spec

    def _member(self, spec: tree.TypeSpec | None, name: str) -> tree.TypeSpec | None:
        resolved = self._resolved(spec)
        if isinstance(resolved, tree.StructSpec):
            return next((f.type for f in resolved.fields if f.name.casefold() == name.casefold()), None)
        return self.parameter(resolved.name, name) if isinstance(resolved, tree.NamedType) else None

    def _element(self, spec: tree.TypeSpec | None, indices: int) -> tree.TypeSpec | None:
        resolved = self._resolved(spec)
        if not isinstance(resolved, tree.ArraySpec | tree.OpenArraySpec):
            return None
        count = len(resolved.dimensions) if isinstance(resolved, tree.ArraySpec) else resolved.count
        if indices < count:
            return None
        left = indices - count
        return self._element(resolved.element, left) if left else resolved.element


def consumer_type(kinds: Kinds, item: Item, pin: Pin, operand: tree.Expression | None) -> tree.TypeSpec | None:
    """The type that the consumer of a wire wants."""
    if item.kind in (Kind.SINK, Kind.THROUGH):
        return kinds.of(operand)
    if item.kind is Kind.BLOCK:
        return kinds.parameter(item.text, pin.name)
    return BOOL if item.kind in (Kind.COIL, Kind.CONTACT, Kind.JUMP, Kind.RETURN) else None
