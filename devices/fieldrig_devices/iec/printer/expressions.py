"""Expressions as text, with the brackets that their precedence needs."""

from fieldrig_devices.iec import literal_texts, tree
from fieldrig_devices.iec.elementary import UNITS_NS, Elementary
from fieldrig_devices.iec.parser.expressions import RANKS
from fieldrig_devices.iec.tree import LiteralKind

_SIGN = max(RANKS.values()) + 1
_PLACES = (tree.Name, tree.Member, tree.Index, tree.Dereference, tree.Call)


def expression_text(node: tree.Expression, weakest: int = 0) -> str:
    """Return an expression as text, in brackets if its operator is weaker than a rank."""
    match node:
        case tree.Name(text):
            return text
        case tree.Literal():
            return _literal(node)
        case tree.Binary():
            return _chain(node, weakest)
        case tree.Assigned(target, value):
            return f"({expression_text(target)} := {expression_text(value)})"
        case tree.Unary(operator, operand):
            inner = expression_text(operand, _SIGN)
            if operator[-1].isalpha():
                return f"{operator} {inner}"
            return f"{operator}({inner})" if inner[0] in "+-" else f"{operator}{inner}"
        case tree.Member(inner_of, name):
            return f"{_place(inner_of)}.{name}"
        case tree.BitOf(inner_of, number, size):
            return f"{_place(inner_of)}.{f'%{size}' if size else ''}{number}"
        case tree.Index(inner_of, indices):
            return f"{_place(inner_of)}[{', '.join(map(expression_text, indices))}]"
        case tree.Dereference(inner_of):
            return f"{_place(inner_of)}^"
        case tree.Call(called, arguments):
            return f"{_place(called)}({', '.join(map(argument_text, arguments))})"
        case tree.Direct():
            return direct_text(node)


def _chain(last: tree.Binary, weakest: int) -> str:
    """Return operators in a row; brackets are open in front of all those that are weaker than what follows them."""
    parts: list[str] = []
    opened = 0
    node: tree.Expression = last
    while isinstance(node, tree.Binary):
        rank = RANKS[node.operator]
        if rank < weakest:
            opened += 1
            parts.append(")")
        parts.append(f" {node.operator} {expression_text(node.right, rank + 1)}")
        node, weakest = node.left, rank
    return "(" * opened + expression_text(node, weakest) + "".join(reversed(parts))


def _place(node: tree.Expression) -> str:
    """Return what a point, an index or ^ follows."""
    text = expression_text(node)
    return text if isinstance(node, _PLACES) else f"({text})"


def argument_text(argument: tree.Argument) -> str:
    value = "" if argument.value is None else f" {expression_text(argument.value)}"
    if argument.is_output:
        return f"{'NOT ' if argument.is_negated else ''}{argument.name} =>{value}"
    if argument.name:
        return f"{argument.name} :={value}"
    return value[1:]


def direct_text(direct: tree.Direct) -> str:
    return f"%{direct.area}{direct.size}{'.'.join(map(str, direct.numbers)) or '*'}"


def _literal(literal: tree.Literal) -> str:
    value = literal.value
    if literal.kind is LiteralKind.BOOL and (not literal.text or literal.text.upper() in ("TRUE", "FALSE")):
        text = "TRUE" if value else "FALSE"
    elif literal.text:
        return literal.text
    elif isinstance(value, str):
        is_wide = literal.kind is LiteralKind.WSTRING
        text = literal_texts.wide_string_text(value) if is_wide else literal_texts.string_text(value)
    elif isinstance(value, float):
        text = literal_texts.real_text(value)
    else:
        text = _number(literal.kind, int(value))
    return f"{literal.type_name}#{text}" if literal.type_name else text


def _number(kind: LiteralKind, value: int) -> str:
    match kind:
        case LiteralKind.TIME:
            return literal_texts.time_text(value)
        case LiteralKind.LTIME:
            return literal_texts.long_time_text(value)
        case LiteralKind.DATE | LiteralKind.TOD | LiteralKind.DT:
            return literal_texts.date_text("D" if kind is LiteralKind.DATE else kind.name, value, _unit_ns(kind))
        case LiteralKind.LDATE | LiteralKind.LTOD | LiteralKind.LDT:
            return literal_texts.date_text(kind.name, value, _unit_ns(kind))
        case LiteralKind.REAL:
            return literal_texts.real_text(float(value))
    return str(value)


def _unit_ns(kind: LiteralKind) -> int:
    return UNITS_NS[Elementary[kind.name]]
