"""Watch expressions: any expression of the language, compiled for a program that runs."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from fieldrig.sandbox import Values, bind, compiled
from fieldrig_devices.languages.faults import CAUGHT
from fieldrig_devices.languages.mistakes import Mistake
from fieldrig_devices.pam.language.check import names_of
from fieldrig_devices.pam.language.check.expressions import type_of
from fieldrig_devices.pam.language.check.symbols import Context, Names
from fieldrig_devices.pam.language.parser.cursor import Cursor, UnexpectedError
from fieldrig_devices.pam.language.parser.expressions import expression
from fieldrig_devices.pam.language.tokens import Token, split
from fieldrig_devices.pam.language.tree import Expression
from fieldrig_devices.pam.runtime.binding import Binding
from fieldrig_devices.pam.runtime.compiler import FUNCTIONS, TABLES, Compiled
from fieldrig_devices.pam.runtime.item import Item, Value
from fieldrig_devices.pam.runtime.kernel import ProgramKernel
from fieldrig_devices.pam.runtime.lower.expressions import Expressions
from fieldrig_devices.pam.runtime.lower.formulas import Formulas
from fieldrig_devices.pam.runtime.lower.uses import Uses
from fieldrig_devices.pam.runtime.watches import UnansweredError

LONGEST: Final = 1_000
"""Longest expression in characters."""
_MOST_KEPT: Final = 1_000


class Watch:
    """Computes expressions for a debugger.  Their code is kept, because a condition is computed again and again."""

    def __init__(
        self,
        kernel: ProgramKernel,
        program: Compiled,
        items: Mapping[str, Sequence[Item]],
        scope: Mapping[str, Any],
    ) -> None:
        """`items` are those of all objects by name, and `scope` has the names that generated code sees."""
        self._kernel, self._program, self._items, self._scope = kernel, program, items, scope
        self._names: Names | None = None
        self._known: dict[str, Callable[[int], Value]] = {}

    def value(self, text: str, item: int = 0) -> Value:
        """Return the value of an expression, where [i] is this item.  ValueError if it has none."""
        function = self._known.get(text)
        if function is None:
            if len(self._known) >= _MOST_KEPT:
                self._known.clear()
            function = self._known[text] = self._compiled(text)
        try:
            return function(item)
        except UnansweredError:
            raise ValueError(f"{text}: the answer is under way on the ring") from None
        except CAUGHT as cause:
            raise ValueError(f"{text} has no value: {cause}") from cause

    def _compiled(self, text: str) -> Callable[[int], Value]:
        tree = self._checked(text)
        uses, formulas = Uses(), Formulas()
        formula = Expressions(self._program.layout, uses, formulas).formula(tree, wanted=None)
        table: list[Callable[[int], Value]] = []
        functions = Binding(self._kernel, self._items, table).of(uses.table)
        known = {each.function for each in formulas.table}
        names = TABLES | FUNCTIONS | functions.keys() | known
        made = bind(compiled(formulas.source, names, Values(TABLES), "<watch>"), {**self._scope, **functions})
        table += [made[each.function] for each in formulas.table]
        return table[formula.number]

    def _checked(self, text: str) -> Expression:
        if len(text) > LONGEST:
            raise ValueError(f"expected an expression of at most {LONGEST} characters, got {len(text)}")
        source = split(text, "")
        cursor = Cursor([*source.tokens[:-1], Token("end", "the end of the text", source.tokens[-1].place)])
        try:
            tree = expression(cursor)
            if not cursor.is_at_end:
                cursor.unexpected("an operator, or the end of the expression")
        except UnexpectedError:
            tree = None
        _refuse([*source.mistakes, *cursor.mistakes])
        assert tree is not None
        if self._names is None:
            self._names = names_of(self._program.program)
        self._names.mistakes.clear()
        type_of(tree, self._names, Context(is_multiple=True))
        _refuse(self._names.mistakes)
        return tree


def _refuse(mistakes: list[Mistake]) -> None:
    if mistakes:
        first = mistakes[0]
        raise ValueError(f"{first.what}; expected {first.expected or 'an expression'}")
