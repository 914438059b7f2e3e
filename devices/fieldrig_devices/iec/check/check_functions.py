"""The functions of Check.lib: a project that declares them has them called before each access that can go wrong.

PacDrive manual 4414 to 4420 (PD-202, PD-368).  The manual names only the library; the names of the functions, their
inputs and what they are called for are those of CoDeSys V2.3:

    CheckBounds(index, lower, upper)                    the index of each element of an array
    CheckDivByte, CheckDivWord, CheckDivDWord, CheckDivReal(divisor)     the right side of / and MOD, by its size
    CheckRangeSigned, CheckRangeUnsigned(value, lower, upper)            a value that goes into a subrange
    CheckPointer(address, size, is_write)               the address before pointer^

What the function returns takes the place of the value.  Without the function nothing changes, and so it is within the
bodies of these functions and within libraries.
"""

from collections.abc import Sequence
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import constants
from fieldrig_devices.iec.check.context import Context, position_of
from fieldrig_devices.iec.elementary import Elementary, Family
from fieldrig_devices.iec.program import (
    Bit,
    CallFunction,
    Component,
    Constant,
    Element,
    Expression,
    OpenElement,
    Place,
    Pou,
    Target,
)
from fieldrig_devices.iec.tree import PouKind
from fieldrig_devices.iec.types import PointerType, SubrangeType

BOUNDS: Final = "CheckBounds"
POINTER: Final = "CheckPointer"
RANGES: Final = ("CheckRangeSigned", "CheckRangeUnsigned")
DIVISORS: Final = {1: "CheckDivByte", 2: "CheckDivWord", 4: "CheckDivDWord"}
"""The functions for integers by the size of the divisor."""
REAL_DIVISOR: Final = "CheckDivReal"
NAMES: Final = frozenset(name.lower() for name in (BOUNDS, POINTER, *RANGES, *DIVISORS.values(), REAL_DIVISOR))


def index(context: Context, value: Expression, low: Expression, high: Expression, at: tree.Node) -> Expression:
    """Return the index as CheckBounds leaves it; a constant one has been compared with constant limits already."""
    is_known = isinstance(value, Constant) and isinstance(low, Constant)
    function = None if is_known else _function(context, BOUNDS)
    return value if function is None else _called(context, function, (value, low, high), at) or value


def divisor(context: Context, value: Expression, at: tree.Node) -> Expression:
    """Return the right side of a division as the function for its type leaves it, in its own type."""
    kind = value.type
    if not isinstance(kind, Elementary) or (isinstance(value, Constant) and value.value != 0):
        return value
    name = REAL_DIVISOR if kind is Elementary.REAL else DIVISORS.get(kind.size, "") if kind.is_integer else ""
    function = _function(context, name)
    made = _called(context, function, (value,), at) if function is not None else None
    return constants.converted(made, kind) if made is not None else value


def in_subrange(context: Context, value: Expression, kind: SubrangeType, at: tree.Node) -> Expression:
    """Return a value that goes into a subrange, as the function for its sign leaves it."""
    function = _function(context, RANGES[kind.base.family is not Family.SIGNED])
    if function is None:
        return value
    made = _called(context, function, (value, limit(kind.low), limit(kind.high)), at)
    return constants.converted(made, kind.base) if made is not None else value


def address(context: Context, pointer: Expression, at: tree.Node) -> Expression:
    """Return the address in a pointer as CheckPointer leaves it; `writes` says later that it is for writing."""
    function = _function(context, POINTER)
    if function is None or not isinstance(pointer.type, PointerType):
        return pointer
    number = constants.converted(pointer, Elementary.DWORD)
    given = (number, limit(pointer.type.to.size), Constant(False, Elementary.BOOL))
    made = _called(context, function, given, at)
    return constants.converted(made, pointer.type) if made is not None else pointer


def writes(place: Place) -> None:
    """Tell CheckPointer that the place behind a pointer is written."""
    while isinstance(place, Component | Element | OpenElement | Bit):
        place = place.of
    call = getattr(place.pointer, "operand", None) if isinstance(place, Target) else None
    if isinstance(call, CallFunction) and call.pou.name.lower() == POINTER.lower():
        variable, _ = call.inputs[2]
        call.inputs = (*call.inputs[:2], (variable, Constant(True, Elementary.BOOL)))


def limit(value: int) -> Constant:
    return Constant(value, Elementary.DINT if value <= Elementary.DINT.high else Elementary.UDINT)


def _function(context: Context, name: str) -> Pou | None:
    """Return the project's function of this name, unless the body that is checked belongs to such a function."""
    if context.owner is None or context.is_library or context.owner.name.lower() in NAMES:
        return None
    function = context.project.pous.get(context.key(name))
    return function if function is not None and function.kind is PouKind.FUNCTION else None


def _called(context: Context, function: Pou, given: Sequence[Expression], at: tree.Node) -> CallFunction | None:
    """Return the call; None after a message if the function does not have the inputs that it should have."""
    inputs = context.project.sources[function].inputs
    elementary = [pin for pin in inputs if isinstance(pin.type, Elementary)]
    result = function.result
    if len(elementary) != len(inputs) or len(inputs) != len(given) or result is None:
        what = f"{function.name} has {len(inputs)} input{'s' * (len(inputs) != 1)}"
        context.say(at, what, f"{len(given)} of elementary types, because it is called here as in Check.lib")
        return None
    if context.pou is not None:
        context.project.calls.setdefault(context.pou, {}).setdefault(function, position_of(at))
    made = [
        value if value.type is one.type else constants.converted(value, one.type)
        for value, one in zip(given, elementary, strict=True)
        if isinstance(one.type, Elementary)
    ]
    return CallFunction(function, tuple(zip(inputs, made, strict=True)), result.type)
