"""Marks in the body of one POU: its statements, and the arms of its choices, loops and charts."""

from collections.abc import Callable, Iterator
from typing import Final, NamedTuple

from fieldrig.coverage.marks import SuiteMarks
from fieldrig.coverage.places import Kind, Place
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.texts import text
from fieldrig_devices.iec.program import (
    AnyStatement,
    Case,
    Continue,
    Exit,
    For,
    If,
    Jump,
    Label,
    Loop,
    Pou,
    Return,
    Statement,
)

_LEAVING: Final = (Continue, Exit, Jump, Label, Return)
"""The statements by which a suite is left, or entered in the middle."""


class Arm(NamedTuple):
    """One way out of a choice or loop."""

    what: str
    line: int = 0
    """Its own line; 0 for that of the choice."""


BODY: Final = Arm("body")
SKIPPED: Final = Arm("body skipped")


class Marks(SuiteMarks):
    """The marks of the body of one POU."""

    def __init__(self, pou: Pou, mark: Callable[[], int], *, is_on: bool) -> None:
        super().__init__(mark, is_on=is_on)
        self._pou = pou

    # ---- suites and statements

    def statement(self, statement: Statement) -> None:
        """Begin a statement."""
        if not self.is_counted(statement) or isinstance(statement, Label):
            return
        if not isinstance(statement.origin, tree.Step | tree.Transition):
            self._place(statement, Kind.STATEMENT, "")

    def after(self, statement: AnyStatement) -> None:
        if self.is_on and _may_leave(statement):
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
            case tree.Transition(sources=sources, targets=targets, name=name):
                yield Arm(name or f"{', '.join(sources)} to {', '.join(targets)}")
            case tree.If(branches=branches):
                for number, branch in enumerate(branches):
                    yield Arm(f"ELSIF {number}" if number else "IF", branch.position.line)

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
            case _ if isinstance(one, _LEAVING):
                return True
    return False
