"""The statements of one body as instructions."""

from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.layout import storage
from fieldrig_devices.iec.lower.assembler import Label
from fieldrig_devices.iec.lower.body import Body
from fieldrig_devices.iec.lower.calls import Calls
from fieldrig_devices.iec.lower.exits import Exits
from fieldrig_devices.iec.lower.marks import BODY, SKIPPED, Arm
from fieldrig_devices.iec.lower.values import Value
from fieldrig_devices.iec.program import (
    AddressOf,
    AnyStatement,
    Assign,
    Binary,
    CallAction,
    CallBlock,
    Case,
    Cell,
    Constant,
    Continue,
    Convert,
    Evaluate,
    Exit,
    Expression,
    For,
    Free,
    If,
    Jump,
    Load,
    Loop,
    Operator,
    Pou,
    Return,
    Space,
    Try,
    Unary,
    Variable,
)
from fieldrig_devices.iec.program import Label as LabelStatement
from fieldrig_devices.iec.tree import Section
from fieldrig_devices.iec.types import ArrayType, BlockType, StructType, Type

FEWEST_FOR_TABLE: Final = 7  # branches of a CASE; fewer are compared one after the other
LARGEST_TABLE: Final = 1_000  # numbers in the labels of a CASE


def frame_variables(pou: Pou) -> list[Variable]:
    """The variables on the stack that the caller does not set, with the result."""
    set_by_caller = (Section.INPUT, Section.IN_OUT)
    variables = [
        variable for variable in pou.variables.values() if variable.space is Space.FRAME and variable.location is None
    ]
    variables = [
        variable for variable in variables if variable.section not in set_by_caller and not variable.is_reference
    ]
    own = [variable for variable in variables if variable is not pou.result]
    return own if pou.result is None else [pou.result, *own]


def has_block(kind: Type) -> bool:
    """True for an instance of a function block, and for what contains one."""
    while isinstance(kind, ArrayType):
        kind = kind.element
    if isinstance(kind, StructType):
        return any(has_block(field.type) for field in kind.fields.values())
    return isinstance(kind, BlockType)


def followed(body: Sequence[AnyStatement]) -> set[int]:
    """Return the VAR_IN_OUT and ARRAY[*], by `id`, that a body uses without asking __ISVALIDREF about them."""
    found, asked = set[int](), set[int]()
    waiting: list[object] = [*body]
    while waiting:
        part = waiting.pop()
        if isinstance(part, Cell):
            if part.variable.is_reference:
                found.add(id(part.variable))
        elif isinstance(part, Binary) and (variable := _asked(part)) is not None:
            asked.add(id(variable))
        elif isinstance(part, tuple | list):
            waiting.extend(part)
        elif is_dataclass(part) and not isinstance(part, type | Variable | Pou | Type):
            waiting.extend(getattr(part, one.name) for one in fields(part))
    return found - asked


def _asked(part: Binary) -> Variable | None:
    """Return x of __ISVALIDREF(x), which is a comparison of its address with 0; None for other operations."""
    left = part.left
    if part.operator is Operator.NE and isinstance(left, Convert) and isinstance(left.operand, AddressOf):
        place = left.operand.place
        return place.variable if isinstance(place, Cell) else None
    return None


class Statements:
    """The statements of one body."""

    def __init__(self, body: Body) -> None:
        self._body, self._calls, self._assembler = body, Calls(body), body.assembler
        self._exits = Exits(body)
        self._labels: dict[str, Label] = {}

    # ---- bodies

    def prologue(self) -> None:
        """Give the variables on the stack their start values, and check the references of an action."""
        pou, emitter = self._body.pou, self._body.emitter()
        for variable in frame_variables(pou):
            self._body.start(variable, emitter)
        for variable in pou.variables.values():
            if variable.space is Space.FRAME and not variable.is_reference and has_block(variable.type):
                self._body.places.mark(variable, emitter)  # its code may hand out pointers to itself
        if pou.owner is not None:
            references = [
                one for one in pou.owner.variables.values() if one.is_reference and one.space is Space.INSTANCE
            ]
            used = followed(pou.body) if references else frozenset()
            for variable in references:
                if id(variable) in used:
                    emitter.add(f"if not M[{self._body.places.cell(variable)}]:")
                    emitter.add("    null_reference()")
        self._body.do(emitter)
        self._body.note_states()

    def native(self, function: str, *, is_block: bool, is_slow: bool, cost_ns: int) -> None:
        """Add the body of a POU that the host implements."""
        emitter = self._body.emitter()
        emitter.add(f"{function}({'base' if is_block else 'frame'})")
        emitter.charge(cost_ns)
        self._body.do(emitter)
        if is_slow:
            emitter = self._body.wait()
            emitter.add("finish()")
            self._body.do(emitter)
        self._assembler.end()

    def add(self, statements: Sequence[AnyStatement], of: AnyStatement | None = None, arm: Arm | None = None) -> None:
        """Add statements; those of an arm of a choice or loop say so."""
        marks = self._body.marks
        with marks.suite():
            if of is not None and arm is not None:
                marks.branch(of, arm)
            for statement in statements:
                self._body.begin(statement.line)
                marks.statement(statement)
                _STATEMENTS[type(statement)](self, statement)
                marks.after(statement)

    def _assign(self, statement: Assign) -> None:
        self._calls.assign(statement)

    def _evaluate(self, statement: Evaluate) -> None:
        self._calls.out_of(statement.value)

    def _call_block(self, statement: CallBlock) -> None:
        self._calls.call_block(statement)

    def _call_action(self, statement: CallAction) -> None:
        self._calls.call_action(statement)

    # ---- selection and loops

    def _if(self, statement: If) -> None:
        """Add an IF with all its ELSIF, of which each is the only statement behind the ELSE of the one before."""
        end, marks = self._assembler.label(), self._body.marks
        rest: Sequence[AnyStatement] = [statement]
        arms = marks.arms_of_if(statement)
        while len(rest) == 1 and isinstance(part := rest[0], If) and (part is statement or not marks.is_counted(part)):
            otherwise = self._assembler.label()
            self._body.begin(part.line)
            arm = next(arms, None)
            self._calls.branch_unless(part.condition, otherwise, arm.condition if arm is not None else None)
            self.add(part.then, statement, arm)
            if part.otherwise or marks.has_arms(statement):
                self._assembler.jump(end, is_free=not part.otherwise)
            self._assembler.place(otherwise)
            rest = part.otherwise
        self.add(rest, statement, marks.last_arm(statement))
        self._assembler.place(end)

    def _case(self, statement: Case) -> None:
        selector = self._calls.out_of(statement.selector)
        if not isinstance(selector, Load | Constant) or not isinstance(getattr(selector, "place", None), Cell):
            selector = self._body.keep(selector)
        otherwise, end = self._assembler.labels(2)
        labels = self._assembler.labels(len(statement.branches))
        counted = sum(high - low + 1 for ranges, _ in statement.branches for low, high in ranges)
        if len(labels) >= FEWEST_FOR_TABLE and counted <= LARGEST_TABLE:
            self._by_table(selector, statement, labels, otherwise, end)
        else:
            self._by_comparisons(selector, statement)
            return
        self._assembler.place(otherwise)
        self.add(statement.otherwise, statement, self._body.marks.last_arm(statement))
        self._assembler.place(end)

    def _by_table(
        self, selector: Expression, statement: Case, labels: list[Label], otherwise: Label, end: Label
    ) -> None:
        targets: dict[int, Label] = {}
        for label, (ranges, _) in zip(labels, statement.branches, strict=True):
            for low, high in ranges:
                for number in range(low, high + 1):
                    targets.setdefault(number, label)
        emitter = self._body.emitter()
        text = self._body.expressions.value(selector, emitter).text
        self._assembler.switch(emitter, text, targets, otherwise)
        arms = self._body.marks.arms_of_case(statement)
        for label, (_, body) in zip(labels, statement.branches, strict=True):
            self._assembler.place(label)
            self.add(body, statement, next(arms, None))
            self._assembler.jump(end)

    def _by_comparisons(self, selector: Expression, statement: Case) -> None:
        """Add comparisons of the form of IF ... ELSIF, so that short branches stay in one block."""
        end, line = self._assembler.label(), self._assembler.line
        arms = self._body.marks.arms_of_case(statement)
        for ranges, body in statement.branches:
            after = self._assembler.label()
            self._assembler.line = line
            emitter = self._body.emitter()
            value = self._body.expressions.value(selector, emitter)
            emitter.charge(emitter.costs.operation_ns * len(ranges))
            tests = [_within(value, low, high) for low, high in ranges]
            self._assembler.branch(emitter, f"not ({' or '.join(tests)})", after)
            self.add(body, statement, next(arms, None))
            self._assembler.jump(end)
            self._assembler.place(after)
        self.add(statement.otherwise, statement, self._body.marks.last_arm(statement))
        self._assembler.place(end)

    def _for(self, statement: For) -> None:
        head, after, end = self._assembler.labels(3)
        line, variable = statement.line, Load(statement.variable)
        self._calls.assign(Assign(statement.variable, statement.first, line=line))
        if self._body.marks.has_arms(statement):
            self._marked_loop(statement, self._in_range(statement, variable), lambda: self._step(statement))
            return
        self._assembler.place(head)
        self._calls.branch_unless(self._in_range(statement, variable), end)
        self._exits.loops.append((after, end))  # CONTINUE still steps, else it would never end
        self.add(statement.body)
        self._exits.loops.pop()
        self._assembler.place(after)
        self._step(statement)
        self._assembler.jump(head)
        self._assembler.place(end)

    def _step(self, statement: For) -> None:
        kind = storage(statement.variable.type)
        assert isinstance(kind, Elementary)
        self._body.begin(statement.line)
        step = Binary(Operator.ADD, Load(statement.variable), statement.step, kind)
        self._calls.assign(Assign(statement.variable, step, line=statement.line))

    def _marked_loop(self, statement: For | Loop, condition: Expression, step: Callable[[], None] | None) -> None:
        """Add a loop with its test in two places, so that it can be seen whether the body has been skipped.

        It takes the time that the loop takes without marks.
        """
        body, after, again, skipped, end = self._assembler.labels(5)
        node = statement.origin.condition if isinstance(statement.origin, tree.While) else None
        self._calls.branch_unless(condition, skipped, node)
        self._assembler.place(body)
        self._exits.loops.append((after if step is not None else again, end))
        self.add(statement.body, statement, BODY)
        self._exits.loops.pop()
        self._assembler.place(after)
        if step is not None:
            step()
        self._assembler.jump(again)
        self._assembler.place(again)
        self._body.begin(statement.line)
        cost = self._assembler.cost
        self._calls.branch_unless(condition, end, node)
        self._assembler.cost = cost  # the size of the program is that without marks
        self._assembler.jump(body, is_free=True)
        self._assembler.place(skipped)
        self.add((), statement, SKIPPED)
        self._assembler.place(end)

    @staticmethod
    def _in_range(statement: For, variable: Load) -> Expression:
        boolean, last, step = Elementary.BOOL, statement.last, statement.step
        upward = Binary(Operator.LE, variable, last, boolean)
        downward = Binary(Operator.GE, variable, last, boolean)
        if isinstance(step, Constant):
            return upward if int(step.value) >= 0 else downward
        is_up = Binary(Operator.GE, step, Constant(0, step.type), boolean)
        both = Binary(Operator.AND, is_up, upward, boolean)
        other = Binary(Operator.AND, Unary(Operator.NOT, is_up, boolean), downward, boolean)
        return Binary(Operator.OR, both, other, boolean)

    def _loop(self, statement: Loop) -> None:
        if statement.condition is not None and self._body.marks.has_arms(statement):
            self._marked_loop(statement, statement.condition, None)
            return
        head, test, end = self._assembler.labels(3)
        self._assembler.place(head)
        if statement.condition is not None:
            self._calls.branch_unless(statement.condition, end)
        # CONTINUE goes to the condition: that of WHILE is at the head, that of REPEAT behind the body.
        self._exits.loops.append((head if statement.until is None else test, end))
        self.add(statement.body)
        self._exits.loops.pop()
        self._assembler.place(test)
        self._body.begin(self._assembler.line)
        if statement.until is not None:
            node = statement.origin.until if isinstance(statement.origin, tree.Repeat) else None
            self._calls.branch_unless(statement.until, head, node)
        else:
            self._assembler.jump(head)
        self._assembler.place(end)

    def _exit(self, statement: Exit) -> None:
        self._exits.out_of_loop()

    def _continue(self, statement: Continue) -> None:
        self._exits.next_pass()

    def _return(self, statement: Return) -> None:
        self._exits.out_of_body()

    def _try(self, statement: Try) -> None:
        kind = Elementary.UDINT if statement.code is None else statement.code.type
        fault = Cell(self._body.held(kind), kind)
        with self._body.marks.one_by_one():
            self._exits.guarded(
                lambda: self.add(statement.body),
                None if statement.caught is None else lambda: self._caught(statement, fault),
                None if statement.final is None else lambda: self.add(statement.final or ()),
                fault,
            )

    def _caught(self, statement: Try, fault: Cell) -> None:
        if statement.code is not None:
            self._calls.assign(Assign(statement.code, Load(fault), line=statement.line))
        self.add(statement.caught or ())

    def _free(self, statement: Free) -> None:
        address = self._calls.out_of(statement.address)
        emitter = self._body.emitter()
        emitter.add(f"free({self._body.expressions.value(address, emitter).text})")
        self._body.do(emitter)

    def _label_of(self, name: str) -> Label:
        return self._labels.setdefault(name.lower(), self._assembler.label())

    def _label(self, statement: LabelStatement) -> None:
        self._assembler.place(self._label_of(statement.name))

    def _jump(self, statement: Jump) -> None:
        if statement.condition is None:
            self._assembler.jump(self._label_of(statement.label))
        else:
            self._calls.branch_if(statement.condition, self._label_of(statement.label))


def _within(value: Value, low: int, high: int) -> str:
    return f"{value.text} == {low}" if low == high else f"{low} <= {value.text} <= {high}"


_STATEMENTS: Final[dict[type, Callable[..., None]]] = {
    Assign: Statements._assign,
    Evaluate: Statements._evaluate,
    CallBlock: Statements._call_block,
    CallAction: Statements._call_action,
    If: Statements._if,
    Case: Statements._case,
    For: Statements._for,
    Loop: Statements._loop,
    Exit: Statements._exit,
    Continue: Statements._continue,
    Return: Statements._return,
    LabelStatement: Statements._label,
    Jump: Statements._jump,
    Free: Statements._free,
    Try: Statements._try,
}
