"""The changes of a source file: what mutation testing calls mutants (DeMillo, Lipton and Sayward, 1978).

The kinds are those of mistakes that people make in programs of machines: a comparison that is off by one, AND for OR, a
contact that opens instead of closing, a missing reset, a transition that fires too early or never.
"""

from collections.abc import Collection, Iterator
from dataclasses import replace
from enum import StrEnum
from typing import Any, Final, NamedTuple

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.instructions import NEGATABLE, SYMBOLS
from fieldrig_devices.iec.mutation.expressions import ARITHMETIC, BITS, COMPARISONS, negated, other_constant
from fieldrig_devices.iec.mutation.places import Way, replaced, walk
from fieldrig_devices.iec.printer import expression_text, print_body

MOST_SHOWN: Final = 100
"""Characters of a text in a report; what is longer is cut in its middle."""


class Kind(StrEnum):
    """The kinds of changes."""

    COMPARE = "compare"
    """Another comparison: a limit that belongs to the other side, or the opposite."""
    LOGIC = "logic"
    """AND for OR, and the reverse."""
    ARITHMETIC = "arithmetic"
    CONSTANT = "constant"
    CONTACT = "contact"
    """A condition, or a part of one, is negated."""
    RESET = "reset"
    """An assignment of FALSE or 0, or a reset, is missing."""
    STATEMENT = "statement"
    """Another statement is missing."""
    TRANSITION = "transition"
    """A transition fires at once, or never."""
    ACTION = "action"
    """A step lacks an action."""


class Change(NamedTuple):
    """One change."""

    file: str
    """The name of the source file, as the compiler has it."""
    line: int
    column: int
    pou: str
    """The name of the POU or list of variables."""
    kind: Kind
    before: str
    """The text that is replaced, in the layout of `fieldrig iec fmt`, on one line."""
    after: str
    """The text in its place; empty if there is none."""
    statement: tree.Position
    """The position of the statement to which it belongs."""


class Made(NamedTuple):
    """A change, and how to make it."""

    change: Change
    way: Way
    part: object

    def made_in(self, unit: tree.Unit) -> tree.Unit:
        changed: tree.Unit = replaced(unit, self.way, self.part)
        return changed


Offer = tuple[Kind, Way, Any]
"""A change of a node: its kind, the place below the node, and the part that comes there."""
_OF_TABLES: Final = ((BITS, Kind.LOGIC), (COMPARISONS, Kind.COMPARE), (ARITHMETIC, Kind.ARITHMETIC))
_OPERATORS: Final = {symbol: word for word, symbol in SYMBOLS.items()}


def changes_of(unit: tree.Unit, left_out: Collection[str] = ()) -> Iterator[Made]:
    """Yield the changes of the declarations of a file, in the order of the text.

    `left_out` are the names, in small letters, of POUs that are no part of the program, such as suites of tests.
    """
    for number, declaration in enumerate(unit.declarations):
        pou = getattr(declaration, "name", "")
        if pou.casefold() in left_out:
            continue
        for found in walk(declaration):
            for kind, below, part in _offers(found.node):
                texts = _texts(found.node, below, part)
                change = Change(unit.file, *found.position, pou, kind, *texts, found.statement)
                yield Made(change, ("declarations", number, *found.way, *below), part)


def _offers(node: tree.Node) -> Iterator[Offer]:
    match node:
        case tree.Binary(operator, left, right):
            others = ((kind, other) for table, kind in _OF_TABLES for other in table.get(operator, ()))
            yield from ((kind, (), replace(node, operator=other)) for kind, other in others)
            if operator in BITS:
                yield from (*_contact("left", left), *_contact("right", right))
        case tree.Unary("NOT", operand):
            yield Kind.CONTACT, (), operand
        case tree.Literal():
            other = other_constant(node)
            if other is not None:
                yield Kind.CONSTANT, (), other
        case tree.Branch(condition) | tree.While(condition):
            yield from _contact("condition", condition)
        case tree.Repeat(_, until):
            yield from _contact("until", until)
        case tree.Transition(_, _, condition):
            truths = (tree.Literal(tree.LiteralKind.BOOL, value) for value in (True, False))
            yield from ((Kind.TRANSITION, ("condition",), truth) for truth in truths if truth != condition)
            yield from _contact("condition", condition)
        case tree.Assign():
            yield Kind.RESET if _is_reset(node) else Kind.STATEMENT, (), tree.Empty()
        case tree.CallStatement() | tree.Return() | tree.Exit() | tree.Continue() | tree.Jump():
            yield Kind.STATEMENT, (), tree.Empty()
        case tree.Step(_, _, uses):
            for number in range(len(uses)):
                yield Kind.ACTION, ("uses",), (*uses[:number], *uses[number + 1 :])
        case tree.IlInstruction():
            yield from _of_instruction(node)


def _contact(name: str, condition: tree.Expression) -> Iterator[Offer]:
    other = negated(condition)
    if other is not None:
        yield Kind.CONTACT, (name,), other


def _is_reset(node: tree.Assign) -> bool:
    return node.kind is tree.AssignKind.RESET or (isinstance(node.value, tree.Literal) and not node.value.value)


def _of_instruction(node: tree.IlInstruction) -> Iterator[Offer]:
    """Yield the changes of a line of Instruction List."""
    word = node.operator
    for table, kind in _OF_TABLES:
        for symbol in table.get(SYMBOLS.get(word, ""), ()):
            if symbol in _OPERATORS:
                yield kind, (), replace(node, operator=_OPERATORS[symbol])
    if word in NEGATABLE or node.is_conditional:
        yield Kind.CONTACT, (), replace(node, is_negated=not node.is_negated)
    if word in ("ST", "S", "R", "CAL"):
        kind = Kind.RESET if word == "R" else Kind.STATEMENT
        yield kind, (), replace(node, operator="", operands=(), is_negated=False, is_conditional=False)


# ---- texts


def _texts(node: tree.Node, below: Way, part: object) -> tuple[str, str]:
    """Return what a change replaces, and what comes there."""
    if isinstance(node, tree.Step):
        kept = part if isinstance(part, tuple) else ()
        gone = next(one for number, one in enumerate(node.uses) if kept[number : number + 1] != (one,))
        return f"{node.name}: {gone.name}({gone.qualifier})", ""
    before = getattr(node, str(below[0])) if below else node
    return _text(before), _text(part)


def _text(part: object) -> str:
    match part:
        case tree.IlInstruction():
            text = print_body(tree.IlBody((replace(part, comments=(), remark="", after=()),)))
        case tree.Empty():
            return ""
        case tree.Statement():
            text = print_body(tree.StBody((replace(part, comments=(), remark="", after=()),)))  # type: ignore[arg-type]
        case _:
            text = expression_text(part)  # type: ignore[arg-type]
    return _short(" ".join(text.split()))


def _short(text: str) -> str:
    if len(text) <= MOST_SHOWN:
        return text
    half = MOST_SHOWN // 2 - 2
    return f"{text[:half]} … {text[-half:]}"
