"""Write a source text in one layout: indented by its structure, with even blanks.

The formatter works on tokens, so comments, directives and the lines of the author stay, and a program with mistakes can
be formatted as well.  A line goes a level deeper behind what END or a word such as END_IF closes.
"""

from collections.abc import Sequence
from typing import Final

from fieldrig_devices.languages.mistakes import Mistake
from fieldrig_devices.pam.language.objects import KINDS
from fieldrig_devices.pam.language.reserved import declared_names
from fieldrig_devices.pam.language.tokens import Token, split
from fieldrig_devices.pam.language.words import STRUCTURE

INDENT: Final = 2
CONTINUED: Final = 4
"""Blanks in front of the further lines of a statement, beyond its level."""
_DECLARATIONS: Final = frozenset(kind for kind in KINDS if " " not in kind)
_PROGRAM_WORDS: Final = (
    "APPLICATION BOOLEAN ACTIONS ROUTINES ROUTINE TASK SEQUENCE SPECS EVENTS POWERON IF LOOP CASE "
    "VME RS422 DUALPORT_IN DUALPORT_OUT"
)
_OPENING: Final = _DECLARATIONS | frozenset(_PROGRAM_WORDS.split())
_BEGINNING_WORDS: Final = "THEN ELSE ACTION LOOP CASE APPLICATION SPECS EVENTS POWERON DUALPORT DUAL_PORT PORT"
_BEGINNINGS: Final = frozenset(_BEGINNING_WORDS.split())
"""Words that a statement or declaration follows without a semicolon."""
_ENDS: Final = frozenset(word for word in STRUCTURE if word.startswith("END"))
_NO_BLANK_BEFORE: Final = frozenset((";", ",", ")", ":", "[i]", "[all]", "[all+]", "[all*]", "."))
_NO_BLANK_AFTER: Final = frozenset(("(", "!", ":", "."))
_OPERANDS: Final = frozenset((")", "[i]", "[all]", "[all+]", "[all*]"))


def formatted(text: str) -> str:
    """Return the text in the layout of fieldrig.  Formatting it again changes nothing."""
    source = split(text, "")
    lines = text.split("\n")
    comments = {place.line: comment for place, comment in source.comments if "\n" not in comment}
    directives = _directives(lines, source.tokens)
    kept = directives | _kept_comments([(place.line, comment) for place, comment in source.comments])
    kept |= {wrong.line for wrong in source.mistakes}
    layout = _Layout(source.tokens)
    written: list[str] = []
    for number, line in enumerate(lines, 1):
        if number in kept or not line.strip():
            written.append(line.rstrip())
            layout.pass_line(number, is_directive=number in directives)
            continue
        code, indent = layout.line(number)
        comment = comments.get(number, "")
        written.append(f"{' ' * indent}{code}{'  ' if code and comment else ''}{comment}".rstrip())
    return "\n".join(_without_double_gaps(written)).strip("\n") + "\n"


def strangers(text: str, file: str) -> list[Mistake]:
    """Return why this is no text of a PAM: signs without a meaning, or neither a semicolon nor a word of it."""
    source = split(text, file)
    known = STRUCTURE | _OPENING | {";"}
    is_known = any(token.kind == "directive" or token.text in known for token in source.tokens)
    if source.mistakes or is_known or not source.tokens[:-1]:
        return source.mistakes
    place = source.tokens[0].place
    return [Mistake(place.line, place.column, "this is no text of a PAM", "words such as NODE or IF", file=file)]


def _directives(lines: Sequence[str], tokens: Sequence[Token]) -> set[int]:
    """Return the numbers of the lines with directives, and of those that continue them."""
    numbers: set[int] = set()
    for token in tokens:
        if token.kind == "directive":
            number = token.place.line
            numbers.add(number)
            while number <= len(lines) and lines[number - 1].rstrip().endswith("\\"):
                number += 1
                numbers.add(number)
    return numbers


def _kept_comments(comments: Sequence[tuple[int, str]]) -> set[int]:
    """Return the numbers of lines whose comments cannot be moved: of several lines, several, or with code behind."""
    numbers = [number for number, _ in comments]
    kept = {number for number, comment in comments if comment.endswith("*/") or numbers.count(number) > 1}
    for number, comment in comments:
        if "\n" in comment:
            kept |= set(range(number, number + comment.count("\n") + 1))
    return kept


def _without_double_gaps(lines: Sequence[str]) -> list[str]:
    return [line for position, line in enumerate(lines) if line or position == 0 or lines[position - 1]]


class _Layout:
    """Follows the structure of a text from line to line."""

    def __init__(self, tokens: Sequence[Token]) -> None:
        self.tokens = tokens
        self._names = declared_names(tokens)
        self.at = 0
        self.level = 0
        self.begins = True
        """True in front of a statement or declaration."""

    def pass_line(self, number: int, *, is_directive: bool = False) -> None:
        """Go behind a line."""
        while self.tokens[self.at].place.line <= number and self.tokens[self.at].kind != "end":
            if is_directive:
                self.at += 1
            else:
                self._step()

    def line(self, number: int) -> tuple[str, int]:
        """Return the code of a line, and how far it is indented."""
        begin, begins, level = self.at, self.begins, self.level
        self.pass_line(number)
        tokens = self.tokens[begin : self.at]
        first = self._word(tokens[0]) if tokens else ""
        is_outer = first in _ENDS or first == "ELSE"
        is_continued = bool(tokens) and not begins and not is_outer
        indent = max(level - is_outer, 0) * INDENT + is_continued * CONTINUED
        return _code(self.tokens, begin, self.at), indent

    def _step(self) -> None:
        token = self.tokens[self.at]
        word = self._word(token)
        following = self.tokens[self.at + 1].text
        is_end = word in _ENDS
        is_item = self.begins and following != "=" and (word in _OPENING or self._opens_variable(word))
        if is_end:
            self.level = max(self.level - 1, 0)
        elif is_item or word == "ACTION":
            self.level += 1
        self.begins = token.text == ";" or word in _BEGINNINGS or (is_end and word != "END_LOOP")
        self.at += 1

    def _word(self, token: Token) -> str:
        """Return a keyword in capitals; nothing for anything else that is no keyword in this program."""
        return token.text.upper() if token.kind == "name" and token.text not in self._names else ""

    def _opens_variable(self, word: str) -> bool:
        """True for a variable with a body, as in INTERNAL FLAG_VAR x; NUMBER = 3; END."""
        if word not in ("INTERNAL", "COMMON", "INPUT", "OUTPUT") or self.at + 4 >= len(self.tokens):
            return False
        following = self.tokens[self.at + 4].text.upper()
        return following == "END" or (
            following in ("NUMBER", "NODES_GROUP", "PERIOD") and self.tokens[self.at + 5].text == "="
        )


def _code(tokens: Sequence[Token], begin: int, end: int) -> str:
    """Return tokens with even blanks between them; with one between any two where some would become other tokens.

    Only a wrong program has such a place: `101 .` without its blank is a number, and `! =` is no sign of the language.
    """
    even = "".join(" " * (at > begin and _has_blank(tokens, at)) + _written(tokens[at]) for at in range(begin, end))
    is_same = [token.text for token in split(even, "").tokens[:-1]] == [token.text for token in tokens[begin:end]]
    return even if is_same else " ".join(_written(token) for token in tokens[begin:end])


def _written(token: Token) -> str:
    return f'"{token.value}"' if token.kind == "text" else token.text


def _has_blank(tokens: Sequence[Token], at: int) -> bool:
    """True if a blank precedes this token."""
    text, before = tokens[at].text, tokens[at - 1]
    if text in _NO_BLANK_BEFORE or before.text in _NO_BLANK_AFTER:
        return False
    if text == "(":
        return not (before.kind == "name" and tokens[at - 2].text in ("<-", "?"))
    is_sign = before.kind == "sign" and before.text in ("+", "-") and at >= 2
    if (is_sign and tokens[at].kind in ("integer", "real", "name")) or (is_sign and text in ("(", "!")):
        earlier = tokens[at - 2]
        return earlier.kind in ("name", "integer", "real") or earlier.text in _OPERANDS
    return True
