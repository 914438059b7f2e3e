"""Split one line of ARP source into words, numbers and signs.

Source: manual 5, 5.1; digest chapter 3.  Upper and lower case are equivalent.  Blanks only separate, but none is
allowed between a system variable and its number.  Strings may be in typographic quotes, as the manual prints them.
"""

import re
from enum import Enum
from typing import NamedTuple

from fieldrig_devices.languages.mistakes import LineError

LONGEST_LINE = 120  # manual 5.1, including blanks and comment


class Kind(Enum):
    WORD = "a name"
    NUMBER = "a number"
    STRING = "a string"
    SYSTEM = "a system variable"
    SIGN = "a sign"
    END = "the end of the line"


class Token(NamedTuple):
    kind: Kind
    text: str
    """Text in capitals; the text of a string keeps its case and has no quotes."""
    column: int

    def is_sign(self, *signs: str) -> bool:
        return self.kind is Kind.SIGN and self.text in signs

    def is_word(self, *words: str) -> bool:
        return self.kind is Kind.WORD and self.text in words

    def __str__(self) -> str:
        return self.kind.value if self.kind is Kind.END else f'"{self.text}"'


_TOKEN = re.compile(
    r"""
      (?P<blank>[ \t]+)
    | (?P<end>;.*)
    | (?P<system>[@\#][ ]*[A-Za-z]+[0-9]*)
    | (?P<word>[A-Za-z][A-Za-z0-9_]*)
    | (?P<number>[0-9]+(?:\.[0-9]*)?)
    | (?P<string>["“”„][^"“”„]*["“”„])
    | (?P<sign><<=|>>=|<<|>>|<=|>=|<>|==|\+=|-=|\*=|/=|\\=|%=|&=|\|=|\^=|[-+*/\\%&|^!=<>(),:\[\]])
    """,
    re.VERBOSE | re.ASCII,
)
_KINDS = {"system": Kind.SYSTEM, "word": Kind.WORD, "number": Kind.NUMBER, "string": Kind.STRING, "sign": Kind.SIGN}


def tokens(line: str) -> list[Token]:
    """The tokens of a line, the last of which is always END.  Raises LineError for an unexpected character."""
    words = []
    at = 0
    while at < len(line):
        match = _TOKEN.match(line, at)
        if match is None:
            raise _unexpected(line, at)
        if match.lastgroup == "end":
            break
        if match.lastgroup in _KINDS:
            words.append(_token(_KINDS[match.lastgroup], match[0], at + 1))
        at = match.end()
    return [*words, Token(Kind.END, "", at + 1)]


def _token(kind: Kind, text: str, column: int) -> Token:
    return Token(kind, text[1:-1] if kind is Kind.STRING else text.upper(), column)


def _unexpected(line: str, at: int) -> LineError:
    if line[at] in '"“”„':
        return LineError(at + 1, "the string has no end", "a closing quote on the same line")
    shown = line[at] if line[at].isprintable() else f"U+{ord(line[at]):04X}"
    return LineError(at + 1, f'"{shown}" has no meaning here', "printable ASCII; comments begin with ;")
