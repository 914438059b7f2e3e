"""Assignments and calls as instructions: what every statement of a body stands on."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.layout import CALL_SIZE, kind_number, storage
from fieldrig_devices.iec.lower.assembler import Assembler, Label
from fieldrig_devices.iec.lower.context import Context
from fieldrig_devices.iec.lower.emitter import Emitter
from fieldrig_devices.iec.lower.expressions import Expressions
from fieldrig_devices.iec.lower.hoisting import Hoisting, has_call
from fieldrig_devices.iec.lower.places import Address, Places, common
from fieldrig_devices.iec.lower.values import constant, of_type
from fieldrig_devices.iec.program import (
    Assign,
    Binary,
    Bit,
    CallAction,
    CallBlock,
    CallFunction,
    Cell,
    Component,
    Constant,
    Convert,
    Enable,
    Enabled,
    Evaluate,
    Expression,
    Load,
    Operator,
    Parameter,
    Place,
    Pou,
    Space,
    Unary,
    Variable,
)
from fieldrig_devices.iec.tree import Section
from fieldrig_devices.iec.types import OpenArrayType, Type


class Calls:
    """The assignments and calls of one body.

    `intermediate` is the number of bytes in the frame for intermediate results; `used` is how many it takes.
    """

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

    @property
    def keeps_stack_addresses(self) -> bool:
        return self._places.keeps_stack_addresses

    def branch_unless(self, condition: Expression, target: Label) -> None:
        raise NotImplementedError

    def choose(self, first: Load, is_and: bool, second: Callable[[], Expression]) -> None:
        """Evaluate `second` into the cell of `first` unless its value decides."""
        raise NotImplementedError

    def emitter(self) -> Emitter:
        return self.assembler.emitter()

    # ---- assignments

    def assign(self, statement: Assign) -> None:
        place, value = statement.place, statement.value
        if has_call(value) or has_call(place):
            value = self._hoisting.out_of(value)
            if has_call(place):
                value = self.keep(value) if not isinstance(value, Constant) else value
                place = self._hoisting.out_of_place(place)
        self.store(place, value)

    def store(self, place: Place, value: Expression) -> None:
        emitter = self.emitter()
        if storage(place.type) is None:
            assert isinstance(value, Load)
            cells = self._places.cells(value.place, emitter)
            self._places.store_cells(place, cells, emitter)
        elif isinstance(place, Parameter) and place.is_slow:
            text = self._expressions.value(value, emitter).text
            emitter.add(f"begin_write({self._places.parameter(place, emitter)}, {text})")
            emitter.charge(emitter.costs.parameter_ns)
            self.assembler.do(emitter)
            emitter = self.wait()
            emitter.add("finish()")
        else:
            raw = self._expressions.raw(value, emitter)
            self._places.store(place, raw, emitter)
        self.assembler.do(emitter)

    def wait(self) -> Emitter:
        self.assembler.hold("is_waiting()")
        return self.emitter()

    # ---- calls

    def evaluate(self, statement: Evaluate) -> None:
        self._hoisting.out_of(statement.value)

    def call_action(self, statement: CallAction) -> None:
        base = self._own_base() if statement.instance is None else self._base_of(statement.instance)
        self._call(statement.pou, base)

    def call_block(self, statement: CallBlock) -> None:
        instance = statement.instance
        if has_call(instance):
            instance = self._hoisting.out_of_place(instance)
        eno, own = statement.pou.eno, None
        if eno is not None and eno.space is Space.INSTANCE:  # a dispatcher has it on the stack
            own = Component(instance, 0, Elementary.BOOL, eno)
        self._while_enabled(statement.enable, lambda otherwise: self._call_block(statement, instance, own), own)

    def _call_block(self, statement: CallBlock, instance: Place, own: Place | None) -> None:
        """Call an instance; `own` is the ENO that its body sets."""
        references = [(variable, self._hoisting.out_of_place(place)) for variable, place in statement.references]
        values = self._hoisting.all_out_of([value for _, value in statement.inputs])
        base = self._base_of(instance)
        emitter = self.emitter()
        for (variable, _), value in zip(statement.inputs, values, strict=True):
            self._pass(_at(base, variable), variable.type, value, emitter)
        copies = [(_at(base, variable), self._refer(place, variable, emitter)) for variable, place in references]
        for cell, (text, _, _) in copies:
            emitter.add(f"M[{cell}] = {text}")
        self.assembler.do(emitter)
        self._call(statement.pou, base)
        given, eno = (_TRUE if own is None else Load(own)), statement.pou.eno
        if eno is not None and own is None and statement.enable.ok is not None:
            given = self.keep(Load(_callee_cell(eno, self.frame_size)))
        self._copy_back([copy for _, copy in copies])
        for target, value in statement.outputs:
            self.assign(Assign(target, value, line=statement.line))
        self._give_eno(statement.enable, given)

    def _while_enabled(
        self, enable: Enable, run: Callable[[Label], None], own: Place | None, *, may_fail: bool = False
    ) -> None:
        """Do what `run` does while EN is TRUE; otherwise, and where it jumps to its label, ENO is FALSE."""
        otherwise, end = self.assembler.label(), self.assembler.label()
        if enable.condition is None and not may_fail:
            run(otherwise)
            return
        if enable.condition is not None:
            self.branch_unless(enable.condition, otherwise)
        run(otherwise)
        if own is not None or enable.ok is not None:
            self.assembler.jump(end)
        self.assembler.place(otherwise)
        if own is not None:
            self.store(own, _FALSE)
        self._give_eno(enable, _FALSE)
        self.assembler.place(end)

    def _give_eno(self, enable: Enable, value: Expression) -> None:
        if enable.ok is not None:
            given = Unary(Operator.NOT, value, Elementary.BOOL) if enable.is_negated else value
            self.assign(Assign(enable.ok, given, line=self.assembler.line))

    def enabled(self, call: Enabled) -> Cell:
        """Compute a call with EN or ENO; return where its result is, which is kept."""
        function = call.value.pou if isinstance(call.value, CallFunction) else None
        kept = self._intermediate(call.type)
        if function is not None and function.result is not None:
            kept.initial = function.result.initial
        may_fail = _may_fail(call)
        if call.enable.condition is not None or may_fail:
            emitter = self.emitter()
            self.start(kept, emitter)
            self.assembler.do(emitter)
        self._while_enabled(
            call.enable, lambda otherwise: self._computed(call, kept, otherwise), None, may_fail=may_fail
        )
        return Cell(kept, kept.type)

    def _computed(self, call: Enabled, kept: Variable, otherwise: Label) -> None:
        value, eno = call.value, _TRUE
        if _may_fail(call):
            value = self._divided(value, otherwise)
        if isinstance(value, CallFunction) and value.pou.eno is not None:
            copy = Cell(self._intermediate(Elementary.BOOL), Elementary.BOOL)
            value, eno = replace(value, outputs=(*value.outputs, (value.pou.eno, copy, False))), Load(copy)
        free = self._hoisting.out_of(value)
        if not isinstance(value, CallFunction) or value.pou.result is not None:
            self.store(Cell(kept, kept.type), free)
        self._give_eno(call.enable, eno)

    def _divided(self, value: Expression, otherwise: Label) -> Expression:
        """Return a division whose divisor is not 0; jump to the label if it is."""
        value = self._hoisting.out_of(value)
        assert isinstance(value, Binary)
        left, right = self.keep(value.left), self.keep(value.right)
        is_right = Binary(Operator.NE, right, Constant(_zero(right.type), right.type), Elementary.BOOL)
        self.branch_unless(is_right, otherwise)
        return replace(value, left=left, right=right)

    def start(self, variable: Variable, emitter: Emitter) -> None:
        """Add the lines that give a variable on the stack its start value."""
        cells = self._context.images.variable(variable)
        where = self._places.cell(variable)
        emitter.charge(emitter.costs.copy_ns * len(cells))
        kind = storage(variable.type)
        if kind is None:
            emitter.add(f"M[{where}:{where.plus(len(cells))}] = {self._context.image(cells)}")
        else:
            emitter.add(f"M[{where}] = {constant(cells[0], kind).text}")

    def call(self, call: CallFunction) -> Cell:
        """Call a function; return where its result is, in the frame that it had, until the next call."""
        pou, step = call.pou, self.frame_size
        base = self._base_of_method(call)
        arguments = [value if isinstance(value, Expression) else Load(value) for _, value in call.inputs]
        variables = [variable for variable, _ in call.inputs]
        for number, value in enumerate(arguments):
            if variables[number].is_reference and isinstance(value, Load):
                arguments[number] = Load(self._hoisting.out_of_place(value.place))
        by_value = [number for number, one in enumerate(variables) if not one.is_reference]
        for number, value in zip(by_value, self._hoisting.all_out_of([arguments[n] for n in by_value]), strict=True):
            arguments[number] = value
        emitter = self.emitter()
        copies = []
        for variable, value in zip(variables, arguments, strict=True):
            cell = Address(("frame",), step + variable.offset, is_frame=True)
            if variable.is_reference:
                place = value.place if isinstance(value, Load) else None
                if place is None:  # an address that the checker has made
                    emitter.add(f"M[{cell}] = {self._expressions.value(value, emitter).text}")
                    continue
                referred = self._refer(place, variable, emitter)
                emitter.add(f"M[{cell}] = {referred[0]}")
                if variable.section is not Section.INPUT:
                    copies.append(referred)
            else:
                self._pass(cell, variable.type, value, emitter)
        self.assembler.do(emitter)
        self._call(pou, base)
        self._copy_back(copies)
        for variable, place, is_negated in call.outputs:
            value = Load(_callee_cell(variable, step))
            given: Expression = Unary(Operator.NOT, value, value.type) if is_negated else value
            if isinstance(place.type, Elementary) and place.type is not variable.type:
                given = Convert(given, place.type)
            self.assign(Assign(place, given, line=self.assembler.line))
        return _callee_cell(pou.result, step) if pou.result is not None else Cell(_NOTHING, Elementary.BOOL)

    def _base_of_method(self, call: CallFunction) -> Address:
        """Return the address of the instance that a method works with; 0 for a function."""
        if call.pou.owner is None:
            return Address((), 0)
        if call.instance is None:
            return self._own_base()
        return self._base_of(call.instance)

    def _call(self, pou: Pou, base: Address) -> None:
        self.assembler.call(self._context.routine(pou), str(base))

    def _own_base(self) -> Address:
        owner = self._pou.owner or self._pou
        return Address((), owner.instance.offset) if owner.instance is not None else Address(("base",), 0)

    def _base_of(self, instance: Place) -> Address:
        """Return the address of an instance, as an expression that stays the same during the call."""
        instance = self._hoisting.out_of_place(instance)
        emitter = self.emitter()
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
            if variable.space is Space.INSTANCE:
                self._places.keep(where)
            if where.is_raw:
                wanted = place.type if isinstance(variable.type, OpenArrayType) else variable.type
                return emitter.new(f"of_form({where}, {self._context.form(common(wanted))})"), place, None
            return emitter.new(str(where)) if len(where.terms) > 1 else str(where), place, None
        copy = self._intermediate(place.type)
        cell = self._places.cell(copy)
        if variable.space is Space.INSTANCE:
            self._places.keep(cell)
        if storage(place.type) is None:
            self._places.store_cells_at(cell, place.type, self._places.cells(place, emitter), emitter)
        else:
            self._places.store_at(cell, place.type, self._places.load(place, emitter), emitter)
        return str(cell), place, Load(Cell(copy, place.type))

    def _copy_back(self, copies: "list[tuple[str, Place, Load | None]]") -> None:
        for _, place, copy in copies:
            if copy is not None:
                self.store(place, copy)

    # ---- intermediate results (`hoisting.Caller`)

    def _intermediate(self, kind: Type) -> Variable:
        variable = Variable("", kind, Space.FRAME, Section.TEMP, offset=self._first + self._taken)
        self._taken += kind.size
        self.used = max(self.used, self._taken)
        return variable

    def keep(self, value: Expression) -> Load:
        cell = Cell(self._intermediate(value.type), value.type)
        self.store(cell, value)
        return Load(cell)

    def read_slowly(self, place: Parameter) -> Cell:
        place = Parameter(
            self._hoisting.out_of(place.object), place.object_type, place.number, place.type, is_slow=True
        )
        kind = storage(place.type)
        assert kind is not None
        emitter = self.emitter()
        emitter.add(f"begin_read({self._places.parameter(place, emitter)})")
        emitter.charge(emitter.costs.parameter_ns)
        self.assembler.do(emitter)
        emitter = self.wait()
        cell = Cell(self._intermediate(place.type), place.type)
        self._places.store(cell, of_type(f"taken({kind_number(kind)})", kind), emitter)
        self.assembler.do(emitter)
        return cell


def _may_fail(call: Enabled) -> bool:
    """True for DIV and MOD whose ENO is used, and which may divide by 0; no other standard function fails."""
    value = call.value
    if call.enable.ok is None or not isinstance(value, Binary) or value.operator not in (Operator.DIV, Operator.MOD):
        return False
    return not isinstance(value.right, Constant) or value.right.value == 0


def _zero(kind: Type) -> int | float:
    return 0.0 if isinstance(kind, Elementary) and kind.is_real else 0


_TRUE: Final[Expression] = Constant(True, Elementary.BOOL)
_FALSE: Final[Expression] = Constant(False, Elementary.BOOL)
_NOTHING: Final = Variable("", Elementary.BOOL, Space.FRAME, Section.TEMP, offset=0)


def _callee_cell(variable: Variable, step: int) -> Cell:
    """The variable of a function that has returned, in the frame behind the caller's."""
    moved = Variable(variable.name, variable.type, Space.FRAME, Section.TEMP, offset=step + variable.offset)
    return Cell(moved, variable.type)


def _at(base: Address, variable: Variable) -> Address:
    return base.plus(variable.offset)
