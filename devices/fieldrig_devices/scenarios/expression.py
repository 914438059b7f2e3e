"""Expressions over the places of a rig: `belt/speed > 477.0 and not wires/feeder.seal`.

Names of places may have signs in them, such as `io/6041:00` or `stop-key/pressed`, so operators stand between blanks.
A word with a slash is a place, and so are calls such as `message(can0, id=0x181)`; all others are numbers, texts in
quotes, true, false, operators and functions.  A single word behind == or != is a text, as in the milestones of faults.
From the weakest to the strongest: or; and; not; == != < <= > >=; |; &; + -; * /; - of a single value.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple

from fieldrig.device import Value
from fieldrig_devices.scenarios.calls import KINDS, call_of
from fieldrig_devices.scenarios.operators import CONSTANTS, FUNCTIONS, LEVELS, check_count
from fieldrig_devices.scenarios.tokens import words_of

LONGEST: Final = 2_000
"""Characters of an expression."""
DEEPEST: Final = 50
"""Brackets and signs within one another."""

Evaluate = Callable[[Mapping[str, Value]], Any]

_TEXT: Final = re.compile(r"[A-Za-z_][\w.-]*")
"""A text without quotes, such as the state `pre_operational`."""
_NUMBER: Final = re.compile(r"[+-]?(0[xX][0-9a-fA-F]+|0[bB][01]+|\d+(\.\d+)?([eE][+-]?\d+)?)")


class Expression(NamedTuple):
    text: str
    places: tuple[str, ...]
    """The places that it reads, each once."""
    evaluate: Evaluate
    texts: tuple[tuple[str, str], ...] = ()
    """Each place that is compared with a text by == or !=, and the text."""

    def __reduce__(self) -> tuple[Callable[[str], "Expression"], tuple[str]]:
        """An expression crosses a pipe as its text."""
        return expression_of, (self.text,)

    def holds(self, values: Mapping[str, Value]) -> bool:
        """Return whether it is true; a result that no number is, as of a division by zero, is not.

        TypeError for values that cannot be compared or counted with.
        """
        try:
            return bool(self.evaluate(values))
        except ArithmeticError:
            return False


def expression_of(text: str) -> Expression:
    """Return the expression of a text.  ValueError, saying what was expected and where, for any other text."""
    if len(text) > LONGEST:
        raise ValueError(f"it has {len(text)} characters\nexpected at most {LONGEST}")
    parser = _Parser(words_of(text))
    evaluate = parser.disjunction()
    parser.expect_end()
    return Expression(text, tuple(dict.fromkeys(parser.places)), evaluate, tuple(parser.texts))


class _Parser:
    """Recursive descent; each method returns what evaluates its part."""

    def __init__(self, words: Sequence[str]) -> None:
        self._words, self._at, self._depth = words, 0, 0
        self.places: list[str] = []
        self.texts: list[tuple[str, str]] = []

    def expect_end(self) -> None:
        if self._at < len(self._words):
            raise ValueError(
                f"{self._words[self._at]!r} does not go on\nexpected an operator between blanks, or the end"
            )

    def disjunction(self) -> Evaluate:
        parts = [self._conjunction()]
        while self._takes("or"):
            parts.append(self._conjunction())
        return parts[0] if len(parts) == 1 else lambda values: any(part(values) for part in parts)

    def _conjunction(self) -> Evaluate:
        parts = [self._negation()]
        while self._takes("and"):
            parts.append(self._negation())
        return parts[0] if len(parts) == 1 else lambda values: all(part(values) for part in parts)

    def _negation(self) -> Evaluate:
        if self._takes("not"):
            inner = self._deeper(self._negation)
            return lambda values: not inner(values)
        return self._level(0)

    def _level(self, number: int) -> Evaluate:
        """Read operators of one rank, from left to right."""
        if number == len(LEVELS):
            return self._signed()
        begin = self._at
        left, operators = self._level(number + 1), LEVELS[number]
        while (word := self._word()) in operators:
            middle = self._at
            self._at += 1
            right = self._bare_text() if word in ("==", "!=") else None
            left = _applied(operators[word], left, self._level(number + 1) if right is None else right)
            if word in ("==", "!="):
                self._note_text(self._words[begin:middle], self._words[middle + 1 : self._at])
            if number == 0:
                break
        return left

    def _note_text(self, left: Sequence[str], right: Sequence[str]) -> None:
        """Note a place that is compared with a text, each alone on its side."""
        for place, text in ((left, right), (right, left)):
            if len(place) == len(text) == 1 and place[0] in self.places:
                quote = text[0][:1]
                if quote in ("'", '"'):
                    self.texts.append((place[0], text[0][1:-1]))
                elif _TEXT.fullmatch(text[0]) and text[0].lower() not in CONSTANTS:
                    self.texts.append((place[0], text[0]))

    def _bare_text(self) -> Evaluate | None:
        """Return a single word as a text; None if it is something else."""
        word, behind = self._word(), self._words[self._at + 1 : self._at + 2]
        if word.lower() in CONSTANTS or not _TEXT.fullmatch(word) or behind not in ([], [")"], ["and"], ["or"]):
            return None
        self._at += 1
        return _constant(word)

    def _signed(self) -> Evaluate:
        if self._takes("-"):
            inner = self._deeper(self._signed)
            return lambda values: -inner(values)
        return self._single()

    def _single(self) -> Evaluate:
        word = self._word()
        self._at += 1
        if word == "(":
            inner = self._deeper(self.disjunction)
            self._expect(")")
            return inner
        if word in FUNCTIONS and self._takes("("):
            return self._call(word)
        if word in KINDS and self._takes("("):
            return self._named(word)
        if word[:1] in ("'", '"') and word:
            return _constant(word[1:-1])
        if word.lower() in CONSTANTS:
            return _constant(CONSTANTS[word.lower()])
        if _NUMBER.fullmatch(word):
            return _constant(float(word) if re.search(r"[.eE]", word) and "x" not in word.lower() else int(word, 0))
        if "/" in word.strip("/"):
            return self._place(word)
        got = f"got {word!r}" if word else "got the end"
        raise ValueError(f"{got}\nexpected a place such as tank/level, a number, true, false or a text in quotes")

    def _call(self, name: str) -> Evaluate:
        arguments = [self._deeper(self.disjunction)]
        while self._takes(","):
            arguments.append(self._deeper(self.disjunction))
        self._expect(")")
        check_count(name, len(arguments))
        function = FUNCTIONS[name]
        return lambda values: function(*(argument(values) for argument in arguments))

    def _named(self, kind: str) -> Evaluate:
        """Read the name of a message or a diagnosis, up to its bracket."""
        begin = self._at
        while self._word() not in (")", ""):
            self._at += 1
        inner = " ".join(self._words[begin : self._at])
        self._expect(")")
        return self._place(str(call_of(f"{kind}({inner})")))

    def _place(self, name: str) -> Evaluate:
        self.places.append(name)
        return lambda values: values[name]

    def _deeper(self, read: Callable[[], Evaluate]) -> Evaluate:
        self._depth += 1
        if self._depth > DEEPEST:
            raise ValueError(f"it is nested too deeply\nexpected at most {DEEPEST} brackets within one another")
        inner = read()
        self._depth -= 1
        return inner

    def _word(self) -> str:
        return self._words[self._at] if self._at < len(self._words) else ""

    def _takes(self, word: str) -> bool:
        is_there = self._word().lower() == word
        self._at += is_there
        return is_there

    def _expect(self, word: str) -> None:
        if not self._takes(word):
            raise ValueError(f"got {self._word()!r}\nexpected {word!r}")


def _constant(value: Value) -> Evaluate:
    return lambda values: value


def _applied(function: Callable[[Any, Any], Any], left: Evaluate, right: Evaluate) -> Evaluate:
    return lambda values: function(left(values), right(values))
