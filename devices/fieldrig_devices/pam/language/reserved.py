"""The reserved words of appendix A, and the names of a program that differ from one by their case only.

Keywords are read in any case, as the listings write them.  The manual prints them in capitals, so that a program may
have an object On although ON is a word.  A spelling that a program declares is a name in all of that program.
"""

from collections.abc import Iterator, Sequence
from itertools import takewhile
from typing import Final

from fieldrig_devices.pam.language.functions import EXECUTIVE, INQUIRIES, MATHEMATICS, REPLACED
from fieldrig_devices.pam.language.objects import KINDS, SPECS
from fieldrig_devices.pam.language.tokens import Token
from fieldrig_devices.pam.language.words import STRUCTURE, SYMBOLIC

_FURTHER: Final = """
    BIT BLOC_SIZE BREAKING CORRECTION_VALUE EDGE_NONE ERROR LENGTH LOCATION MASTER_TIMEOUT Pi RS422PORT
    RS422_WATCHDOG_TIMEOUT ST1_CMD SUBSET anti_delay enable_stroke_limits inquire_value modify_value output_amplitude
    output_offset
"""
"""Words of appendix A that the tables of the language do not have."""
RESERVED: Final = frozenset(
    {
        *STRUCTURE,
        *SYMBOLIC,
        *(word for kind in KINDS for word in kind.split()),
        *(name for rules in (*KINDS.values(), *SPECS.values()) for name in rules),
        *(name for table in (*EXECUTIVE.values(), *INQUIRIES.values()) for name in table),
        *MATHEMATICS,
        *REPLACED,
        *_FURTHER.split(),
    }
)
"""Words that no object may have as its name (appendix A, PAMS-102)."""
IN_CAPITALS: Final = frozenset(word.upper() for word in RESERVED)
ITEMS: Final = frozenset({kind.partition(" ")[0] for kind in KINDS} - {"TRACE"}) | {
    "APPLICATION",
    "ACTIONS",
    "ROUTINES",
    "TASK",
    "BOOLEAN",
}
"""The words that an item of a program begins with."""
_NAMING: Final = frozenset(kind.rpartition(" ")[2] for kind in KINDS) | {
    "ACTIONS",
    "ROUTINES",
    "ROUTINE",
    "TASK",
    "SEQUENCE",
    "BOOLEAN",
    "EXCEPTION_ENTRY",
}
"""Words with a new name behind them."""
_BEHIND: Final = (";", "[i]", "WITH")


def declared_names(tokens: Sequence[Token]) -> frozenset[str]:
    """Return the names that a program gives to its objects, labels and formal parameters."""
    return frozenset(_declared(tokens))


def _declared(tokens: Sequence[Token]) -> Iterator[str]:
    for at in range(1, len(tokens) - 1):
        token = tokens[at]
        if token.kind != "name" or tokens[at - 1].text.upper() not in _NAMING:
            continue
        behind = tokens[at + 1].text.upper()
        if behind in _BEHIND and token.text not in RESERVED:
            yield token.text
        if behind == "WITH":
            formals = takewhile(lambda part: part.text != ";", tokens[at + 2 :])
            yield from (part.text for part in formals if part.kind == "name" and part.text not in RESERVED)
