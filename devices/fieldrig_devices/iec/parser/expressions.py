"""Expressions, by precedence climbing.

Source: PacDrive manual 1391 to 1415 and 1952 to 1976 with X27: strongest is **, then the signs and NOT, then * / MOD,
+ -, the comparisons, = <>, AND, XOR, OR; equal ranks from left to right.  Edition 3 of the standard has the signs and
NOT in front of **.
"""

import re
from collections.abc import Callable, Mapping
from typing import Final

from fieldrig_devices.iec import characters, literals, tree
from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.parser.cursor import DEEPEST_EXPRESSION, LONGEST_CHAIN, Cursor
from fieldrig_devices.iec.tree import LiteralKind

RANKS: Final[Mapping[str, int]] = {
    "OR": 1,
    "OR_ELSE": 1,
    "XOR": 2,
    "AND": 3,
    "AND_THEN": 3,
    "&": 3,
    "=": 4,
    "<>": 4,
    "<": 5,
    ">": 5,
    "<=": 5,
    ">=": 5,
    "+": 6,
    "-": 6,
    "*": 7,
    "/": 7,
    "MOD": 7,
    "**": 8,
}
"""Ranks of the operators with two operands, the weakest first."""

_OTHER_SYSTEMS: Final[Mapping[str, str]] = {
    "AND_THEN": "Write AND, or two IF in each other.",
    "OR_ELSE": "Write OR, or two IF.",
}
_FUNCTIONS: Final = frozenset({"AND", "OR", "XOR", "MOD"})
"""Keywords that are names of functions too."""
_STEPS: Final = frozenset({"+", "-"})
"""Signs that other languages write twice, to count by one."""
_INTEGER_TYPES: Final = frozenset(
    {"SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT", "BYTE", "WORD", "DWORD", "LWORD"}
)
_INSTEAD: Final[Mapping[LiteralKind, int | float | str]] = {
    LiteralKind.STRING: "",
    LiteralKind.WSTRING: "",
    LiteralKind.REAL: 0.0,
}
"""The value of a literal that cannot be read; 0 for the other kinds."""
_TIMES: Final[Mapping[str, tuple[LiteralKind, Callable[[str], int]]]] = {
    "D": (LiteralKind.DATE, literals.day),
    "DATE": (LiteralKind.DATE, literals.day),
    "TOD": (LiteralKind.TOD, literals.time_of_day),
    "TIME_OF_DAY": (LiteralKind.TOD, literals.time_of_day),
    "DT": (LiteralKind.DT, literals.date_and_time),
    "DATE_AND_TIME": (LiteralKind.DT, literals.date_and_time),
}
_LONG_TIMES: Final[Mapping[str, tuple[LiteralKind, Callable[[str, Dialect], int]]]] = {
    "LD": (LiteralKind.LDATE, literals.long_day),
    "LDATE": (LiteralKind.LDATE, literals.long_day),
    "LTOD": (LiteralKind.LTOD, lambda text, _: literals.long_time_of_day(text)),
    "LTIME_OF_DAY": (LiteralKind.LTOD, lambda text, _: literals.long_time_of_day(text)),
    "LDT": (LiteralKind.LDT, literals.long_date_and_time),
    "LDATE_AND_TIME": (LiteralKind.LDT, literals.long_date_and_time),
}


class Expressions(Cursor):
    """Reads expressions."""

    def expression(self, weakest: int = 1) -> tree.Expression:
        """Read an expression whose operators have at least a rank."""
        left = self._unary()
        kind = self.kinds[self.i]
        if RANKS.get(kind, 0) >= weakest:
            left = self._climb(left, weakest)
            kind = self.kinds[self.i]
        return self._unknown_operator(left) if kind == token.NAME else left

    def _climb(self, left: tree.Expression, weakest: int) -> tree.Expression:
        """Read operators of at least a rank with their right operands.

        A chain such as a OR b OR c is one level: its tree grows to the left, and is never walked by recursion there.
        """
        kinds = self.kinds
        height = self.height
        rank = RANKS.get(kinds[self.i], 0)
        length = 0
        self._rise()
        while rank >= weakest:
            at = self.i
            operator = kinds[at]
            self.i = at + 1
            length += 1
            if length > LONGEST_CHAIN:
                raise self.too_long(LONGEST_CHAIN)
            if operator == "**" and not self.dialect.has_power:
                self.say(at, "the operator ** is not supported", "EXPT(base, exponent)", "Write EXPT(2, 3) for 2**3.")
            elif operator == "**":
                self._rise()  # it becomes a call of EXPT within another
            right = self._unary()
            following = RANKS.get(kinds[self.i], 0)
            if following > rank:
                right = self._climb(right, rank + 1)
                following = RANKS.get(kinds[self.i], 0)
            left = tree.Binary("AND" if operator == "&" else operator, left, right, position=self.positions[at])
            rank = following
        self.height = height
        return left

    def _unknown_operator(self, left: tree.Expression) -> tree.Expression:
        """Report AND_THEN and OR_ELSE where they are not known, and go on behind them."""
        while self.kinds[self.i] == token.NAME and (word := self.texts[self.i].upper()) in _OTHER_SYSTEMS:
            plain, position = word[: word.index("_")], self.positions[self.i]
            self.say(self.i, f"the operator {word} is not supported", plain, _OTHER_SYSTEMS[word])
            self.i += 1
            left = tree.Binary(plain, left, self.expression(RANKS[plain] + 1), position=position)
        return left

    def assigned(self, left: tree.Expression) -> tree.Expression:
        """Read the rest of an assignment behind its target, where one is an expression, as in `IF a := b = 3 THEN`."""
        if self.kinds[self.i] != ":=" or not self.dialect.has_chained_assignments:
            return left
        position = self.positions[self.i]
        self._rise()
        self.i += 1
        value = self.assigned(self.expression())
        self.height -= 1
        return tree.Assigned(left, value, position=position)

    def _unary(self) -> tree.Expression:
        kind = self.kinds[self.i]
        if kind == token.NAME:
            return self.place_or_call()
        if kind == "NOT" or kind == "-" or kind == "+":
            position = self.positions[self.i]
            self._rise()
            self.i += 1
            operand = self._unary()
            self.height -= 1
            return tree.Unary(kind, operand, position=position)
        return self._primary(kind)

    def _rise(self) -> None:
        self.height += 1
        if self.height > DEEPEST_EXPRESSION:
            self.height = 0
            raise self.too_deep("the expression is too long or nested too deeply", DEEPEST_EXPRESSION)

    # ---- constants and brackets

    def _primary(self, kind: str) -> tree.Expression:
        at = self.i
        position = self.positions[at]
        if kind == token.INTEGER:
            self.i += 1
            text = self.texts[at]
            if len(text) < 19 and text.isdecimal():
                return tree.Literal(LiteralKind.INTEGER, int(text), text, position=position)
            return self._literal(LiteralKind.INTEGER, at, self._single(text), literals.integer)
        if kind == "(":
            self._rise()
            self.i += 1
            inner = self.assigned(self.expression())
            self.close(")", at)
            self.height -= 1
            return self._behind(inner) if self.kinds[self.i] in (".", "[", "^") else inner
        if kind == "TRUE" or kind == "FALSE":
            self.i += 1
            return tree.Literal(LiteralKind.BOOL, kind == "TRUE", self.texts[at], position=position)
        if kind == token.REAL:
            self.i += 1
            return self._literal(LiteralKind.REAL, at, self.texts[at], literals.real)
        if kind == token.TYPED:
            self.i += 1
            return self._typed(self.texts[at], at)
        if kind == token.STRING:
            self.i += 1
            text = self.texts[at]
            if self.dialect.has_windows_strings and not text.isascii():
                text = characters.of_windows(text)
            return self._literal(LiteralKind.STRING, at, text, literals.string)
        if kind == token.WIDE_STRING:
            self.i += 1
            return self._literal(LiteralKind.WSTRING, at, self.texts[at], literals.wide_string)
        if kind in _FUNCTIONS and self.kinds[at + 1] == "(" and self.dialect.has_operator_calls:
            self.i += 1
            return tree.Call(tree.Name(self.texts[at], position=position), self.arguments(), position=position)
        if kind == token.DIRECT:
            self.i += 1
            operand = self.direct(self.texts[at], at)
            return self._behind(operand) if self.kinds[self.i] in (".", "[", "^") else operand
        if kind == token.JUNK:
            self.i += 1
            return tree.Name("", position=position)
        return self._no_operand(kind)

    def _no_operand(self, kind: str) -> tree.Expression:
        hint = ""
        if kind == "=" and self.i and self.kinds[self.i - 1] in ("=", ":="):
            hint = "A comparison is written with one equals sign, an assignment with := and no blank."
        elif kind == "." and self.kinds[self.i + 1] == token.INTEGER:
            hint = f"A number has a digit in front of its point: 0.{self.texts[self.i + 1]}."
        elif kind in ("<", ">") and self.kinds[self.i - 1] in ("<", ">"):
            hint = "The sign for unequal is <>, and bits are moved by SHL and SHR."
        elif (before := self.kinds[self.i - 1]) in _STEPS and before == self.kinds[self.i - 2]:
            hint = f"Write x := x {before} 1 in a line of its own for x{before}{before}."
        elif kind == "&":
            hint = "The address of a variable is ADR(variable)."
        elif self.texts[self.i][:1].isalpha():
            hint = f"{kind} is a keyword and cannot be a name."
        raise self.unexpected("a variable, a constant or a call", hint)

    def close(self, bracket: str, opening: int) -> None:
        """Read a closing bracket."""
        if self.kinds[self.i] == bracket:
            self.i += 1
            return
        line, column = self.positions[opening]
        opened = f"{bracket} for the {self.texts[opening]} in line {line}, column {column}"
        if self.kinds[self.i] in (";", "THEN", "DO", "OF", token.END):
            self.missing(opened)
        elif self.kinds[self.i] == ":=":
            raise self.unexpected(opened, "A comparison is written with =.")
        else:
            raise self.unexpected(opened)

    def _literal(
        self, kind: LiteralKind, at: int, text: str, read: Callable[[str], int | float | str], type_name: str = ""
    ) -> tree.Literal:
        value: int | float | str
        try:
            value = read(text)
        except literals.LiteralError as bad:
            self.say(at, bad.what, bad.expected, bad.hint)
            value = _INSTEAD.get(kind, 0)
        return tree.Literal(kind, value, self.texts[at], type_name, position=self.positions[at])

    def _typed(self, text: str, at: int) -> tree.Expression:
        prefix, _, rest = text.partition("#")
        upper = prefix.upper()
        if upper in _TIMES:
            kind, read = _TIMES[upper]
            return self._literal(kind, at, rest, read)
        if self.dialect.has_long_types and upper in _LONG_TIMES:
            kind, read_long = _LONG_TIMES[upper]
            return self._literal(kind, at, rest, lambda inner: read_long(inner, self.dialect))
        if self.dialect.has_long_types and upper in ("LT", "LTIME"):
            return self._literal(LiteralKind.LTIME, at, rest, lambda inner: literals.long_time(inner, self.dialect))
        if upper in ("T", "TIME", "LTIME"):
            return self._literal(LiteralKind.TIME, at, rest, lambda inner: literals.time(inner, self.dialect))
        if upper == "BOOL":
            return self._bool(rest, at)
        if upper in _INTEGER_TYPES:
            return self._literal(LiteralKind.INTEGER, at, self._single(rest), _signed_integer, upper)
        if upper in ("REAL", "LREAL"):
            return self._literal(LiteralKind.REAL, at, rest, literals.real, upper)
        is_character = upper == "CHAR" and self.dialect.has_long_types
        if (upper == "STRING" or is_character) and rest[:1] == "'":
            return self._literal(LiteralKind.STRING, at, rest, literals.string, upper)
        if upper in ("WSTRING", "WCHAR") and rest[:1] == '"' and self.dialect.has_wide_strings:
            return self._literal(LiteralKind.WSTRING, at, rest, literals.wide_string, upper)
        if rest[:1].isalpha() or rest[:1] == "_":
            position = self.positions[at]
            return tree.Member(tree.Name(prefix, position=position), rest, position=position)
        self.say(at, f"{self.shown(at)} is not a constant", "the name of an elementary type in front of #")
        return tree.Literal(LiteralKind.INTEGER, 0, "0", position=self.positions[at])

    def _single(self, text: str) -> str:
        """Return digits with single underscores between them, where the dialect has several."""
        return re.sub("_+", "_", text) if self.dialect.has_system_names else text

    def _bool(self, rest: str, at: int) -> tree.Literal:
        value = {"TRUE": True, "1": True, "FALSE": False, "0": False}.get(rest.upper())
        if value is None:
            self.say(at, f"{self.shown(at)} is not a truth value", "BOOL#TRUE, BOOL#FALSE, BOOL#1 or BOOL#0")
        return tree.Literal(LiteralKind.BOOL, bool(value), self.texts[at], "BOOL", position=self.positions[at])

    def direct(self, text: str, at: int) -> tree.Direct:
        """Return an address such as %QX1.0."""
        area, rest = text[1].upper(), text[2:]
        size = rest[:1].upper() if rest[:1].isalpha() else ""
        numbers = rest[len(size) :]
        if size == "L" and not self.dialect.has_long_types:
            self.say(at, f"{text} has the size L, which is not supported", "X, B, W or D")
        if numbers == "*":
            return tree.Direct(area, size, (), position=self.positions[at])
        parts = numbers.split(".")
        if len(parts) > 16 or any(len(part) > 9 for part in parts):
            self.say(at, f"{self.shown(at)} is not an address", "smaller numbers")
            parts = ["0"]
        return tree.Direct(area, size, tuple(map(int, parts)), position=self.positions[at])

    # ---- places and calls

    def place_or_call(self) -> tree.Expression:
        """Read a variable, a part of one, or a call, from its name on."""
        at = self.i
        self.i = at + 1
        name = tree.Name(self.texts[at], position=self.positions[at])
        kind = self.kinds[at + 1]
        if kind == "." or kind == "[" or kind == "(" or kind == "^":
            return self._behind(name)
        return name

    def _behind(self, front: tree.Expression) -> tree.Expression:
        """Read what follows a name: components, indices, ^ and arguments."""
        kinds = self.kinds
        height = self.height
        while True:
            kind = kinds[self.i]
            at = self.i
            position = self.positions[at]
            if kind == ".":
                self.i += 1
                front = self._component(front, position)
            elif kind == "[":
                self.i += 1
                self._rise()
                indices = [self.expression()]
                while self.accept(","):
                    indices.append(self.expression())
                self.close("]", at)
                front = tree.Index(front, tuple(indices), position=position)
            elif kind == "^":
                self.i += 1
                front = tree.Dereference(front, position=position)
            elif kind == "(":
                self._rise()
                front = tree.Call(front, self.arguments(), position=position)
            else:
                break
            self._rise()
        self.height = height
        return front

    def _component(self, front: tree.Expression, position: tree.Position) -> tree.Expression:
        at = self.i
        if self.kinds[at] == token.INTEGER and self.texts[at].isdecimal() and len(self.texts[at]) < 6:
            self.i += 1
            return tree.BitOf(front, int(self.texts[at]), position=position)
        text = self.texts[at]
        if self.kinds[at] == token.PART:
            self.i += 1
            return tree.BitOf(front, int(text[2:]), text[1].upper().replace("X", ""), position=position)
        if self.kinds[at] == token.TYPED and self.dialect.has_namespace_blocks and _is_path(front):
            self.i += 1
            return self._typed(text, at)
        if not (text[:1].isalpha() or text[:1] == "_") or "#" in text:
            raise self.unexpected("the name of a component, or the number of a bit, behind the point")
        self.i += 1
        return tree.Member(front, text, position=position)

    def arguments(self) -> tuple[tree.Argument, ...]:
        """Read the arguments of a call with their brackets."""
        opening = self.i
        self.i += 1
        if self.accept(")"):
            return ()
        given = [self._argument()]
        while self.accept(","):
            if self.kinds[self.i] == ")":
                if not self.dialect.allows_trailing_commas:
                    self.say(self.i - 1, "got , behind the last argument", ")", "Remove this comma.")
                break
            given.append(self._argument())
        if self.kinds[self.i] == "=" or (self.kinds[self.i] == token.NAME and not self.is_next_line()):
            raise self.unexpected(", or ) in the arguments", "Arguments are separated by commas, and assigned with :=.")
        self.close(")", opening)
        return tuple(given)

    def _argument(self) -> tree.Argument:
        at = self.i
        kinds = self.kinds
        position = self.positions[at]
        following = kinds[at + 1] if kinds[at] != token.END else token.END
        if following == ":=" and self._is_identifier(at):
            self.i += 2
            if kinds[self.i] in (",", ")"):
                return tree.Argument(None, self.texts[at], position=position)
            return tree.Argument(self.expression(), self.texts[at], position=position)
        if following == "=>" and self._is_identifier(at):
            self.i += 2
            return self._output(at, False)
        if kinds[at] == "NOT" and self._is_identifier(at + 1) and kinds[at + 2] == "=>":
            self.i += 3
            return self._output(at + 1, True)
        if kinds[at] == "POINTER" and kinds[at + 1] == "TO" and self.dialect.has_heap:
            return tree.Argument(self._pointer_to(), position=position)
        return tree.Argument(self.expression(), position=position)

    def _pointer_to(self) -> tree.Expression:
        """Read `POINTER TO type` in `__NEW(POINTER TO type)`, and the like with several pointers."""
        fronts = []
        while self.kinds[self.i] == "POINTER" and self.kinds[self.i + 1] == "TO":
            fronts.append(self.positions[self.i])
            self.i += 2
        node = self.expression()
        for position in reversed(fronts):
            node = tree.Unary("POINTER TO", node, position=position)
        return node

    def _is_identifier(self, at: int) -> bool:
        return self.texts[at][:1].isalpha() or self.texts[at][:1] == "_"

    def _output(self, at: int, is_negated: bool) -> tree.Argument:
        value = None if self.kinds[self.i] in (",", ")") else self.expression()
        return tree.Argument(value, self.texts[at], True, is_negated, position=self.positions[at])


def _signed_integer(text: str) -> int:
    if text[:1] in ("-", "+"):
        value = literals.integer(text[1:])
        return -value if text[0] == "-" else value
    return literals.integer(text)


def _is_path(node: tree.Expression) -> bool:
    """True for names with points between them, such as those of a namespace in front of `Colour#red`."""
    while isinstance(node, tree.Member):
        node = node.of
    return isinstance(node, tree.Name)
