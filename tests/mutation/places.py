"""The places of the code that a row's tests run, and the changes that can be made there.

Left out is what serves no row: text for people (log lines, messages of exceptions, `__repr__`), assertions, and type
annotations.  An operator is only replaced by one that a programmer could have written by mistake: its opposite or its
neighbour.  Others either crash at once or make no difference (`+` and `|` of bits that don't overlap).
"""

import ast
import random
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.plugins import get_operator

Lines = Mapping[str, Mapping[str, set[int]]]
"""Line numbers by row, or by test, and by file."""

BINARY = ("Add_Sub", "Sub_Add", "Mul_Div", "Mul_FloorDiv", "Div_Mul", "FloorDiv_Mul", "Mod_FloorDiv")
BITWISE = ("BitAnd_BitOr", "BitOr_BitAnd", "BitXor_BitOr", "LShift_RShift", "RShift_LShift")
EQUALITY = ("Eq_NotEq", "NotEq_Eq", "Is_IsNot", "IsNot_Is")
ORDER = ("Lt_LtE", "Lt_GtE", "LtE_Lt", "LtE_Gt", "Gt_GtE", "Gt_LtE", "GtE_Gt", "GtE_Lt")
OPERATORS = (
    *(f"core/ReplaceBinaryOperator_{pair}" for pair in (*BINARY, *BITWISE)),
    *(f"core/ReplaceComparisonOperator_{pair}" for pair in (*EQUALITY, *ORDER)),
    "core/AddNot",
    "core/NumberReplacer",
    "core/ReplaceAndWithOr",
    "core/ReplaceOrWithAnd",
    "core/ReplaceTrueWithFalse",
    "core/ReplaceFalseWithTrue",
    "core/ReplaceBreakWithContinue",
    "core/ReplaceContinueWithBreak",
    "core/ReplaceUnaryOperator_Delete_Not",
    "core/ReplaceUnaryOperator_Delete_USub",
    "core/ZeroIterationForLoop",
)
FOR_PEOPLE = {"__repr__", "__str__"}


@dataclass(frozen=True, slots=True)
class Mutant:
    row: str
    file: str
    line: int
    operator: str
    occurrence: int
    source: str
    """The changed line, before the change."""


class Verdict(Enum):
    KILLED = "killed"
    ELSEWHERE = "elsewhere"
    """The row's own tests pass, and a test of another row fails."""
    SURVIVED = "SURVIVED"


@dataclass(frozen=True, slots=True)
class Change:
    """One change of a file."""

    line: int
    operator: str
    occurrence: int


def chosen(row: str, lines: Lines, count: int, chance: random.Random, folder: Path) -> Iterator[Mutant]:
    """Yield some of the changes that can be made where this row's tests run, the row's own lines first."""
    shared = Counter((file, line) for files in lines.values() for file, numbers in files.items() for line in numbers)
    places = [(file, line) for file, numbers in sorted(lines[row].items()) for line in sorted(numbers)]
    weights = [1 / shared[place] ** 2 for place in places]
    taken: set[tuple[str, int]] = set()
    for _ in range(100 * count):
        if not places or len(taken) == count:
            return
        file, line = place = chance.choices(places, weights)[0]
        text = (folder / file).read_text(encoding="utf-8")
        changes = [] if place in taken else [item for item in changes_of(text) if item.line == line]
        if changes:
            taken.add(place)
            change = chance.choice(changes)
            yield Mutant(row, file, line, change.operator, change.occurrence, text.splitlines()[line - 1].strip())


@cache
def changes_of(text: str) -> list[Change]:
    """Return all changes of a module that may matter to a row."""
    tree = get_ast(text)
    nodes = list(ast_nodes(tree))
    useless = list(_useless(ast.parse(text)))
    found = []
    for name in OPERATORS:
        operator = get_operator(name)()
        positions = [start for node in nodes for start, _ in operator.mutation_positions(node)]
        for occurrence, start in enumerate(positions):
            if not any(first <= start < last for first, last in useless):
                found.append(Change(start[0], name, occurrence))
    return found


def _useless(tree: ast.Module) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """Yield the ranges of lines and columns that serve no row."""
    for node in ast.walk(tree):
        match node:
            case ast.Assert():
                yield _range(node)
            case ast.Raise():  # the message alone: an exception may carry the code that goes onto the wire
                yield from (_range(part) for part in ast.walk(node) if isinstance(part, ast.JoinedStr))
            case ast.Call(func=ast.Attribute(value=ast.Name(id="log"))):
                yield _range(node)
            case ast.FunctionDef(name=name) if name in FOR_PEOPLE:
                yield _range(node)
            case ast.FunctionDef(returns=ast.expr() as annotation):
                yield _range(annotation)
            case ast.AnnAssign(annotation=annotation) | ast.arg(annotation=ast.expr() as annotation):
                yield _range(annotation)


def _range(node: ast.stmt | ast.expr) -> tuple[tuple[int, int], tuple[int, int]]:
    assert node.end_lineno is not None
    assert node.end_col_offset is not None
    return (node.lineno, node.col_offset), (node.end_lineno, node.end_col_offset)
