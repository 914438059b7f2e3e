"""The statements of one body as instructions."""

from collections.abc import Callable, Sequence
from typing import Final

from fieldrig_devices.iec.layout import CALL_SIZE, kind_number, storage
from fieldrig_devices.iec.lower.assembler import Assembler, Label
from fieldrig_devices.iec.lower.context import Context
from fieldrig_devices.iec.lower.emitter import Emitter
from fieldrig_devices.iec.lower.expressions import Expressions
from fieldrig_devices.iec.lower.hoisting import Hoisting, has_call
from fieldrig_devices.iec.lower.places import Address, Places
from fieldrig_devices.iec.lower.values import Value, constant, of_type
from fieldrig_devices.iec.program import (
    AnyStatement,
    Assign,
    Binary,
    Bit,
    CallAction,
    CallBlock,
    CallFunction,
    Case,
    Cell,
    Constant,
    Continue,
    Evaluate,
    Exit,
    Expression,
    For,
    If,
    Jump,
    Load,
    Loop,
    Operator,
    Parameter,
    Place,
    Pou,
    Return,
    Space,
    Unary,
    Variable,
)
from fieldrig_devices.iec.program import Label as LabelStatement
from fieldrig_devices.iec.tree import Section
from fieldrig_devices.iec.types import Elementary, Type

FEWEST_FOR_TABLE: Final = 7  # branches of a CASE; fewer are compared one after the other
LARGEST_TABLE: Final = 1_000  # numbers in the labels of a CASE


def frame_variables(pou: Pou) -> list[Variable]:
    """The variables on the stack that the caller does not set, with the result."""
    set_by_caller = (Section.INPUT, Section.IN_OUT)
    found = [
        variable for variable in pou.variables.values() if variable.space is Space.FRAME and variable.location is None
    ]
    own = [variable for variable in found if variable.section not in set_by_caller and variable is not pou.result]
    return own if pou.result is None else [pou.result, *own]


class Statements:
    """`intermediate` is the number of bytes in the frame for intermediate results; `used` is how many it takes."""

    def __init__(self, context: Context, pou: Pou, intermediate: int) -> None:
        self._context, self._pou = context, pou
        self.assembler = Assembler(context.costs)
        self._places = Places(pou, context.form)
        self._expressions = Expressions(self._places)
        self._hoisting = Hoisting(self)
        self._first = pou.frame_size
        self._taken = 0
        self.used = 0
        self.frame_size = pou.frame_size + intermediate + CALL_SIZE
        self._loops: list[tuple[Label, Label]] = []
        """Labels that CONTINUE and EXIT jump to."""
        self._labels: dict[str, Label] = {}

    @property
    def registers(self) -> frozenset[str]:
        return frozenset(self._places.registers)

    # ---- bodies

    def prologue(self) -> None:
        """Give the variables on the stack their start values, and check the references of an action."""
        pou, emitter = self._pou, self._emitter()
        for variable in frame_variables(pou):
            cells = self._context.images.variable(variable)
            where = self._places.cell(variable)
            emitter.charge(emitter.costs.copy * len(cells))
            kind = storage(variable.type)
            if kind is None:
                emitter.add(f"M[{where}:{where.plus(len(cells))}] = {self._context.image(cells)}")
            else:
                emitter.add(f"M[{where}] = {constant(cells[0], kind).text}")
        if pou.owner is not None:
            for variable in pou.owner.variables.values():
                if variable.is_reference and variable.space is Space.INSTANCE:
                    emitter.add(f"if not M[{self._places.cell(variable)}]:")
                    emitter.add("    null_reference()")
        self.assembler.do(emitter)

    def native(self, function: str, *, is_block: bool, is_slow: bool, cost_ns: int) -> None:
        """Add the body of a POU that the host implements."""
        emitter = self._emitter()
        emitter.add(f"{function}({'base' if is_block else 'frame'})")
        emitter.charge(cost_ns)
        self.assembler.do(emitter)
        if is_slow:
            emitter = self._wait()
            emitter.add("finish()")
            self.assembler.do(emitter)
        self.assembler.end()

    def body(self, statements: Sequence[AnyStatement]) -> None:
        for statement in statements:
            self.assembler.line = statement.line
            self._taken = 0
            _STATEMENTS[type(statement)](self, statement)

    def _emitter(self) -> Emitter:
        return self.assembler.emitter()

    # ---- assignments

    def _assign(self, statement: Assign) -> None:
        place, value = statement.place, statement.value
        if has_call(value) or has_call(place):
            value = self._hoisting.out_of(value)
            if has_call(place):
                value = self.keep(value) if not isinstance(value, Constant) else value
                place = self._hoisting.out_of_place(place)
        self._store(place, value)

    def _store(self, place: Place, value: Expression) -> None:
        emitter = self._emitter()
        if storage(place.type) is None:
            assert isinstance(value, Load)
            cells = self._places.cells(value.place, emitter)
            self._places.store_cells(place, cells, emitter)
        elif isinstance(place, Parameter) and place.is_slow:
            text = self._expressions.value(value, emitter).text
            emitter.add(f"begin_write({self._places.parameter(place, emitter)}, {text})")
            emitter.charge(emitter.costs.parameter)
            self.assembler.do(emitter)
            emitter = self._wait()
            emitter.add("finish()")
        else:
            raw = self._expressions.raw(value, emitter)
            self._places.store(place, raw, emitter)
        self.assembler.do(emitter)

    def _wait(self) -> Emitter:
        self.assembler.hold("is_waiting()")
        return self._emitter()

    def _condition(self, expression: Expression, emitter: Emitter) -> str:
        return self._expressions.value(expression, emitter).text

    def _branch_unless(self, condition: Expression, target: Label) -> None:
        free = self._hoisting.out_of(condition)
        emitter = self._emitter()
        self.assembler.branch(emitter, f"not {self._condition(free, emitter)}", target)

    def _branch_if(self, condition: Expression, target: Label) -> None:
        free = self._hoisting.out_of(condition)
        emitter = self._emitter()
        text = self._condition(free, emitter)
        self.assembler.branch(emitter, text, target)

    # ---- selection and loops

    def _if(self, statement: If) -> None:
        """Add an IF with all its ELSIF, of which each is the only statement behind the ELSE of the one before."""
        end = self.assembler.label()
        rest: Sequence[AnyStatement] = [statement]
        while len(rest) == 1 and isinstance(found := rest[0], If):
            otherwise = self.assembler.label()
            self.assembler.line, self._taken = found.line, 0
            self._branch_unless(found.condition, otherwise)
            self.body(found.then)
            if found.otherwise:
                self.assembler.jump(end)
            self.assembler.place(otherwise)
            rest = found.otherwise
        self.body(rest)
        self.assembler.place(end)

    def _case(self, statement: Case) -> None:
        selector = self._hoisting.out_of(statement.selector)
        if not isinstance(selector, Load | Constant) or not isinstance(getattr(selector, "place", None), Cell):
            selector = self.keep(selector)
        otherwise, end = self.assembler.label(), self.assembler.label()
        labels = [self.assembler.label() for _ in statement.branches]
        counted = sum(high - low + 1 for ranges, _ in statement.branches for low, high in ranges)
        if len(labels) >= FEWEST_FOR_TABLE and counted <= LARGEST_TABLE:
            self._by_table(selector, statement, labels, otherwise, end)
        else:
            self._by_comparisons(selector, statement)
            return
        self.assembler.place(otherwise)
        self.body(statement.otherwise)
        self.assembler.place(end)

    def _by_table(
        self, selector: Expression, statement: Case, labels: list[Label], otherwise: Label, end: Label
    ) -> None:
        targets: dict[int, Label] = {}
        for label, (ranges, _) in zip(labels, statement.branches, strict=True):
            for low, high in ranges:
                for number in range(low, high + 1):
                    targets.setdefault(number, label)
        emitter = self._emitter()
        text = self._expressions.value(selector, emitter).text
        self.assembler.switch(emitter, text, targets, otherwise)
        for label, (_, body) in zip(labels, statement.branches, strict=True):
            self.assembler.place(label)
            self.body(body)
            self.assembler.jump(end)

    def _by_comparisons(self, selector: Expression, statement: Case) -> None:
        """Add comparisons of the form of IF ... ELSIF, so that short branches stay in one block."""
        end, line = self.assembler.label(), self.assembler.line
        for ranges, body in statement.branches:
            after = self.assembler.label()
            self.assembler.line = line
            emitter = self._emitter()
            value = self._expressions.value(selector, emitter)
            emitter.charge(emitter.costs.operation * len(ranges))
            tests = [_within(value, low, high) for low, high in ranges]
            self.assembler.branch(emitter, f"not ({' or '.join(tests)})", after)
            self.body(body)
            self.assembler.jump(end)
            self.assembler.place(after)
        self.body(statement.otherwise)
        self.assembler.place(end)

    def _for(self, statement: For) -> None:
        kind = storage(statement.variable.type)
        assert isinstance(kind, Elementary)
        head, after, end = (self.assembler.label() for _ in range(3))
        line, variable = statement.line, Load(statement.variable)
        self._assign(Assign(statement.variable, statement.first, line=line))
        self.assembler.place(head)
        self._branch_unless(self._in_range(statement, variable), end)
        self._loops.append((after, end))
        self.body(statement.body)
        self._loops.pop()
        self.assembler.place(after)
        self.assembler.line, self._taken = line, 0
        step = Binary(Operator.ADD, variable, statement.step, kind)
        self._assign(Assign(statement.variable, step, line=line))
        self.assembler.jump(head)
        self.assembler.place(end)

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
        head, test, end = (self.assembler.label() for _ in range(3))
        self.assembler.place(head)
        if statement.condition is not None:
            self._branch_unless(statement.condition, end)
        self._loops.append((head if statement.until is None else test, end))
        self.body(statement.body)
        self._loops.pop()
        self.assembler.place(test)
        self._taken = 0
        if statement.until is not None:
            self._branch_unless(statement.until, head)
        else:
            self.assembler.jump(head)
        self.assembler.place(end)

    def _exit(self, statement: Exit) -> None:
        self.assembler.jump(self._loops[-1][1])

    def _continue(self, statement: Continue) -> None:
        self.assembler.jump(self._loops[-1][0])

    def _return(self, statement: Return) -> None:
        self.assembler.end()

    def _label_of(self, name: str) -> Label:
        return self._labels.setdefault(name.lower(), self.assembler.label())

    def _label(self, statement: LabelStatement) -> None:
        self.assembler.place(self._label_of(statement.name))

    def _jump(self, statement: Jump) -> None:
        if statement.condition is None:
            self.assembler.jump(self._label_of(statement.label))
        else:
            self._branch_if(statement.condition, self._label_of(statement.label))

    # ---- calls

    def _evaluate(self, statement: Evaluate) -> None:
        self.call(statement.value)

    def _call_action(self, statement: CallAction) -> None:
        base = self._own_base() if statement.instance is None else self._base_of(statement.instance)
        self._call(statement.pou, base)

    def _call_block(self, statement: CallBlock) -> None:
        instance = statement.instance
        if has_call(instance):
            instance = self._hoisting.out_of_place(instance)
        values = self._hoisting.all_out_of([value for _, value in statement.inputs])
        base = self._base_of(instance)
        emitter = self._emitter()
        for (variable, _), value in zip(statement.inputs, values, strict=True):
            self._pass(_at(base, variable), variable.type, value, emitter)
        copies = [
            (_at(base, variable), self._refer(place, variable, emitter)) for variable, place in statement.references
        ]
        for cell, (text, _, _) in copies:
            emitter.add(f"M[{cell}] = {text}")
        self.assembler.do(emitter)
        self._call(statement.pou, base)
        self._copy_back([copy for _, copy in copies])
        for target, value in statement.outputs:
            self._assign(Assign(target, value, line=statement.line))

    def call(self, call: CallFunction) -> Cell:
        """Call a function; return where its result is, in the frame that it had, until the next call."""
        pou, step = call.pou, self.frame_size
        base = self._base_of_method(call)
        arguments = [value if isinstance(value, Expression) else Load(value) for _, value in call.inputs]
        variables = [variable for variable, _ in call.inputs]
        by_value = [number for number, one in enumerate(variables) if not one.is_reference]
        for number, value in zip(by_value, self._hoisting.all_out_of([arguments[n] for n in by_value]), strict=True):
            arguments[number] = value
        emitter = self._emitter()
        copies = []
        for variable, value in zip(variables, arguments, strict=True):
            cell = Address(("frame",), step + variable.offset, is_frame=True)
            if variable.is_reference:
                place = value.place if isinstance(value, Load) else None
                if place is None:  # an address that the checker has made
                    emitter.add(f"M[{cell}] = {self._expressions.value(value, emitter).text}")
                    continue
                copies.append(self._refer(place, variable, emitter))
                emitter.add(f"M[{cell}] = {copies[-1][0]}")
            else:
                self._pass(cell, variable.type, value, emitter)
        self.assembler.do(emitter)
        self._call(pou, base)
        self._copy_back(copies)
        for variable, place in call.outputs:
            self._assign(Assign(place, Load(_callee_cell(variable, step)), line=self.assembler.line))
        return _callee_cell(pou.result, step) if pou.result is not None else Cell(_NOTHING, Elementary.BOOL)

    def _base_of_method(self, call: CallFunction) -> Address:
        """Return the address of the instance that a method works with; 0 for a function."""
        if call.pou.owner is None:
            return Address((), 0)
        if call.instance is None:
            return self._own_base()
        is_calling = has_call(call.instance)
        return self._base_of(self._hoisting.out_of_place(call.instance) if is_calling else call.instance)

    def _call(self, pou: Pou, base: Address) -> None:
        self.assembler.call(self._context.routine(pou), str(base))

    def _own_base(self) -> Address:
        owner = self._pou.owner or self._pou
        return Address((), owner.instance.offset) if owner.instance is not None else Address(("base",), 0)

    def _base_of(self, instance: Place) -> Address:
        """Return the address of an instance, as an expression that stays the same during the call."""
        emitter = self._emitter()
        where = self._places.instance(instance, emitter)
        if not emitter.lines and where.terms in ((), ("base",), ("frame",)):
            return where
        cell = self._places.cell(self._intermediate(Elementary.DWORD))
        emitter.add(f"M[{cell}] = {where}")
        self.assembler.do(emitter)
        return Address((f"M[{cell}]",), 0)

    def _pass(self, where: Address, kind: Type, value: Expression, emitter: Emitter) -> None:
        """Add the lines that copy an argument to the variable of the callee."""
        if storage(kind) is None:
            assert isinstance(value, Load)
            cells = self._places.cells(value.place, emitter)
            self._places.store_cells_at(where, kind, cells, emitter)
        else:
            self._places.store_at(where, kind, self._expressions.raw(value, emitter), emitter)

    def _refer(self, place: Place, variable: Variable, emitter: Emitter) -> "tuple[str, Place, Load | None]":
        """Return the address of an argument of a VAR_IN_OUT.

        What has no cell of its own, such as a marker, is copied to an intermediate cell and back after the call.
        """
        is_cell = not isinstance(place, Bit | Parameter)
        where = self._places.address(place, emitter) if is_cell else None
        if isinstance(where, Address):
            if where.is_raw:
                return emitter.new(f"of_form({where}, {self._context.form(variable.type)})"), place, None
            return emitter.new(str(where)) if len(where.terms) > 1 else str(where), place, None
        copy = self._intermediate(place.type)
        cell = self._places.cell(copy)
        if storage(place.type) is None:
            self._places.store_cells_at(cell, place.type, self._places.cells(place, emitter), emitter)
        else:
            self._places.store_at(cell, place.type, self._places.load(place, emitter), emitter)
        return str(cell), place, Load(Cell(copy, place.type))

    def _copy_back(self, copies: "list[tuple[str, Place, Load | None]]") -> None:
        for _, place, copy in copies:
            if copy is not None:
                self._store(place, copy)

    # ---- intermediate results (`hoisting.Caller`)

    def _intermediate(self, kind: Type) -> Variable:
        variable = Variable("", kind, Space.FRAME, Section.TEMP, offset=self._first + self._taken)
        self._taken += kind.size
        self.used = max(self.used, self._taken)
        return variable

    def keep(self, value: Expression) -> Load:
        cell = Cell(self._intermediate(value.type), value.type)
        self._store(cell, value)
        return Load(cell)

    def choose(self, first: Load, is_and: bool, second: Callable[[], Expression]) -> None:
        end = self.assembler.label()
        (self._branch_unless if is_and else self._branch_if)(first, end)
        self._store(first.place, second())
        self.assembler.place(end)

    def read_slowly(self, place: Parameter) -> Cell:
        place = Parameter(
            self._hoisting.out_of(place.object), place.object_type, place.number, place.type, is_slow=True
        )
        kind = storage(place.type)
        assert kind is not None
        emitter = self._emitter()
        emitter.add(f"begin_read({self._places.parameter(place, emitter)})")
        emitter.charge(emitter.costs.parameter)
        self.assembler.do(emitter)
        emitter = self._wait()
        cell = Cell(self._intermediate(place.type), place.type)
        self._places.store(cell, of_type(f"taken({kind_number(kind)})", kind), emitter)
        self.assembler.do(emitter)
        return cell


_NOTHING: Final = Variable("", Elementary.BOOL, Space.FRAME, Section.TEMP, offset=0)


def _callee_cell(variable: Variable, step: int) -> Cell:
    """The variable of a function that has returned, in the frame behind the caller's."""
    moved = Variable(variable.name, variable.type, Space.FRAME, Section.TEMP, offset=step + variable.offset)
    return Cell(moved, variable.type)


def _at(base: Address, variable: Variable) -> Address:
    return base.plus(variable.offset)


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
}
