"""Types of what flows through wires, as far as one file declares them; a hidden variable needs one.

Only fan-outs of function results, results of blocks with EN, and loops need such a variable.  Where the file does not
say the type, the import asks for a variable at the wire.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.networks import functions
from fieldrig_devices.iec.imports.networks.graph import Item, Kind, Pin

BOOL = tree.NamedType("BOOL")


@dataclass(slots=True)
class Kinds:
    """The declarations that a POU sees in its own file."""

    variables: dict[str, tree.TypeSpec] = field(default_factory=dict)
    pous: dict[str, tree.Pou] = field(default_factory=dict)
    types: dict[str, tree.TypeSpec] = field(default_factory=dict)

    def of_pou(self, name: str, blocks: Sequence[tree.Variables], result: tree.TypeSpec | None) -> "Kinds":
        """Return what a POU sees: its own variables hide those of the file."""
        own = {v.name.casefold(): v.type for block in blocks for v in block.variables}
        if result is not None:
            own[name.casefold()] = result
        return Kinds({**self.variables, **own}, self.pous, self.types)

    def of(self, expression: tree.Expression | None) -> tree.TypeSpec | None:
        match expression:
            case tree.Literal():
                return _of_literal(expression)
            case tree.Name(text):
                return self.variables.get(text.casefold())
            case tree.Member(of, name):
                return self._member(self.of(of), name)
            case tree.Index(of, indices):
                return self._element(self.of(of), len(indices))
            case tree.BitOf(size=""):
                return BOOL
            case tree.Unary("NOT", operand) | tree.Unary(_, operand):
                return self.of(operand)
            case tree.Binary(operator, left, right):
                return BOOL if operator in functions.COMPARISONS else functions.wider(self.of(left), self.of(right))
            case tree.Direct(size="X" | "", numbers=_):
                return BOOL
            case tree.Call(tree.Name(text), arguments):
                return self.of_function(text) or self._of_arguments(arguments)
        return None

    def of_function(self, name: str) -> tree.TypeSpec | None:
        known = self.pous.get(name.casefold())
        return known.result if known else functions.result_of(name)

    def parameter(self, pou: str, pin: str) -> tree.TypeSpec | None:
        """The type of a pin of a POU of this file, or of a standard block."""
        known = self.pous.get(pou.casefold())
        if known is None:
            return functions.output_of(pou, pin)
        found = (v for block in known.blocks for v in block.variables if v.name.casefold() == pin.casefold())
        return next((variable.type for variable in found), None)

    def _of_arguments(self, arguments: Sequence[tree.Argument]) -> tree.TypeSpec | None:
        result: tree.TypeSpec | None = None
        for argument in arguments:
            if not argument.is_output:
                result = functions.wider(result, self.of(argument.value))
        return result

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


def _of_literal(literal: tree.Literal) -> tree.TypeSpec | None:
    if literal.type_name:
        return tree.NamedType(literal.type_name)
    match literal.kind:
        case tree.LiteralKind.STRING:
            return tree.StringSpec()
        case tree.LiteralKind.WSTRING:
            return tree.StringSpec(is_wide=True)
        case tree.LiteralKind.INTEGER:
            return tree.NamedType("INT" if -32768 <= int(literal.value) <= 32767 else "DINT")
        case tree.LiteralKind.REAL:
            return tree.NamedType("REAL")
        case kind:
            return tree.NamedType(kind.name)


def consumer_type(kinds: Kinds, item: Item, pin: Pin, operand: tree.Expression | None) -> tree.TypeSpec | None:
    """The type that the consumer of a wire wants."""
    if item.kind in (Kind.SINK, Kind.THROUGH):
        return kinds.of(operand)
    if item.kind is Kind.BLOCK:
        return kinds.parameter(item.text, pin.name)
    return BOOL if item.kind in (Kind.COIL, Kind.CONTACT, Kind.JUMP, Kind.RETURN) else None
