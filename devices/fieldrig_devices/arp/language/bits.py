"""Which expressions are about single bits, and which are constants.

A bit among numbers counts as 1 or 0 (raw 1000 or 0), so bits and numbers may be mixed; only `!` makes a difference: of
a bit it is the other bit, of a word the complement of its 32 bits.
"""

from fieldrig_devices.arp.language.tree import (
    Binary,
    Constant,
    Direct,
    Expression,
    Function,
    Indexed,
    Number,
    Unary,
)


def can_be_bit(one: Expression) -> bool:
    match one:
        case Number(raw, False):
            return raw in (0, 1_000)
        case Constant(word):
            return word != "PIG"
        case Direct(letter) | Indexed(letter):
            return letter != "V"
        case Unary("!", operand):
            return can_be_bit(operand)
        case Binary("&" | "|" | "^", left, right):
            return can_be_bit(left) and can_be_bit(right)
    return False


def is_bit(one: Expression) -> bool:
    """Can be a bit, and has one in it: `!0` is a word, `!F1` is not."""
    return can_be_bit(one) and _has_bit(one)


def _has_bit(one: Expression) -> bool:
    match one:
        case Unary(_, operand):
            return _has_bit(operand)
        case Binary(_, left, right):
            return _has_bit(left) or _has_bit(right)
    return isinstance(one, Direct | Indexed)


def is_constant(one: Expression) -> bool:
    match one:
        case Unary(_, operand) | Function(_, operand):
            return is_constant(operand)
        case Binary(_, left, right):
            return is_constant(left) and is_constant(right)
    return isinstance(one, Number | Constant)
