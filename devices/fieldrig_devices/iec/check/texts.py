"""Short source text of an expression, for messages."""

from collections.abc import Iterable
from itertools import islice

from fieldrig_devices.iec import tree

LONGEST = 40
MOST_LISTED = 20
"""Names in a message."""
SPOKEN_WITH_A_VOWEL = (
    "A",
    "E",
    "I",
    "O",
    "a",
    "e",
    "i",
    "o",
    "LREAL",
    "LWORD",
    "LINT",
    "LTIME",
    "LTOD",
    "LDATE",
    "LDT",
    "MC_",
)


def text(node: tree.Node) -> str:
    """Return the expression as it could be written; "..." where it would be long."""
    if isinstance(node, tree.Binary) and _is_chain(node):
        return "..."
    shown = _text(node)
    return shown if len(shown) <= LONGEST else "..."


def _is_chain(node: tree.Expression) -> bool:
    """True if an expression has more operators in a row than a short text can show."""
    operators = 0
    while isinstance(node, tree.Binary) and operators <= LONGEST:
        operators, node = operators + 1, node.left
    return operators > LONGEST


def _text(node: tree.Node) -> str:
    match node:
        case tree.Name():
            return node.text
        case tree.Literal():
            return node.text or str(node.value)
        case tree.Member():
            return f"{_text(node.of)}.{node.name}"
        case tree.BitOf():
            return f"{_text(node.of)}.{f'%{node.size}' if node.size else ''}{node.number}"
        case tree.Index():
            return f"{_text(node.of)}[{', '.join(map(_text, node.indices))}]"
        case tree.Dereference():
            return f"{_text(node.of)}^"
        case tree.Direct():
            return f"%{node.area}{node.size}{'.'.join(map(str, node.numbers))}"
        case tree.Call():
            return f"{_text(node.called)}(...)"
        case tree.Unary():
            return f"{node.operator}{' ' if node.operator[-1].isalpha() else ''}{_text(node.operand)}"
        case tree.Binary():
            return "..." if _is_chain(node) else f"{_text(node.left)} {node.operator} {_text(node.right)}"
        case tree.Assigned():
            return f"{_text(node.target)} := {_text(node.value)}"
        case _:
            return "..."


def a(kind: object) -> str:
    """Return the name of a type with its article."""
    shown = str(kind)
    return f"{'an' if shown.startswith(SPOKEN_WITH_A_VOWEL) else 'a'} {shown}"


def listed(names: Iterable[str]) -> str:
    """Return names for a message, with "..." if there are many."""
    shown = list(islice(names, MOST_LISTED + 1))
    return ", ".join(shown if len(shown) <= MOST_LISTED else [*shown[:MOST_LISTED], "..."])
