"""Compiles the text of an application to a program that can run: parse, check, place, lower, and compile the Python.

The result can be pickled, so that another process can do the work.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from fieldrig.coverage.marks import HIT
from fieldrig.sandbox import Values
from fieldrig_devices.languages.mistakes import CompileError, Mistake
from fieldrig_devices.languages.resumable import prepare
from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.items import Actions, Application, BooleanEquation, Program, Task
from fieldrig_devices.pam.language.preprocessor import Reader, no_files
from fieldrig_devices.pam.language.tokens import mistake
from fieldrig_devices.pam.language.tree import Node, Reduction, Reference, StartTask
from fieldrig_devices.pam.language.words import PREDECLARED
from fieldrig_devices.pam.runtime import sizes
from fieldrig_devices.pam.runtime.layout import Layout, layout_of, number_of
from fieldrig_devices.pam.runtime.lower import lower
from fieldrig_devices.pam.runtime.lower.lowered import Lowered
from fieldrig_devices.pam.runtime.walk import nodes


def check_counts(program: Program, layout: Layout) -> list[Mistake]:
    """Report objects that have fewer items than what uses them with [i], so that [i] always is an item (PAML-294)."""
    mistakes: list[Mistake] = []
    for item in program.items:
        if isinstance(item, BooleanEquation | Actions | Task):
            mistakes += _wrong_counts(item, item.name, layout)
    return mistakes


def _wrong_counts(root: Node, owner: str, layout: Layout) -> Iterator[Mistake]:
    reductions = [node for node in nodes(root) if isinstance(node, Reduction)]
    inside = {id(part) for reduction in reductions for part in nodes(reduction.operand)}
    for node in nodes(root):
        if isinstance(node, Reference) and node.index == "i" and id(node) not in inside:
            yield from _compared(node, node.name, owner, layout)
        elif isinstance(node, StartTask) and node.sequence.is_indexed:
            yield from _compared(node, node.task, owner, layout)
    for reduction in reductions:
        present = [node for node in nodes(reduction.operand) if isinstance(node, Reference) and node.index == "i"]
        for node in present[1:]:
            yield from _compared(node, node.name, present[0].name, layout)


def _compared(node: Node, name: str, owner: str, layout: Layout) -> Iterator[Mistake]:
    own, wanted = layout.counts.get(name, 1), layout.counts[owner]
    if own < wanted and name not in PREDECLARED:
        yield mistake(node.place, f"{name} has {own} items, but {owner} has {wanted}", f"at least {wanted} items")


DEFAULT_CYCLE: Final = 3
"""Thirds of a millisecond."""
TABLES: Final = frozenset({"M", "W"})
"""Names in generated code that are lists: the cells, and what makes a program give way."""
_FUNCTIONS: Final = """
    overflow invalid signed truncated quotient remainder power changed poke_all poke_and_tell poke_inverted
    timed_out answer condition condition_until choose choose_until wait_time gate
    switch start_task arm arm_until arm_rest disarm
    ceil floor exp ln log10 sqrt cos sin tan acos asin atan cosh sinh tanh
"""
FUNCTIONS: Final = frozenset(_FUNCTIONS.split())
"""Functions of the run time that generated code calls."""


@dataclass(slots=True)
class Compiled:
    program: Program
    layout: Layout
    code: Lowered
    texts: Mapping[str, str] = field(default_factory=dict)
    """The source files, for the debugger."""
    notes: tuple[Mistake, ...] = ()

    @property
    def application(self) -> Application:
        first = self.program.items[0]
        assert isinstance(first, Application)
        return first

    @property
    def thirds(self) -> int:
        """BASIC_PAM_CYCLE in thirds of a millisecond (PAML-012)."""
        return number_of(self.application.parameters, "BASIC_PAM_CYCLE") or DEFAULT_CYCLE

    @property
    def names(self) -> frozenset[str]:
        """All names that generated code may use, apart from its own variables."""
        formulas = {formula.function for formula in self.code.formulas.table}
        return self._tables | FUNCTIONS | self.code.uses.table.keys() | formulas

    @property
    def rules(self) -> Values:
        return Values(self._tables)

    @property
    def _tables(self) -> frozenset[str]:
        return TABLES | ({HIT} if self.code.marked.hits else set())


def compile_application(
    text: str, file: str, read: Reader = no_files, *, ignores_case: bool = False, is_debugged: bool = False
) -> Compiled:
    """Compile an application; CompileError with all mistakes if it has any.

    `read` returns the text of an included file.  With `ignores_case` names are the same in any case, and with
    `is_debugged` the code for breakpoints is made in advance.
    """
    texts = {file: text}

    def reading(name: str) -> str | None:
        found = read(name)
        if found is not None:
            texts[name] = found
        return found

    program, found = checked(text, file, reading, ignores_case=ignores_case)
    found += too_large(program, found) or wrong_counts(program, found)
    mistakes = [mistake for mistake in found if not mistake.is_note]
    if mistakes:
        raise CompileError(mistakes)
    compiled = compile_program(program, is_debugged=is_debugged)
    compiled.texts, compiled.notes = texts, tuple(found)
    return compiled


def compile_program(program: Program, *, is_debugged: bool = False) -> Compiled:
    """Compile a checked application."""
    layout = layout_of(program)
    code = lower(program, layout)
    compiled = Compiled(program, layout, code)
    prepare(code.routines, compiled.names, compiled.rules, is_debugged=is_debugged)
    return compiled


def wrong_counts(program: Program, mistakes: Sequence[Mistake]) -> list[Mistake]:
    """Report objects with too few items, if nothing else is wrong."""
    if any(not mistake.is_note for mistake in mistakes):
        return []
    return check_counts(program, layout_of(program))


def too_large(program: Program, mistakes: Sequence[Mistake]) -> list[Mistake]:
    """Report an application that has no room in the PAM (PAML-013), if nothing else is wrong."""
    if any(not mistake.is_note for mistake in mistakes):
        return []
    size, place = sizes.application(program), program.items[0].place
    if size <= sizes.MOST_BYTES:
        return []
    what, expected = f"the application has {size} bytes", f"at most {sizes.MOST_BYTES} bytes"
    hint = "Objects with NUMBER or NODES_GROUP, and routines, save the repetition of declarations and statements."
    return [Mistake(place.line, place.column, what, expected, file=place.file, hint=hint)]
