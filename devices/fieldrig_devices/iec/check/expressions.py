"""Expressions: from the tree to the checked program, with explicit types and conversions.

`Expressions` is what the bodies of all languages stand on (statements.py, il.py, sfc.py).  `checker.Checker` says what
its methods promise; `constant` and `constant_as` want a value that is known at compile time.

Constants without a type of their own are `Untyped` until `convert`, `operate` or a call gives them one.  Values of
subranges and enumerations stay what they are until an operator or a conversion needs the integer behind them; that is a
`Convert`, which costs nothing.
"""

from collections.abc import Callable
from typing import Any, Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import (
    assignable,
    calls,
    check_functions,
    constants,
    operators,
    places,
    properties,
    references,
)
from fieldrig_devices.iec.check.checker import Checker, Meaning
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.project import UNKNOWN
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.check.untyped import Untyped, integer, real
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import Cell, Constant, Expression, Load, Operator, Place, Pou, Target, Variable
from fieldrig_devices.iec.tree import LiteralKind, PouKind
from fieldrig_devices.iec.types import BlockType, EnumType, ObjectType, OpenArrayType, PointerType, StringType, Type

LITERAL_TYPES: Final[dict[LiteralKind, Elementary]] = {
    LiteralKind.BOOL: Elementary.BOOL,
    LiteralKind.DATE: Elementary.DATE,
    LiteralKind.TOD: Elementary.TOD,
    LiteralKind.DT: Elementary.DT,
    LiteralKind.LTIME: Elementary.LTIME,
    LiteralKind.LDATE: Elementary.LDATE,
    LiteralKind.LTOD: Elementary.LTOD,
    LiteralKind.LDT: Elementary.LDT,
}


class Expressions:
    def __init__(self, context: Context) -> None:
        self.context = context

    # ---- expressions

    def expression(self, node: tree.Expression, wanted: Type | None = None) -> Expression | None:
        return _EXPRESSIONS[type(node)](self, node, wanted)

    def expression_as(self, node: tree.Expression, kind: Type) -> Expression | None:
        if isinstance(kind, PointerType) and kind.is_reference:
            return references.reference_to(self, node, kind)
        found = _EXPRESSIONS[type(node)](self, node, kind)
        if found is None or (found.type is kind and type(found) is not Untyped and type(kind) is not BlockType):
            return found
        return assignable.convert(self.context, found, kind, node)

    def convert(self, value: Expression, kind: Type, at: tree.Node) -> Expression | None:
        return assignable.convert(self.context, value, kind, at)

    def operate(self, operator: Operator, left: Expression, right: Expression, at: tree.Node) -> Expression | None:
        return operators.binary(self.context, operator, left, right, at)

    def negate(self, operator: Operator, operand: Expression, at: tree.Node) -> Expression | None:
        return operators.unary(self.context, operator, operand, at)

    # ---- places

    def meaning(self, node: tree.Expression) -> Meaning | None:
        return places.meaning(self, node)

    def place(self, node: tree.Expression) -> Place | None:
        found = self.meaning(node)
        if isinstance(found, Pou) and found.instance is not None:
            return Cell(found.instance, found.instance.type)
        if found is None or isinstance(found, Place):
            return None if found is None or found.type is UNKNOWN else found
        self.context.say(node, f"{text(node)} is not a variable", "a variable")
        return None

    def target(self, node: tree.Expression) -> Place | None:
        found = self.meaning(node)
        if isinstance(found, Place):
            return found if found.type is not UNKNOWN and places.is_writable(self.context, found, node) else None
        if found is not None:
            self.context.say(node, f"{text(node)} is {self._kind(found, node)}", "a variable that may be written here")
        return None

    def _kind(self, found: Constant | Pou | EnumType, node: tree.Expression) -> str:
        if isinstance(found, Pou):
            return f"a {found.kind.value}" if found.owner is None else "an action"
        if isinstance(found, Constant) and isinstance(found.type, ObjectType):
            return "a configuration object"
        named = self.context.find(node.text) if isinstance(node, tree.Name) else None
        is_value = isinstance(found, Constant) and isinstance(found.type, EnumType) and not isinstance(named, Variable)
        return "a value of an enumeration" if is_value else "a type" if isinstance(found, EnumType) else "a constant"

    # ---- constants

    def constant(self, node: tree.Expression) -> Constant | None:
        found = self.expression(node)
        made = constants.folded(found) if found is not None else None
        if made is None or isinstance(made, Constant):
            return made
        self.context.say(node, f"{text(node)} is not constant", "a value that is known at compile time")
        return None

    def constant_as(self, node: tree.Expression, kind: Type) -> Constant | None:
        found = self.expression(node)
        if found is None or not isinstance(constants.whole(found), Constant):
            found = self.constant(node)
        made = self.convert(found, kind, node) if found is not None else None
        made = constants.folded(made) if made is not None else None
        return made if isinstance(made, Constant) else None

    def constant_integer(self, node: tree.Expression) -> int | None:
        found = self.constant(node)
        if found is None:
            return None
        if isinstance(found.value, bool) or not isinstance(found.value, int) or operators.integer_of(found) is None:
            self.context.say(node, f"{text(node)} is {a(found.type)}", "an integer")
            return None
        return found.value


# ---- the kinds of trees


def _literal(checker: Checker, node: tree.Literal, wanted: Type | None) -> Expression | None:
    value = node.value
    if node.type_name:
        return _typed_literal(checker, node)
    if node.kind is LiteralKind.INTEGER:
        assert isinstance(value, int)
        return integer(value, is_pattern="#" in node.text)
    if node.kind is LiteralKind.REAL:
        assert isinstance(value, float)
        return real(value)
    if node.kind is LiteralKind.STRING:
        assert isinstance(value, str)
        return _text_constant(value)
    if node.kind is LiteralKind.WSTRING:
        assert isinstance(value, str)
        return _text_constant(value, is_wide=True)
    return Constant(value, _type_of(checker, node.kind))


def _type_of(checker: Checker, kind: LiteralKind) -> Elementary:
    return checker.context.project.dialect.time if kind is LiteralKind.TIME else LITERAL_TYPES[kind]


def _text_constant(value: str, *, is_wide: bool = False) -> Constant:
    return Constant(value, StringType(max(len(value), 1), is_wide))


def _typed_literal(checker: Checker, node: tree.Literal) -> Expression | None:
    kind = checker.context.project.types.get(checker.context.key(node.type_name))
    if kind is None:
        checker.context.say_unknown(node, node.type_name, "a declared type")
        return None
    if isinstance(node.value, str):
        given = _text_constant(node.value, is_wide=node.kind is LiteralKind.WSTRING)
    elif node.kind is LiteralKind.INTEGER:
        given = integer(int(node.value), is_pattern=node.text.count("#") > 1)
    elif node.kind is LiteralKind.REAL:
        given = real(float(node.value))
    else:
        given = Constant(node.value, _type_of(checker, node.kind))
    return checker.convert(given, kind, node)


def _named(checker: Checker, node: tree.Expression, wanted: Type | None) -> Expression | None:
    reading = properties.reading(checker, node) if checker.context.project.properties else None
    if reading is not None:
        return _call(checker, reading[0], wanted) if reading else None
    found = places.meaning(checker, node)
    if found is None or isinstance(found, Constant):
        return found
    if isinstance(found, Place):
        if isinstance(found.type, OpenArrayType):
            hint = f"choose an element: {text(node)}[...]"
            checker.context.say(
                node, f"{text(node)} is {a(found.type)} and has no value as a whole", "an element", hint
            )
            return None
        if isinstance(found, Cell) and found.variable.narrow is not None:
            return constants.narrowed(Load(found), found.variable.narrow)
        return None if found.type is UNKNOWN else Load(found)
    if isinstance(found, Pou) and found.kind is PouKind.PROGRAM and found.instance is not None:
        return Load(Cell(found.instance, found.instance.type))
    if isinstance(found, Pou) and found.owner is not None:
        checker.context.say(node, f"{found.name} is an action", "a value", f"call it as a statement: {text(node)};")
        return None
    if isinstance(found, Pou):
        hints = {PouKind.FUNCTION: f"{found.name}(...) calls it", PouKind.FUNCTION_BLOCK: f"declare x : {found.name};"}
        checker.context.say(node, f"{found.name} is {a(found.kind.value)}", "a value", hints.get(found.kind, ""))
        return None
    checker.context.say(node, f"{text(node)} is a type", "a value")
    return None


def _unary(checker: Checker, node: tree.Unary, wanted: Type | None) -> Expression | None:
    operand = checker.expression(node.operand, wanted)
    if operand is None:
        return None
    if node.operator == "+":
        return operators.positive(checker.context, operand, node)
    return operators.unary(checker.context, Operator.NEG if node.operator == "-" else Operator.NOT, operand, node)


_OPERATORS: Final = {operator.value: operator for operator in Operator}


def _binary(checker: Checker, node: tree.Binary, wanted: Type | None) -> Expression | None:
    """Check the operators of a chain from left to right."""
    chain = [node]
    first = node.left
    while isinstance(first, tree.Binary):
        chain.append(first)
        first = first.left
    found = _EXPRESSIONS[type(first)](checker, first, wanted)
    while chain:
        found = _with_right_side(checker, found, chain.pop(), wanted)
    return found


def _with_right_side(
    checker: Checker, left: Expression | None, node: tree.Binary, wanted: Type | None
) -> Expression | None:
    right = _EXPRESSIONS[type(node.right)](checker, node.right, wanted)
    if left is None or right is None:
        return None
    if node.operator == "**":
        return calls.standard(checker, "EXPT", [left, right], node, wanted)
    return operators.binary(checker.context, _OPERATORS[node.operator], left, right, node)


def _call(checker: Checker, node: tree.Call, wanted: Type | None) -> Expression | None:
    """A result that is a reference means what it refers to."""
    found = calls.value(checker, node, wanted)
    kind = found.type if found is not None and type(found) is not Untyped else None
    if found is not None and isinstance(kind, PointerType) and kind.is_reference:
        return Load(Target(check_functions.address(checker.context, found, node), kind.to))
    return found


_EXPRESSIONS: Final[dict[type, Callable[[Checker, Any, Type | None], Expression | None]]] = {
    tree.Literal: _literal,
    tree.Name: _named,
    tree.Member: _named,
    tree.BitOf: _named,
    tree.Index: _named,
    tree.Dereference: _named,
    tree.Direct: _named,
    tree.Unary: _unary,
    tree.Binary: _binary,
    tree.Call: _call,
}
