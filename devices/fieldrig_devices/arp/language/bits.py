"""Classify expressions: which are single bits, and which are constant.

A bit among numbers counts as 1 or 0 (raw 1000 or 0), so bits and numbers may be mixed.  Only `!` treats them
differently: it inverts a bit, and complements the 32 bits of a word.
"""

from fieldrig_devices.arp.language import tree


def can_be_bit(expression: tree.Expression) -> bool:
    match expression:
        case tree.Number(raw, False):
            return raw in (0, 1_000)
        case tree.Constant(word):
            return word != "PIG"
        case tree.Direct(letter) | tree.Indexed(letter):
            return letter != "V"
        case tree.Unary("!", operand):
            return can_be_bit(operand)
        case tree.Binary("&" | "|" | "^", left, right):
            return can_be_bit(left) and can_be_bit(right)
    return False


def is_bit(expression: tree.Expression) -> bool:
    """True if the expression can be a bit and contains one: `!0` is a word, `!F1` is not."""
    return can_be_bit(expression) and _has_bit(expression)


def _has_bit(expression: tree.Expression) -> bool:
    match expression:
        case tree.Unary(_, operand):
            return _has_bit(operand)
        case tree.Binary(_, left, right):
            return _has_bit(left) or _has_bit(right)
    return isinstance(expression, tree.Direct | tree.Indexed)


def is_constant(expression: tree.Expression) -> bool:
    match expression:
        case tree.Unary(_, operand) | tree.Function(_, operand):
            return is_constant(operand)
        case tree.Binary(_, left, right):
            return is_constant(left) and is_constant(right)
    return isinstance(expression, tree.Number | tree.Constant)
