"""Standard functions as blocks of a network: which are operators of the language, and the types of their results."""

from itertools import pairwise
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.library import intrinsics

OPERATORS: Final = {
    "add": "+", "sub": "-", "mul": "*", "div": "/", "mod": "MOD", "and": "AND", "or": "OR", "xor": "XOR",
    "gt": ">", "ge": ">=", "eq": "=", "le": "<=", "lt": "<", "ne": "<>",
    "+": "+", "-": "-", "*": "*", "/": "/", "&": "AND",
    ">": ">", ">=": ">=", "=": "=", "<=": "<=", "<": "<", "<>": "<>",
}  # fmt: skip
"""Operators by the names of their blocks; some tools write the sign itself."""

COMPARISONS: Final = frozenset((">", ">=", "=", "<=", "<", "<>"))

DIVISIONS: Final = {"/": "DIV", "MOD": "MOD"}
"""The functions of the operators whose ENO is FALSE after a division by 0."""

_OF_ADDRESSES: Final = {"adr": "DWORD", "sizeof": "DINT", "indexof": "INT"}
"""The results of the functions that take variables and types instead of values."""


def is_standard(name: str) -> bool:
    """True for a function without effects besides its result."""
    key = name.casefold()
    return key in OPERATORS or key in _OF_ADDRESSES or intrinsics.is_standard(name)


def result_of(name: str) -> tree.TypeSpec | None:
    """The type of the result if it does not depend on the arguments."""
    fixed = _OF_ADDRESSES.get(name.casefold())
    return tree.NamedType(fixed) if fixed is not None else None


def operation(operator: str, values: list[tree.Expression], position: tree.Position) -> tree.Expression:
    """An operator with two or more operands, as its block has them: a comparison holds for each pair of neighbours."""
    if operator in COMPARISONS and len(values) > 2:
        pairs = [tree.Binary(operator, a, b, position=position) for a, b in pairwise(values)]
        return operation("AND", list[tree.Expression](pairs), position)
    if operator in ("AND", "OR", "XOR"):
        return balanced(operator, values, position)
    result = values[0]
    for value in values[1:]:
        result = tree.Binary(operator, result, value, position=position)
    return result


def balanced(operator: str, values: list[tree.Expression], position: tree.Position) -> tree.Expression:
    """An operation whose order does not matter, as a tree that is as low as possible.  Up to 8 stay in a row."""
    if len(values) == 1:
        return values[0]
    middle = len(values) - 1 if len(values) <= 8 else len(values) // 2
    left, right = balanced(operator, values[:middle], position), balanced(operator, values[middle:], position)
    return tree.Binary(operator, left, right, position=position)


def _height_of_chain(chain: tree.Binary) -> int:
    highest, level = 0, 0
    node: tree.Expression = chain
    while isinstance(node, tree.Binary):
        level += 1
        highest = max(highest, level + height(node.right))
        node = node.left
    return max(highest, level + height(node))


def height(node: tree.Expression | None) -> int:
    """The levels of a tree of operations and calls; what else is in an expression is small."""
    match node:
        case tree.Binary():
            return _height_of_chain(node)
        case tree.Unary(_, operand):
            return 1 + height(operand)
        case tree.Call(_, arguments):
            return 1 + max((height(argument.value) for argument in arguments), default=0)
    return 1
