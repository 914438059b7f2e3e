"""Expressions whose type only their surroundings can tell, as they are made of literals: `SHL(1, n)`, `NOT 16#FF`.

IEC 61131-3 (2013), 6.4.2: a literal without a type has that of its operands or of what takes the result.
"""

from collections.abc import Iterable, Sequence
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.types import Type

_FIRST: Final = frozenset({"SHL", "SHR", "ROL", "ROR"})
"""Functions whose first argument has the type of the result."""
_BEHIND_FIRST: Final = frozenset({"SEL", "MUX"})
DIVISIONS: Final = frozenset({"/", "DIV", "MOD"})
"""Operators and functions that divide."""
_ARITHMETIC: Final = DIVISIONS | {"+", "-", "*"}
_ALL: Final = frozenset({"MAX", "MIN", "LIMIT", "MOVE", "ABS", "NOT", "AND", "OR", "XOR"})


def takes_its_type_from_outside(node: tree.Expression) -> bool:
    """Return whether nothing in an expression has a type of its own that the result has."""
    match node:
        case tree.Literal(type_name="", kind=tree.LiteralKind.INTEGER):
            return True
        case tree.Unary(operator="-" | "+" | "NOT", operand=operand):
            return takes_its_type_from_outside(operand)
        case tree.Call(tree.Name(name), arguments) if arguments:
            decisive = _decisive(name.upper(), arguments)
            return bool(decisive) and all(takes_its_type_from_outside(value) for value in decisive)
    return False


def divides_integers(first: tree.Expression, chain: Sequence[tree.Binary]) -> bool:
    """Return whether operators behind `first` divide what is made of integer literals alone.

    Such a division is one of integers whatever takes its result, as `7 / 2` is: `real := SEL(b, 7, 9) / 2` is 3 or 4.
    """
    return any(each.operator in DIVISIONS for each in chain) and are_whole((first, *(each.right for each in chain)))


def is_real(wanted: Type | None) -> bool:
    return isinstance(wanted, Elementary) and wanted.is_real


def are_whole(nodes: Iterable[tree.Expression | None]) -> bool:
    """Return whether expressions are made of integer literals alone; None is one that is left out."""
    return all(node is None or _is_whole(node) for node in nodes)


def _is_whole(node: tree.Expression) -> bool:
    while isinstance(node, tree.Binary):
        if node.operator not in _ARITHMETIC or not _is_whole(node.right):
            return False
        node = node.left
    return takes_its_type_from_outside(node)


def _decisive(name: str, arguments: Sequence[tree.Argument]) -> list[tree.Expression]:
    """Return the arguments with the type of the result; empty for a function whose result has a type of its own."""
    given = [(argument.name.upper(), argument.value) for argument in arguments if argument.value is not None]
    if name in _ALL:
        return [value for _, value in given]
    if name in _FIRST:
        return [value for formal, value in given if formal == "IN"] or [value for _, value in given[:1]]
    if name in _BEHIND_FIRST:
        is_formal = bool(given) and bool(given[0][0])
        return [value for formal, value in given if formal not in ("G", "K")][0 if is_formal else 1 :]
    return []
