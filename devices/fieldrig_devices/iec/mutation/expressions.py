"""Changes of expressions."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.tree import LiteralKind

BITS: Final[Mapping[str, tuple[str, ...]]] = {
    "AND": ("OR",),
    "OR": ("AND",),
    "XOR": ("OR",),
    "AND_THEN": ("OR_ELSE",),
    "OR_ELSE": ("AND_THEN",),
}
COMPARISONS: Final[Mapping[str, tuple[str, ...]]] = {
    "<": ("<=", ">="),
    "<=": ("<", ">"),
    ">": (">=", "<="),
    ">=": (">", "<"),
    "=": ("<>",),
    "<>": ("=",),
}
"""The comparison with the limit on the other side, and the opposite."""
ARITHMETIC: Final[Mapping[str, tuple[str, ...]]] = {
    "+": ("-",),
    "-": ("+",),
    "*": ("/",),
    "/": ("*",),
    "MOD": ("*",),
}
_LARGE: Final = 10
"""The least number that is halved: one more is seldom a mistake that matters, and half has the same type."""
_TIMES: Final = (LiteralKind.TIME, LiteralKind.LTIME)
_PLACES: Final = (tree.Name, tree.Member, tree.BitOf, tree.Index, tree.Dereference, tree.Direct, tree.Call)


def negated(node: tree.Expression) -> tree.Expression | None:
    """Return NOT of a place or a call; None for other expressions, whose own operators are changed."""
    return tree.Unary("NOT", node, position=node.position) if isinstance(node, _PLACES) else None


def other_constant(node: tree.Literal) -> tree.Literal | None:
    """Return another constant of the same type: one more or half, twice as long, the other truth, an empty text."""
    value = node.value
    match node.kind:
        case LiteralKind.BOOL:
            return replace(node, value=not value, text="")
        case LiteralKind.INTEGER if isinstance(value, int):
            return replace(node, value=value + 1 if abs(value) < _LARGE else value // 2, text="")
        case LiteralKind.REAL if isinstance(value, int | float):
            return replace(node, value=value + 1.0 if abs(value) < _LARGE else value / 2, text="")
        case kind if kind in _TIMES and isinstance(value, int):
            return replace(node, value=2 * value if value else 1, text="")
        case LiteralKind.STRING | LiteralKind.WSTRING:
            return replace(node, value="" if value else "X", text="")
    return None
