"""The operators of expressions: which types they have, and the type in which the result is computed (digest 2.3).

Decided here, because the manual is silent or contradicts itself:

- MOD is for integers only (X11).
- A chained comparison such as 20 > 30 > 40 compares BOOL with a number, and is refused (PD-L34).
- Operands of the same size and different sign meet in the signed type, as in CoDeSys V2.3; a comparison of them is
  made in a larger type, so that it is right for all values.  CODESYS documents a warning for such a pair (C0195 and
  C0196, "possible change of sign"), and not which of both it converts; on its 32-bit targets UINT and INT, and smaller
  types, are also compared by their values.
- AND, OR, XOR and NOT also work on integers in EPAS-4, as in CoDeSys V2.3.
- The minus sign in front of an unsigned value gives the next larger signed type.
"""

from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import check_functions, constants, implicit, times
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.check.untyped import Untyped, bit_string, integer, real
from fieldrig_devices.iec.elementary import SHORT_TIMES, Elementary, Family
from fieldrig_devices.iec.library.arguments import common as common_type
from fieldrig_devices.iec.library.arguments import fits, widens
from fieldrig_devices.iec.program import COMPARISONS, Binary, Constant, Expression, Operator
from fieldrig_devices.iec.types import EnumType, PointerType, StringType, SubrangeType, Type

ARITHMETIC: Final = frozenset({Operator.ADD, Operator.SUB, Operator.MUL, Operator.DIV, Operator.MOD})
LOGIC: Final = frozenset({Operator.AND, Operator.OR, Operator.XOR})
SHORT_CIRCUIT: Final = frozenset({Operator.AND_THEN, Operator.OR_ELSE})
BOOL: Final = Elementary.BOOL


def plain(value: Expression) -> Expression:
    """Return the elementary value behind an enumeration, a subrange or a pointer."""
    kind = value.type
    if isinstance(kind, EnumType | SubrangeType):
        return constants.converted(value, kind.base)
    if isinstance(kind, PointerType):
        return constants.converted(value, Elementary.DWORD)
    return value


def _is_strict(value: Expression) -> bool:
    return isinstance(value.type, EnumType) and value.type.is_strict


def integer_of(value: Expression) -> Elementary | None:
    """Return the integer type of a value, also behind an enumeration or a subrange; None for other values."""
    kind = value.type
    base = kind.base if isinstance(kind, SubrangeType | EnumType) else kind
    return base if isinstance(base, Elementary) and base.is_integer and not _is_real(value) else None


def _is_real(value: Expression) -> bool:
    return type(value) is Untyped and value.is_real


# ---- two operands


def binary(
    context: Context, operator: Operator, left: Expression, right: Expression, at: tree.Node
) -> Expression | None:
    """Return the operation on both operands; the divisor goes through the functions of Check.lib, if there are any."""
    made = _operation(context, operator, left, right, at)
    if operator in (Operator.DIV, Operator.MOD) and isinstance(made, Binary):
        made.right = check_functions.divisor(context, made.right, at)
    return made


def _register(context: Context, operator: Operator, kind: Elementary, sides: tuple[Expression, ...]) -> Elementary:
    """Return the type in which the processor computes: 32 bits for smaller integers, if the dialect has this.

    Logic of values that fit their types never leaves the type.
    """
    if not context.computes_in_32_bits or not kind.is_integer or kind.size >= 4:
        return kind
    is_larger = any(constants.whole(side) is not side for side in sides)
    return constants.REGISTER[kind.family] if operator in ARITHMETIC or is_larger else kind


def _operation(
    context: Context, operator: Operator, left: Expression, right: Expression, at: tree.Node
) -> Expression | None:
    if type(left) is Untyped and type(right) is Untyped:
        return _literals(context, operator, left, right, at)
    strict = next((one.type for one in (left, right) if _is_strict(one)), None)
    if strict is not None and operator in ARITHMETIC and not context.is_library:
        hint = "TO_INT(...) is the number of a value"
        context.say(at, f"{operator.value} with a value of {strict}, which is strict", "two numbers", hint)
        return None
    left, right = plain(left), plain(right)
    if times.is_scaled_below_zero(context, operator, left, right):
        hint = "edition-3 has negative times"
        context.say(at, "the result is a negative time", "T#0s or more", hint)
        return None
    if operator in COMPARISONS:
        left, right = constants.whole(left), constants.whole(right)
    kind = left.type
    if kind is not right.type or type(left) is Untyped or type(right) is Untyped:
        met = _meet(context, operator, left, right, at)
        if met is None:
            return None
        if not isinstance(met, tuple):
            return met
        left, right, kind = met
    if operator in COMPARISONS:
        if isinstance(kind, Elementary | StringType):
            return constants.binary(operator, *_as(kind, left, right), BOOL)
        return _no(context, operator, left, right, at, "elementary types, STRING, enumerations or pointers")
    if not isinstance(kind, Elementary):
        hint = "CONCAT(a, b) joins strings" if isinstance(kind, StringType) and operator is Operator.ADD else ""
        return _no(context, operator, left, right, at, "two numbers", hint)
    if operator in ARITHMETIC:
        return _arithmetic(context, operator, left, right, kind, at)
    return _logic(context, operator, left, right, kind, at)


def _arithmetic(
    context: Context, operator: Operator, left: Expression, right: Expression, kind: Elementary, at: tree.Node
) -> Expression | None:
    family = kind.family
    if kind.is_time:
        if times.is_negative(context, operator, left, right):
            if isinstance(left, Constant) and left.value == 0:  # as OSCAT writes the largest TIME
                context.note(at, "the difference is below T#0s, and wraps around to a large time")
                return times.of_the_same_type(context, operator, left, right, kind)
            context.say(at, "the difference of these times is negative", "T#0s or more", "edition-3 has negative times")
            return None
        made = times.of_the_same_type(context, operator, left, right, kind)
        return made or _no(context, operator, left, right, at, "an operation for times, such as TIME + TIME")
    if family in (Family.BOOL, Family.CHARACTER) or (family is Family.BITS and not context.mixes_integers):
        return _no(context, operator, left, right, at, "two numbers")
    if operator is Operator.MOD and family is Family.REAL:
        return _no(context, operator, left, right, at, "two integers", "MOD is for integers only")
    if operator in (Operator.DIV, Operator.MOD) and isinstance(right, Constant) and right.value == 0:
        if isinstance(left, Constant):
            context.say(at, "this is a division by zero", "a divisor other than 0")
            return None
        context.note(at, "this is a division by zero", "the task stops here with a division error")
    return _computed(context, operator, left, right, kind, at)


def _as(kind: Elementary | StringType, left: Expression, right: Expression) -> tuple[Expression, Expression]:
    """Return the operands in the type in which they meet; a text of any length is one already."""
    if isinstance(kind, StringType):
        return left, right
    return constants.converted(left, kind), constants.converted(right, kind)


def _computed(
    context: Context, operator: Operator, left: Expression, right: Expression, kind: Elementary, at: tree.Node
) -> Expression:
    """Return the operation on integers or real numbers that meet in the type `kind`."""
    register = _register(context, operator, kind, (left, right))
    if register is kind:
        return constants.binary(operator, *_as(kind, left, right), kind)
    if operator in (Operator.DIV, Operator.MOD):  # the function for the divisor goes by the type in the source
        divisor = constants.converted(right, kind)
        checked = check_functions.divisor(context, divisor, at)
        right = right if checked is divisor else checked
    return constants.narrowed(constants.binary(operator, *_as(register, left, right), register), kind)


def _logic(
    context: Context, operator: Operator, left: Expression, right: Expression, kind: Elementary, at: tree.Node
) -> Expression | None:
    if kind is BOOL:
        return constants.binary(operator, left, right, BOOL)
    is_allowed = kind.family is Family.BITS or (kind.is_integer and context.mixes_integers)
    if operator in SHORT_CIRCUIT or not is_allowed:
        expected = "two BOOL" if operator in SHORT_CIRCUIT else "two BOOL or two bit strings"
        return _no(context, operator, left, right, at, expected)
    return _computed(context, operator, left, right, kind, at)


def _meet(
    context: Context, operator: Operator, left: Expression, right: Expression, at: tree.Node
) -> tuple[Expression, Expression, Type] | Expression | None:
    """Return both operands and the type in which they meet, or the whole result for times with another type."""
    first, second = left.type, right.type
    if type(left) is Untyped or type(right) is Untyped:
        return _meet_literal(context, operator, left, right, at)
    if isinstance(first, StringType) and isinstance(second, StringType) and first.is_wide is second.is_wide:
        return left, right, first
    if isinstance(first, StringType) and widens(second, first):
        return left, constants.converted(right, first), first
    if isinstance(second, StringType) and widens(first, second):
        return constants.converted(left, second), right, second
    if not isinstance(first, Elementary) or not isinstance(second, Elementary):
        return _no(context, operator, left, right, at, "two values of the same type")
    if first.is_time or second.is_time:
        made = times.of_two_types(context, operator, left, right)
        return made or _no(context, operator, left, right, at, "two values of the same type", _time_hint(first, second))
    if operator in COMPARISONS:
        kind = implicit.compared(first, second)
    else:
        kind = implicit.common(first, second, not context.mixes_integers)
    if kind is None:
        return _no(context, operator, left, right, at, _expected(operator), _bool_hint(operator, first, second, at))
    return left, right, kind


def _meet_literal(
    context: Context, operator: Operator, left: Expression, right: Expression, at: tree.Node
) -> tuple[Expression, Expression, Type] | Expression | None:
    """A literal takes the type of the other operand if its value fits, and both take a larger one otherwise."""
    literal, typed = (left, right) if type(left) is Untyped else (right, left)
    assert isinstance(literal, Untyped)
    kind = typed.type
    if isinstance(kind, Elementary):
        if kind.is_time:
            return _time_and_literal(context, operator, left, right, literal, kind, at)
        fitted = _fitted(literal, kind)
        if fitted is None and (kind.is_integer or kind.is_real):
            wider = _wider(operator, kind, literal)
            if isinstance(wider, Elementary):
                fitted, kind = _fitted(literal, wider), wider
        if fitted is not None:
            return (fitted, typed, kind) if literal is left else (typed, fitted, kind)
    second = right.type if literal is left else left.type
    return _no(context, operator, left, right, at, _expected(operator), _bool_hint(operator, kind, second, at))


def _wider(operator: Operator, kind: Elementary, literal: Untyped) -> object:
    """The type of both operands where the literal does not fit the other one; for a comparison it holds both values."""
    if operator in COMPARISONS and isinstance(literal.type, Elementary):
        return implicit.compared(kind, literal.type)
    return common_type((kind, literal.argument))


def _fitted(literal: Untyped, kind: Elementary) -> Constant | None:
    value = literal.value
    assert not isinstance(value, str)
    if kind.is_integer and not literal.is_real and kind.low <= value <= kind.high:
        return Constant(value, kind)
    if kind.is_integer and literal.is_pattern and 0 <= value < 2**kind.bits:
        return Constant(constants.limited(value, kind), kind)
    if kind.is_real:
        return Constant(constants.limited(value, kind), kind)
    if kind is BOOL and not literal.is_real and value in (0, 1):
        return Constant(bool(value), kind)
    return None


def _time_and_literal(
    context: Context,
    operator: Operator,
    left: Expression,
    right: Expression,
    literal: Untyped,
    kind: Elementary,
    at: tree.Node,
) -> tuple[Expression, Expression, Type] | Expression | None:
    if kind.family is Family.TIME and operator in (Operator.MUL, Operator.DIV):
        number: Expression = Constant(literal.value, Elementary.LREAL if literal.is_real else Elementary.DINT)
        made = times.of_two_types(context, operator, *((number, right) if literal is left else (left, number)))
        if made is not None:
            return made
    if kind in SHORT_TIMES and not literal.is_real and context.project.dialect.allows_numbers_as_times:
        fitted = Constant(literal.value, kind)
        return (fitted, right, kind) if literal is left else (left, fitted, kind)
    hint = f"write T#{literal.value}ms for milliseconds" if kind in SHORT_TIMES else ""
    return _no(context, operator, left, right, at, "two values of the same type", hint)


# ---- literals only


def _literals(context: Context, operator: Operator, left: Untyped, right: Untyped, at: tree.Node) -> Expression | None:
    """Literals alone are computed exactly."""
    if operator in COMPARISONS:
        return constants.binary(operator, left, right, BOOL)
    if (operator in ARITHMETIC and operator is not Operator.MOD) or not (left.is_real or right.is_real):
        if operator in SHORT_CIRCUIT:
            return _no(context, operator, left, right, at, "two BOOL")
        value = constants.exact(operator, left.value, right.value)
        if value is None:
            context.say(at, "this is a division by zero", "a divisor other than 0")
            return None
        if isinstance(value, float):
            return real(value)
        assert isinstance(value, int)
        return integer(value, left.is_pattern and right.is_pattern and operator in LOGIC)
    return _no(context, operator, left, right, at, _expected(operator))


# ---- one operand


def unary(
    context: Context, operator: Operator, operand: Expression, at: tree.Node, wanted: Type | None = None
) -> Expression | None:
    """`wanted` is the type that the surroundings give a literal."""
    if type(operand) is Untyped:
        return _unary_literal(context, operator, operand, at, wanted)
    operand = plain(operand)
    kind = operand.type
    if not isinstance(kind, Elementary):
        return _no_operand(context, operator, kind, at)
    if operator is Operator.NOT:
        operand = constants.folded(operand)
        is_integer = kind.is_integer and context.mixes_integers
        if kind is BOOL or kind.family is Family.BITS or is_integer:
            return constants.unary(operator, operand, kind)
        return _no_operand(context, operator, kind, at)
    if kind.family is Family.TIME and kind.is_signed:
        return constants.unary(operator, operand, kind)
    if kind.family in (Family.SIGNED, Family.REAL):
        return _negative(context, operand, kind)
    if kind.is_integer:
        signed = next(
            (wide for wide in (Elementary.INT, Elementary.DINT, Elementary.LINT) if wide.size > kind.size),
            Elementary.LINT,
        )
        if signed is Elementary.LINT and not context.project.dialect.has_long_types:
            signed = Elementary.DINT
        return _negative(context, operand, signed)
    return _no_operand(context, operator, kind, at)


def _negative(context: Context, operand: Expression, kind: Elementary) -> Expression:
    """Return the operand with the other sign in a signed type, in 32 bits if the dialect computes so."""
    register = constants.REGISTER[kind.family] if context.computes_in_32_bits and kind.size < 4 else kind
    made = constants.unary(Operator.NEG, constants.converted(operand, register), register)
    return made if register is kind else constants.narrowed(made, kind)


def positive(context: Context, operand: Expression, at: tree.Node) -> Expression | None:
    operand = plain(operand)
    if isinstance(operand.type, Elementary) and (operand.type.is_integer or operand.type.is_real):
        return operand
    context.say(at, f"a plus sign in front of {a(operand.type)}", "a number")
    return None


def _unary_literal(
    context: Context, operator: Operator, operand: Untyped, at: tree.Node, wanted: Type | None
) -> Expression | None:
    """NOT of a literal is as wide as what is wanted, or the smallest bit string that the literal fits in (PD-L29)."""
    value = operand.value
    assert not isinstance(value, str)
    if operator is Operator.NEG:
        return real(-value) if isinstance(value, float) else integer(-value)
    kind = bit_string(value) if isinstance(value, int) else None
    if isinstance(wanted, Elementary) and wanted.is_integer and isinstance(value, int) and fits(value, wanted):
        kind = wanted if wanted.family is Family.BITS or context.mixes_integers else kind
    if kind is None:
        return _no_operand(context, operator, operand.type, at)
    return constants.unary(operator, Constant(value, kind), kind)


# ---- messages


def _expected(operator: Operator) -> str:
    if operator in LOGIC:
        return "two BOOL or two bit strings"
    return (
        "two BOOL"
        if operator in SHORT_CIRCUIT
        else "two numbers"
        if operator in ARITHMETIC
        else "two values of the same type"
    )


def _shown(value: Expression) -> str:
    return f"the number {value.value}" if type(value) is Untyped else str(value.type)


def _no(
    context: Context,
    operator: Operator,
    left: Expression,
    right: Expression,
    at: tree.Node,
    expected: str,
    hint: str = "",
) -> Constant | None:
    if not hint and operator in COMPARISONS and isinstance(at, tree.Binary):
        hint = _chained(at)
    context.say(at, f"{operator.value} between {_shown(left)} and {_shown(right)}", expected, hint)
    return None


def _no_operand(context: Context, operator: Operator, kind: object, at: tree.Node) -> Constant | None:
    sign, expected = ("NOT", "a BOOL or a bit string") if operator is Operator.NOT else ("a minus sign", "a number")
    context.say(at, f"{sign} in front of {a(kind)}", expected)
    return None


def _chained(at: tree.Binary) -> str:
    """A hint for a > b > c, which compares the result of the first comparison."""
    left = at.left
    if isinstance(left, tree.Binary) and any(left.operator == sign.value for sign in COMPARISONS):
        return f"write {text(left)} AND {text(left.right)} {at.operator} {text(at.right)}"
    return ""


def _bool_hint(operator: Operator, first: object, second: object, at: tree.Node) -> str:
    if BOOL in (first, second) and operator in COMPARISONS and isinstance(at, tree.Binary):
        return _chained(at) or "compare the BOOL with TRUE or FALSE, or use it alone"
    if BOOL in (first, second) and operator in LOGIC:
        return "comparisons bind more strongly than AND or OR; write a > 1 AND b > 1"
    if BOOL in (first, second):
        return "use BOOL_TO_INT(...) for 0 or 1"
    return ""


def _time_hint(first: Elementary, second: Elementary) -> str:
    if first in SHORT_TIMES or second in SHORT_TIMES:
        other = second if first in SHORT_TIMES else first
        return f"use {other}_TO_TIME(...) for milliseconds" if other.is_integer or other.is_real else ""
    return ""
