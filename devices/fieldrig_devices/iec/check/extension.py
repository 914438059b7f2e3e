"""Statements that tests of programs have besides those of the language, such as assertions.

The checker knows only that there may be such a thing: it asks the extension about the calls in its files.
"""

from collections.abc import Collection, Sequence
from typing import Any, Protocol

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.program import AnyStatement, Expression, Pou, Program


class Extension(Protocol):
    """`checker` is a `checker.Checker`, whose context has the project that has the extension."""

    def units(self, units: Sequence[tree.Unit]) -> Sequence[tree.Unit]:
        """Return the files of a project as the checker is to see them."""

    def begin(self, project: Any) -> None:
        """Called with the `project.Project` when everything is declared and no body has been checked."""

    def applies(self, file: str) -> bool:
        """True for a file whose code may use its statements, and write variables that belong to other blocks."""

    @property
    def words(self) -> Collection[str]:
        """The words of its statements, for hints."""

    def statement(self, checker: Any, node: tree.Call, line: int) -> list[AnyStatement] | None:
        """Return the statements of a call; None for one that is not its own."""

    def value(self, checker: Any, node: tree.Call) -> Expression | None:
        """Return the value of a call for which `has_value` is true; None after a message."""

    def has_value(self, node: tree.Call) -> bool:
        """True for a call in an expression that is its own."""

    def first(self, project: Any) -> Sequence[Pou]:
        """Return what may run first besides the programs of tasks, and so starts the variables of the program."""

    def finish(self, program: Program) -> None:
        """Called when all bodies have been checked, in front of the layout."""
