"""Structured Text: every statement with its rules, and the lists that the checked program has instead."""

from collections.abc import Callable, Sequence
from typing import Any, Final

from fieldrig_devices.iec import program, tree
from fieldrig_devices.iec.check import blocks, constants, enable, loops, properties, references
from fieldrig_devices.iec.check.case_labels import CaseLabels
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.expressions import Expressions
from fieldrig_devices.iec.check.operators import integer_of
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.check.untyped import Untyped
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import AnyStatement, Constant, Expression
from fieldrig_devices.iec.tree import NOWHERE
from fieldrig_devices.iec.types import EnumType, SubrangeType, Type

BOOL: Final = Elementary.BOOL
Tries = tuple[object, ...]
"""The position of each __TRY around a statement, and the number of the part of it, from the outside."""
ONE: Final = tree.Literal(tree.LiteralKind.INTEGER, 1)


def is_exception_code(kind: Type) -> bool:
    """True for ExceptionCode, and for integers that have room for its numbers."""
    base = kind.base if isinstance(kind, EnumType) else kind
    return isinstance(base, Elementary) and base.is_integer and base.size >= 4


class Statements:
    """The statements of one body."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self.expressions = Expressions(context)
        self._loops = 0
        self._ifs = 0
        self._labels: dict[str, tree.Label] = {}
        self._jumps: list[tuple[tree.Jump, Tries]] = []
        self._tries: Tries = ()
        self._tries_of: dict[str, Tries] = {}
        """The parts of __TRY around each label."""

    def body(self, nodes: Sequence[tree.AnyStatement]) -> list[AnyStatement]:
        """Check a whole body, whose labels are its own."""
        made = self.statements(nodes)
        for jump, tries in self._jumps:
            if tries != self._tries_of.get(self.context.key(jump.label), tries):
                what = f"JMP {jump.label} leads into or out of a __TRY"
                self.context.say(jump, what, "a label in the same part of it")
            if self.context.key(jump.label) not in self._labels:
                hint = self.context.project.reports.closest(jump.label, self._labels)
                self.context.say(
                    jump, f"there is no label {jump.label}", f"a line {jump.label}: in the same body", hint
                )
        return made

    def statements(self, nodes: Sequence[tree.AnyStatement]) -> list[AnyStatement]:
        made: list[AnyStatement] = []
        for node in nodes:
            checked = _STATEMENTS[type(node)](self, node)
            parts = checked if isinstance(checked, list) else [checked] if checked is not None else []
            for part in parts:
                part.origin = None
            if parts:
                parts[0].origin = node
            made += parts
        return made

    # ---- assignments and calls

    def _assign(self, node: tree.Assign) -> AnyStatement | list[AnyStatement] | None:
        if node.others:
            return self._chain(node)
        if node.kind is tree.AssignKind.REFER:
            return references.assignment(self.expressions, node)
        if node.kind is tree.AssignKind.ATTEMPT:
            return references.attempt(self.expressions, node)
        if node.kind is tree.AssignKind.PLAIN and self.context.project.properties:
            writing = properties.writing(self.expressions, node)
            if writing is not None:
                return [
                    made
                    for call in writing
                    for made in blocks.call_statement(self.expressions, call, node.position.line)
                ]
        target = self.expressions.target(node.target)
        if target is None:
            self.expressions.expression(node.value)
            return None
        if node.kind is not tree.AssignKind.PLAIN:
            return self._set(node, target)
        value, line = self.expressions.expression_as(node.value, target.type), node.position.line
        return enable.statements(value, lambda made: program.Assign(target, made, line=line), line) if value else None

    def _chain(self, node: tree.Assign) -> list[AnyStatement]:
        """`a := b := 3` assigns from right to left, so that a gets what b has then."""
        parts = [node.target, *node.others, node.value]
        pairs = [tree.Assign(parts[n], parts[n + 1], position=node.position) for n in reversed(range(len(parts) - 1))]
        return self.statements(pairs)

    def _set(self, node: tree.Assign, target: program.Place) -> AnyStatement | None:
        """`x S= y` sets x if y is TRUE, and `x R= y` resets it."""
        condition = self._condition(node.value)
        if target.type is not BOOL:
            self.context.say(
                node.target, f"{text(node.target)} is {a(target.type)}", f"a BOOL in front of {node.kind.value}"
            )
            return None
        line = node.position.line
        value = Constant(node.kind is tree.AssignKind.SET, BOOL)
        return program.If(condition, [program.Assign(target, value, line=line)], line=line) if condition else None

    def _call(self, node: tree.CallStatement) -> list[AnyStatement]:
        extension = self.context.extension
        own = None if extension is None else extension.statement(self.expressions, node.call, node.position.line)
        return own if own is not None else blocks.call_statement(self.expressions, node.call, node.position.line)

    # ---- conditions and choices

    def _condition(self, node: tree.Expression) -> Expression | None:
        condition = self.expressions.expression(node, BOOL)
        if condition is None or condition.type is BOOL:
            return condition
        if type(condition) is Untyped:
            return self.expressions.convert(condition, BOOL, node)
        hint = f"write {text(node)} <> 0" if integer_of(condition) is not None else ""
        if isinstance(node, tree.Assigned):
            hint = "a comparison is written with =, an assignment with :="
        self.context.say(node, f"the condition {text(node)} is {a(condition.type)}", "a BOOL", hint)
        return None

    def _if(self, node: tree.If) -> AnyStatement | None:
        self._ifs += 1
        limit = self.context.project.limits.if_depth
        if self._ifs == limit + 1:
            hint = "use a CASE, a function or a BOOL variable"
            self.context.say(node, f"IF is nested {self._ifs} deep", f"at most {limit} (PD-318)", hint)
        branches = [
            (self._condition(branch.condition), self.statements(branch.body), branch) for branch in node.branches
        ]
        otherwise = self.statements(node.otherwise) if node.otherwise is not None else []
        self._ifs -= 1
        for condition, body, branch in reversed(branches):
            if condition is None:
                return None
            otherwise = [program.If(condition, body, otherwise, line=branch.position.line or node.position.line)]
        return otherwise[0]

    def _case(self, node: tree.Case) -> AnyStatement | None:
        selector = self.expressions.expression(node.selector)
        selector = constants.whole(selector) if selector is not None else None
        kind: Type | None = selector.type if selector is not None else None
        if selector is not None and (integer_of(selector) is None or kind is None):
            if node.selector.position != NOWHERE:  # otherwise the parser has reported it
                self.context.say(node.selector, f"{text(node.selector)} is {a(kind)}", "an integer behind CASE")
            kind = None
        labels = CaseLabels(self.expressions, kind)
        made = [(labels.ranges(branch.labels), self.statements(branch.body)) for branch in node.branches]
        otherwise = self.statements(node.otherwise) if node.otherwise is not None else []
        if selector is None or kind is None:
            return None
        if type(selector) is Untyped:
            selector = Constant(selector.value, selector.type)
        return program.Case(selector, made, otherwise, line=node.position.line)

    # ---- loops

    def _for(self, node: tree.For) -> AnyStatement | None:
        variable = self.expressions.target(node.variable)
        kind: Type | None = variable.type if variable is not None else None
        base = kind.base if isinstance(kind, SubrangeType | EnumType) else kind
        if isinstance(base, Elementary) and base.is_integer:
            ends = kind if isinstance(kind, EnumType) else base
            values = [self.expressions.expression_as(part, ends) for part in (node.first, node.last)]
            step = self._step(node.step or ONE, base)
        else:
            if kind is not None:
                self.context.say(node.variable, f"{text(node.variable)} is {a(kind)}", "an integer variable behind FOR")
            values, step = [None, None], None
        body = self._looped(node.body)
        if isinstance(base, Elementary) and not loops.has_way_out(node.body):
            self._warn_of_endless(node, values, step, base)
        if variable is None or values[0] is None or values[1] is None or step is None or kind is None:
            return None
        first = self.expressions.convert(values[0], kind, node.first)
        return (
            program.For(variable, first, values[1], step, body, line=node.position.line) if first is not None else None
        )

    def _warn_of_endless(
        self, node: tree.For, values: Sequence[Expression | None], step: Expression | None, kind: Elementary
    ) -> None:
        shown, hint = text(node.variable), "use a larger type for the variable"
        wraps = f"as {shown} is {a(kind)} and wraps around at {kind.low} and {kind.high}"
        if loops.never_ends(values[1], step, kind):
            expected = f"an end that {shown} can pass, or EXIT in the loop"
            self.context.say(node.last, f"the loop never ends, {wraps}", expected, hint)
        elif loops.steps_over_its_end(values, step, kind):
            self.context.note(node.last, f"the loop never ends unless its body changes {shown}, {wraps}", hint)

    def _step(self, node: tree.Expression, kind: Elementary) -> Expression | None:
        """The step may be negative (X16); a negative one for an unsigned variable counts down by wrapping around."""
        step = self.expressions.expression(node)
        if isinstance(step, Constant) and step.value == 0:
            self.context.say(node, "the step is 0 and the loop never ends", "a step that is not 0")
            return None
        if type(step) is Untyped and not step.is_real and int(step.value) < 0 and kind.low == 0:
            signed = next(
                wide
                for wide in (Elementary.SINT, Elementary.INT, Elementary.DINT, Elementary.LINT)
                if wide.size == kind.size
            )
            return self.expressions.convert(step, signed, node)
        return self.expressions.convert(step, kind, node) if step is not None else None

    def _looped(self, nodes: Sequence[tree.AnyStatement]) -> list[AnyStatement]:
        self._loops += 1
        made = self.statements(nodes)
        self._loops -= 1
        return made

    def _while(self, node: tree.While) -> AnyStatement | None:
        condition = self._condition(node.condition)
        body = self._looped(node.body)
        self._note_endless(node.condition, condition, node.body, ends_at=False)
        return program.Loop(body, condition=condition, line=node.position.line) if condition is not None else None

    def _repeat(self, node: tree.Repeat) -> AnyStatement | None:
        """REPEAT ends when the condition is TRUE (X8)."""
        body = self._looped(node.body)
        until = self._condition(node.until)
        self._note_endless(node.until, until, node.body, ends_at=True)
        return program.Loop(body, until=until, line=node.position.line) if until is not None else None

    def _note_endless(
        self, node: tree.Expression, condition: Expression | None, body: Sequence[tree.AnyStatement], *, ends_at: bool
    ) -> None:
        """Note a loop with a constant condition that is never the value `ends_at`, and nothing in it that leaves it."""
        if node.position == NOWHERE:  # the parser has reported the condition or the header
            return
        if isinstance(condition, Constant) and condition.value is not ends_at and not loops.has_way_out(body):
            self.context.note(node, "the loop never ends", "EXIT or RETURN leaves it")

    def _exit(self, node: tree.Exit) -> AnyStatement | None:
        return program.Exit(line=node.position.line) if self._is_in_loop(node, "EXIT") else None

    def _continue(self, node: tree.Continue) -> AnyStatement | None:
        return program.Continue(line=node.position.line) if self._is_in_loop(node, "CONTINUE") else None

    def _is_in_loop(self, node: tree.Node, word: str) -> bool:
        if not self._loops:
            self.context.say(node, f"{word} outside a loop", "a place in FOR, WHILE or REPEAT", "RETURN leaves the POU")
        return self._loops > 0

    def _try(self, node: tree.Try) -> AnyStatement | None:
        code = None if node.code is None else self._exception_code(node.code)
        parts: list[list[AnyStatement] | None] = []
        for part in (node.body, node.caught, node.final):
            self._tries = (*self._tries, node.position, len(parts))
            parts.append(None if part is None else self.statements(part))
            self._tries = self._tries[:-2]
        body, caught, final = parts
        return program.Try(body or [], code, caught, final, line=node.position.line)

    def _exception_code(self, node: tree.Expression) -> program.Place | None:
        code = self.expressions.target(node)
        if code is None or is_exception_code(code.type):
            return code
        self.context.say(node, f"{text(node)} is {a(code.type)}", "a variable of type __SYSTEM.ExceptionCode")
        return None

    # ---- jumps

    def _return(self, node: tree.Return) -> AnyStatement | None:
        if node.condition is None:
            return program.Return(line=node.position.line)
        leave = tree.Return(position=node.position)
        return self._if(
            tree.If((tree.Branch(node.condition, (leave,), position=node.position),), position=node.position)
        )

    def _label(self, node: tree.Label) -> AnyStatement | None:
        name = self.context.key(node.name)
        if name in self._labels:
            where = self._labels[name].position.line
            self.context.say(node, f"the label {node.name} exists already in line {where}", "another name")
            return None
        self._labels[name] = node
        self._tries_of[name] = self._tries
        return program.Label(name, line=node.position.line)

    def _jump(self, node: tree.Jump) -> AnyStatement:
        self._jumps.append((node, self._tries))
        return program.Jump(self.context.key(node.label), line=node.position.line)

    def _empty(self, node: tree.Empty) -> None:
        return None


_STATEMENTS: Final[dict[type, Callable[[Statements, Any], AnyStatement | list[AnyStatement] | None]]] = {
    tree.Assign: Statements._assign,
    tree.CallStatement: Statements._call,
    tree.If: Statements._if,
    tree.Case: Statements._case,
    tree.For: Statements._for,
    tree.While: Statements._while,
    tree.Repeat: Statements._repeat,
    tree.Try: Statements._try,
    tree.Exit: Statements._exit,
    tree.Continue: Statements._continue,
    tree.Return: Statements._return,
    tree.Label: Statements._label,
    tree.Jump: Statements._jump,
    tree.Empty: Statements._empty,
}
