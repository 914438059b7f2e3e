"""Assignments, branches and calls as instructions: what every statement of a body stands on."""

from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from typing import Final, TypeVar

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.any_types import DESCRIPTION
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.layout import kind_number, storage
from fieldrig_devices.iec.lower.addresses import Address
from fieldrig_devices.iec.lower.assembler import Label
from fieldrig_devices.iec.lower.body import Body
from fieldrig_devices.iec.lower.emitter import Emitter
from fieldrig_devices.iec.lower.hoisting import Hoisting, has_call
from fieldrig_devices.iec.lower.places import common
from fieldrig_devices.iec.lower.values import of_type
from fieldrig_devices.iec.program import (
    AddressOf,
    Assign,
    Assigned,
    Binary,
    Bit,
    CallAction,
    CallBlock,
    CallFunction,
    Cell,
    Component,
    Constant,
    Description,
    Enable,
    Enabled,
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
    """The assignments, branches and calls of one body: whatever may have calls in its expressions.

    It is the `Caller` of its hoisting: a call in an argument is made by the one who makes the outer call.
    """

    def __init__(self, body: Body) -> None:
        self._body = body
        self._assembler, self._places, self._expressions = body.assembler, body.places, body.expressions
        self._hoisting = Hoisting(self)

    def keep(self, value: Expression) -> Load:
        return self._body.keep(value)

    def keep_in(self, variable: Variable, value: Expression) -> Cell:
        cell = Cell(variable, variable.type)
        self._body.store(cell, value)
        return cell

    def out_of(self, expression: Expression) -> Expression:
        """Make the calls in an expression; return it with their results."""
        return self._hoisting.out_of(expression)

    # ---- branches

    def branch_unless(self, condition: Expression, target: Label, node: tree.Expression | None = None) -> None:
        """Jump if a condition does not hold; `node` is where the source has it, if it is there."""
        self._assembler.branch(*self._condition(condition, "not ", node), target)

    def branch_if(self, condition: Expression, target: Label) -> None:
        self._assembler.branch(*self._condition(condition, "", None), target)

    def _condition(self, condition: Expression, sign: str, node: tree.Expression | None) -> tuple[Emitter, str]:
        free = self._hoisting.out_of(condition)
        emitter = self._body.emitter()
        value = emitter.cut(self._body.value(free, emitter, node))
        return emitter, f"{sign}{value.text}"

    def choose(self, first: Load, is_and: bool, second: Callable[[], Expression]) -> None:
        end = self._assembler.label()
        (self.branch_unless if is_and else self.branch_if)(first, end)
        self._body.store(first.place, second())
        self._assembler.place(end)

    # ---- assignments

    def assigned(self, given: Assigned) -> Expression:
        value = self._hoisting.out_of(given.value)
        place = given.place
        if has_call(place) or isinstance(place, Parameter):
            value = self._body.keep(value)
            place = self._hoisting.out_of_place(place)
        self._body.store(place, value)
        return value if isinstance(place, Parameter) else Load(place)

    def assign(self, statement: Assign) -> None:
        place, value = statement.place, statement.value
        if has_call(value) or has_call(place):
            value = self._hoisting.out_of(value)
            if has_call(place):
                value = self._body.keep(value) if not isinstance(value, Constant) else value
                place = self._hoisting.out_of_place(place)
        origin = statement.origin
        self._body.store(place, value, origin.value if isinstance(origin, tree.Assign) else None)

    # ---- calls

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
        emitter = self._body.emitter()
        for (variable, _), value in zip(statement.inputs, values, strict=True):
            self._pass(_at(base, variable), variable.type, value, emitter)
        copies = [(_at(base, variable), self._refer(place, variable, emitter)) for variable, place in references]
        for cell, (text, _, _) in copies:
            emitter.add(f"M[{cell}] = {text}")
        self._body.do(emitter)
        self._call(statement.pou, base)
        given, eno = (_TRUE if own is None else Load(own)), statement.pou.eno
        if eno is not None and own is None and statement.enable.ok is not None:
            given = self._body.keep(Load(_callee_cell(eno, self._body.frame_size)))
        self._copy_back([copy for _, copy in copies])
        for target, value in statement.outputs:
            self.assign(Assign(target, value, line=statement.line))
        self._give_eno(statement.enable, given)

    def _while_enabled(
        self, enable: Enable, run: Callable[[Label], None], own: Place | None, *, may_fail: bool = False
    ) -> None:
        """Do what `run` does while EN is TRUE; otherwise, and where it jumps to its label, ENO is FALSE."""
        otherwise, end = self._assembler.labels(2)
        if enable.condition is None and not may_fail:
            run(otherwise)
            return
        if enable.condition is not None:
            self.branch_unless(enable.condition, otherwise)
        run(otherwise)
        if own is not None or enable.ok is not None:
            self._assembler.jump(end)
        self._assembler.place(otherwise)
        if own is not None:
            self._body.store(own, _FALSE)
        self._give_eno(enable, _FALSE)
        self._assembler.place(end)

    def _give_eno(self, enable: Enable, value: Expression) -> None:
        if enable.ok is not None:
            given = Unary(Operator.NOT, value, Elementary.BOOL) if enable.is_negated else value
            self.assign(Assign(enable.ok, given, line=self._assembler.line))

    def enabled(self, call: Enabled) -> Cell:
        """Compute a call with EN or ENO; return where its result is, which is kept."""
        function = call.value.pou if isinstance(call.value, CallFunction) else None
        kept = self._body.intermediate(call.type)
        if function is not None and function.result is not None:
            kept.initial = function.result.initial
        may_fail = _may_fail(call)
        if call.enable.condition is not None or may_fail:
            emitter = self._body.emitter()
            self._body.start(kept, emitter)
            self._body.do(emitter)
        self._while_enabled(
            call.enable, lambda otherwise: self._computed(call, kept, otherwise), None, may_fail=may_fail
        )
        return Cell(kept, kept.type)

    def _computed(self, call: Enabled, kept: Variable, otherwise: Label) -> None:
        value, eno = call.value, _TRUE
        if _may_fail(call):
            value = self._divided(value, otherwise)
        if isinstance(value, CallFunction) and value.pou.eno is not None:
            copy = Cell(self._body.intermediate(Elementary.BOOL), Elementary.BOOL)
            eno = Load(Cell(value.pou.eno, Elementary.BOOL))
            value, eno = replace(value, outputs=(*value.outputs, (value.pou.eno, copy, eno))), Load(copy)
        free = self._hoisting.out_of(value)
        if not isinstance(value, CallFunction) or value.pou.result is not None:
            self._body.store(Cell(kept, kept.type), free)
        self._give_eno(call.enable, eno)

    def _divided(self, value: Expression, otherwise: Label) -> Expression:
        """Return a division whose divisor is not 0; jump to the label if it is."""
        value = self._hoisting.out_of(value)
        assert isinstance(value, Binary)
        left, right = self._body.keep(value.left), self._body.keep(value.right)
        is_right = Binary(Operator.NE, right, Constant(_zero(right.type), right.type), Elementary.BOOL)
        self.branch_unless(is_right, otherwise)
        return replace(value, left=left, right=right)

    def call(self, call: CallFunction) -> Cell:
        """Call a function; return where its result is, in the frame that it had, until the next call."""
        pou, step = call.pou, self._body.frame_size
        base = self._base_of_method(call)
        arguments = [value if isinstance(value, Expression) else Load(value) for _, value in call.inputs]
        variables = [variable for variable, _ in call.inputs]
        for number, value in enumerate(arguments):
            if variables[number].is_reference and isinstance(value, Load):
                arguments[number] = Load(self._hoisting.out_of_place(value.place))
        by_value = [number for number, one in enumerate(variables) if not one.is_reference]
        calling = {number for number in by_value if has_call(arguments[number])}
        for number, value in zip(by_value, self._hoisting.all_out_of([arguments[n] for n in by_value]), strict=True):
            # The result of a call is where the arguments go, unless it is one cell and so is the result of this call.
            is_in_the_way = number in calling and (pou.result is None or storage(value.type) is None)
            is_in_the_way = is_in_the_way and not isinstance(value, Constant | AddressOf | Description)
            arguments[number] = self._body.keep(value) if is_in_the_way else value
        emitter = self._body.emitter()
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
        self._body.do(emitter)
        self._call(pou, base)
        self._copy_back(copies)
        is_called_again = any(has_call(value) for _, _, value in call.outputs)  # a function that checks a range
        cells = {one: self._returned(one, step, is_called_again) for one, _, _ in call.outputs}
        result = Cell(_NOTHING, Elementary.BOOL)
        if pou.result is not None:
            result = self._returned(pou.result, step, is_called_again)
        for variable, place, value in call.outputs:
            self.assign(Assign(place, _with_cell(value, variable, cells[variable]), line=self._assembler.line))
        return result

    def _returned(self, variable: Variable, step: int, is_kept: bool) -> Cell:
        """Return the cell of a variable of a function that has returned, or of a copy, which outlives further calls."""
        cell = _callee_cell(variable, step)
        if not is_kept:
            return cell
        copy = Cell(self._body.intermediate(variable.type), variable.type)
        self._body.store(copy, Load(cell))
        return copy

    def _base_of_method(self, call: CallFunction) -> Address:
        """Return the address of the instance that a method works with; 0 for a function."""
        if call.pou.owner is None:
            return Address((), 0)
        if call.instance is None:
            return self._own_base()
        return self._base_of(call.instance)

    def _call(self, pou: Pou, base: Address) -> None:
        self._assembler.call(self._body.context.routine(pou), str(base))

    def _own_base(self) -> Address:
        owner = self._body.pou.owner or self._body.pou
        return Address((), owner.instance.offset) if owner.instance is not None else Address(("base",), 0)

    def _base_of(self, instance: Place) -> Address:
        """Return the address of an instance, as an expression that stays the same during the call."""
        instance = self._hoisting.out_of_place(instance)
        emitter = self._body.emitter()
        where = self._places.instance(instance, emitter)
        if not emitter.lines and where.terms in ((), ("base",), ("frame",)):
            return where
        cell = self._places.cell(self._body.intermediate(Elementary.DWORD))
        emitter.add(f"M[{cell}] = {where}")
        self._body.do(emitter)
        return Address((f"M[{cell}]",), 0)

    def _pass(self, where: Address, kind: Type, value: Expression, emitter: Emitter) -> None:
        """Add the lines that copy an argument to the variable of the callee."""
        if isinstance(value, Description):
            self._describe(where, value, emitter)
        elif storage(kind) is None:
            assert isinstance(value, Load)
            cells = self._places.cells(value.place, emitter)
            self._places.store_cells_at(where, kind, cells, emitter)
        else:
            self._places.store_at(where, kind, self._expressions.raw(value, emitter), emitter)

    def _describe(self, where: Address, value: Description, emitter: Emitter) -> None:
        """Add the lines that write what an input of type ANY gets."""
        address = self._places.marked(value.place, emitter)
        parts = (str(value.type_class), address, str(value.place.type.size))
        for field, text in zip(DESCRIPTION.fields.values(), parts, strict=True):
            emitter.add(f"M[{where.plus(field.offset)}] = {text}")
        emitter.charge(emitter.costs.copy_ns * DESCRIPTION.size)

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
                return emitter.new(f"of_form({where}, {self._body.context.form(common(wanted))})"), place, None
            return emitter.new(str(where)) if len(where.terms) > 1 else str(where), place, None
        copy = self._body.intermediate(place.type)
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
                self._body.store(place, copy)

    # ---- parameters that are read slowly

    def read_slowly(self, place: Parameter) -> Cell:
        place = Parameter(
            self._hoisting.out_of(place.object), place.object_type, place.number, place.type, is_slow=True
        )
        kind = storage(place.type)
        assert kind is not None
        emitter = self._body.emitter()
        emitter.add(f"begin_read({self._places.parameter(place, emitter)})")
        emitter.charge(emitter.costs.parameter_ns)
        self._body.do(emitter)
        emitter = self._body.wait()
        cell = Cell(self._body.intermediate(place.type), place.type)
        self._places.store(cell, of_type(f"taken({kind_number(kind)})", kind), emitter)
        self._body.do(emitter)
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


Part = TypeVar("Part")


def _with_cell(part: Part, variable: Variable, cell: Cell) -> Part:
    """Return an expression with another cell for a variable."""
    if isinstance(part, Cell) and part.variable is variable:
        return cell  # type: ignore[return-value]
    if isinstance(part, tuple):
        return tuple(_with_cell(one, variable, cell) for one in part)  # type: ignore[return-value]
    if not is_dataclass(part) or isinstance(part, type | Variable | Pou | Type):
        return part
    return replace(part, **{one.name: _with_cell(getattr(part, one.name), variable, cell) for one in fields(part)})


def _at(base: Address, variable: Variable) -> Address:
    return base.plus(variable.offset)
