"""Watch expressions: what a debugger shows, and the conditions of breakpoints.

They are expressions of Structured Text over the variables of a running program, computed without a compiler: integers
of any type have 64 bits and a sign of their own, and there are no calls.  Names are looked up by the caller.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache
from operator import add, eq, ge, gt, le, lt, mul, ne, sub, xor
from typing import Any, Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import EDITION_3, Dialect
from fieldrig_devices.iec.parser import parse_body
from fieldrig_devices.iec.types import Value

LONGEST: Final = 1_000
"""Longest expression in characters."""

Read = Callable[[str], Value]
"""Return the value of a variable by its path; ValueError for an unknown one."""

_NUMBERS: Final[Mapping[str, Callable[[Any, Any], Any]]] = {"+": add, "-": sub, "*": mul}
_COMPARISONS: Final[Mapping[str, Callable[[Any, Any], bool]]] = {
    "=": eq,
    "<>": ne,
    "<": lt,
    "<=": le,
    ">": gt,
    ">=": ge,
}
_LOGIC: Final[Mapping[str, Callable[[Any, Any], Any]]] = {
    "AND": lambda left, right: left & right,
    "OR": lambda left, right: left | right,
    "XOR": xor,
    "AND_THEN": lambda left, right: left and right,
    "OR_ELSE": lambda left, right: left or right,
}


@lru_cache(maxsize=1_000)
def expression_of(text: str, dialect: Dialect = EDITION_3) -> tree.Expression:
    """Return the tree of an expression.  ValueError, saying what was expected, if it is none.

    Trees are kept, because a trace and a condition compute the same expression in every cycle; no caller changes them.
    """
    if len(text) > LONGEST:
        raise ValueError(f"expected an expression of at most {LONGEST} characters, got {len(text)}")
    body, mistakes = parse_body(f"watch := {text};", "", "ST", dialect)
    if mistakes:
        raise ValueError(f"{mistakes[0].what}; expected {mistakes[0].expected or 'an expression'}")
    match body:
        case tree.StBody(statements=(tree.Assign(value=value),)):
            return value
    raise ValueError(f"expected one expression, got {text!r}")


_MOST: Final = 1 << 64
"""No variable has an integer as large as this one."""
_PART_BITS: Final = {"B": 8, "W": 16, "D": 32, "L": 64}


def path_of(expression: tree.Expression, read: Read) -> str | None:
    """Return the path of a variable, with the present values of its indices; None for any other expression."""
    match expression:
        case tree.Name(text=text):
            return text
        case tree.Member(of=of, name=name):
            inner = path_of(of, read)
            return None if inner is None else f"{inner}.{name}"
        case tree.Index(of=of, indices=indices):
            inner = path_of(of, read)
            numbers = ",".join(str(evaluate(index, read)) for index in indices)
            return None if inner is None else f"{inner}[{numbers}]"
    return None


def evaluate(expression: tree.Expression, read: Read) -> Value:
    """Return the value of an expression.  ValueError, saying what was expected, if it has none."""
    path = path_of(expression, read)
    if path is not None:
        return read(path)
    match expression:
        case tree.Literal(value=value):
            return value
        case tree.BitOf(of=of, number=number, size=""):
            return bool(_whole(evaluate(of, read)) >> number & 1)
        case tree.BitOf(of=of, number=number, size=size):
            bits = _PART_BITS[size]
            return _whole(evaluate(of, read)) >> number * bits & (1 << bits) - 1
        case tree.Unary(operator=operator, operand=operand):
            return _unary(operator, evaluate(operand, read))
        case tree.Binary():
            chain = []
            first: tree.Expression = expression
            while isinstance(first, tree.Binary):
                chain.append(first)
                first = first.left
            value = evaluate(first, read)
            try:
                for term in reversed(chain):
                    value = _fitting(_binary(term.operator, value, evaluate(term.right, read)))
            except OverflowError as cause:  # an integer beyond the range of LREAL
                raise ValueError("the result is too large") from cause
            return value
    raise ValueError("expected an expression of variables, constants and operators")


def _fitting(value: Value) -> Value:
    """Return a result.  OverflowError if it has more digits than a value of the language."""
    if isinstance(value, int) and not -_MOST < value < _MOST:
        raise OverflowError
    return value


def _unary(operator: str, value: Value) -> Value:
    if operator == "NOT":
        return not value if isinstance(value, bool) else ~_whole(value)
    number = _number(value)
    return -number if operator == "-" else number


def _binary(operator: str, left: Value, right: Value) -> Value:
    if operator in _COMPARISONS:
        if isinstance(left, str) is not isinstance(right, str):
            raise ValueError(f"expected values of one kind around {operator}, got {left!r} and {right!r}")
        return _COMPARISONS[operator](left, right)
    if operator in _LOGIC:
        if isinstance(left, bool) and isinstance(right, bool):
            return bool(_LOGIC[operator](left, right))
        return int(_LOGIC[operator](_whole(left), _whole(right)))
    first, second = _number(left), _number(right)
    if operator in _NUMBERS:
        result: Value = _NUMBERS[operator](first, second)
        return result
    if operator not in ("/", "MOD"):
        raise ValueError(f"expected another operator than {operator}")
    if second == 0:
        raise ValueError("a division by zero")
    if operator == "/" and (isinstance(first, float) or isinstance(second, float)):
        return first / second
    quotient = abs(_whole(first)) // abs(_whole(second))
    quotient = quotient if (first < 0) is (second < 0) else -quotient
    return quotient if operator == "/" else first - quotient * second


def _number(value: Value) -> int | float:
    if isinstance(value, bool | str):
        raise ValueError(f"expected a number, got {value!r}")
    return value


def _whole(value: Value) -> int:
    if isinstance(value, str | float):
        raise ValueError(f"expected a whole number, got {value!r}")
    return int(value)
