"""Colours for Structured Text, which Pygments doesn't know."""

import re
from typing import Any, ClassVar

from pygments.lexer import RegexLexer, words
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String, Text

BLOCKS = (
    "PROGRAM", "FUNCTION", "FUNCTION_BLOCK", "ACTION", "METHOD", "PROPERTY", "CLASS", "INTERFACE", "TYPE", "STRUCT",
    "VAR", "IF", "CASE", "FOR", "WHILE", "REPEAT", "TEST", "STEP", "TRANSITION", "CONFIGURATION", "RESOURCE",
)  # fmt: skip
OTHERS = (
    "THEN", "ELSE", "ELSIF", "OF", "TO", "BY", "DO", "UNTIL", "EXIT", "CONTINUE", "RETURN", "AND", "OR", "XOR", "NOT",
    "MOD", "AT", "WITH", "TASK", "EXTENDS", "IMPLEMENTS", "ABSTRACT", "FINAL", "PUBLIC", "PRIVATE", "CONSTANT",
    "RETAIN", "TRUE", "FALSE", "ARRAY", "POINTER", "THIS", "SUPER", *(f"VAR_{kind}" for kind in (
        "INPUT", "OUTPUT", "IN_OUT", "GLOBAL", "EXTERNAL", "TEMP", "CONFIG", "STAT", "INST")),
)  # fmt: skip
TYPES = (
    "BOOL", "BYTE", "WORD", "DWORD", "LWORD", "SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT", "REAL",
    "LREAL", "TIME", "LTIME", "DATE", "TOD", "DT", "TIME_OF_DAY", "DATE_AND_TIME", "STRING", "WSTRING",
)  # fmt: skip


class StructuredText(RegexLexer):  # type: ignore[misc]  # Pygments has no types
    """A lexer for the examples of the docs."""

    name = "Structured Text"
    flags = re.IGNORECASE | re.DOTALL
    tokens: ClassVar[dict[str, Any]] = {
        "root": [
            (r"\(\*.*?\*\)|//[^\n]*|\{.*?\}", Comment),
            (r"'[^']*'|\"[^\"]*\"", String),
            (r"\b(?:[a-z]+#)?[0-9][0-9a-z_.#:-]*|\b(?:T|TIME|D|DT|TOD)#[\w.:-]+", Number),
            (words((*BLOCKS, *(f"END_{block}" for block in BLOCKS), *OTHERS), r"\b", r"\b"), Keyword),
            (words(TYPES, r"\b", r"\b"), Keyword.Type),
            (r"%[IQM][XBWD]?[\d.]+", Name.Variable),
            (r"\w+", Name),
            (r":=|=>|<=|>=|<>|[-+*/=<>&^]", Operator),
            (r"[^\w\s]", Punctuation),
            (r"\s+", Text),
        ]
    }
