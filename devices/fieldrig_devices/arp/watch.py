"""Watch expressions of the debugging service: an expression of the card's BASIC, or a condition as in an IF.

They are computed outside of the program, on raw values: nothing saturates or warns, and a division by zero has no
value.  `AND` and `OR` join conditions, from left to right; in BASIC a condition is a single comparison.
"""

from collections.abc import Callable, Mapping
from operator import eq, ge, gt, le, lt, ne
from typing import Final

from fieldrig_devices.arp.fixed import LIMIT, SCALE
from fieldrig_devices.arp.language.expression import ExpressionReader
from fieldrig_devices.arp.language.printer import argument_text
from fieldrig_devices.arp.language.tokens import LONGEST_LINE, Kind, tokens
from fieldrig_devices.arp.language.tree import Binary, Constant, Expression, Function, Name, Number, Unary
from fieldrig_devices.languages.mistakes import LineError

Read = Callable[[str], int]
"""Return the raw value of a name, where a bit has 0 or 1000; ValueError for an unknown one."""

_RELATIONS: Final[Mapping[str, Callable[[int, int], bool]]] = {
    "=": eq, "<>": ne, "<": lt, "<=": le, ">": gt, ">=": ge,
}  # fmt: skip
_CONSTANTS: Final = {"HI": SCALE, "ON": SCALE, "LO": 0, "OFF": 0}


def evaluate(text: str, read: Read) -> int | bool:
    """Return the raw value of an expression, or whether a condition holds.  ValueError, saying what was expected."""
    if len(text) > LONGEST_LINE:
        raise ValueError(f"expected an expression of at most {LONGEST_LINE} characters, got {len(text)}")
    try:
        return _Reader(text, read).value()
    except LineError as wrong:
        raise ValueError(f"{wrong.what}; expected {wrong.expected or 'an expression'}") from wrong


class _Reader(ExpressionReader):
    def __init__(self, text: str, read: Read) -> None:
        super().__init__(tokens(text), ())
        self._read = read

    def value(self) -> int | bool:
        truth = self._term()
        while self._token.is_word("AND", "OR"):
            word = self._next().text
            other = self._term()
            if not isinstance(truth, bool) or not isinstance(other, bool):
                raise ValueError(f"expected conditions around {word}, such as V1 > 5")
            truth = (truth and other) if word == "AND" else (truth or other)
        if self._token.kind is not Kind.END:
            raise LineError(self._token.column, f"{self._token} is not allowed here", "=, <>, <, <=, >, >=, AND or OR")
        return truth

    def _term(self) -> int | bool:
        left = _raw(self._expression(), self._read)
        if not self._token.is_sign(*_RELATIONS):
            return left
        return _RELATIONS[self._next().text](left, _raw(self._expression(), self._read))


def _raw(expression: Expression, read: Read) -> int:
    match expression:
        case Number(raw):
            return raw
        case Constant(word) if word in _CONSTANTS:
            return _CONSTANTS[word]
        case Unary("-", operand):
            return -_raw(operand, read)
        case Unary("+", operand):
            return _raw(operand, read)
        case Binary(sign, left, right):
            return _limited(_binary(sign, _raw(left, read), _raw(right, read)))
        case Unary() | Constant() | Function():
            raise ValueError(f"{argument_text(expression)}: expected values, numbers, and the signs + - * / %")
        case Name(text):
            return read(text)
    return read(argument_text(expression))


def _binary(sign: str, left: int, right: int) -> int:
    match sign:
        case "+":
            return left + right
        case "-":
            return left - right
        case "*":
            return _divided(left * right, SCALE)
        case "/" | "%" if right == 0:
            raise ValueError("a division by zero")
        case "/":
            return _divided(left * SCALE, right)
        case "%":
            return left - _divided(left, right) * right
    raise ValueError(f"expected the signs + - * / %, got {sign}")


def _divided(left: int, right: int) -> int:
    """Divide, and round towards zero as the card does."""
    quotient = abs(left) // abs(right)
    return quotient if (left < 0) is (right < 0) else -quotient


def _limited(raw: int) -> int:
    if abs(raw) > LIMIT:
        raise ValueError("the result is outside -999999.999 to 999999.999")
    return raw
