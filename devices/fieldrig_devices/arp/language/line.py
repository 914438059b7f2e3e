"""Parses one line of an ARP program, with one method for each rule of the grammar (digest chapter 3)."""

import re
from collections.abc import Collection
from difflib import get_close_matches
from typing import Final

from fieldrig_devices.arp.language import instructions
from fieldrig_devices.arp.language.expression import ExpressionReader
from fieldrig_devices.arp.language.instructions import KEYWORDS, READS, SIGNATURES, Signature, Value
from fieldrig_devices.arp.language.tokens import Kind, Token
from fieldrig_devices.arp.language.tree import (
    Argument,
    Assign,
    BitCondition,
    Call,
    Command,
    Equ,
    Goto,
    If,
    Line,
    Mode,
    Number,
    OnEvent,
    PositionCondition,
    Read,
    Resource,
    Statement,
    Text,
)
from fieldrig_devices.languages.mistakes import LineError

ASSIGNMENTS: Final = ("==", "+=", "-=", "*=", "/=", "\\=", "%=", "&=", "|=", "^=", "<<=", ">>=")
RELATIONS: Final = ("=", "<>", "<", ">", "<=", ">=")
EDGES: Final = ("!", "/", "\\")
DEEPEST_IF: Final = 20  # a line of 120 characters cannot hold more
_NUMBERED = re.compile(r"(ON|CAM)([0-9]+)", re.ASCII)
_RESERVED = re.compile(r"[VFIO][0-9]+|(ON|CAM)[1-6]", re.ASCII)
_LABEL = re.compile(r"\s*([A-Z]\w*)\s*:", re.ASCII | re.IGNORECASE)


def label_of(text: str, number: int) -> Line | None:
    """The line up to its label, for a line that cannot be read to its end, or None if it has no valid label."""
    match = _LABEL.match(text)
    name = match[1].upper() if match is not None else ""
    if match is None or _is_reserved(name):
        return None
    return Line(number, name, None, match.start(1) + 1)


def _is_reserved(name: str) -> bool:
    return name in KEYWORDS or _RESERVED.fullmatch(name) is not None


class LineReader(ExpressionReader):
    def __init__(self, tokens: list[Token], names: Collection[str]) -> None:
        super().__init__(tokens, names)
        self.first_column = tokens[0].column
        self._ifs = 0

    # ---- lines

    def begin(self) -> str:
        self._next()
        name = self._new_name("the name of the routine")
        self._end()
        return name

    def single_word(self) -> None:
        self._next()
        self._end()

    def line(self, number: int) -> Line:
        label, column = None, self._token.column
        if self._token.kind is Kind.WORD and self._after.is_sign(":"):
            label = self._new_name("a label")
            self._next()
        if self._token.kind is Kind.END:
            return Line(number, label, None, column)
        is_equ = self._after.is_word("EQU")
        content = self._equ() if is_equ else self._statement()
        self._end()
        return Line(number, label, content, column)

    def _end(self) -> None:
        if self._token.kind is not Kind.END:
            raise LineError(self._token.column, f"{self._token} is not expected here", "one instruction per line")

    def _equ(self) -> Equ:
        column = self._token.column
        name = self._new_name("a name")
        self._next()
        if self._token.kind is Kind.NUMBER or self._is_hex():
            meaning: Resource | Number = self._number()
        else:
            meaning = self._resource("a variable, a flag, an input, an output, a parameter or a number")
        return Equ(name, meaning, column=column)

    def _new_name(self, what: str) -> str:
        token = self._token
        if token.kind is not Kind.WORD:
            raise LineError(token.column, f"{token} cannot be a name", what)
        if _is_reserved(token.text):
            raise LineError(token.column, f"{token.text} is a word of the language", what)
        return self._next().text

    # ---- statements

    def _statement(self) -> Statement:
        token = self._token
        if token.kind is Kind.SYSTEM:
            return self._assign()
        if token.kind is not Kind.WORD:
            raise LineError(token.column, f"{token} cannot begin an instruction", "an instruction or an assignment")
        if numbered := _NUMBERED.fullmatch(token.text):
            return self._numbered(numbered[1], int(numbered[2]))
        match token.text:
            case "IF":
                return self._if()
            case "GOTO":
                self._next()
                return Goto(self._name("a label"), column=token.column)
            case "CALL":
                self._next()
                return Call(self._name("a subprogram"), column=token.column)
            case "ON" | "CAM":
                raise LineError(token.column, f"{token.text} has no number", f"{token.text}1 to {token.text}6")
            case word if word in SIGNATURES:
                self._next()
                return self._command(SIGNATURES[word], token.column)
            case word if word in KEYWORDS:
                raise LineError(token.column, f"{word} cannot begin an instruction here", "an instruction")
        return self._assign()

    def _name(self, what: str) -> str:
        token = self._token
        if token.kind is not Kind.WORD or token.text in KEYWORDS:
            raise LineError(token.column, f"{token} is no name", what)
        return self._next().text

    def _numbered(self, word: str, number: int) -> Statement:
        token = self._next()
        if not 1 <= number <= 6:
            raise LineError(token.column, f"there is no {token.text}", f"{word}1 to {word}6")
        if word == "ON" and self._token.kind is not Kind.END:
            return self._on_event(number, token.column)
        return self._command(SIGNATURES[word], token.column, number)

    def _command(self, signature: Signature, column: int, number: int | None = None) -> Command:
        arguments: list[Argument] = []
        if self._token.kind is not Kind.END:
            arguments.append(self._argument(signature, 0))
            while self._token.is_sign(","):
                self._next()
                arguments.append(self._argument(signature, len(arguments)))
        if not signature.takes(len(arguments)):
            more = len(arguments) < len(signature.values)
            what = f"{self._token} comes too early" if more else f"{self._token} is not expected here"
            raise LineError(self._token.column, what, str(signature))
        return Command(signature.word, tuple(arguments), number, column=column)

    def _argument(self, signature: Signature, index: int) -> Argument:
        token = self._token
        if index >= len(signature.values):
            raise LineError(token.column, f"{token} is not expected here", str(signature))
        value = signature.values[index]
        if value is Value.TEXT:
            if token.kind is not Kind.STRING:
                raise LineError(token.column, f"{token} is no string", value.value)
            if not (token.text.isascii() and token.text.isprintable()):
                raise LineError(token.column, "the string has characters that no terminal shows", "printable ASCII")
            return Text(self._next().text, column=token.column)
        if value is Value.MODE:
            if not token.is_word("E", "P"):
                raise LineError(token.column, f"{token} is no mode", value.value)
            return Mode(self._next().text, column=token.column)
        return self._expression(value.value)

    def _assign(self) -> Assign:
        token = self._token
        target = self._resource("an instruction or an assignment")
        sign = self._token
        if sign.is_sign("="):
            raise LineError(sign.column, "values are assigned by ==, and = compares", "==")
        if not sign.is_sign(*ASSIGNMENTS):
            close = get_close_matches(token.text, sorted({*SIGNATURES, *instructions.ORGANISATION}), n=1)
            hint = f"; did you mean {close[0]}?" if close else ""
            raise LineError(sign.column, f"{sign} after {token.text}{hint}", "== or another assignment")
        self._next()
        if sign.text == "==" and self._token.is_word(*READS):
            return Assign(target, "==", self._read(), column=token.column)
        return Assign(target, sign.text.replace("\\", "/"), self._expression(), column=token.column)

    def _read(self) -> Read:
        token = self._next()
        number = self._expression("its number") if READS[token.text] is not None else None
        return Read(token.text, number, column=token.column)

    def _if(self) -> If:
        column = self._next().column
        self._ifs += 1
        if self._ifs > DEEPEST_IF:
            raise LineError(column, "too many IF in one line", f"at most {DEEPEST_IF}")
        left = self._expression("a condition")
        relation = self._token
        if not relation.is_sign(*RELATIONS):
            hint = "a comparison is written with one =, not" if relation.text == "==" else "no comparison:"
            raise LineError(relation.column, f"{hint} {relation}", "=, <>, <, >, <= or >=")
        self._next()
        right = self._expression("what to compare with")
        self._expect(",", "a comma, and an instruction or a label")
        return If(left, relation.text, right, self._then(), column=column)

    def _then(self) -> Statement:
        token = self._token
        is_alone = token.kind is Kind.WORD and self._after.kind is Kind.END
        if is_alone and token.text not in KEYWORDS and not _NUMBERED.fullmatch(token.text):
            return Goto(self._next().text, is_bare=True, column=token.column)
        return self._statement()

    # ---- events

    def _on_event(self, number: int, column: int) -> OnEvent:
        enable = self._resource("an enabling flag")
        self._expect("&", "& and the condition")
        has_bracket = self._token.is_sign("(")
        if has_bracket:
            self._next()
        condition = self._on_condition()
        if has_bracket:
            self._expect(")", ")")
        if self._token.is_sign(","):
            self._next()
        return OnEvent(number, enable, condition, self._name("the name of an interrupt routine"), column=column)

    def _on_condition(self) -> BitCondition | PositionCondition:
        token = self._token
        if token.is_sign(*EDGES):
            self._next()
            return BitCondition(token.text, self._resource("a flag or an input"), column=token.column)
        if self._after.is_sign("<", ">"):
            axis = self._primary("an axis, 1 or 2")
            relation = self._next().text
            return PositionCondition(axis, relation, self._resource("a variable V"), column=token.column)
        return BitCondition("", self._resource("a flag, an input, or an axis and > or <"), column=token.column)
