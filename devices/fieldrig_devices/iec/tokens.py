"""Split a source text into tokens, and set the comments aside.

One regular expression finds all tokens; blanks between them are skipped.  What is misspelled in a way that is known,
such as ENDIF or ==, becomes the token that was meant, with its mistake, so that the parser goes on as if it were right.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from fieldrig_devices.iec import conditional
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.limits import MOST_MESSAGES
from fieldrig_devices.iec.tree import Position
from fieldrig_devices.languages.mistakes import Mistake

# Kinds of tokens.  A keyword or symbol is a kind of its own, in capitals.
NAME: Final = "name"
INTEGER: Final = "integer"
REAL: Final = "real"
STRING: Final = "string"
WIDE_STRING: Final = "wide string"
"""A constant of a WSTRING, in double quotes."""
TYPED: Final = "typed"
"""A constant or value of an enumeration with a type in front of it: T#5s, INT#16#FF, Colour#red."""
DIRECT: Final = "direct"
PART: Final = "part"
"""A part of a value behind a point: %X3, %B1."""
NATIVE: Final = "{native}"
JUNK: Final = "junk"
"""The kind of a token that cannot be read where an operand is expected; it has its mistake."""
END: Final = "end of the text"

_KEYWORD_TEXT = """
    TRUE FALSE NOT AND OR XOR MOD IF THEN ELSIF ELSE END_IF CASE OF END_CASE FOR TO BY DO END_FOR WHILE END_WHILE
    REPEAT UNTIL END_REPEAT EXIT RETURN VAR VAR_INPUT VAR_OUTPUT VAR_IN_OUT VAR_TEMP VAR_EXTERNAL VAR_GLOBAL VAR_CONFIG
    VAR_ACCESS END_VAR CONSTANT RETAIN PERSISTENT AT TYPE END_TYPE STRUCT END_STRUCT ARRAY POINTER PROGRAM END_PROGRAM
    FUNCTION END_FUNCTION FUNCTION_BLOCK END_FUNCTION_BLOCK ACTION END_ACTION CONFIGURATION END_CONFIGURATION RESOURCE
    END_RESOURCE INITIAL_STEP END_STEP TRANSITION END_TRANSITION END_ENTRY END_ACTIVE END_EXIT
    """
KEYWORDS: Final = frozenset(_KEYWORD_TEXT.split())
"""Words that are never names.  STEP, TASK, ON, WITH, FROM and the like are keywords at their places only."""

FREE_IN_OBJECTS: Final = frozenset(
    {"CONFIGURATION", "END_CONFIGURATION", "RESOURCE", "END_RESOURCE", "INITIAL_STEP", "TRANSITION"}
)
"""Keywords that a text cannot begin with in a file of TwinCAT, where they may be names."""
MISSPELLED: Final[Mapping[str, str]] = {
    **{f"END{word}": f"END_{word}" for word in ("IF", "CASE", "FOR", "WHILE", "REPEAT", "VAR", "TYPE", "STRUCT")},
    **{f"END{word}": f"END_{word}" for word in ("PROGRAM", "FUNCTION", "FUNCTIONBLOCK", "ACTION", "STEP")},
    "ENDFUNCTION_BLOCK": "END_FUNCTION_BLOCK",
    "ENDFUNCTIONBLOCK": "END_FUNCTION_BLOCK",
    "END_FUNCTIONBLOCK": "END_FUNCTION_BLOCK",
    "FUNCTIONBLOCK": "FUNCTION_BLOCK",
    "END_FB": "END_FUNCTION_BLOCK",
    "VAR_END": "END_VAR",
    "TYPE_END": "END_TYPE",
    "STRUCT_END": "END_STRUCT",
    "IF_END": "END_IF",
    "ELSEIF": "ELSIF",
    "ELIF": "ELSIF",
    "ENDLOOP": "END_WHILE",
}
"""Words of other languages and of misprints (X12), and what is meant."""

_MISSPELLED_SIGNS: Final[Mapping[str, tuple[str, str]]] = {
    "==": ("=", "A comparison is written with one equals sign."),
    "!=": ("<>", "The sign for unequal is <>."),
    "&&": ("AND", "The operator is AND or &."),
    "||": ("OR", "The operator is OR."),
    "=<": ("<=", "The sign for less or equal is <=."),
    "::=": (":=", "The sign of the assignment is :=."),
    ": =": (":=", "There is no blank in the sign of the assignment."),
}

_TYPOGRAPHIC: Final[Mapping[str, str]] = {
    "←": ":=",
    "–": "-",
    "−": "-",
    "×": "*",
    "÷": "/",
    "≠": "<>",
    "≤": "<=",
    "≥": ">=",
    "；": ";",
    "，": ",",
    "：": ":",
    "（": "(",
    "）": ")",
}
"""Signs that a word processor writes, and what is meant."""
_OF_OTHER_LANGUAGES: Final = re.compile(
    r"(?:0x(?P<hex>[0-9a-f_]+)|0b(?P<bin>[01_]+)|0o(?P<oct>[0-7_]+)|\$(?P<dollar>[0-9a-f]+)"
    r"|(?P<suffix>[0-9][0-9a-f]*)h)\b",
    re.IGNORECASE,
)
"""Numbers as other languages write them."""
_BASES: Final = {"hex": 16, "bin": 2, "oct": 8, "dollar": 16, "suffix": 16}
_SAID: Final = re.compile(r"\{\s*(error|warning|info|text)\s+'((?:\$.|[^'$])*)'\s*\}", re.IGNORECASE | re.DOTALL)
"""A message of the compiler that a program has."""
_QUOTED: Final = re.compile(r"'[^']*'|\"[^\"]*\"")
_BLANKS: Final = " \t\r\f\v"
# Python tries the alternatives in their order, so the frequent ones come first: in our libraries and examples, 93 of
# 100 matches are words, signs and ends of lines.  Integers may precede real numbers because they look ahead.  What is
# open or wrong comes last, and the last alternative takes any character, so that no text is left over.
# Possessive repeats (*+ and ++) give no character back.  With plain ones, ten thousand digits before a letter that fits
# nowhere took thirty times as long, because each alternative was tried with every length.
# The signs look ahead because (*, // and /* begin comments.
_PATTERN: Final = re.compile(
    r"""[ \t\r\f\v]*+(?:
      ([^\W\d]\w*+)(?!\#)
    | (:=|\?=|\+=|-=|\*=(?!\))|<=|>=|<>|=>|==|!=|&&|\|\||=<|::=|:[ ]=|\.\.|\*\*(?!\))
      |[;,.:=+\-*&<>)\[\]^]|\((?!\*)|/(?![/*]))
    | (\n)
    | ([0-9](?:_?[0-9])*+(?![\w#]|\.[0-9]))
    | (\(\*.*?\*\)|//[^\n]*+|/\*.*?\*/)
    | ('(?:[^'$\n]|\$[^\n])*+')
    | ("(?:[^"$\n]|\$[^\n])*+")
    | ((?:L?T|L?TIME)\#[-+]?\w*(?:\.[0-9]\w*)*
      |(?:L?D|L?DATE)\#(?:[0-9][0-9_]*-[0-9][0-9_]*-[0-9][0-9_]*|[\w.:-]*)
      |(?:L?TOD|L?TIME_OF_DAY)\#(?:[0-9][0-9_]*:[0-9][0-9_]*(?::[0-9][0-9_]*(?:\.[0-9][0-9_]*)?)?|[\w.:-]*)
      |(?:L?DT|L?DATE_AND_TIME)\#(?:[0-9][0-9_]*-[0-9][0-9_]*-[0-9][0-9_]*-[0-9][0-9_]*:[0-9][0-9_]*(?::[0-9][0-9_]*(?:\.[0-9][0-9_]*)?)?|[\w.:-]*)
      |[^\W\d]\w*+\#(?:'(?:[^'$\n]|\$[^\n])*+'|"(?:[^"$\n]|\$[^\n])*+"|[-+]?[0-9]+\#\w*|[-+]?[0-9][0-9_]*(?:\.[0-9][0-9_]*)?(?:E[-+]?[0-9][0-9_]*)?|\w*))
    | ([0-9](?:_?[0-9])*+(?:\.[0-9](?:_?[0-9])*+(?:E[-+]?[0-9](?:_?[0-9])*+)?|E[-+]?[0-9](?:_?[0-9])*+)(?!\w))
    | ([0-9]+\#\w*)
    | (%[IQM](?:[XBWDL](?:\*|[0-9]+(?:\.[0-9]+)*)|\*|[0-9]+(?:\.[0-9]+)*)(?!\w))
    | (\{\{|\{[^{}]*+\})
    | ((?:\(\*|/\*).*+)
    | (['"‘’“”´`](?:[ \t\r]*+(?:\)++|[^ \t\r\n]))*?(?=[ \t\r]*+\)*+[ \t\r]*+;?+[ \t\r]*+(?:\n|\Z|\(\*|//)))
    | ([0-9]\w*+(?:\.[0-9]\w*+)?|%\w*(?:\.[0-9]+)*|.)
    )""",
    re.VERBOSE | re.DOTALL | re.IGNORECASE,
)
(
    _WORD,
    _SIGN,
    _NEWLINE,
    _INTEGER,
    _COMMENT,
    _STRING,
    _WIDE_STRING,
    _TYPED,
    _REAL,
    _BASED,
    _DIRECT,
    _PRAGMA,
    _OPEN_COMMENT,
    _OPEN_STRING,
    _JUNK,
) = range(1, 16)
_KINDS: Final = {
    _INTEGER: INTEGER,
    _STRING: STRING,
    _TYPED: TYPED,
    _REAL: REAL,
    _BASED: INTEGER,
    _DIRECT: DIRECT,
}
_TIME_WITHOUT_PREFIX: Final = re.compile(r"(?:[0-9]+(?:d|h|ms|m|s)_?)+", re.IGNORECASE)
_PART: Final = re.compile("%[XBWDL][0-9]{1,2}", re.IGNORECASE)
_OPERAND_ENDS: Final = frozenset({NAME, INTEGER, REAL, ")", "]", "^"})
"""The kinds of tokens that end an operand."""
_BEFORE_WORD: Final = re.compile(r"(\d+)(?:THEN|DO|OF|TO|BY|AND|OR|XOR|MOD|END_\w+)", re.IGNORECASE)
"""A number with the next word right behind it, `IF n > 0THEN`."""
_NAMED_IN_TESTS: Final = frozenset({"TEST", "SKIP", "RIG", "USES"})
"""The words of test files with a text behind them."""
_OPERATORS: Final = frozenset({"__ISVALIDREF", "__POUNAME", "__QUERYINTERFACE", "__QUERYPOINTER"})
"""Names of functions of today's tools that begin with two underscores."""
_EXCEPTIONS: Final = ("__TRY", "__CATCH", "__FINALLY", "__ENDTRY")
_NOT_NESTED: Final = re.compile(r"\(\*\s*@NESTEDCOMMENTS\s*:=\s*'No'")
"""The remark of an export of CoDeSys V2.3 whose comments end at the first *)."""
_PREFIX_OF_QUOTE: Final = "'‘’´`"


@dataclass(slots=True)
class Tokens:
    """The tokens of a text, as three lists of the same length; the last token is END."""

    kinds: list[str] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)
    positions: list[Position] = field(default_factory=list)
    comments: dict[int, list[tuple[int, str]]] = field(default_factory=dict)
    """The comments in front of a token, with the line where each begins."""
    mistakes: list[Mistake] = field(default_factory=list)
    is_cut: bool = False
    """True if the text ends in a comment that is not closed."""


def tokens(text: str, file: str, dialect: Dialect, first_line: int = 1) -> Tokens:
    """Split a text.  All of it becomes tokens, whatever it is."""
    if not dialect.has_conditional_code or conditional.IS_USED.search(text) is None:
        return _Scanner(text, file, dialect, first_line).run()
    compiled = conditional.resolved(text, nests_comments=dialect.nests_comments)
    made = _Scanner(compiled.text, file, dialect, first_line).run()
    for offset, mistake in compiled.mistakes[:MOST_MESSAGES]:
        line, column = text.count("\n", 0, offset) + first_line, offset - text.rfind("\n", 0, offset)
        made.mistakes.append(replace(mistake, line=line, column=column, file=file))
    return made


def keywords(dialect: Dialect) -> frozenset[str]:
    allowed = {
        ("CONTINUE",): dialect.has_continue,
        ("AND_THEN", "OR_ELSE"): dialect.has_short_circuit,
        ("REFERENCE", "REF_TO"): dialect.has_references,
        ("UNION", "END_UNION"): dialect.has_unions,
        ("METHOD", "END_METHOD", "PROPERTY", "END_PROPERTY", "END_GET", "END_SET"): dialect.has_methods,
        ("INTERFACE", "END_INTERFACE"): dialect.has_methods,
        ("CLASS", "END_CLASS"): dialect.has_classes,
        ("VAR_STAT", "VAR_INST"): dialect.has_static_variables,
        ("VAR_GENERIC",): dialect.has_generic_constants,
        _EXCEPTIONS: dialect.has_exceptions,
    }
    return KEYWORDS.union(word for words, is_allowed in allowed.items() if is_allowed for word in words)


class _Scanner:
    def __init__(self, text: str, file: str, dialect: Dialect, first_line: int) -> None:
        self._text, self._file, self._dialect = text, file, dialect
        self._end = len(text.rstrip(_BLANKS))
        """Blanks at the end are left out: the pattern would look through them again from each of them."""
        self._line, self._line_start = first_line, 0
        self._is_unbalanced = dialect.leaves_comments_open and _NOT_NESTED.search(text) is not None
        """True once a comment had more beginnings than ends up to the end of the text; no other is searched then."""
        self._is_foreign_open = False
        """True once no }} was found behind a {{; no other is searched then."""
        self._keywords = keywords(dialect)
        if not dialect.reserves_configurations:
            self._keywords -= FREE_IN_OBJECTS
        self._words: dict[str, str] = {}
        """The kind of each word that has occurred; words with a mistake are not in it."""
        self._tokens = Tokens()

    def run(self) -> Tokens:
        tokens = self._tokens
        offset: int | None = 0
        while offset is not None:
            offset = self._scan(offset)
        tokens.kinds.append(END)
        tokens.texts.append("")
        tokens.positions.append(self._position(len(self._text)))
        return tokens

    def _position(self, offset: int) -> Position:
        return Position(self._line, offset - self._line_start + 1)

    def _scan(self, offset: int) -> int | None:
        """Read tokens from an offset on.  Return where to go on after a jump, or None at the end of the text."""
        tokens = self._tokens
        add_kind, add_text, add_position = tokens.kinds.append, tokens.texts.append, tokens.positions.append
        words, new = self._words, tuple.__new__
        line, line_start = self._line, self._line_start
        for match in _PATTERN.finditer(self._text, offset, self._end):
            group = match.lastindex
            if group == _NEWLINE:
                line += 1
                line_start = match.end()
                continue
            assert group is not None
            text = match[group]
            if group == _WORD:
                kind = words.get(text)
                if kind is not None:
                    add_kind(kind)
                    add_text(text)
                    add_position(new(Position, (line, match.start(_WORD) - line_start + 1)))
                    continue
            elif group == _SIGN and text not in _MISSPELLED_SIGNS:
                add_kind(text)
                add_text(text)
                add_position(new(Position, (line, match.start(_SIGN) - line_start + 1)))
                continue
            elif group in _KINDS:
                add_kind(_KINDS[group])
                add_text(text)
                add_position(new(Position, (line, match.start(group) - line_start + 1)))
                continue
            self._line, self._line_start = line, line_start
            after = self._other(group, text, match.start(group))
            line, line_start = self._line, self._line_start
            if after is not None:
                return after
        self._line, self._line_start = line, line_start
        return None

    def _add(self, kind: str, text: str, offset: int) -> None:
        self._tokens.kinds.append(kind)
        self._tokens.texts.append(text)
        self._tokens.positions.append(self._position(offset))

    def _say(self, offset: int, what: str, expected: str = "", hint: str = "") -> None:
        line, column = self._position(offset)
        if len(self._tokens.mistakes) < MOST_MESSAGES:
            self._tokens.mistakes.append(Mistake(line, column, what, expected, file=self._file, hint=hint))

    def _note(self, offset: int, what: str, hint: str) -> None:
        line, column = self._position(offset)
        if len(self._tokens.mistakes) < MOST_MESSAGES:
            self._tokens.mistakes.append(Mistake(line, column, what, is_note=True, file=self._file, hint=hint))

    def _other(self, group: int, text: str, offset: int) -> int | None:
        """Read what is rare: words for the first time, comments, pragmas, and what is wrong."""
        if group == _WORD:
            self._word(text, offset)
        elif group == _SIGN:
            right, hint = _MISSPELLED_SIGNS[text]
            self._say(offset, f"got {text}", right, hint)
            self._add(right, right, offset)
        elif group == _COMMENT:
            return self._comment(text, offset)
        elif group == _PRAGMA:
            return self._foreign(offset) if text == "{{" else self._pragma(text, offset)
        elif group == _OPEN_COMMENT:
            self._say(offset, "the comment is not closed", f"{'*)' if text[0] == '(' else '*/'} at its end")
            self._tokens.is_cut = True
        elif group == _OPEN_STRING:
            self._open_string(text, offset)
        elif group == _WIDE_STRING:
            self._wide_string(text, offset)
        else:
            return self._junk(text, offset)
        return None

    def _foreign(self, offset: int) -> int | None:
        """Leave out C code of MatIEC in double braces."""
        end = -1 if self._is_foreign_open else self._text.find("}}", offset + 2)
        if end < 0:
            self._is_foreign_open = True
            self._junk("{", offset)
            return offset + 1
        self._note(offset, "the text between {{ and }} is C code of MatIEC, and does not run", "use ST")
        text = self._text[offset : end + 2]
        self._keep(text)
        return self._after(text, offset)

    def _pragma(self, text: str, offset: int) -> int | None:
        if text[1:-1].strip().lower() == "native":
            self._add(NATIVE, text, offset)
            return None
        if self._dialect.has_conditional_code and (said := _SAID.fullmatch(text)) is not None:
            self._say_pragma(said[1].casefold(), said[2], offset)
        elif ";" in _QUOTED.sub("", text):
            hint = "Statements have no braces: IF ... THEN ... END_IF;"
            self._note(offset, "the text in braces is a pragma, and its statements do not run", hint)
        self._keep(text)
        return self._after(text, offset) if "\n" in text else None

    def _say_pragma(self, kind: str, text: str, offset: int) -> None:
        """Say what a program wants the compiler to say."""
        if kind == "error":
            self._say(offset, text)
        else:
            self._note(offset, text, "")

    # ---- words

    def _word(self, text: str, offset: int) -> None:
        upper = text.upper()
        if upper in self._keywords:
            self._words[text] = upper
            self._add(upper, text, offset)
            return
        if upper in _EXCEPTIONS:  # read as it is meant, with one message for all its words
            if upper == "__TRY":
                self._say(offset, "__TRY is not known in this dialect", "a statement", "The dialect codesys has it.")
            self._add(upper, text, offset)
            return
        meant = MISSPELLED.get(upper)
        if meant is not None and upper == "FUNCTIONBLOCK" and self._dialect.has_joined_words:
            self._add(meant, text, offset)
            return
        if meant is not None:
            self._say(offset, f"got {text}", meant, f"The keyword is {meant}.")
            self._add(meant, text, offset)
            return
        self._words[text] = NAME
        self._add(NAME, text, offset)
        if not text.isascii():
            self._say(offset, f"the name {text} has letters that are not allowed", "A to Z, digits and underscores")
        elif "__" in text and not self._may_have_underscores(text):
            hint = f"Write {re.sub('_+', '_', text)}."
            self._say(offset, f"the name {text} has several underscores in a row", "single underscores", hint)

    def _may_have_underscores(self, text: str) -> bool:
        """True for a name of the tool itself."""
        if self._dialect.has_system_names and "__" not in text[2:]:
            return True
        return text.upper() in _OPERATORS and self._dialect.has_references

    # ---- comments

    def _keep(self, text: str) -> None:
        self._tokens.comments.setdefault(len(self._tokens.kinds), []).append((self._line, text))

    def _comment(self, text: str, offset: int) -> int | None:
        """Keep a comment.  Return where to go on if it reaches further than its first closing bracket."""
        if text.startswith("//"):
            if not self._dialect.has_line_comments:
                self._say(offset, "// does not begin a comment", "(* ... *)", "Write the comment as (* ... *).")
                text = f"(*{text[2:].rstrip().replace('*)', '* )').replace('(*', '( *')} *)"
            self._keep(text.rstrip())
            return None
        end = offset + len(text)
        if text[0] == "/":
            kept = text
            if not self._dialect.has_line_comments:
                self._say(offset, "/* does not begin a comment", "(* ... *)", "Write the comment as (* ... *).")
                kept = f"(*{text[2:-2].replace('*)', '* )').replace('(*', '( *')}*)"
            self._keep(kept)
            return self._after(text, offset) if "\n" in text else None
        if "(*" in text[2:]:
            end = self._nested(text, offset)
            if end < 0:
                return None
        whole = self._text[offset:end]
        self._keep(whole)
        return self._after(whole, offset) if "\n" in whole or len(whole) > len(text) else None

    def _after(self, text: str, offset: int) -> int | None:
        """Count the lines of a text that is skipped."""
        lines = text.count("\n")
        if lines:
            self._line += lines
            self._line_start = offset + text.rindex("\n") + 1
        return offset + len(text)

    def _nested(self, text: str, offset: int) -> int:
        """Return the end of a comment that contains the beginning of another, or -1 if it has none."""
        depth, at = 0, offset
        if self._is_unbalanced:
            return offset + len(text)
        for match in re.compile(r"\(\*|\*\)").finditer(self._text, offset):
            if match.start() < at:  # the bracket of "(*)"
                continue
            at = match.end()
            depth += 1 if match[0] == "(*" else -1
            if depth == 0:
                if not self._dialect.nests_comments:
                    inner = offset + 2 + text[2:].index("(*")
                    hint = "The first *) ends the comment. Remove the inner (* and *)."
                    self._say(inner, "a comment begins inside a comment", "*) first", hint)
                return at
        if not self._dialect.nests_comments or self._dialect.leaves_comments_open:
            self._is_unbalanced = True
            return offset + len(text)
        self._say(offset, "the comment is not closed", "a *) for each (* in it")
        self._tokens.is_cut = True
        self._after(self._text[offset:], offset)
        return len(self._text)

    # ---- what is wrong

    def _wide_string(self, text: str, offset: int) -> None:
        texts = self._tokens.texts
        is_name = bool(texts) and texts[-1].upper() in _NAMED_IN_TESTS  # it may be in either quotes
        if self._dialect.has_wide_strings or is_name:
            self._add(WIDE_STRING, text, offset)
        else:
            self._open_string(text, offset)

    def _open_string(self, text: str, offset: int) -> None:
        if text[0] in _PREFIX_OF_QUOTE and len(text) > 1 and text[-1] in _PREFIX_OF_QUOTE and text[0] != "'":
            self._say(offset, f"the string has the quotes {text[0]} and {text[-1]}", "straight quotes: 'text'")
        elif text[0] == "'":
            self._say(offset, "the string is not closed", "' at its end, in the same line")
        elif len(text) > 1 and text[-1] == text[0] and "'" not in text:
            self._say(offset, f"got {text}", f"a string in single quotes: '{text[1:-1]}'")
        else:
            self._say(offset, f"got {text[0]}", "a string in single quotes: 'text'")
        self._add(JUNK, text, offset)

    def _junk(self, text: str, offset: int) -> int | None:
        """Report what has no meaning.  Return where to go on if more than this text is wrong."""
        number = _OF_OTHER_LANGUAGES.match(self._text, offset)
        if number is not None and number.lastgroup is not None and not _TIME_WITHOUT_PREFIX.fullmatch(text):
            wrong, meant = number[0], f"{_BASES[number.lastgroup]}#{number[number.lastgroup]}"
            self._say(offset, f"got {wrong}", meant, f"The number is written {meant}.")
            self._add(INTEGER, meant, offset)
            return offset + len(wrong)
        if _TIME_WITHOUT_PREFIX.fullmatch(text):
            self._say(offset, f"{text} has no T# in front of it", f"T#{text}", f"A time is written T#{text}.")
            self._add(TYPED, "T#0ms", offset)
        elif (number := _BEFORE_WORD.fullmatch(text)) is not None:
            self._add(INTEGER, number[1], offset)
            return offset + len(number[1])
        elif text[0].isascii() and text[0].isdigit():
            expected = "a name that begins with a letter or an underscore"
            self._say(offset, f"{text} is neither a number nor a name", expected)
            self._add(NAME, text, offset)
        elif self._tokens.kinds[-1:] == ["."] and _PART.fullmatch(text):
            if not self._dialect.has_partial_access:
                hint = f"Write .{text[2:]} for a bit." if text[1] in "Xx" else "Shift the value to the right."
                self._say(offset, f"{text} is a part of a value", "the number of a bit", hint)
            self._add(PART, text, offset)
        elif text[0] == "%" and self._tokens.kinds[-1:] and self._tokens.kinds[-1] in _OPERAND_ENDS:
            self._say(offset, f"got {text[0]}", "MOD", "The remainder of a division is a MOD b.")
            self._add("MOD", text[0], offset)
            if len(text) > 1:
                self._add(INTEGER if text[1:].isdecimal() else NAME, text[1:], offset + 1)
        elif text[0] == "%":
            what = f"{text} is not an address"
            self._say(offset, what, "%I, %Q or %M, a size X, B, W or D, and numbers, such as %QX1.0")
            self._add(JUNK, text, offset)
        elif text == "!":
            self._say(offset, "got !", "NOT", "The operator is NOT.")
            self._add("NOT", text, offset)
        elif text in _TYPOGRAPHIC:
            self._say(offset, f"got {text}", _TYPOGRAPHIC[text])
            self._add(_TYPOGRAPHIC[text], text, offset)
        else:
            shown = text if text.isprintable() else f"the character with code {ord(text[0])}"
            hint = "Statements have no braces: IF ... THEN ... END_IF;" if text in ("{", "}") else ""
            self._say(offset, f"got {shown}", "a character that has a meaning in the language", hint)
        return None
