"""Standard functions as blocks of a network: which are operators of the language, and the types of their results."""

from itertools import pairwise
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.types import OF_EDITION_3

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

_OF_THE_ARGUMENTS: Final = frozenset(
    ("move", "abs", "sel", "mux", "min", "max", "limit", "shl", "shr", "rol", "ror", "not", "insert", "neg")
)
_FIXED: Final = {
    "len": "INT", "find": "INT", "left": "STRING", "right": "STRING", "mid": "STRING", "concat": "STRING",
    "insert": "STRING", "delete": "STRING", "replace": "STRING", "trunc": "DINT", "time": "TIME", "sqrt": "REAL",
    "ln": "REAL", "log": "REAL", "exp": "REAL", "sin": "REAL", "cos": "REAL", "tan": "REAL", "asin": "REAL",
    "acos": "REAL", "atan": "REAL", "expt": "REAL", "adr": "DWORD", "sizeof": "DINT",
}  # fmt: skip
_BLOCKS: Final = {
    "ton": {"q": "BOOL", "et": "TIME"}, "tof": {"q": "BOOL", "et": "TIME"}, "tp": {"q": "BOOL", "et": "TIME"},
    "r_trig": {"q": "BOOL"}, "f_trig": {"q": "BOOL"}, "sr": {"q1": "BOOL"}, "rs": {"q1": "BOOL"},
    "ctu": {"q": "BOOL", "cv": "WORD"}, "ctd": {"q": "BOOL", "cv": "WORD"},
    "ctud": {"qu": "BOOL", "qd": "BOOL", "cv": "WORD"}, "rtc": {"q": "BOOL", "cdt": "DT"},
}  # fmt: skip
_WIDTH: Final = (
    "BOOL", "BYTE", "USINT", "SINT", "WORD", "UINT", "INT", "DWORD", "UDINT", "DINT", "LWORD", "ULINT", "LINT", "REAL",
    "LREAL",
)  # fmt: skip
_ELEMENTARY: Final = frozenset(
    (*_WIDTH, "TIME", "DATE", "TOD", "DT", *(kind.name for kind in OF_EDITION_3), "STRING", "WSTRING")
)


def is_standard(name: str) -> bool:
    """True for a function without effects besides its result."""
    key = name.casefold()
    return key in OPERATORS or key in _OF_THE_ARGUMENTS or key in _FIXED or conversion(name) is not None


def is_block(name: str) -> bool:
    """True for a standard function block."""
    return name.casefold() in _BLOCKS


def conversion(name: str) -> str | None:
    """The type behind X_TO_Y or TO_Y."""
    source, mark, result = name.upper().rpartition("TO_")
    if not mark or result not in _ELEMENTARY or (source and source[:-1] not in _ELEMENTARY | {"ANY"}):
        return None
    return result


def result_of(name: str) -> tree.TypeSpec | None:
    """The type of the result if it does not depend on the arguments."""
    key = name.casefold()
    if OPERATORS.get(key) in COMPARISONS:
        return tree.NamedType("BOOL")
    fixed = _FIXED.get(key) or conversion(name)
    if fixed is None:
        return None
    is_text = fixed in ("STRING", "WSTRING")
    return tree.StringSpec(is_wide=fixed == "WSTRING") if is_text else tree.NamedType(fixed)


def output_of(block: str, pin: str) -> tree.TypeSpec | None:
    """The type of an output of a standard function block."""
    name = _BLOCKS.get(block.casefold(), {}).get(pin.casefold())
    return tree.NamedType(name) if name else None


def wider(one: tree.TypeSpec | None, other: tree.TypeSpec | None) -> tree.TypeSpec | None:
    """The type of an operation with these two."""
    if one is None or other is None:
        return one or other
    if isinstance(one, tree.NamedType) and isinstance(other, tree.NamedType):
        first, second = one.name.upper(), other.name.upper()
        if first in _WIDTH and second in _WIDTH:
            return one if _WIDTH.index(first) >= _WIDTH.index(second) else other
        if first not in _ELEMENTARY or second in ("TIME", "DATE", "TOD", "DT"):
            return other
    return one


def operation(operator: str, values: list[tree.Expression], place: tree.Place) -> tree.Expression:
    """An operator with two or more operands, as its block has them: a comparison holds for each pair of neighbours."""
    if operator in COMPARISONS and len(values) > 2:
        pairs = [tree.Binary(operator, a, b, place=place) for a, b in pairwise(values)]
        return operation("AND", list[tree.Expression](pairs), place)
    if operator in ("AND", "OR", "XOR"):
        return balanced(operator, values, place)
    result = values[0]
    for value in values[1:]:
        result = tree.Binary(operator, result, value, place=place)
    return result


def balanced(operator: str, values: list[tree.Expression], place: tree.Place) -> tree.Expression:
    """An operation whose order does not matter, as a tree that is as low as possible.  Up to 8 stay in a row."""
    if len(values) == 1:
        return values[0]
    middle = len(values) - 1 if len(values) <= 8 else len(values) // 2
    left, right = balanced(operator, values[:middle], place), balanced(operator, values[middle:], place)
    return tree.Binary(operator, left, right, place=place)


def _height_of_chain(of: tree.Binary) -> int:
    highest, level = 0, 0
    node: tree.Expression = of
    while isinstance(node, tree.Binary):
        level += 1
        highest = max(highest, level + height(node.right))
        node = node.left
    return max(highest, level + height(node))


def height(of: tree.Expression | None) -> int:
    """The levels of a tree of operations and calls; what else is in an expression is small."""
    match of:
        case tree.Binary():
            return _height_of_chain(of)
        case tree.Unary(_, operand):
            return 1 + height(operand)
        case tree.Call(_, arguments):
            return 1 + max((height(argument.value) for argument in arguments), default=0)
    return 1
