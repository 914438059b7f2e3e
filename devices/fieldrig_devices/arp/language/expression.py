"""Parse expressions and resources of the ARP's BASIC.

Source: manual 4.2, 4.3, 5.3; digest chapters 3 and 4.  The manual only says that brackets group; the precedence is the
digest's, high to low: unary `! - +`; `* / \\ %`; `+ -`; `<< >>`; `&`; `^`; `|`.  All operators are left associative.
"""

import re
from collections.abc import Collection
from typing import Final

from fieldrig_devices.arp import fixed
from fieldrig_devices.arp.language.instructions import CONSTANTS, FUNCTIONS, KEYWORDS, SYSTEM
from fieldrig_devices.arp.language.tokens import Kind, Token
from fieldrig_devices.arp.language.tree import (
    Binary,
    Constant,
    Direct,
    Expression,
    Function,
    Indexed,
    Name,
    Number,
    Resource,
    System,
    Unary,
)
from fieldrig_devices.languages.mistakes import LineError

PRECEDENCE: Final = {
    "|": 1, "^": 2, "&": 3, "<<": 4, ">>": 4, "+": 5, "-": 5, "*": 6, "/": 6, "\\": 6, "%": 6,
}  # fmt: skip
MAX_BRACKET_DEPTH: Final = 50  # levels of nested brackets
MAX_OPERATORS: Final = 100  # operators in one line
_DIRECT = re.compile(r"([VFIO])([0-9]+)", re.ASCII)
_HEX = re.compile(r"H([0-9A-F]+)", re.ASCII)
_SYSTEM = re.compile(r"([@#])( *)([A-Z]+)([0-9]*)", re.ASCII)
_OPERAND = "a number, a variable, a bit or ("


class ExpressionReader:
    """Reads tokens from left to right and collects `notes`, pairs of a column and a text, for the user."""

    def __init__(self, tokens: list[Token], names: Collection[str]) -> None:
        self._tokens, self._names = tokens, names
        self._place = self._depth = self._operators = 0
        self.notes: list[tuple[int, str]] = []

    @property
    def _token(self) -> Token:
        return self._tokens[self._place]

    @property
    def _after(self) -> Token:
        return self._tokens[min(self._place + 1, len(self._tokens) - 1)]

    def _next(self) -> Token:
        token = self._tokens[self._place]
        if token.kind is not Kind.END:
            self._place += 1
        return token

    def _expect(self, sign: str, expected: str) -> None:
        if not self._token.is_sign(sign):
            raise LineError(self._token.column, f"{self._token} is where {sign} is missing", expected)
        self._next()

    def _expression(self, expected: str = _OPERAND, lowest: int = 1) -> Expression:
        left = self._unary(expected)
        while self._token.is_sign(*PRECEDENCE) and PRECEDENCE[self._token.text] >= lowest:
            sign = self._next()
            self._count(sign.column)
            right = self._expression(_OPERAND, PRECEDENCE[sign.text] + 1)
            left = Binary(sign.text.replace("\\", "/"), left, right, column=sign.column)
        return left

    def _count(self, column: int) -> None:
        self._operators += 1
        if self._operators > MAX_OPERATORS:
            raise LineError(column, "the expression is too long", f"at most {MAX_OPERATORS} operators")

    def _unary(self, expected: str) -> Expression:
        token = self._token
        if token.is_sign("-", "+", "!"):
            self._next()
            self._count(token.column)
            return Unary(token.text, self._primary(_OPERAND), column=token.column)
        return self._primary(expected)

    def _primary(self, expected: str) -> Expression:
        token = self._token
        if token.kind is Kind.NUMBER or self._is_hex():
            return self._number()
        if token.is_sign("("):
            return self._bracketed()
        if token.is_word(*CONSTANTS):
            return Constant(self._next().text, column=token.column)
        if token.is_word(*FUNCTIONS):
            self._next()
            if not self._token.is_sign("("):
                raise LineError(self._token.column, f"{self._token} after {token.text}", "( and one value")
            return Function(token.text, self._bracketed(), column=token.column)
        return self._resource(expected)

    def _bracketed(self) -> Expression:
        column = self._next().column
        self._depth += 1
        if self._depth > MAX_BRACKET_DEPTH:
            raise LineError(column, "brackets are nested too deep", f"at most {MAX_BRACKET_DEPTH}")
        inner = self._expression()
        self._expect(")", ")")
        self._depth -= 1
        return inner

    def _is_hex(self) -> bool:
        token = self._token
        return token.kind is Kind.WORD and token.text not in self._names and _HEX.fullmatch(token.text) is not None

    def _number(self) -> Number:
        token = self._next()
        if token.kind is Kind.WORD:
            return self._hex(token)
        head, point, tail = token.text.partition(".")
        if point and not 1 <= len(tail) <= 3:
            raise LineError(token.column, f"{token.text} is no number", "one to three digits after the point")
        raw = int(head) * fixed.SCALE + int(tail.ljust(3, "0") or 0)
        if raw > fixed.LIMIT:
            raise LineError(token.column, f"{token.text} is too large", "at most 999999.999")
        return Number(raw, column=token.column)

    def _hex(self, token: Token) -> Number:
        digits = token.text[1:]
        if len(digits) > 8:
            raise LineError(token.column, f"{token.text} has {len(digits)} digits", "at most 8 (32 bits)")
        return Number(fixed.signed(int(digits, 16)), is_hex=True, column=token.column)

    def _resource(self, expected: str) -> Resource:
        token = self._token
        if token.kind is Kind.SYSTEM:
            return self._system()
        if token.kind is not Kind.WORD or token.text in KEYWORDS:
            raise LineError(token.column, f"{token} is not allowed here", expected)
        self._next()
        if token.is_word("V", "F", "I", "O") and self._token.is_sign("["):
            return self._indexed(token)
        if direct := _DIRECT.fullmatch(token.text):
            return Direct(direct[1], int(direct[2]), column=token.column)
        return Name(token.text, column=token.column)

    def _indexed(self, letter: Token) -> Direct | Indexed:
        self._next()
        index = self._token
        if index.kind is Kind.NUMBER:
            resource: Direct | Indexed = Direct(letter.text, self._digits(), column=letter.column)
        elif index.kind is Kind.WORD and index.text not in KEYWORDS:
            self._next()
            direct = _DIRECT.fullmatch(index.text)
            if direct is not None and direct[1] != "V":
                raise LineError(index.column, f"{index.text} cannot be an index", "a number or a variable V")
            name = Name(index.text, column=index.column)
            variable = name if direct is None else Direct("V", int(direct[2]), column=index.column)
            resource = Indexed(letter.text, variable, column=letter.column)
        else:
            raise LineError(index.column, f"{index} cannot be an index", "a number or a variable V")
        self._expect("]", "]")
        return resource

    def _digits(self) -> int:
        token = self._token
        if token.kind is not Kind.NUMBER or not token.text.isdigit():
            raise LineError(token.column, f"{token} is no whole number", "digits")
        return int(self._next().text)

    def _system(self) -> System:
        token = self._next()
        match = _SYSTEM.fullmatch(token.text)
        assert match is not None
        word, digits = match[1] + match[3], match[4]
        if match[2]:
            self.notes.append((token.column, f"the manual allows no blank within {word}{digits} (4.2)"))
        if word == "@PAR":
            self._expect("[", "[ and the number of the parameter")
            index = self._digits()
            self._expect("]", "]")
            return System(word, int(digits) if digits else None, index, column=token.column)
        if word not in SYSTEM:
            raise LineError(token.column, f"there is no {word}{digits}", f"{', '.join(SYSTEM)} or @PAR")
        if not digits:
            first, last = SYSTEM[word]
            raise LineError(token.column, f"{word} has no number", f"{first} to {last}, without a blank")
        return System(word, int(digits), column=token.column)
