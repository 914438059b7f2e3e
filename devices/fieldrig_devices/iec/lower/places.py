"""The addresses of places, and reading and writing what is there.

What an address that came from a pointer leads to is compared with the type that is wanted, and read or written byte by
byte if it is something else.
"""

from collections.abc import Callable
from typing import Protocol

from fieldrig_devices.iec.elementary import Elementary, Family
from fieldrig_devices.iec.layout import AREAS, kind_number, storage
from fieldrig_devices.iec.lower import areas
from fieldrig_devices.iec.lower.addresses import Address, AreaAddress, located
from fieldrig_devices.iec.lower.emitter import INDENT, Emitter
from fieldrig_devices.iec.lower.texts import shortened
from fieldrig_devices.iec.lower.values import Value, of_type
from fieldrig_devices.iec.program import (
    Bit,
    Cell,
    Component,
    Element,
    Expression,
    Located,
    OpenElement,
    Parameter,
    Place,
    Pou,
    Space,
    Swapped,
    Target,
    This,
    Variable,
)
from fieldrig_devices.iec.tree import PouKind
from fieldrig_devices.iec.types import BlockType, OpenArrayType, StringType, Type
from fieldrig_devices.languages.registers import is_register


class Values(Protocol):
    """The other half, `Expressions`: values are in places, and an index or a pointer in a place is a value."""

    def value(self, expression: Expression, emitter: Emitter) -> Value:
        """Add the lines that compute an expression, and return its value in the range of its type."""

    def raw(self, expression: Expression, emitter: Emitter) -> Value:
        """Return the value, which may have to be cut to its type."""


class Places:
    """The places as one POU sees them."""

    values: Values

    def __init__(self, pou: Pou, form_of: Callable[[Type], int]) -> None:
        """`form_of` numbers types that a pointer may point to, for checks at run time."""
        owner = pou.owner or pou
        self._base = owner.instance.offset if owner.instance is not None else None
        self._form_of = form_of
        self._is_program = self._base is not None
        self.keeps_stack_addresses = False
        """True if a pointer or a VAR_IN_OUT may outlive the call whose variable it refers to."""
        self.registers: set[str] = set()
        """The cells that only one text reaches in this POU, for `languages.registers`."""

    def form(self, kind: Type) -> int:
        """Return the number of a type, for functions of the memory."""
        return self._form_of(kind)

    # ---- addresses

    def address(self, place: Place, emitter: Emitter) -> Address | AreaAddress:
        match place:
            case Cell(variable):
                return self._of_variable(variable)
            case Element():
                return self._element(place, emitter)
            case OpenElement():
                return self._open_element(place, emitter)
            case Component(of, offset, _, variable):
                outer = self.address(of, emitter)
                if variable is None:
                    return outer.plus(offset)
                if variable.location is not None:
                    return located(variable.location)
                inner = outer.plus(variable.offset)
                return Address((f"M[{inner}]",), 0) if variable.is_reference else inner
            case Target(pointer):
                emitter.charge(emitter.costs.access_ns)
                return Address((emitter.atom(self.values.value(pointer, emitter)).text,), 0, is_raw=True)
            case This():
                return Address((), self._base) if self._base is not None else Address(("base",), 0)
            case Located():
                return located(place)
        raise AssertionError(f"{place} has no address")

    def _of_variable(self, variable: Variable) -> Address | AreaAddress:
        if variable.location is not None:
            return located(variable.location)
        cell = self.cell(variable)
        return Address((f"M[{cell}]",), 0) if variable.is_reference else cell

    def keep(self, where: Address) -> None:
        """Note that this address may be used after the present call."""
        self.keeps_stack_addresses |= where.terms not in ((), ("base",))

    def cell(self, variable: Variable) -> Address:
        """Return where the cell of a variable is, also of a VAR_IN_OUT, whose cell contains an address."""
        assert variable.offset >= 0, variable.name
        if variable.space is Space.GLOBAL:
            return Address((), variable.offset)
        if variable.space is Space.FRAME:
            return Address(("frame",), variable.offset, is_frame=True)
        if self._base is not None:
            return Address((), self._base + variable.offset)
        return Address(("base",), variable.offset)

    def _element(self, place: Element, emitter: Emitter) -> Address | AreaAddress:
        outer = self.address(place.of, emitter)
        low, high, stride = place.low, place.high, place.stride
        index = self._index(place.index, low, high, emitter)
        emitter.charge(emitter.costs.access_ns)
        if not (low <= index.low and index.high <= high):
            if not is_register(index.text):  # one that may become a local variable needs no other
                index = emitter.atom(index)
            emitter.add(f"if not {low} <= {index.text} <= {high}:")
            emitter.add(f"{INDENT}outside_array({index.text}, {low}, {high})")
        if index.low == index.high:
            return outer.plus((index.low - low) * stride)
        text = index.text if index.is_atom or is_register(index.text) else f"({index.text})"
        return outer.plus(-low * stride, text if stride == 1 else f"{stride} * {text}")

    def _open_element(self, place: OpenElement, emitter: Emitter) -> Address | AreaAddress:
        """Return the address of an element of an ARRAY[*]; the limits are in variables."""
        outer = self.address(place.of, emitter)
        index = emitter.cut(self.values.raw(place.index, emitter))
        if not is_register(index.text):
            index = emitter.atom(index)
        low, high = (self._limit(limit, emitter) for limit in place.array.limits)
        emitter.charge(emitter.costs.access_ns)
        emitter.add(f"if not {low} <= {index.text} <= {high}:")
        emitter.add(f"{INDENT}outside_array({index.text}, {low}, {high})")
        return outer.plus(0, f"{self._stride(place.type, emitter)} * ({index.text} - {low})")

    def _stride(self, kind: Type, emitter: Emitter) -> str:
        """Return the size of an element, which may be an ARRAY[*] of fewer dimensions."""
        factors = []
        while isinstance(kind, OpenArrayType):
            low, high = (self._limit(limit, emitter) for limit in kind.limits)
            emitter.charge(emitter.costs.operation_ns)
            factors.append(f"({high} - {low} + 1)")
            kind = kind.element
        return " * ".join([str(kind.size), *factors])

    def _limit(self, limit: Variable, emitter: Emitter) -> str:
        return self.load(Cell(limit, limit.type), emitter).text

    def _index(self, expression: Expression, low: int, high: int, emitter: Emitter) -> Value:
        """Return an index, without cutting it if what is cut could not become an index of the array."""
        raw = emitter.short(self.values.raw(expression, emitter))
        assert isinstance(raw.type, Elementary)
        span = 1 << raw.type.bits
        return raw if high - span < raw.low and raw.high < low + span else emitter.cut(raw)

    def reference(self, place: Place, emitter: Emitter) -> Value:
        """Return the address of a place as a number, for ADR."""
        if isinstance(place, Bit | Parameter):
            raise AssertionError(f"{place} has no address")
        where = self.address(place, emitter)
        emitter.charge(emitter.costs.operation_ns)
        if isinstance(where, AreaAddress):
            text = str(Address(where.terms, AREAS[where.area] + where.byte))
        else:
            self.keep(where)
            is_reference = not where.is_raw and any(term.startswith("M[") for term in where.terms)
            if where.is_frame and not where.is_raw:
                text = self._mark(where, place.type)
            elif is_reference:  # a VAR_IN_OUT, which may refer to a variable on the stack of a caller
                text = f"mark_on_stack({where}, {self._form_of(place.type)})"
            else:
                text = str(where)
        return of_type(text if text.isdigit() else f"({text})", Elementary.DWORD)

    def marked(self, place: Place, emitter: Emitter) -> str:
        """Return the address of a place whose kinds are noted, also if it is on the stack of a caller."""
        where = self.address(place, emitter)
        if isinstance(where, AreaAddress):
            return str(Address(where.terms, AREAS[where.area] + where.byte))
        self.keep(where)
        return str(where) if where.is_raw or where.terms in ((), ("base",)) else self._mark(where, place.type)

    def mark(self, variable: Variable, emitter: Emitter) -> None:
        """Note the kinds of a variable on the stack."""
        emitter.add(self._mark(self.cell(variable), variable.type))

    def _mark(self, where: Address, kind: Type) -> str:
        return f"mark({where}, {self._form_of(kind)})"

    def instance(self, place: Place, emitter: Emitter) -> Address:
        """Return the address of an instance of a function block."""
        where = self.address(place, emitter)
        assert isinstance(where, Address)
        if where.is_raw:
            return Address((emitter.new(f"of_form({where}, {self._form_of(common(place.type))})"),), 0)
        return where

    # ---- reading

    def load(self, place: Place, emitter: Emitter) -> Value:
        """Return the value of a place with one cell."""
        if isinstance(place, Bit):
            value = self.load(place.of, emitter)
            return Value(f"({value.text} & {1 << place.number} != 0)", Elementary.BOOL)
        kind = storage(place.type)
        assert kind is not None, place
        if isinstance(place, Parameter):
            emitter.charge(emitter.costs.parameter_ns)
            return of_type(emitter.new(f"parameter({self.parameter(place, emitter)}, {kind_number(kind)})"), kind)
        where = self.address(place, emitter)
        if isinstance(where, AreaAddress):
            emitter.charge(emitter.costs.access_ns if where.area == "M" else emitter.costs.io_ns)
            return areas.load(where, kind, emitter)
        emitter.charge(emitter.costs.text_ns if isinstance(kind, StringType) else emitter.costs.access_ns)
        if where.is_raw:
            at = emitter.new(str(where))
            number = kind_number(kind)
            return of_type(emitter.new(f"M[{at}] if K[{at}] == {number} else peek({at}, {number})"), kind)
        self._note(place, where)
        return of_type(f"M[{where}]", kind)

    def _note(self, place: Place, where: Address) -> None:
        """Note a cell that nothing but its own text reaches: a variable, or a part of one that is no array.

        A block of function reaches its variables by `base`, and might reach them by the name of its instance as well.
        """
        if len(where.terms) > 1 or (where.terms and where.terms[0] not in ("base", "frame")):
            return
        is_named = not where.terms and not self._is_program
        depth = 0
        while isinstance(place, Component):
            place, depth = place.of, depth + 1
        if isinstance(place, Cell) and not (is_named and depth > _is_main(place)):
            self.registers.add(f"M[{where}]")

    def parameter(self, place: Parameter, emitter: Emitter) -> str:
        """Return the logical address of a parameter."""
        outer = self.values.value(place.object, emitter)
        if outer.low == outer.high:
            return str(outer.low + place.number)
        return f"{outer.text} + {place.number}"

    def cells(self, place: Place, emitter: Emitter) -> str:
        """Return all cells of a structure or an array."""
        if isinstance(place, Swapped):
            emitter.charge(emitter.costs.copy_ns * place.type.size)
            return emitter.new(f"swapped_cells({self.cells(place.of, emitter)}, {self._form_of(place.type)})")
        where, size = self.address(place, emitter), place.type.size
        emitter.charge(emitter.costs.copy_ns * size)
        if isinstance(where, AreaAddress):
            return emitter.new(f"peek_cells({AREAS[where.area]} + {where}, {self._form_of(place.type)})")
        if where.is_raw:
            return emitter.new(f"peek_cells({where}, {self._form_of(place.type)})")
        return f"M[{_slice(where, size, emitter)}]"

    # ---- writing

    def store(self, place: Place, value: Value, emitter: Emitter) -> None:
        """Add the lines that write a value of one cell."""
        kind = storage(place.type)
        assert kind is not None, place
        value = emitter.cut(value)
        if isinstance(place, Bit):
            self._store_bit(place, value, emitter)
            return
        if isinstance(place, Parameter):
            emitter.charge(emitter.costs.parameter_ns)
            emitter.add(f"set_parameter({self.parameter(place, emitter)}, {value.text})")
            return
        where = self.address(place, emitter)
        if isinstance(where, AreaAddress):
            emitter.charge(emitter.costs.access_ns if where.area == "M" else emitter.costs.io_ns)
            if isinstance(kind, StringType):
                value = Value(_cut_to(kind, value, emitter), kind)
            areas.store(where, kind, value, emitter)
            return
        if not where.is_raw:
            self._note(place, where)
        self.store_at(where, place.type, value, emitter)

    def store_at(self, where: Address, wanted: Type, value: Value, emitter: Emitter) -> None:
        """Add the lines that write a value of one cell to an address."""
        kind = storage(wanted)
        assert kind is not None
        text = _cut_to(wanted, emitter.cut(value), emitter)
        emitter.charge(emitter.costs.text_ns if isinstance(kind, StringType) else emitter.costs.access_ns)
        if where.is_raw:
            number, at = kind_number(kind), emitter.new(str(where))
            emitter.add(f"if K[{at}] == {number}:")
            emitter.add(f"{INDENT}M[{at}] = {text}")
            emitter.add("else:")
            emitter.add(f"{INDENT}poke({at}, {number}, {text})")
        else:
            emitter.add(f"M[{where}] = {text}")

    def _store_bit(self, place: Bit, value: Value, emitter: Emitter) -> None:
        whole = storage(place.of.type)
        assert isinstance(whole, Elementary)
        before = emitter.atom(self.load(place.of, emitter))
        mask = 1 << place.number
        emitter.charge(emitter.costs.operation_ns)
        is_sign = whole.family is Family.SIGNED and place.number == whole.bits - 1
        bits = f"{before.text} | {mask}" if not is_sign else f"{before.text} | {-mask}"
        none = f"{before.text} & {~mask}" if not is_sign else f"{before.text} & {mask - 1}"
        self.store(place.of, of_type(emitter.new(f"{bits} if {value.text} else {none}"), whole), emitter)

    def store_cells(self, place: Place, cells: str, emitter: Emitter) -> None:
        """Add the lines that write a structure or an array."""
        where = self.address(place, emitter)
        if isinstance(where, AreaAddress):
            emitter.add(
                f"poke_cells({AREAS[where.area]} + {where}, {self._form_of(place.type)}, {_kept(cells, emitter)})"
            )
        else:
            self.store_cells_at(where, place.type, cells, emitter)

    def store_cells_at(self, where: Address, kind: Type, cells: str, emitter: Emitter) -> None:
        if where.is_raw:
            emitter.add(f"poke_cells({where}, {self._form_of(kind)}, {_kept(cells, emitter)})")
        else:
            emitter.add(f"M[{_slice(where, kind.size, emitter)}] = {cells}")


def common(kind: Type) -> Type:
    """Return what an instance at a pointer must at least be, which may be one of a block that extends the type."""
    return kind.open if isinstance(kind, BlockType) and kind.open is not None else kind


def _kept(cells: str, emitter: Emitter) -> str:
    return cells if cells.isidentifier() else emitter.new(cells)


def _is_main(cell: Cell) -> bool:
    """True for the instance of a program."""
    kind = cell.variable.type
    return isinstance(kind, BlockType) and kind.pou is not None and kind.pou.kind is PouKind.PROGRAM


def _slice(where: Address, size: int, emitter: Emitter) -> str:
    if not where.terms:
        return f"{where.offset}:{where.offset + size}"
    if len(where.terms) == 1:
        return f"{where}:{where.plus(size)}"
    start = emitter.new(str(where))
    return f"{start}:{start} + {size}"


def _cut_to(kind: Type, value: Value, emitter: Emitter) -> str:
    """Return the text of a value; a string is cut to the length of the target."""
    if not isinstance(kind, StringType) or not isinstance(value.type, StringType):
        return value.text
    return shortened(value, kind.length, emitter).text
