"""Computing with constants, with the arithmetic of the run time: integers wrap around, REAL is rounded each time.

`unary`, `binary`, `converted` and `intrinsic` make the expression of the checked program, or its constant if everything
in it is constant.  A division by zero is left to the run time, where it is a fault of the task (PD-L53).
"""

from collections.abc import Callable, Sequence
from typing import Final

from fieldrig_devices.iec.elementary import Elementary, Family
from fieldrig_devices.iec.library import conversions, intrinsics
from fieldrig_devices.iec.library.integers import cut
from fieldrig_devices.iec.library.overload import Overload
from fieldrig_devices.iec.library.reals import single
from fieldrig_devices.iec.program import COMPARISONS, Binary, Constant, Convert, Expression, Intrinsic, Operator, Unary
from fieldrig_devices.iec.types import EnumType, PointerType, StringType, SubrangeType, Type, Value


def divided(left: int, right: int) -> int:
    """Integer division towards zero."""
    quotient = abs(left) // abs(right)
    return quotient if (left < 0) == (right < 0) else -quotient


def remainder(left: int, right: int) -> int:
    """MOD, with the sign of the dividend."""
    return left - right * divided(left, right)


_INTEGER: Final[dict[Operator, Callable[[int, int], int]]] = {
    Operator.ADD: lambda left, right: left + right,
    Operator.SUB: lambda left, right: left - right,
    Operator.MUL: lambda left, right: left * right,
    Operator.DIV: divided,
    Operator.MOD: remainder,
    Operator.AND: lambda left, right: left & right,
    Operator.OR: lambda left, right: left | right,
    Operator.XOR: lambda left, right: left ^ right,
    Operator.AND_THEN: lambda left, right: left & right,
    Operator.OR_ELSE: lambda left, right: left | right,
}

_REAL: Final[dict[Operator, Callable[[float, float], float]]] = {
    Operator.ADD: lambda left, right: left + right,
    Operator.SUB: lambda left, right: left - right,
    Operator.MUL: lambda left, right: left * right,
    Operator.DIV: lambda left, right: left / right,
}

_COMPARED: Final[dict[Operator, Callable[[Value, Value], bool]]] = {
    Operator.EQ: lambda left, right: left == right,
    Operator.NE: lambda left, right: left != right,
    Operator.LT: lambda left, right: left < right,  # type: ignore[operator]
    Operator.LE: lambda left, right: left <= right,  # type: ignore[operator]
    Operator.GT: lambda left, right: left > right,  # type: ignore[operator]
    Operator.GE: lambda left, right: left >= right,  # type: ignore[operator]
}


def exact(operator: Operator, left: Value, right: Value) -> Value | None:
    """Return the result without any limit of a type; None for a division by zero or an operator for other types."""
    if operator in COMPARISONS:
        return _COMPARED[operator](left, right)
    assert not isinstance(left, str)
    assert not isinstance(right, str)
    if operator in (Operator.DIV, Operator.MOD) and right == 0:
        return None
    if isinstance(left, float) or isinstance(right, float):
        compute = _REAL.get(operator)
        return compute(float(left), float(right)) if compute is not None else None
    return _INTEGER[operator](left, right)


def limited(value: Value, kind: Type) -> Value:
    """Cut a computed value to the range of its type."""
    if isinstance(kind, Elementary) and not isinstance(value, str):
        if kind is Elementary.BOOL:
            return bool(value)
        if kind is Elementary.REAL:
            return single(float(value))
        if kind is Elementary.LREAL:
            return float(value)
        return cut(int(value), kind)
    return value


def binary(operator: Operator, left: Expression, right: Expression, kind: Type) -> Expression:
    if isinstance(left, Constant) and isinstance(right, Constant):
        value = exact(operator, left.value, right.value)
        if value is not None:
            return Constant(limited(value, kind), kind)
    return Binary(operator, left, right, kind)


def unary(operator: Operator, operand: Expression, kind: Type) -> Expression:
    if isinstance(operand, Constant) and not isinstance(operand.value, str):
        value = operand.value
        if operator is Operator.NEG:
            return Constant(limited(-value, kind), kind)
        if kind is Elementary.BOOL:
            return Constant(not value, kind)
        return Constant(limited(~int(value), kind), kind)
    return Unary(operator, operand, kind)


def _plain(kind: Type) -> Elementary | StringType | None:
    if isinstance(kind, PointerType):
        return Elementary.DWORD
    if isinstance(kind, SubrangeType | EnumType):
        return kind.base
    return kind if isinstance(kind, Elementary | StringType) else None


REGISTER: Final = {
    Family.SIGNED: Elementary.DINT,
    Family.UNSIGNED: Elementary.UDINT,
    Family.BITS: Elementary.DWORD,
}
"""The types in which a 32-bit target computes with smaller integers."""


def narrowed(value: Expression, kind: Type) -> Expression:
    """Return the result of arithmetic in 32 bits in the smaller type of its operands."""
    if isinstance(value, Constant) and isinstance(kind, Elementary) and kind.low <= int(value.value) <= kind.high:
        return Constant(value.value, kind)
    return Convert(value, kind, is_narrowing=True)


def whole(value: Expression) -> Expression:
    """Return the result of arithmetic in 32 bits before it is cut to a smaller type; any other value as it is."""
    return value.operand if type(value) is Convert and value.is_narrowing else value


def folded(value: Expression) -> Expression:
    """Return a constant result of arithmetic in 32 bits as a constant of the smaller type."""
    inner = whole(value)
    if inner is value or not isinstance(inner, Constant):
        return value
    return Constant(limited(inner.value, value.type), value.type)


def converted(operand: Expression, kind: Type) -> Expression:
    if operand.type is kind:
        return operand
    if isinstance(kind, Elementary) and (kind.is_integer or kind.is_real):
        operand = whole(operand)
        if operand.type is kind:
            return operand
    else:
        operand = folded(operand)
    if isinstance(operand, Constant):
        source, target = _plain(operand.type), _plain(kind)
        assert source is not None
        assert target is not None
        return Constant(conversions.convert(operand.value, source, target), kind)
    return Convert(operand, kind)


def intrinsic(overload: Overload, arguments: Sequence[Expression]) -> Expression:
    if overload.name == "MOVE":
        return arguments[0]  # also a structure or an array
    values = [argument.value for argument in arguments if isinstance(argument, Constant)]
    if arguments and len(values) == len(arguments):
        return Constant(intrinsics.evaluate(overload.name, values), overload.result)
    return Intrinsic(overload.name, tuple(arguments), overload.result)
