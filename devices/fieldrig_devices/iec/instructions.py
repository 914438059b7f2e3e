"""The operators of Instruction List with their modifiers.

Source: PacDrive manual 1293 to 1341, table 4-10.  MOD and NOT are operators too (2080, 2221); every function is one.
"""

from collections.abc import Mapping
from typing import Final

NEGATABLE: Final = ("LD", "ST", "AND", "OR", "XOR")
"""Operators that modifier N gives a negated operand."""
CONDITIONAL: Final = ("JMP", "CAL", "RET")
"""Operators with the modifiers C and CN: only if the accumulator is TRUE, or FALSE."""
BRACKETS: Final = frozenset({"AND", "OR", "XOR", "ADD", "SUB", "MUL", "DIV", "MOD", "GT", "GE", "EQ", "NE", "LE", "LT"})
"""Operators that a bracket may follow, whose result is the operand."""
SYMBOLS: Final[Mapping[str, str]] = {
    "AND": "AND",
    "OR": "OR",
    "XOR": "XOR",
    "ADD": "+",
    "SUB": "-",
    "MUL": "*",
    "DIV": "/",
    "MOD": "MOD",
    "GT": ">",
    "GE": ">=",
    "EQ": "=",
    "NE": "<>",
    "LE": "<=",
    "LT": "<",
}
"""The operators of expressions that IL operators are."""
SPELLINGS: Final[Mapping[str, tuple[str, bool, bool]]] = {
    **{word: (word, False, False) for word in (*NEGATABLE, *CONDITIONAL, *sorted(BRACKETS), "S", "R", "NOT")},
    **{f"{word}N": (word, True, False) for word in NEGATABLE},
    **{f"{word}C": (word, False, True) for word in CONDITIONAL},
    **{f"{word}CN": (word, True, True) for word in CONDITIONAL},
    "&": ("AND", False, False),
    "&N": ("AND", True, False),
}
"""Operator, modifier N, and modifier C by the spelling."""
