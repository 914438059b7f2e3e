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
    methods,
    operators,
    places,
    properties,
    references,
    special,
    standard,
    writing,
)
from fieldrig_devices.iec.check.checker import Checker, Meaning
from fieldrig_devices.iec.check.context import Checked, Context
from fieldrig_devices.iec.check.literal_only import divides_integers, is_real, takes_its_type_from_outside
from fieldrig_devices.iec.check.project import UNKNOWN
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.check.untyped import Untyped, integer, real
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import (
    Assigned,
    Cell,
    Constant,
    Expression,
    Load,
    Operator,
    Place,
    Pou,
    Target,
    Variable,
)
from fieldrig_devices.iec.tree import LiteralKind, PouKind
from fieldrig_devices.iec.types import BlockType, EnumType, ObjectType, OpenArrayType, PointerType, StringType, Type
from fieldrig_devices.languages.mistakes import Code

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
        value = _EXPRESSIONS[type(node)](self, node, kind)
        if value is None or (value.type is kind and type(value) is not Untyped and type(kind) is not BlockType):
            return value
        return assignable.convert(self.context, value, kind, node)

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
        meaning = self.meaning(node)
        if isinstance(meaning, Pou) and meaning.instance is not None:
            return Cell(meaning.instance, meaning.instance.type)
        if meaning is None or isinstance(meaning, Place):
            return None if meaning is None or meaning.type is UNKNOWN else meaning
        self.context.say(node, f"{text(node)} is not a variable", "a variable")
        return None

    def target(self, node: tree.Expression) -> Place | None:
        meaning = self.meaning(node)
        if isinstance(meaning, Place):
            return meaning if meaning.type is not UNKNOWN and writing.is_writable(self.context, meaning, node) else None
        if meaning is not None:
            self.context.say(
                node, f"{text(node)} is {self._kind(meaning, node)}", "a variable that may be written here"
            )
        return None

    def _kind(self, meaning: Constant | Pou | EnumType, node: tree.Expression) -> str:
        if isinstance(meaning, Pou):
            return f"a {meaning.kind.value}" if meaning.owner is None else "an action"
        if isinstance(meaning, Constant) and isinstance(meaning.type, ObjectType):
            return "a configuration object"
        named = self.context.find(node.text) if isinstance(node, tree.Name) else None
        is_value = (
            isinstance(meaning, Constant) and isinstance(meaning.type, EnumType) and not isinstance(named, Variable)
        )
        return "a value of an enumeration" if is_value else "a type" if isinstance(meaning, EnumType) else "a constant"

    # ---- constants

    def constant(self, node: tree.Expression) -> Constant | None:
        value = self.expression(node)
        made = constants.folded(value) if value is not None else None
        if made is None or isinstance(made, Constant):
            return made
        expected = "a value that is known at compile time"
        self.context.say(node, f"{text(node)} is not constant", expected, code=Code.NOT_CONSTANT)
        return None

    def constant_as(self, node: tree.Expression, kind: Type) -> Constant | None:
        value = self.expression(node, kind if isinstance(kind, EnumType) else None)
        if value is None or not isinstance(constants.whole(value), Constant):
            value = self.constant(node)
        made = self.convert(value, kind, node) if value is not None else None
        made = constants.folded(made) if made is not None else None
        return made if isinstance(made, Constant) else None

    def constant_integer(self, node: tree.Expression) -> int | None:
        constant = self.constant(node)
        if constant is None:
            return None
        if (
            isinstance(constant.value, bool)
            or not isinstance(constant.value, int)
            or operators.integer_of(constant) is None
        ):
            self.context.say(node, f"{text(node)} is {a(constant.type)}", "an integer")
            return None
        return constant.value


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
    dialect = checker.context.project.dialect
    if kind is LiteralKind.TIME:
        return dialect.time
    return dialect.durations.get(LITERAL_TYPES[kind], LITERAL_TYPES[kind])


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
    pointer = methods.pointer_to_this(checker.context, node)
    if pointer is not None:
        return pointer
    meaning = places.meaning(checker, node)
    if isinstance(meaning, Constant):
        return assignable.own_value(checker.context, meaning, wanted, node)
    if meaning is None:
        return None
    if isinstance(meaning, Place):
        if isinstance(meaning.type, OpenArrayType):
            has_address = checker.context.project.dialect.gives_open_arrays_as_addresses
            if has_address and isinstance(wanted, PointerType) and not wanted.is_reference:
                return special.address_of(checker, meaning, node)
            hint = f"choose an element: {text(node)}[...]"
            checker.context.say(
                node, f"{text(node)} is {a(meaning.type)} and has no value as a whole", "an element", hint
            )
            return None
        if isinstance(meaning, Cell) and meaning.variable.narrow is not None:
            return constants.narrowed(Load(meaning), meaning.variable.narrow)
        return None if meaning.type is UNKNOWN else Load(meaning)
    if isinstance(meaning, Pou) and meaning.kind is PouKind.PROGRAM and meaning.instance is not None:
        if isinstance(wanted, Elementary):
            checker.context.say(node, f"{meaning.name} is a PROGRAM", "a value", f"{meaning.name}.x is its variable x")
            return None
        return Load(Cell(meaning.instance, meaning.instance.type))
    if isinstance(meaning, Pou) and meaning.owner is not None:
        checker.context.say(node, f"{meaning.name} is an action", "a value", f"call it as a statement: {text(node)};")
        return None
    if isinstance(meaning, Pou):
        hints = {
            PouKind.FUNCTION: f"{meaning.name}(...) calls it",
            PouKind.FUNCTION_BLOCK: f"declare x : {meaning.name};",
        }
        checker.context.say(node, f"{meaning.name} is {a(meaning.kind.value)}", "a value", hints.get(meaning.kind, ""))
        return None
    checker.context.say(node, f"{text(node)} is a type", "a value")
    return None


def _unary(checker: Checker, node: tree.Unary, wanted: Type | None) -> Expression | None:
    if node.operator == "POINTER TO":
        checker.context.say(node, f"{text(node)} is a type", "a value")
        return None
    operand = checker.expression(node.operand, wanted)
    if operand is None:
        return None
    if node.operator == "+":
        return operators.positive(checker.context, operand, node)
    sign = Operator.NEG if node.operator == "-" else Operator.NOT
    return operators.unary(checker.context, sign, operand, node, wanted)


_OPERATORS: Final = {operator.value: operator for operator in Operator}


def _binary(checker: Checker, node: tree.Binary, wanted: Type | None) -> Expression | None:
    """Check an operation, once for each type that is wanted.

    An operand such as `SHL(1, n + 1)` is checked again when the type of the other one is known.  What is inside it is
    not, or the work would double with each level.
    """
    chain = [node]
    first = node.left
    while isinstance(first, tree.Binary):
        chain.append(first)
        first = first.left
    if is_real(wanted) and divides_integers(first, chain):
        wanted = None
    known = checker.context.operations
    if known is None:
        if not any(map(_may_be_checked_twice, (first, *(each.right for each in chain)))):
            return _chain(checker, first, chain, wanted)
        known = checker.context.operations = {}
        try:
            return _chain(checker, first, chain, wanted)
        finally:
            checker.context.operations = None
    key = id(node), id(wanted)
    if key not in known:
        known[key] = Checked(node, wanted, _chain(checker, first, chain, wanted))
    return known[key].value


def _may_be_checked_twice(node: tree.Expression) -> bool:
    return isinstance(node, tree.Call | tree.Unary) and takes_its_type_from_outside(node)


def _chain(
    checker: Checker, first: tree.Expression, chain: list[tree.Binary], wanted: Type | None
) -> Expression | None:
    """Check the operators of a chain from left to right."""
    value = _EXPRESSIONS[type(first)](checker, first, wanted)
    while chain:
        value = _with_right_side(checker, value, chain.pop(), wanted)
    return value


def _with_right_side(
    checker: Checker, left: Expression | None, node: tree.Binary, wanted: Type | None
) -> Expression | None:
    of_left = left is not None and isinstance(left.type, EnumType) and isinstance(node.right, tree.Name)
    right = _EXPRESSIONS[type(node.right)](checker, node.right, left.type if left is not None and of_left else wanted)
    if left is None or right is None:
        return None
    if node.operator == "**":
        return standard.of_values(checker, "EXPT", [left, right], node, wanted)
    if left.type is not right.type and not isinstance(node.left, tree.Binary):
        if takes_its_type_from_outside(node.left) and not takes_its_type_from_outside(node.right):
            left = _of_type(checker, node.left, left, right)
        elif takes_its_type_from_outside(node.right) and not takes_its_type_from_outside(node.left):
            right = _of_type(checker, node.right, right, left)
    if isinstance(left, Constant) and isinstance(node.left, tree.Name) and isinstance(right.type, EnumType):
        left = _named(checker, node.left, right.type) or left  # now that it is known what is compared
    return operators.binary(checker.context, _OPERATORS[node.operator], left, right, node)


def _of_type(checker: Checker, node: tree.Expression, value: Expression, other: Expression) -> Expression:
    """Return an operand made of literals alone, such as `SHL(1, n)`, in the type of the other operand (6.4.2)."""
    if type(value) is Untyped or type(other) is Untyped or not isinstance(other.type, Elementary):
        return value
    return checker.expression(node, other.type) or value


def _call(checker: Checker, node: tree.Call, wanted: Type | None) -> Expression | None:
    """A result that is a reference means what it refers to."""
    value = calls.value(checker, node, wanted)
    kind = value.type if value is not None and type(value) is not Untyped else None
    if value is not None and isinstance(kind, PointerType) and kind.is_reference:
        return Load(Target(check_functions.address(checker.context, value, node), kind.to))
    return value


def _assigned(checker: Checker, node: tree.Assigned, _wanted: Type | None) -> Expression | None:
    """`(a := b)` of ExST has the type of a, as CODESYS has it: `int := real := int` is refused."""
    target = checker.target(node.target)
    value = checker.expression(node.value) if target is None else checker.expression_as(node.value, target.type)
    return Assigned(target, value) if target is not None and value is not None else None


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
    tree.Assigned: _assigned,
}
