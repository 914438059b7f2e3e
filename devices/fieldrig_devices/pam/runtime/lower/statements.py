"""Statements as resumable instructions (`languages.resumable`).

`base` is the number of the item for which they run, from 0, and `frame` is where the formal parameters are.
"""

from collections.abc import Callable, Sequence
from typing import Final

from fieldrig.coverage import collecting
from fieldrig.coverage.decisions import FEWEST, MOST
from fieldrig.coverage.marks import SuiteMarks, combination, hit
from fieldrig.coverage.places import Kind, Place
from fieldrig_devices.languages import instructions as resumable
from fieldrig_devices.languages.instructions import Branch, Do, End, Instruction, Jump, Pause
from fieldrig_devices.pam.language import tree
from fieldrig_devices.pam.language.functions import REPLACED, VALUES, Type
from fieldrig_devices.pam.language.tree import Expression, Node, Reference, RoutineCall, Statement
from fieldrig_devices.pam.runtime.layout import Cells
from fieldrig_devices.pam.runtime.lower.conditions import Decision, conditions_at_most
from fieldrig_devices.pam.runtime.lower.expressions import Expressions, Surroundings, base_of, cell
from fieldrig_devices.pam.runtime.lower.lowered import Lowered, routine_name
from fieldrig_devices.pam.runtime.lower.operands import INDENT, Emitter, Operand, OperandOf
from fieldrig_devices.pam.runtime.lower.uses import ItemOf, Use, Verb

INTERRUPTED: Final = "W[1]"
"""True if the exception of the sequence that runs has occurred (PAML-377)."""
_INTEGER_OUTPUTS: Final = ("DIGITAL_OUTPUT", "ANALOG_OUTPUT", "LONG_VAR", "WORD_VAR")
_UNROLLED: Final = 8
"""Items of a variable that [all] sets one by one."""


class Body:
    """Lowers the statements of one routine, action or sequence."""

    def __init__(
        self,
        expressions: Expressions,
        code: Lowered,
        watched: frozenset[str],
        at: Surroundings,
        on_call: Callable[[str, tuple[Type, ...]], None],
        title: str,
    ) -> None:
        self._title = title
        self._expressions, self._code, self._watched, self._at, self._on_call = (
            expressions,
            code,
            watched,
            at,
            on_call,
        )
        self.frame_size = max(len(at.formals), 1)
        """At least 1, so that a formal parameter is the same text in its routine and in the caller."""
        self.instructions: list[Instruction] = []
        self._line = 0
        self._loop_pause = ""
        """The condition under which the end of a loop gives way."""
        self._has_exceptions = False
        self.marks = SuiteMarks(self._mark, is_on=collecting.is_on())

    def lower(self, statements: Sequence[Statement], end: tree.Place) -> list[Instruction]:
        with self.marks.suite():
            self._statements(statements)
        self.instructions.append(End(self._code.line(end)))
        return self.instructions

    # ---- instructions

    def _statements(self, statements: Sequence[Statement]) -> None:
        for statement in statements:
            self._line = self._code.line(statement.place)
            self._at.answers.clear()
            is_entry = isinstance(statement, tree.ExceptionEntry)
            if not is_entry:
                self._count(statement)
            before = len(self.instructions)
            self._statement(statement)
            if is_entry:  # an exception leads to its own instruction, so the mark is behind that
                self.marks.leave()
                self._count(statement)
            if any(isinstance(one, Pause | End) for one in self.instructions[before:]):
                self.marks.leave()

    def _mark(self) -> int:
        """Add a mark to the code, which costs the program no time; return its number."""
        number = self._code.marked.new()
        self.instructions.append(Do(self._line, (hit(number),), 0))
        return number

    def _count(self, statement: Statement, branch: str = "") -> None:
        """Count a statement, or a branch of it."""
        self.marks.add(self._place(statement, branch))

    def _place(self, statement: Statement, branch: str = "", at: tree.Place | None = None) -> Place:
        """Return the place of a statement, or of a branch of it, which may be on a line of its own."""
        kind, of = (Kind.BRANCH, statement.place.line) if branch else (Kind.STATEMENT, 0)
        line, column = (at or statement.place).line, statement.place.column
        return Place(statement.place.file, self._title, kind, line, column, of, branch)

    def _condition(self, condition: Expression, emitter: Emitter, operand_of: OperandOf | None = None) -> Operand:
        """Return a condition as a flag; the conditions of a decision have marks, if they are wanted."""
        operand_of = operand_of or self._operand
        if not collecting.is_detailed() or not conditions_at_most(condition, MOST):
            return emitter.flag(operand_of(condition, emitter))
        decision = Decision(operand_of, emitter)
        value, formula = decision.lower(condition)
        if len(decision.values) >= FEWEST:
            first = self._code.marked.new(1 << len(decision.values))
            emitter.lines.append(combination(first, decision.values))
            file, line, column = condition.place
            self.marks.decision(formula, first, decision.texts, Place(file, self._title, Kind.CONDITION, line, column))
        return value

    def _alternatives(self, statement: Statement, branches: Sequence[tuple[str, tree.Place]]) -> tuple[int, ...]:
        """Count branches whose marks are not in the code of their own; return the marks, or nothing without marks."""
        if not self.marks.is_on:
            return ()
        marks = [self._code.marked.new() for _ in branches]
        for mark, (name, at) in zip(marks, branches, strict=True):
            self.marks.alone(mark, self._place(statement, name, at))
        return tuple(marks)

    def _branch(self, statement: tree.If, branch: str, statements: Sequence[Statement]) -> None:
        """Add the statements of a branch."""
        with self.marks.suite():
            self._count(statement, branch)
            self._statements(statements)

    def _do(self, emitter: Emitter, *lines: str, is_event: bool = False) -> None:
        """Add an instruction; one that may cause an event of the sequence's own exception can end the slice."""
        python = (*emitter.lines, *lines)
        if is_event and self._has_exceptions:
            self.instructions.append(Pause(self._line, python, INTERRUPTED))
        else:
            self.instructions.append(Do(self._line, python))

    def _operand(self, expression: Expression, emitter: Emitter) -> Operand:
        return self._expressions.operand(expression, emitter, self._at)

    def _ask_before(self, *roots: Node | None) -> None:
        """Wait for the answers that a statement needs; only sequences can."""

    def _service(self, statement: Statement) -> None:
        """Lower a statement that only sequences have."""
        raise AssertionError(f"{statement} is not checked")

    # ---- statements

    def _statement(self, statement: Statement) -> None:
        match statement:
            case tree.Assign(target=target, value=value):
                self._ask_before(value)
                self._assign(target, value)
            case tree.Execute():
                self._ask_before(*statement.arguments)
                self._execute(statement)
            case tree.Modify():
                self._ask_before(statement.value)
                self._modify(statement.target.subject, statement.target.parameter, statement.value)
            case tree.Ask(inquiry=inquiry):
                self._ask_before(inquiry)
                emitter = Emitter()
                emitter.new(self._operand(inquiry, emitter).text)
                self._do(emitter)
            case tree.Connect(blocks=blocks):
                names = tuple(ItemOf(block.name, block.index) for block in blocks)
                called = self._expressions.uses.name(Use(Verb.CONNECT, blocks[0].name, None, "", names))
                self._do(Emitter(), f"{called}()", is_event=True)
            case tree.Call(call=call):
                self._ask_before(*call.arguments)
                self._call(call)
            case tree.If():
                self._if(statement)
            case tree.Loop():
                self._loop(statement)
            case _:
                self._service(statement)

    def _if(self, statement: tree.If) -> None:
        self._ask_before(statement.condition)
        emitter = Emitter()
        condition = self._condition(statement.condition, emitter).text
        branch = len(self.instructions)
        line = self._line
        self.instructions.append(Branch(line, tuple(emitter.lines), f"not {condition}", -1))
        self._branch(statement, "IF", statement.then)
        if statement.otherwise or self.marks.is_on:
            jump = len(self.instructions)
            self.instructions.append(Jump(line, -1, 0))
            self._target(branch)
            self._branch(statement, "ELSE" if statement.otherwise else "no ELSE", statement.otherwise)
            self._target(jump)
        else:
            self._target(branch)

    def _target(self, pc: int) -> None:
        """Let a jump lead to the next instruction."""
        jump = self.instructions[pc]
        target = len(self.instructions)
        if isinstance(jump, Branch):
            self.instructions[pc] = Branch(jump.line, jump.python, jump.condition, target, jump.cost)
        else:
            self.instructions[pc] = Jump(jump.line, target, jump.cost)

    def _loop(self, statement: tree.Loop) -> None:
        start = len(self.instructions)
        self._statements(statement.body)
        self._line = self._code.line(statement.until.place)
        self._at.answers.clear()
        self._ask_before(statement.until)
        emitter = Emitter()
        until = self._condition(statement.until, emitter).text
        python = tuple(emitter.lines)
        self.instructions.append(Branch(self._line, python, f"not {until}", start, pause=self._loop_pause))

    # ---- access to objects

    def _assign(self, target: Reference, value: Expression) -> None:
        emitter = Emitter()
        operand = self._operand(value, emitter)
        cells = self._expressions.layout.cells.get(target.name)
        if cells is not None:
            text = emitter.as_type(operand, cells.type).text
            self._store(cells, target, text, emitter)
            return
        kind = self._expressions.kind(target.name)
        if VALUES[kind] == "flag":
            operand = emitter.flag(operand)
        else:
            operand = emitter.integer(operand) if kind in _INTEGER_OUTPUTS else emitter.checked(emitter.number(operand))
        called = self._expressions.uses.name(Use(Verb.SET, target.name, target.index))
        self._do(emitter, _called(called, base_of(target), [operand.text]), is_event=True)

    def _store(self, cells: Cells, target: Reference, text: str, emitter: Emitter) -> None:
        """Write a variable.  A change that something may wait for is made known."""
        is_watched = cells.name in self._watched and not cells.is_common
        if target.index == "all":
            if not is_watched and cells.count <= _UNROLLED:
                text = emitter.new(text)
                self._do(emitter, *(f"M[{cells.first + number}] = {text}" for number in range(cells.count)))
            else:
                name = "poke_and_tell" if is_watched else "poke_all"
                self._do(emitter, f"{name}({cells.first}, {cells.count}, {text})", is_event=is_watched)
            return
        where = cell("base" if target.index == "i" else "", cells.first)
        if not is_watched:
            self._do(emitter, f"{where} = {text}")
            return
        new = emitter.new(text)
        number = where[2:-1]
        lines = f"if {where} != {new}:", f"{INDENT}{where} = {new}", f"{INDENT}changed({number})"
        self._do(emitter, *lines, is_event=True)

    def _execute(self, statement: tree.Execute) -> None:
        target, function = statement.target, statement.function
        cells = self._expressions.layout.cells.get(target.name)
        if cells is not None:
            self._switch(cells, target, function)
            return
        if function in REPLACED:
            self._modify(target, REPLACED[function], statement.arguments[0])
            return
        emitter = Emitter()
        arguments, texts = self._expressions.arguments(statement.arguments, emitter, self._at)
        called = self._expressions.uses.name(Use(Verb.DO, target.name, target.index, function, arguments))
        self._do(emitter, _called(called, base_of(target), texts), is_event=True)

    def _switch(self, cells: Cells, target: Reference, function: str) -> None:
        """Carry out set, reset or invert on a flag."""
        if function == "invert" and target.index == "all":
            self._do(Emitter(), f"poke_inverted({cells.first}, {cells.count})", is_event=True)
            return
        where = cell("base" if target.index == "i" else "", cells.first)
        text = {"set": "True", "reset": "False"}.get(function) or f"not {where}"
        self._store(cells, target, text, Emitter())

    def _modify(self, subject: Reference, parameter: str, value: Expression | RoutineCall) -> None:
        emitter = Emitter()
        if isinstance(value, RoutineCall):
            operands = [emitter.checked(self._operand(argument, emitter)) for argument in value.arguments]
            if value.routine:
                self._on_call(value.routine, tuple(operand.type for operand in operands))
            use = Use(Verb.PUT, subject.name, subject.index, parameter, (None,) * len(operands), value.routine)
            texts = [operand.text for operand in operands]
        else:
            arguments, texts = self._expressions.arguments([value], emitter, self._at)
            use = Use(Verb.PUT, subject.name, subject.index, parameter, arguments)
        self._do(emitter, _called(self._expressions.uses.name(use), base_of(subject), texts), is_event=True)

    def _call(self, call: RoutineCall) -> None:
        emitter = Emitter()
        operands = [emitter.checked(self._operand(argument, emitter)) for argument in call.arguments]
        types = tuple(operand.type for operand in operands)
        self._on_call(call.routine, types)
        start = self.frame_size
        lines = [f"{cell('frame', start + slot)} = {operand.text}" for slot, operand in enumerate(operands)]
        if lines or emitter.lines:
            self._do(emitter, *lines)
        self.instructions.append(
            resumable.Call(self._line, routine_name(call.routine, types), cost=1 if not lines else 0, is_checked=False)
        )
        if self._has_exceptions:
            self._do(Emitter(), is_event=True)


def _called(function: str, base: str, texts: Sequence[str]) -> str:
    return f"{function}({', '.join([*filter(None, [base]), *texts])})"
