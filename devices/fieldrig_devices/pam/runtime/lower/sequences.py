"""Statements of sequences: those of `statements`, and those that wait.

A statement that waits calls a function of the run time (`runtime.services`), which says whether the slice has to end.
"""

from collections.abc import Callable, Sequence
from typing import Final

from fieldrig.coverage.marks import hit
from fieldrig_devices.languages.instructions import Do, End, Instruction, Pause
from fieldrig_devices.pam.language import tree
from fieldrig_devices.pam.language.functions import Type
from fieldrig_devices.pam.language.tree import Expression, Inquiry, Node, Reduction, Reference, Statement
from fieldrig_devices.pam.runtime.lower import lowered
from fieldrig_devices.pam.runtime.lower.expressions import Expressions, Surroundings, base_of
from fieldrig_devices.pam.runtime.lower.formulas import Formula
from fieldrig_devices.pam.runtime.lower.lowered import Lowered
from fieldrig_devices.pam.runtime.lower.operands import INDENT, Emitter
from fieldrig_devices.pam.runtime.lower.statements import Body
from fieldrig_devices.pam.runtime.lower.uses import PENDING, Use, Verb
from fieldrig_devices.pam.runtime.walk import nodes

GIVE_WAY: Final = "W[0]"
"""True if another program or a connected routine waits for the end of a loop (PAML-301)."""


class SequenceBody(Body):
    """Lowers the statements of a sequence."""

    def __init__(
        self,
        expressions: Expressions,
        code: Lowered,
        watched: frozenset[str],
        at: Surroundings,
        on_call: Callable[[str, tuple[Type, ...]], None],
        title: str,
    ) -> None:
        super().__init__(expressions, code, watched, at, on_call, title)
        self._loop_pause = GIVE_WAY
        self._entries: dict[str, int] = {}
        self._waiting_for_entries: list[tuple[int, str]] = []

    def lower(self, statements: Sequence[Statement], end: tree.Place) -> list[Instruction]:
        self._has_exceptions = any(isinstance(node, tree.ArmException) for node in nodes(*statements))
        super().lower(statements, end)
        for site, label in self._waiting_for_entries:
            known = self._code.sites[site]
            assert isinstance(known, lowered.ExceptionSite)
            self._code.sites[site] = lowered.ExceptionSite(known.formula, lowered.Entry(self._entries[label]))
        return self.instructions

    def _wait(self, emitter: Emitter, condition: str) -> None:
        self.instructions.append(Pause(self._line, tuple(emitter.lines), condition))

    def _ask_before(self, *roots: Node | None) -> None:
        """Let a sequence wait for the answers that come over the ring, before the statement that needs them."""
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

    # ---- statements that wait

    def _site(self, site: lowered.Site) -> int:
        self._code.sites.append(site)
        return len(self._code.sites) - 1

    def _formula(self, expression: Expression) -> Formula:
        return self._expressions.formula(expression, self._at.items, lower=self._condition)

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
                if timeout is not None:
                    self._count_timeout(statement)
            case tree.Case(branches=branches, timeout=timeout):
                cases = tuple((self._formula(branch.condition), branch.sequence.name) for branch in branches)
                late = None if timeout is None else timeout.sequence.name
                arms = [(f"CASE {number}", branch.place) for number, branch in enumerate(branches, 1)]
                arms += [] if timeout is None else [("TIMEOUT", timeout.place)]
                site = self._site(lowered.CaseSite(cases, late, self._alternatives(statement, arms)))
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

    def _count_timeout(self, statement: Statement) -> None:
        """Count how a CONDITION with a time-out ends."""
        marks = self._alternatives(statement, [("TIMEOUT", statement.place), ("no TIMEOUT", statement.place)])
        if marks:
            late, met = marks
            python = "if timed_out():", f"{INDENT}{hit(late)}", "else:", f"{INDENT}{hit(met)}"
            self.instructions.append(Do(self._line, python, 0))

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
