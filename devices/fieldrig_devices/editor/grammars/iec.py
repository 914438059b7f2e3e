"""The colours of Structured Text and Instruction List, of all dialects at once.

A dialect decides by the text around a word whether it is a keyword, which a grammar cannot; so a name of an older
dialect that is a keyword in a newer one is shown as a keyword.
"""

from typing import Any, Final

from fieldrig_devices.editor.grammars import rules
from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.tokens import keywords
from fieldrig_devices.iec.tree import TestWord

CONSTANTS: Final = frozenset({"TRUE", "FALSE"})
OPERATORS: Final = frozenset({"NOT", "AND", "OR", "XOR", "MOD", "AND_THEN", "OR_ELSE"})
_STATEMENTS: Final = """
    IF THEN ELSIF ELSE END_IF CASE OF END_CASE FOR TO BY DO END_FOR WHILE END_WHILE REPEAT UNTIL END_REPEAT EXIT RETURN
    CONTINUE __TRY __CATCH __FINALLY __ENDTRY
    """
STATEMENTS: Final = frozenset(_STATEMENTS.split())
_BEFORE_NAMES: Final = "TASK|WITH|EXTENDS|IMPLEMENTS|ABSTRACT|FINAL|OVERRIDE"
_BLOCKS: Final = "|".join(word.value for word in TestWord)
_PLACED: Final = "|".join(
    (
        r"^\s*STEP(?=\s+\w+\s*:)",
        rf"\b(?:{_BEFORE_NAMES})(?=\s+[A-Za-z_])",
        r"\b(?:TEST|RIG|USES)(?=\s*['\"])",
        rf"^\s*(?:END_)?(?:{_BLOCKS})(?=\s*(?:$|VAR\b|//|\(\*))",
    )
)
"""Words that are keywords at their places only, among them those of test files (`iec/parser/tests.py`)."""
_MORE_TYPES: Final = ["STRING", "WSTRING", "TIME_OF_DAY", "DATE_AND_TIME", "LTIME_OF_DAY", "LDATE_AND_TIME", "ANY"]
TYPES: Final = frozenset({*(word.value for word in Elementary if "_" not in word.value), *_MORE_TYPES})


def grammar() -> dict[str, Any]:
    known = {word for dialect in DIALECTS.values() for word in keywords(dialect)}
    return rules.grammar(
        "Structured Text",
        "source.st",
        (
            rules.block("comment.block.st", r"\(\*", r"\*\)", is_nested=True),
            rules.block("comment.block.documentation.st", r"/\*", r"\*/"),
            rules.match("comment.line.double-slash.st", r"//.*$"),
            rules.block("meta.preprocessor.st", r"\{", r"\}"),
            rules.match("constant.numeric.typed.st", r"(?i)\b[a-z_]\w*#(?:[-+]?[0-9]+#\w+|[-+]?[\w.:-]*\w)"),
            rules.match("string.quoted.single.st", r"'(?:[^'$]|\$.)*'"),
            rules.match("string.quoted.double.st", r'"(?:[^"$]|\$.)*"'),
            rules.match("constant.other.address.st", r"(?i)%[IQM](?:[XBWDL]?\*|[XBWDL]?[0-9]+(?:\.[0-9]+)*)"),
            rules.words("constant.language.st", CONSTANTS),
            rules.words("keyword.control.st", STATEMENTS),
            rules.words("keyword.operator.word.st", OPERATORS),
            rules.words("storage.type.st", known - CONSTANTS - OPERATORS - STATEMENTS),
            rules.match("storage.type.placed.st", f"(?i)(?:{_PLACED})"),
            rules.words("support.type.st", TYPES),
            rules.match("entity.name.function.st", r"\b[A-Za-z_]\w*(?=\s*\()"),
            rules.match("variable.other.st", r"\b[A-Za-z_]\w*\b"),
            rules.match("constant.numeric.st", r"(?i)\b[0-9][0-9_]*(?:#\w+|(?:\.[0-9][0-9_]*)?(?:e[-+]?[0-9]+)?)"),
            rules.match("keyword.operator.st", r":=|\?=|=>|<=|>=|<>|\*\*|[-+*/=<>&^]"),
        ),
    )
