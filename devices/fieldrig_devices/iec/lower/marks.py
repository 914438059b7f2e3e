"""Marks in the body of one POU: its statements, and the arms of its choices, loops and charts."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final, NamedTuple

from fieldrig.coverage import collecting
from fieldrig.coverage.marks import SuiteMarks
from fieldrig.coverage.places import Kind, Place
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.texts import text
from fieldrig_devices.iec.program import (
    AnyStatement,
    Assign,
    Case,
    Cell,
    Constant,
    Continue,
    Exit,
    For,
    If,
    Jump,
    Label,
    Loop,
    Pou,
    Return,
    Space,
    Statement,
    Try,
    Variable,
)
from fieldrig_devices.iec.tree import Section
from fieldrig_devices.iec.types import EnumType

_LEAVING: Final = (Continue, Exit, Jump, Label, Return)
"""The statements by which a suite is left, or entered in the middle."""


MOST_STATES: Final = 256
"""Numbers from the lowest to the highest value of an enumeration whose states are noted."""


class Arm(NamedTuple):
    """One way out of a choice or loop."""

    what: str
    line: int = 0
    """Its own line; 0 for that of the choice."""
    condition: tree.Expression | None = None
    """The condition that has to hold for it."""


BODY: Final = Arm("body")
SKIPPED: Final = Arm("body skipped")


def _span(kind: EnumType) -> int:
    return max(kind.values.values()) - min(kind.values.values()) + 1 if kind.values else MOST_STATES + 1


class Marks(SuiteMarks):
    """The marks of the body of one POU."""

    def __init__(self, pou: Pou, mark: Callable[[], int], *, is_on: bool) -> None:
        super().__init__(mark, is_on=is_on)
        self._pou = pou
        self._is_guarded = False
        self.is_detailed = is_on and collecting.is_detailed()

    # ---- suites and statements

    def statement(self, statement: Statement) -> None:
        """Begin a statement."""
        if not self.is_counted(statement) or isinstance(statement, Label):
            return
        if not isinstance(statement.origin, tree.Step | tree.Transition):
            self._place(statement, Kind.STATEMENT, "")
        if self.is_detailed and isinstance(statement, Assign):
            self._assigned(statement)

    @contextmanager
    def one_by_one(self) -> Iterator[None]:
        """Give each statement a mark of its own, since a fault in any of them may be caught."""
        before, self._is_guarded = self._is_guarded, True
        yield
        self._is_guarded = before

    def after(self, statement: AnyStatement) -> None:
        if self.is_on and (self._is_guarded or _may_leave(statement)):
            self.leave()

    def branch(self, statement: Statement, arm: Arm) -> None:
        """Begin an arm of a choice, a chart or a loop."""
        if not self.is_on:
            return
        match statement.origin:
            case tree.Step(name=name):
                self._place(statement, Kind.STEP, name)
            case tree.Transition():
                self._place(statement, Kind.TRANSITION, arm.what)
            case _:
                self._place(statement, Kind.BRANCH, arm.what, arm.line)

    def _place(self, statement: Statement, kind: Kind, what: str, line: int = 0) -> None:
        position = statement.origin.position if statement.origin is not None else tree.NOWHERE
        of = (position.line or statement.line) if kind is Kind.BRANCH else 0
        line = line or position.line or statement.line
        place = Place(self._pou.file, self._pou.name, kind, line, position.column, of, what)
        self.add(place)

    # ---- details

    def place_of(self, node: tree.Node) -> Place:
        """Return a place without a name."""
        return Place(self._pou.file, self._pou.name, Kind.CONDITION, node.position.line, node.position.column)

    def states_to_note(self) -> Iterator[Variable]:
        """Yield the variables of the POU whose values are noted as its body begins."""
        for variable in self._pou.variables.values() if self.is_detailed and self._pou.owner is None else ():
            is_lasting = variable.space is Space.INSTANCE or variable.section is Section.INPUT
            is_plain = variable.location is None and not (variable.is_reference or variable.is_constant)
            if is_lasting and is_plain and isinstance(variable.type, EnumType) and _span(variable.type) <= MOST_STATES:
                yield variable

    def state(self, variable: Variable, name: str) -> Place:
        """Return the place of a value of a variable."""
        position = variable.position
        what = f"{variable.name} = {name}"
        return Place(self._pou.file, self._pou.name, Kind.STATE, position.line, position.column, 0, what)

    def _assigned(self, statement: Assign) -> None:
        """Count the value of an enumeration that a statement assigns; the next one may assign another."""
        match statement:
            case Assign(place=Cell(variable, EnumType(values=values)), value=Constant(number)) if any(
                variable is one for one in self.states_to_note()
            ):
                for name in (name for name, value in values.items() if value == number):
                    self.add(self.state(variable, name))

    # ---- the arms of choices

    def is_counted(self, statement: Statement) -> bool:
        """True for a statement of the source in a body that is covered."""
        return self.is_on and statement.origin is not None

    def has_arms(self, statement: Statement) -> bool:
        """True for a choice or a loop of the source."""
        return self.is_on and isinstance(statement.origin, tree.If | tree.Case | tree.For | tree.While)

    def arms_of_if(self, statement: If) -> Iterator[Arm]:
        """Yield the arms of an IF behind its conditions, or what a chart does in a step or when a transition fires."""
        match statement.origin if self.is_on else None:
            case tree.Step(name=name):
                yield Arm(name)
            case tree.Transition(sources=sources, targets=targets, name=name, condition=condition):
                yield Arm(name or f"{', '.join(sources)} to {', '.join(targets)}", condition=condition)
            case tree.If(branches=branches):
                for number, branch in enumerate(branches):
                    yield Arm(f"ELSIF {number}" if number else "IF", branch.position.line, branch.condition)

    def arms_of_case(self, statement: Case) -> Iterator[Arm]:
        if self.is_on and isinstance(statement.origin, tree.Case):
            for branch in statement.origin.branches:
                yield Arm(f"CASE {', '.join(map(_label, branch.labels))}", branch.position.line)

    def last_arm(self, statement: If | Case) -> Arm | None:
        """Return the arm of ELSE, also of one that is missing."""
        if not self.is_on or not isinstance(statement.origin, tree.If | tree.Case):
            return None
        return Arm("no ELSE" if statement.origin.otherwise is None else "ELSE")


def _label(node: tree.Expression | tree.Range) -> str:
    return f"{text(node.low)}..{text(node.high)}" if isinstance(node, tree.Range) else text(node)


def _may_leave(statement: AnyStatement) -> bool:
    """True if what follows a statement may not run, or run without it.

    It is no recursive function, because an IF may have more ELSIF than Python has room for.
    """
    waiting = [statement]
    while waiting:
        match one := waiting.pop():
            case If(then=then, otherwise=otherwise):
                waiting += (*then, *otherwise)
            case Case(branches=branches, otherwise=otherwise):
                waiting += (*(inside for _, body in branches for inside in body), *otherwise)
            case For(body=body) | Loop(body=body):
                waiting += body
            case Try():
                return True
            case _ if isinstance(one, _LEAVING):
                return True
    return False
