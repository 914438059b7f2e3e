"""The effects of one pass of a body: variables that it overwrites on every way through, or uses first.

A value that a client has put into a variable has an effect only if the body uses it before it overwrites it.
Where the analysis is not exact, it says "used" or "not overwritten": after a jump, for elements with a variable index,
for parts of a word, and for the target of a pointer.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from itertools import chain
from typing import Final, NamedTuple

from fieldrig_devices.iec import program as ir
from fieldrig_devices.iec.layout import variable_size
from fieldrig_devices.iec.tree import PouKind
from fieldrig_devices.iec.types import BlockType

DATA: Final = ""
"""The space of absolute addresses, in cells."""
OWN: Final = "own"
"""The space of the instance whose code runs, in cells from its start."""


class Span(NamedTuple):
    """Cells of `DATA` or `OWN`, or bits of the area I, Q or M; `end` is the first one behind them."""

    space: str
    start: int
    end: int


class Effects(NamedTuple):
    """Effects of a body, with all that it calls, on variables that outlive it."""

    overwritten: frozenset[Span]
    used: frozenset[Span]

    def outside(self) -> "Effects":
        """Return the effects beyond the instance whose code runs."""
        return Effects(*(frozenset(span for span in spans if span.space != OWN) for spans in self))


class Where(NamedTuple):
    """A place: its span, the span of the whole variable, and whether the span is exactly the place."""

    span: Span
    whole: Span
    is_exact: bool


@dataclass(slots=True)
class Mentioned:
    """The places and calls in the statements of all bodies."""

    targets: list[tuple[ir.Pou, ir.Place]] = field(default_factory=list)
    """The places that statements write, pins in calls among them, with the body."""
    calls: list[ir.CallBlock] = field(default_factory=list)
    pointed: set[Span] = field(default_factory=set)
    """The variables whose address is taken."""


class Flow:
    """The way through one body."""

    def __init__(
        self, pou: ir.Pou, known: Mapping[ir.Pou, Effects], outside: Mapping[ir.Pou, Effects], mentioned: Mentioned
    ):
        """`known` and `outside` are the effects of what the body calls."""
        self._pou, self._known, self._outside, self._mentioned = pou, known, outside, mentioned
        self._overwritten = set[Span]()
        self._trail: list[Span] = []
        """The spans of `_overwritten` in their order, so that a branch can be left again."""
        self._used = set[Span]()
        self._at_returns: set[Span] | None = None
        """The spans that were overwritten at every RETURN so far; None before the first one."""
        self._is_straight = True
        """False behind a jump or a label: what follows may be left out."""

    def effects(self) -> Effects:
        self._body(self._pou.body)
        if self._at_returns is not None:
            self._overwritten &= self._at_returns
        return Effects(frozenset(self._overwritten), frozenset(self._used))

    # ---- statements

    def _body(self, body: Sequence[ir.AnyStatement]) -> None:
        for statement in body:
            self._statement(statement)

    def _statement(self, statement: ir.AnyStatement) -> None:
        match statement:
            case ir.Free():
                self._read(statement.address)
            case ir.Assign():
                self._evaluated(statement.value)
                self._write(statement.place)
            case ir.Evaluate():
                self._evaluated(statement.value)
            case ir.CallBlock():
                self._block(statement)
            case ir.CallAction():
                self._called(statement.pou, is_own=statement.instance is None)
            case ir.If():
                self._if(statement)
            case ir.Case():
                self._read(statement.selector)
                self._join([*(self._branch(body) for _, body in statement.branches), self._branch(statement.otherwise)])
            case ir.For():
                self._read((statement.first, statement.last, statement.step))
                self._write(statement.variable)
                self._branch(statement.body)
            case ir.Loop():
                self._read((statement.condition, statement.until))
                self._branch(statement.body)
            case ir.Try():
                self._read(None if statement.code is None else _indices(statement.code))
                for part in (statement.body, statement.caught, statement.final):
                    self._branch(part or ())  # each may end at any place
            case ir.Return():
                self._return()
            case ir.Jump():
                self._read(statement.condition)
                self._is_straight = False
            case ir.Label():
                self._is_straight = False

    def _if(self, statement: ir.If) -> None:
        """Follow an IF with all its ELSIF, of which there may be a thousand in each other."""
        ends: list[list[Span]] = []
        while True:
            self._read(statement.condition)
            ends.append(self._branch(statement.then))
            match statement.otherwise:
                case [ir.If() as following]:
                    statement = following
                case otherwise:
                    ends.append(self._branch(otherwise))
                    break
        self._join(ends)

    def _branch(self, body: Sequence[ir.AnyStatement]) -> list[Span]:
        """Follow a body that may be left out, and return what it overwrites."""
        mark = len(self._trail)
        self._body(body)
        added = self._trail[mark:]
        del self._trail[mark:]
        self._overwritten.difference_update(added)
        return added

    def _join(self, ends: Sequence[list[Span]]) -> None:
        """Continue behind branches of which exactly one has run."""
        self._add(span for span, count in Counter(chain(*ends)).items() if count == len(ends))

    def _return(self) -> None:
        self._at_returns = self._overwritten & (self._overwritten if self._at_returns is None else self._at_returns)

    # ---- calls

    def _block(self, call: ir.CallBlock) -> None:
        self._mentioned.calls.append(call)
        self._read([value for _, value in call.inputs])
        self._read([place for _, place in call.references])
        self._read(_indices(call.instance))
        condition = call.enable.condition
        self._read(condition)
        for pin, _ in call.inputs:
            self._mentioned.targets.append((self._pou, ir.Component(call.instance, 0, pin.type, pin)))
        self._called(call.pou, is_own=False, always=condition is None)
        for place, value in call.outputs:
            self._read(value)
            self._write(place, always=condition is None)
        if call.enable.ok is not None:
            self._write(call.enable.ok)

    def _evaluated(self, value: ir.Expression) -> None:
        """Read the value of a statement.  A call that it consists of always happens."""
        self._read(value)
        if isinstance(value, ir.CallFunction):
            self._called(value.pou, is_own=value.instance is None)
            for _, place, _ in value.outputs:
                self._write(place)

    def _called(self, pou: ir.Pou, *, is_own: bool, always: bool = True) -> None:
        effects = (self._known if is_own else self._outside).get(pou)
        if effects is None:  # a recursion
            self._is_straight = False
            return
        self._used |= effects.used - self._overwritten
        if always:
            self._add(effects.overwritten)

    # ---- places

    def _add(self, spans: Iterable[Span]) -> None:
        if self._is_straight:
            new = frozenset(spans) - self._overwritten
            self._overwritten |= new
            self._trail += new

    def _write(self, place: ir.Place, *, always: bool = True) -> None:
        self._mentioned.targets.append((self._pou, place))
        self._read(_indices(place))
        where = where_is(self._pou, place)
        if where is not None and where.is_exact and always:
            self._add((where.span,))

    def _read(self, node: object) -> None:
        """Note all that an expression uses.  The list of what waits is no recursion: expressions may be long."""
        waiting = [node]
        while waiting:
            node = waiting.pop()
            match node:
                case list() | tuple():
                    waiting.extend(node)
                case ir.Load(place) | ir.AddressOf(place) | ir.Description(place):
                    waiting.append(place)
                    if not isinstance(node, ir.Load) and (where := where_is(self._pou, place)) is not None:
                        self._mentioned.pointed.add(where.span)
                case ir.Allocate():
                    waiting.append(node.count)
                case ir.CallFunction():
                    waiting.extend(argument for _, argument in node.inputs)
                    waiting.extend(_indices(node.instance) if node.instance is not None else ())
                    self._called(node.pou, is_own=node.instance is None, always=False)
                    for _, place, _ in node.outputs:
                        self._write(place, always=False)
                case ir.Enabled():
                    waiting += [node.value, node.enable.condition]
                    if node.enable.ok is not None:
                        self._write(node.enable.ok, always=False)
                case ir.Assigned():
                    waiting.append(node.value)
                    self._write(node.place, always=False)
                case ir.Unary() | ir.Binary() | ir.Convert() | ir.Intrinsic():
                    waiting.extend(getattr(node, part.name) for part in fields(node) if part.name != "type")
                case _ if isinstance(node, ir.Place):
                    waiting.extend(_indices(node))
                    self._use(node)

    def _use(self, place: ir.Place) -> None:
        where = where_is(self._pou, place)
        if where is not None and self._overwritten.isdisjoint((where.span, where.whole)):
            self._used.add(where.span)


def _indices(place: ir.Place) -> list[object]:
    """Return the expressions in a place: indices, pointers and calls."""
    indices: list[object] = []
    while True:
        match place:
            case ir.Element() | ir.OpenElement():
                indices.append(place.index)
                place = place.of
            case ir.Component() | ir.Bit() | ir.Swapped():
                place = place.of
            case ir.Target():
                return [*indices, place.pointer]
            case ir.Result():
                return [*indices, place.call]
            case ir.Kept():
                return [*indices, place.value]
            case ir.Parameter():
                return [*indices, place.object]
            case _:
                return indices


def where_is(pou: ir.Pou, place: ir.Place) -> Where | None:
    """Return where a place of a body is; None for what has no lasting address, and for what a reference leads to."""
    match place:
        case ir.Cell(variable=variable):
            if variable.is_reference or variable.space is ir.Space.FRAME:
                return None
            space, base = (DATA, 0) if variable.space is ir.Space.GLOBAL else _home(pou)
            return _whole(space, base + variable.offset, variable_size(variable))
        case ir.Located():
            first = place.byte * 8 + max(place.bit, 0)
            return _whole(place.area, first, 1 if place.bit >= 0 else 8 * place.type.size)
        case ir.This():
            return _whole(*_home(pou), place.type.size)
        case ir.Swapped(of=whole):
            return where_is(pou, whole)
        case ir.Component() | ir.Element() | ir.OpenElement() | ir.Bit():
            of = where_is(pou, place.of)
            return None if of is None else _part(of, place)
    return None


def _whole(space: str, start: int, size: int) -> Where:
    span = Span(space, start, start + size)
    return Where(span, span, True)


def _part(outer: Where, place: ir.Component | ir.Element | ir.OpenElement | ir.Bit) -> Where | None:
    """Return where a part is; for what is not known exactly, the whole that it is a part of."""
    offset = None
    if isinstance(place, ir.Component):
        if place.variable is not None and place.variable.is_reference:
            return None
        offset = place.offset if place.variable is None else place.variable.offset
    elif isinstance(place, ir.Element) and isinstance(place.index, ir.Constant):
        offset = (int(place.index.value) - place.low) * place.stride
    if offset is None or not outer.is_exact or outer.span.space not in (DATA, OWN):
        return outer._replace(is_exact=False)
    start = outer.span.start + offset
    return outer._replace(span=Span(outer.span.space, start, start + place.type.size))


def _home(pou: ir.Pou) -> tuple[str, int]:
    """Return the space and the address of the variables of a body: a program has a fixed address."""
    while pou.owner is not None:
        pou = pou.owner
    is_program = pou.kind is PouKind.PROGRAM and pou.instance is not None
    return (DATA, pou.instance.offset) if is_program and pou.instance is not None else (OWN, 0)


def is_pin(place: ir.Place) -> bool:
    """True for a variable of an instance of a function block."""
    if not isinstance(place, ir.Component) or place.variable is None:
        return False
    kind = place.of.type
    return isinstance(kind, BlockType) and kind.pou is not None and kind.pou.kind is not PouKind.PROGRAM
