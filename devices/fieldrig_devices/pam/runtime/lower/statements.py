"""Statements as resumable instructions (`languages.resumable`).

`base` is the number of the item for which they run, from 0, and `frame` is where the formal parameters are.  Only the
statements of sequences wait: they call a function of the run time, which says whether the slice has to end.
"""

from collections.abc import Callable, Sequence
from typing import Final

from fieldrig_devices.languages import instructions as resumable
from fieldrig_devices.languages.instructions import Branch, Do, End, Instruction, Jump, Pause
from fieldrig_devices.pam.language import tree
from fieldrig_devices.pam.language.functions import REPLACED, VALUES, Type
from fieldrig_devices.pam.language.tree import Expression, Inquiry, Node, Reduction, Reference, RoutineCall, Statement
from fieldrig_devices.pam.runtime.layout import Cells
from fieldrig_devices.pam.runtime.lower import lowered
from fieldrig_devices.pam.runtime.lower.expressions import Expressions, Surroundings, base_of, cell
from fieldrig_devices.pam.runtime.lower.formulas import Formula
from fieldrig_devices.pam.runtime.lower.lowered import Lowered, routine_name
from fieldrig_devices.pam.runtime.lower.operands import INDENT, Emitter, Operand
from fieldrig_devices.pam.runtime.lower.uses import PENDING, ItemOf, Use, Verb
from fieldrig_devices.pam.runtime.walk import nodes

GIVE_WAY: Final = "W[0]"
"""True if another program or a connected routine waits for the end of a loop (PAML-301)."""
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
    ) -> None:
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
        self._can_wait = at.asks is Verb.LATER
        self._has_exceptions = False
        self._entries: dict[str, int] = {}
        self._waiting_for_entries: list[tuple[int, str]] = []

    def lower(self, statements: Sequence[Statement], end: tree.Place) -> list[Instruction]:
        self._has_exceptions = any(isinstance(node, tree.ArmException) for node in nodes(*statements))
        self._statements(statements)
        self.instructions.append(End(self._code.line(end)))
        for site, label in self._waiting_for_entries:
            known = self._code.sites[site]
            assert isinstance(known, lowered.ExceptionSite)
            self._code.sites[site] = lowered.ExceptionSite(known.formula, lowered.Entry(self._entries[label]))
        return self.instructions

    # ---- instructions

    def _statements(self, statements: Sequence[Statement]) -> None:
        for statement in statements:
            self._line = self._code.line(statement.place)
            self._at.answers.clear()
            self._statement(statement)

    def _do(self, emitter: Emitter, *lines: str, is_event: bool = False) -> None:
        """Add an instruction; one that may cause an event of the sequence's own exception can end the slice."""
        python = (*emitter.lines, *lines)
        if is_event and self._has_exceptions:
            self.instructions.append(Pause(self._line, python, INTERRUPTED))
        else:
            self.instructions.append(Do(self._line, python))

    def _wait(self, emitter: Emitter, condition: str) -> None:
        self.instructions.append(Pause(self._line, tuple(emitter.lines), condition))

    def _operand(self, expression: Expression, emitter: Emitter) -> Operand:
        return self._expressions.operand(expression, emitter, self._at)

    def _ask_before(self, *roots: Node | None) -> None:
        """Let a sequence wait for the answers that come over the ring, before the statement that needs them."""
        if not self._can_wait:
            return
        inside = {id(part) for node in nodes(*roots) if isinstance(node, Reduction) for part in nodes(node.operand)}
        named = {id(node.subject) for node in nodes(*roots) if isinstance(node, Inquiry | tree.ParameterOf)}
        for node in nodes(*roots):
            asked = self._pending(node) if id(node) not in inside | named else None
            if asked is None:
                continue
            subject, function = asked
            called = self._expressions.uses.name(Use(Verb.LATER, subject.name, subject.index, function))
            slot = len(self._at.answers)
            parts = [*filter(None, [base_of(subject)]), str(slot)]
            self._wait(Emitter(), f"{called}({', '.join(parts)})")
            self._at.answers[id(node)] = f"answer({slot})"

    def _pending(self, node: Node) -> tuple[Reference, str] | None:
        match node:
            case Inquiry(subject=Reference() as subject, function=function):
                pass
            case Reference() as subject if subject.name not in self._expressions.layout.cells:
                function = "value"
            case _:
                return None
        if subject.name in self._at.formals:
            return None
        is_pending = (self._expressions.kind(subject.name), function) in PENDING
        return (subject, function) if is_pending else None

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
        condition = emitter.flag(self._operand(statement.condition, emitter)).text
        branch = len(self.instructions)
        line = self._line
        self.instructions.append(Branch(line, tuple(emitter.lines), f"not {condition}", -1))
        self._statements(statement.then)
        if statement.otherwise:
            jump = len(self.instructions)
            self.instructions.append(Jump(line, -1, 0))
            self._target(branch)
            self._statements(statement.otherwise)
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
        until = emitter.flag(self._operand(statement.until, emitter)).text
        pause = GIVE_WAY if self._can_wait else ""
        self.instructions.append(Branch(self._line, tuple(emitter.lines), f"not {until}", start, pause=pause))

    # ---- access to objects

    def _assign(self, target: Reference, value: Expression) -> None:
        emitter = Emitter()
        found = self._operand(value, emitter)
        cells = self._expressions.layout.cells.get(target.name)
        if cells is not None:
            text = emitter.as_type(found, cells.type).text
            self._store(cells, target, text, emitter)
            return
        kind = self._expressions.kind(target.name)
        if VALUES[kind] == "flag":
            found = emitter.flag(found)
        else:
            found = emitter.integer(found) if kind in _INTEGER_OUTPUTS else emitter.checked(emitter.number(found))
        called = self._expressions.uses.name(Use(Verb.SET, target.name, target.index))
        self._do(emitter, _called(called, base_of(target), [found.text]), is_event=True)

    def _store(self, cells: Cells, target: Reference, text: str, emitter: Emitter) -> None:
        """Write a variable.  A change that something may wait for is made known."""
        is_watched = cells.name in self._watched and not cells.is_common
        if target.index == "all":
            if not is_watched and cells.count <= _UNROLLED:
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

    # ---- statements that wait

    def _site(self, site: lowered.Site) -> int:
        self._code.sites.append(site)
        return len(self._code.sites) - 1

    def _formula(self, expression: Expression) -> Formula:
        return self._expressions.formula(expression, self._at.items)

    def _milliseconds(self, duration: Expression, emitter: Emitter) -> str:
        return emitter.checked(emitter.number(self._operand(duration, emitter))).text

    def _timed(self, function: str, site: int, timeout: Expression | None) -> None:
        """Wait at a site, with a time-out if there is one."""
        self._ask_before(timeout)
        emitter = Emitter()
        if timeout is None:
            self._wait(emitter, f"{function}({site})")
        else:
            self._wait(emitter, f"{function}_until({site}, {self._milliseconds(timeout, emitter)})")

    def _service(self, statement: Statement) -> None:
        match statement:
            case tree.Condition(condition=condition, timeout=timeout):
                self._timed("condition", self._site(lowered.ConditionSite(self._formula(condition))), timeout)
            case tree.Case(branches=branches, timeout=timeout):
                found = tuple((self._formula(branch.condition), branch.sequence.name) for branch in branches)
                late = None if timeout is None else timeout.sequence.name
                site = self._site(lowered.CaseSite(found, late))
                self._timed("choose", site, None if timeout is None else timeout.condition)
            case tree.Wait(duration=duration):
                self._ask_before(duration)
                emitter = Emitter()
                self._wait(emitter, f"wait_time({self._milliseconds(duration, emitter)})")
            case tree.DuplicateStart():
                self._wait(Emitter(), "gate()")
            case tree.StartSequence(sequence=sequence):
                site = self._site(lowered.Switch(sequence.name))
                self._do(Emitter(), f"switch({site})")
                self.instructions.append(End(self._line, 0))
            case tree.StartTask():
                self._wait(Emitter(), f"start_task({self._site(_start(statement))})")
            case tree.ArmException():
                self._arm(statement)
            case tree.ExceptionEntry(label=label):
                self._entries[label] = len(self.instructions)
                self._do(Emitter())
            case tree.RemoveException():
                self._do(Emitter(), "disarm()")

    def _arm(self, statement: tree.ArmException) -> None:
        action: lowered.ExceptionAction
        match statement.action:
            case tree.StartSequence(sequence=sequence):
                action = lowered.Switch(sequence.name)
            case tree.StartTask() as start:
                action = _start(start)
            case tree.EntryAction():
                action = lowered.Entry(-1)
            case tree.AbortAction():
                action = lowered.Abort()
        site = self._site(lowered.ExceptionSite(self._formula(statement.condition), action))
        if isinstance(statement.action, tree.EntryAction):
            self._waiting_for_entries.append((site, statement.action.label))
        if statement.has_timeout and statement.timeout is None:
            self._wait(Emitter(), f"arm_rest({site})")
        else:
            self._timed("arm", site, statement.timeout)


def _start(statement: tree.StartTask) -> lowered.StartSite:
    sequence = statement.sequence
    return lowered.StartSite(statement.task, sequence.name, sequence.is_indexed, statement.mode)


def _called(function: str, base: str, texts: Sequence[str]) -> str:
    return f"{function}({', '.join([*filter(None, [base]), *texts])})"
