"""The colours of the PAM's language.

Its words are read in any case, but the manual has objects such as On beside the word ON; so a word has its colour in
the spelling of the manual, in capitals and in small letters.
"""

from collections.abc import Iterable
from typing import Any, Final

from fieldrig_devices.editor.grammars import rules
from fieldrig_devices.pam.language.objects import KINDS
from fieldrig_devices.pam.language.reserved import RESERVED
from fieldrig_devices.pam.language.words import PREDECLARED, STRUCTURE, SYMBOLIC

KINDS_OF_OBJECTS: Final = frozenset(word for kind in KINDS for word in kind.split())
STATEMENTS: Final = frozenset(STRUCTURE - KINDS_OF_OBJECTS)
VALUES: Final = frozenset(SYMBOLIC - STATEMENTS - KINDS_OF_OBJECTS)
OTHERS: Final = frozenset(RESERVED - STATEMENTS - KINDS_OF_OBJECTS - VALUES)
"""Parameters of objects, and functions."""


def grammar() -> dict[str, Any]:
    return rules.grammar(
        "PAM",
        "source.pam",
        (
            rules.match("comment.line.pam", r"//.*$|/\*\*(?!/).*?(?:\*/|$)|/\*\*/"),
            rules.block("comment.block.pam", r"/\*(?!\*)", r"\*/"),
            rules.match("keyword.control.directive.pam", r"(?i)^\s*#\s*(?:define|set|undef|include)\b"),
            rules.match("string.quoted.double.pam", r'"[^"]*"'),
            rules.match("constant.numeric.pam", r"#[0-9A-Fa-f]+\b|\b[0-9]+(?:\.[0-9]*)?(?!\w)"),
            _words("keyword.control.pam", STATEMENTS),
            _words("storage.type.pam", KINDS_OF_OBJECTS),
            _words("constant.language.pam", VALUES),
            _words("support.function.pam", OTHERS),
            _words("support.variable.pam", PREDECLARED),
            rules.match("variable.other.pam", r"\b[^\W\d]\w*\b"),
            rules.match("keyword.operator.pam", r"<-|<<|<=|>=|<>|[-+*%^=<>!?/|]"),
        ),
    )


def _words(scope: str, names: Iterable[str]) -> dict[str, str]:
    spellings = {spelling for name in names for spelling in (name, name.upper(), name.lower())}
    return rules.words(scope, spellings, any_case=False)
