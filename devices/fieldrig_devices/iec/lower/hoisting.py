"""Calls in expressions: they become instructions of their own, in front of the statement, from left to right.

`Hoisting.out_of` returns an expression without calls, in which each call is replaced by its result.  A result is read
where the callee left it, or from an intermediate cell of the frame if another call follows before it is used.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final, Protocol, TypeVar

from fieldrig_devices.iec.program import (
    AddressOf,
    Allocate,
    Assigned,
    Binary,
    Bit,
    CallFunction,
    Cell,
    Component,
    Constant,
    Convert,
    Description,
    Element,
    Enabled,
    Expression,
    Intrinsic,
    Kept,
    Load,
    OpenElement,
    Operator,
    Parameter,
    Place,
    Result,
    Swapped,
    Target,
    Unary,
    Variable,
)

SHORT_CIRCUIT = frozenset({Operator.AND_THEN, Operator.OR_ELSE})
Part = TypeVar("Part")


LONGEST_CHAIN: Final = 64
"""Operators in a row, such as a OR b OR c, that are one instruction."""


def has_call(node: Expression | Place) -> bool:
    """True if a call, a parameter that is read slowly or a long row of operators is in an expression or a place."""
    operators = 0
    while isinstance(node, Binary):
        operators += 1
        if operators > LONGEST_CHAIN or has_call(node.right):
            return True
        node = node.left
    match node:
        case CallFunction() | Enabled() | Result() | Kept() | Assigned():
            return True
        case Load(place) | AddressOf(place) | Description(place):
            return (isinstance(place, Parameter) and place.is_slow) or has_call(place)
        case Unary(operand=operand) | Convert(operand=operand):
            return has_call(operand)
        case Allocate(count=count):
            return has_call(count)
        case Intrinsic(arguments=arguments):
            return any(map(has_call, arguments))
        case Element(of, index) | OpenElement(of, index):
            return has_call(of) or has_call(index)
        case Component(of) | Bit(of) | Swapped(of):
            return has_call(of)
        case Target(pointer):
            return has_call(pointer)
        case Parameter(object=outer):
            return has_call(outer)
    return False


class Caller(Protocol):
    """The part of the statements that hoisting needs."""

    def call(self, call: CallFunction) -> Cell:
        """Make the call; return where its result is until the next call."""

    def enabled(self, call: Enabled) -> Cell:
        """Make a call with EN or ENO; return where its result is until the next call."""

    def assigned(self, given: Assigned) -> Expression:
        """Make an assignment; return the value of its place."""

    def read_slowly(self, place: Parameter) -> Cell: ...

    def keep(self, value: Expression) -> Load:
        """Store a value in an intermediate cell."""

    def keep_in(self, variable: Variable, value: Expression) -> Cell:
        """Store a value in a variable."""

    def choose(self, first: Load, is_and: bool, second: Callable[[], Expression]) -> None:
        """Evaluate `second` into the cell of `first` unless its value decides."""


class Hoisting:
    def __init__(self, caller: Caller) -> None:
        self._caller = caller

    def out_of(self, expression: Expression) -> Expression:
        if not has_call(expression):
            return expression
        match expression:
            case CallFunction():
                return Load(self._caller.call(expression))
            case Enabled():
                return Load(self._caller.enabled(expression))
            case Assigned():
                return self._caller.assigned(expression)
            case Binary():
                return self._out_of_chain(expression)
            case Intrinsic():
                return replace(expression, arguments=tuple(self.all_out_of(expression.arguments)))
            case Unary() | Convert():
                return replace(expression, operand=self.out_of(expression.operand))
            case Allocate():
                return replace(expression, count=self.out_of(expression.count))
            case Load(Parameter() as place) if place.is_slow:
                return Load(self._caller.read_slowly(place))
            case Load() | AddressOf() | Description():
                return replace(expression, place=self.out_of_place(expression.place))
        raise AssertionError(f"{expression} has no parts")

    def _out_of_chain(self, last: Binary) -> Expression:
        """Hoist from operators in a row, from left to right; a long row is computed in parts."""
        chain, node = [], last.left
        chain.append(last)
        while isinstance(node, Binary):
            chain.append(node)
            node = node.left
        value = self.out_of(node)
        length = 0
        for link in reversed(chain):
            is_calling = has_call(link.right)
            if length >= LONGEST_CHAIN or (is_calling and not isinstance(value, Constant | AddressOf)):
                value, length = self._caller.keep(value), 0
            if is_calling and link.operator in SHORT_CIRCUIT:
                value = self._chosen(value, link)
            else:
                right = self.out_of(link.right) if is_calling else link.right
                value, length = replace(link, left=value, right=right), length + 1
        return value

    def _chosen(self, left: Expression, link: Binary) -> Load:
        """Call what is on the right of AND_THEN or OR_ELSE only if the left side does not decide."""
        first = left if isinstance(left, Load) else self._caller.keep(left)
        self._caller.choose(first, link.operator is Operator.AND_THEN, lambda: self.out_of(link.right))
        return first

    def all_out_of(self, expressions: Sequence[Expression]) -> list[Expression]:
        """Hoist from several expressions; each that precedes a call is evaluated before it."""
        calls = [number for number, one in enumerate(expressions) if has_call(one)]
        last = calls[-1] if calls else 0
        free_of_calls = []
        for number, one in enumerate(expressions):
            free = self.out_of(one)
            is_kept = number < last and not isinstance(free, Constant | AddressOf | Description)
            free_of_calls.append(self._caller.keep(free) if is_kept else free)
        return free_of_calls

    def out_of_place(self, place: Place) -> Place:
        if not has_call(place):
            return place
        match place:
            case Element() | OpenElement():
                index = self._caller.keep(self.out_of(place.index))
                return replace(place, of=self.out_of_place(place.of), index=index)
            case Result(call):
                return self._caller.call(call)
            case Kept(value, variable):
                return self._caller.keep_in(variable, self.out_of(value))
            case Component() | Bit() | Swapped():
                return replace(place, of=self.out_of_place(place.of))
            case Target():
                return replace(place, pointer=self._caller.keep(self.out_of(place.pointer)))
            case Parameter():
                return replace(place, object=self._caller.keep(self.out_of(place.object)))
        raise AssertionError(f"{place} has no parts")
