"""Split the text of an application into tokens, and set the comments aside (section 1.1 of the manual's digest).

A comment is a block, from `/**` to the end of the line, or from `//` to the end of the line.  Blocks do not nest.  The
sign # is in front of hexadecimal digits, and before a directive at the beginning of a line.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

from fieldrig_devices.languages.mistakes import Mistake
from fieldrig_devices.pam.language.objects import KINDS, SPECS
from fieldrig_devices.pam.language.tree import Place

Kind = Literal["name", "integer", "real", "text", "directive", "sign", "end"]

LONGEST_SOURCE: Final = 4 << 20
"""Characters of one source file.  A compiled application has at most 262,144 bytes (PAML-013)."""
LARGEST_INTEGER: Final = 0xFFFF_FFFF
"""Masks of errors use all 32 bits."""

_PATTERN: Final = re.compile(
    r"""(?P<blank>[ \t\r\f\v]+|\\[ \t\r]*\n)
      | (?P<line>\n)
      | (?P<stray>\*/)
      | (?P<foreign>!=|==|:=|->|=>|=<|><|<[–−]|[≠≤≥←–−；，~]|&&?|\|\||\*\*)
      | (?P<pascal>\(\*(?:[^*]|\*(?!\)))*\*\))
      | (?P<comment>//[^\n]*|/\*\*(?!/)(?:(?!\*/)[^\n])*(?:\*/)?|/\*(?!\*)(?:[^*]|\*(?!/))*\*/|/\*\*/)
      | (?P<directive>\#[ \t]*(?i:define|set|undef|include)\b)
      | (?P<time>(?:(?i:t|time)\#)?[0-9]+(?:\.[0-9]+)?(?i:ms|s|sec|min|h)(?![\w.])|(?i:t|time)\#\w[\w.]*)
      | (?P<number>(?:0[xX]|16\#|\$)[0-9A-Fa-f]+(?!\w)|[0-9]+(?:\.[0-9]*)?[eE][-+]?[0-9]+(?!\w)
          |[0-9][0-9A-Fa-f]*[hH](?!\w)|(?:0[bB]|2\#)[01_]+(?!\w)|(?:0[oO]|8\#)[0-7_]+(?!\w)|[0-9]+(?:_[0-9]+)+(?!\w)
          |(?<![\w.])\.[0-9]+(?![\w.]))
      | (?P<hexadecimal>\#[0-9A-Fa-f]+(?!\w))
      | (?P<real>[0-9]+\.[0-9]+(?![\w.])|[0-9]+\.(?![\w.]))
      | (?P<integer>[0-9]+(?![\w]))
      | (?P<name>[^\W\d]\w*)
      | (?P<text>"[^"\n]*")
      | (?P<quoted>'[^'"\n]*'|[“”„][^“”"\n]*[“”])
      | (?P<index>\[[ \t]*(?i:i|all[ \t]*[+*]?)[ \t]*\])
      | (?P<wrong_index>\[[^\[\]\n;]*\])
      | (?P<sign><-|<<|<=|>=|<>|[-+*%^=<>!?:;,()|.]|/(?!\*))
    """,
    re.VERBOSE,
)

_BLOCK: Final = re.compile(r"/\*(?!\*)")
_PARAMETERS: Final = frozenset(
    {"NAME", "LINKED_OUTPUT", "EQUATION"}
    | {name for rules in (*KINDS.values(), *SPECS.values()) for name in rules if name != "ON"}
)
"""Words with = behind them."""
FOREIGN: Final[Mapping[str, str]] = {
    "!=": "<>",
    "==": "=",
    ":=": "<-",
    "->": "<-",
    "=>": ">=",
    "=<": "<=",
    "><": "<>",
    "≠": "<>",
    "≤": "<=",
    "≥": ">=",
    "&": "*",
    "&&": "*",
    "||": "+",
    "**": "^",
    "←": "<-",
    "<–": "<-",
    "<−": "<-",
    "–": "-",
    "−": "-",
    "；": ";",
    "，": ",",
    "~": "!",
}
"""Signs of other languages, and what they are here."""
_TIME: Final = re.compile(r"(?:t|time)?#?([0-9]+(?:\.[0-9]+)?)(ms|s|sec|min|h)", re.IGNORECASE)
_BASES: Final = {"0x": 16, "16#": 16, "$": 16, "0b": 2, "2#": 2, "0o": 8, "8#": 8}
"""The marks of numbers in other languages, and their bases."""
_MILLISECONDS: Final = {"ms": 1, "s": 1_000, "sec": 1_000, "min": 60_000, "h": 3_600_000}


@dataclass(frozen=True, slots=True)
class Token:
    kind: Kind
    text: str
    place: Place
    value: int | float | str = 0
    """The value of a number or text."""
    begins_line: bool = False


@dataclass(slots=True)
class Tokens:
    """The tokens of one file; the last is of the kind `end`."""

    tokens: list[Token] = field(default_factory=list)
    comments: list[tuple[Place, str]] = field(default_factory=list)
    mistakes: list[Mistake] = field(default_factory=list)


def split(text: str, file: str) -> Tokens:
    """Return the tokens of a source text.  What is no token is reported once a line and passed over."""
    source = Tokens()
    line, line_start, at = 1, 0, 0
    begins_line = True
    last_wrong_line = 0
    comment = _Comment()
    while at < len(text):
        match = _PATTERN.match(text, at)
        place = Place(file, line, at - line_start + 1)
        if match is None:
            if line != last_wrong_line:
                source.mistakes.append(_wrong_character(text, at, place))
                last_wrong_line = line
            at += len(text) - at if text.startswith("/*", at) else 1
            continue
        kind, word = match.lastgroup, match.group()
        if kind == "line":
            begins_line = True
        elif kind == "comment":
            source.comments.append((place, word.rstrip()))
            inner = text.count("/*", at + 2, match.end()) if _BLOCK.match(word) else 0
            _suspect(comment, source)
            comment = _Comment(at, len(source.tokens), len(source.mistakes), inner)
        elif kind == "stray":
            _close_again(source, text, match.end(), place, comment)
        elif kind in _FOREIGN:
            source.tokens += _FOREIGN[kind](word, place, begins_line, source)
            begins_line = False
        elif kind != "blank":
            source.tokens.append(_token(kind or "", word, place, begins_line, source.mistakes))
            begins_line = False
        if "\n" in word:
            line += word.count("\n")
            line_start = at + word.rindex("\n") + 1
        at = match.end()
    _suspect(comment, source)
    source.tokens.append(Token("end", "the end of the text", Place(file, line, at - line_start + 1), begins_line=True))
    return source


def _token(kind: str, word: str, place: Place, begins_line: bool, mistakes: list[Mistake]) -> Token:
    match kind:
        case "hexadecimal":
            return Token("integer", word, place, _limited(int(word[1:], 16), word, place, mistakes), begins_line)
        case "integer":
            return Token("integer", word, place, _limited(_decimal(word), word, place, mistakes), begins_line)
        case "real":
            return Token("real", word, place, float(word), begins_line)
        case "text":
            return Token("text", word, place, word[1:-1], begins_line)
        case "directive":
            return Token("directive", word[1:].strip().lower(), place, 0, begins_line)
        case "index":
            return Token("sign", "".join(word.split()).lower(), place, 0, begins_line)
        case "name":
            return Token("name", word, place, 0, begins_line)
    return Token("sign", word, place, 0, begins_line)


def _native(word: str, place: Place, begins_line: bool, source: Tokens) -> Sequence[Token]:
    """Report a sign of another language, and return what it is in this one."""
    before = [token.text for token in source.tokens[-2:]]
    is_parameter = bool(before) and before[-1].upper() in _PARAMETERS and before[0] != ":"
    right = "=" if is_parameter and word in ("==", ":=") else FOREIGN[word]
    source.mistakes.append(mistake(place, f"got {word}", right))
    return (Token("sign", right, place, 0, begins_line),)


def _native_number(word: str, place: Place, begins_line: bool, source: Tokens) -> Sequence[Token]:
    """Report a number of another language, such as 0x1F or 1e3, and return the number that it means."""
    right, kind = _number_here(word)
    source.mistakes.append(mistake(place, f"got {word}", right or "a number without an exponent"))
    if not right:
        return (Token("real", word, place, float(word), begins_line),)
    return (_token(kind, right, place, begins_line, source.mistakes),)


def _number_here(word: str) -> tuple[str, Literal["hexadecimal", "integer", "real"]]:
    """Return the number that a word means, and its kind; an empty one for an exponent."""
    for marks, base in _BASES.items():
        if word.lower().startswith(marks):
            digits = word[len(marks) :].strip("_")
            return (f"#{digits}", "hexadecimal") if base == 16 else (str(int(digits or "0", base)), "integer")
    if word[-1] in "hH":
        return f"#{word[:-1]}", "hexadecimal"
    if word.startswith("."):
        return f"0{word}", "real"
    return (word.replace("_", ""), "integer") if "_" in word else ("", "real")


def _native_time(word: str, place: Place, begins_line: bool, source: Tokens) -> Sequence[Token]:
    """Report a time with a unit, such as 5s or T#5s, and return its milliseconds: a time is always a number of them."""
    parts = _TIME.fullmatch(word)
    right = "" if parts is None else f"{float(parts[1]) * _MILLISECONDS[parts[2].lower()]:.15g}"
    if not right.isdecimal():
        source.mistakes.append(mistake(place, f"got {word}", "a number of milliseconds without a unit"))
        return (Token("integer", word, place, 0, begins_line),)
    source.mistakes.append(mistake(place, f"got {word}", right, "A time is a number of milliseconds, without a unit."))
    return (_token("integer", right, place, begins_line, source.mistakes),)


def _native_text(word: str, place: Place, begins_line: bool, source: Tokens) -> Sequence[Token]:
    """Report a text between the quotation marks of IEC languages, and return it."""
    right = f'"{word[1:-1]}"'
    source.mistakes.append(mistake(place, f"got {word}", right))
    return (_token("text", right, place, begins_line, source.mistakes),)


def _pascal_comment(word: str, place: Place, _begins_line: bool, source: Tokens) -> Sequence[Token]:
    """Report a comment of IEC languages, and pass over it."""
    source.mistakes.append(mistake(place, "got (*", "a comment, /* ... */ or // up to the end of the line"))
    source.comments.append((place, f"/*{word[2:-2]}*/"))
    return ()


def _wrong_index(_word: str, place: Place, _begins_line: bool, source: Tokens) -> Sequence[Token]:
    source.mistakes.append(_index_is_wrong(place))
    return ()


_FOREIGN: Final[Mapping[str | None, Callable[[str, Place, bool, Tokens], Sequence[Token]]]] = {
    "foreign": _native,
    "number": _native_number,
    "time": _native_time,
    "quoted": _native_text,
    "wrong_index": _wrong_index,
    "pascal": _pascal_comment,
}
"""The functions that read each sort of tokens that this language does not have."""


@dataclass(slots=True)
class _Comment:
    """The last comment."""

    start: int = 0
    tokens: int = 0
    """The number of tokens in front of it, and that of mistakes."""
    mistakes: int = 0
    inner: int = 0
    """The number of comments that seem to begin in it."""


def _suspect(comment: _Comment, source: Tokens) -> None:
    """Say that another comment begins in this one, whose own end may have been forgotten."""
    if comment.inner:
        begun, _ = source.comments[-1]
        hint = "Comments do not nest. Perhaps its own */ is missing, so that what follows is no part of the program."
        source.mistakes.append(mistake(begun, "the comment has another /* in it", "", hint, is_note=True))


def _close_again(source: Tokens, text: str, end: int, place: Place, comment: _Comment) -> None:
    """Report */ where no comment is open.  Behind a comment in which another one seems to begin, it belongs to that."""
    if not comment.inner:
        source.mistakes.append(mistake(place, "*/ ends no comment", "/* before it"))
        return
    begun, _ = source.comments[-1]
    hint = f"Comments do not nest: the one of line {begun.line} ends at its first */."
    del source.tokens[comment.tokens :], source.mistakes[comment.mistakes :]
    source.mistakes.append(mistake(place, "a comment is inside another one", "one comment", hint))
    source.comments[-1] = begun, text[comment.start : end]
    comment.inner -= 1


def _decimal(word: str) -> int:
    return int(word) if len(word) <= 20 else LARGEST_INTEGER + 1


def _limited(value: int, word: str, place: Place, mistakes: list[Mistake]) -> int:
    if value > LARGEST_INTEGER:
        shown = word if len(word) <= 20 else f"{word[:17]}..."
        mistakes.append(mistake(place, f"{shown} has more than 32 bits", f"at most {LARGEST_INTEGER}"))
        return LARGEST_INTEGER
    return value


def _wrong_character(text: str, at: int, place: Place) -> Mistake:
    if text.startswith("/*", at):
        return mistake(place, "the comment has no end", "*/")
    if text[at] == '"':
        return mistake(place, "the text has no end", 'a second " in the same line')
    if text[at] == "[":
        return _index_is_wrong(place)
    if text[at] == "#":
        return mistake(place, "# has no meaning here", "hexadecimal digits, define, set, undef or include")
    if text[at] in "{}":
        hint = "Statements are between words such as THEN and END_IF, and a comment is between /* and */."
        return mistake(place, f"{text[at]} has no meaning here", "", hint)
    return mistake(place, f"{text[at]!r} has no meaning here", "a name, a number, a text or a sign")


def _index_is_wrong(place: Place) -> Mistake:
    hint = "Items have no numbers in a program: [i] is the present item, [all] means each of them."
    return mistake(place, "an index is wrong", "[i], [all], [all+] or [all*]", hint)


def mistake(place: Place, what: str, expected: str = "", hint: str = "", *, is_note: bool = False) -> Mistake:
    """Return the message about a place in the sources."""
    return Mistake(place.line, place.column, what, expected, is_note, place.file, hint)
