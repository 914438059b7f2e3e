"""Write a source text in one layout: names and labels in the first column, statements indented, even blanks.

The formatter works on the tokens of each line, so comments, numbers and capitals stay as the author has written them.
A line never gets other tokens, nor more than the 120 characters that it may have (manual 5.1).
"""

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Final

from fieldrig_devices.arp.language.tokens import LONGEST_LINE, Kind, Token, tokens
from fieldrig_devices.languages.mistakes import LineError, Mistake

INDENT: Final = "  "
COMMENT_COLUMN: Final = 32
"""Characters in front of a comment behind a statement, if the statement is shorter."""
_BORDERS: Final = frozenset(("BEG", "BEGA", "END", "ENDA"))
_NO_BLANK_BEFORE: Final = (",", ")", "]", ":")
_NO_BLANK_AFTER: Final = ("(", "[")
_PREFIXES: Final = ("-", "+", "/", "\\", "!", "%")
"""Signs in front of one operand, or between two."""
_CLOSING: Final = (")", "]")
_OPERANDS: Final = (Kind.WORD, Kind.NUMBER, Kind.SYSTEM, Kind.STRING)


def strangers(text: str) -> list[Mistake]:
    """Return why this is no text of an ARP: lines with characters that have no meaning."""
    found = []
    for number, line in enumerate(_lines(text), start=1):
        try:
            tokens(line)
        except LineError as wrong:
            found.append(Mistake(number, wrong.column, wrong.what, wrong.expected))
    return found


def formatted(text: str) -> str:
    """Return the text in the layout of fieldrig; it has no `strangers`.  Formatting it again changes nothing."""
    lines = [line.rstrip() for line in _lines(text)]
    widths = list(_widths(lines))
    written: list[str] = []
    is_inside = False
    for line, width in zip(lines, widths, strict=True):
        found = tokens(line)
        is_inside = is_inside or found[0].is_word("BEG", "BEGA")
        shown = _line(line, found, width, INDENT if is_inside else "")
        is_inside = is_inside and not found[0].is_word("END", "ENDA")
        if shown or (written and written[-1]):
            written.append(shown)
    return "\n".join(written).rstrip("\n") + "\n"


def _lines(text: str) -> list[str]:
    return re.split(r"\r\n|\n|\r", text)


def _widths(lines: Sequence[str]) -> Iterator[int]:
    """Yield for each line how wide its name is in front of EQU, as wide as in all lines of EQU beside it."""
    names = [found[0].text if _is_equ(found := tokens(line)) else "" for line in lines]
    width = 0
    for place, name in enumerate(names):
        if name and not (place and names[place - 1]):
            end = next((behind for behind in range(place, len(names)) if not names[behind]), len(names))
            width = max(map(len, names[place:end]))
        yield width if name else 0


def _is_equ(found: Sequence[Token]) -> bool:
    return len(found) > 2 and found[0].kind is Kind.WORD and found[1].is_word("EQU")


def _line(line: str, found: list[Token], width: int, indent: str) -> str:
    """Return one line in its layout; as it is if it would get too long."""
    comment = line[found[-1].column - 1 :].strip()
    code = _code(line, found, width, indent)
    if not found[:-1]:
        return f"{indent if line[:1].isspace() else ''}{comment}".rstrip()
    if not comment:
        return code if len(code) <= LONGEST_LINE else line
    for shown in (f"{code} ".ljust(COMMENT_COLUMN) + comment, f"{code} {comment}"):
        if len(shown) <= LONGEST_LINE:
            return shown
    return line


def _code(line: str, found: list[Token], width: int, indent: str) -> str:
    """Return the code of a line with its indentation and even blanks."""
    texts = [line[token.column - 1 : behind.column - 1].rstrip() for token, behind in pairwise(found)]
    if not texts:
        return ""
    if width:
        texts[0] = texts[0].ljust(width)
    is_label = len(found) > 2 and found[0].kind is Kind.WORD and found[1].is_sign(":")
    is_outer = is_label or width > 0 or (found[0].kind is Kind.WORD and found[0].text in _BORDERS)
    code = "" if is_outer else indent
    for place, text in enumerate(texts):
        blank = " " if place and _has_blank(line, found, place) else ""
        code += f"{blank}{text}"
    return code if _alike(tokens(code), found) else f"{code[: len(code) - len(code.lstrip())]}{_stripped(line, found)}"


def _alike(one: Sequence[Token], other: Sequence[Token]) -> bool:
    return [(token.kind, token.text) for token in one] == [(token.kind, token.text) for token in other]


def _stripped(line: str, found: Sequence[Token]) -> str:
    """Return the code of a line as it was written, where even blanks would make one sign of two that are wrong."""
    return line[: found[-1].column - 1].strip()


def _has_blank(line: str, found: list[Token], place: int) -> bool:
    """True if there is a blank between a token and the one before it."""
    before, token = found[place - 1], found[place]
    if token.is_sign(*_NO_BLANK_BEFORE) or before.is_sign(*_NO_BLANK_AFTER) or _is_prefix(found, place - 1):
        return False
    if token.is_sign("("):  # a function, or a word in front of brackets: as it was written
        return line[token.column - 2] in " \t" or before.kind is Kind.SIGN
    return not token.is_sign("[")


def _is_prefix(found: list[Token], place: int) -> bool:
    """True for a sign in front of its operand."""
    if not found[place].is_sign(*_PREFIXES):
        return False
    before = found[place - 1] if place else found[place]
    return not (before.kind in _OPERANDS or before.is_sign(*_CLOSING))
