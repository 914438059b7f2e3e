"""REFERENCE TO of today's tools, and the functions REF and __ISVALIDREF.

Wherever a reference is named, what it refers to is meant (`places.meaning`); only REF= and __ISVALIDREF mean the
reference itself.  A reference to nothing is a fault at run time, like a pointer to nothing.
"""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import dispatch, places, properties, var_info, writing
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.project import UNKNOWN
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import (
    AddressOf,
    Assign,
    Binary,
    CallFunction,
    Constant,
    Convert,
    Evaluate,
    Expression,
    Load,
    Operator,
    Place,
    Target,
    Variable,
)
from fieldrig_devices.iec.tree import Section
from fieldrig_devices.iec.types import BlockType, InterfaceType, OpenArrayType, PointerType, StringType, Type


def assignment(checker: Checker, node: tree.Assign) -> Assign | None:
    """`x REF= y` lets x refer to y, and `x REF= 0` to nothing."""
    target = _reference(checker, node.target)
    if target is None or not writing.is_writable(checker.context, target, node.target):
        return None
    assert isinstance(target.type, PointerType)
    value = reference_to(checker, node.value, target.type)
    return Assign(target, value, line=node.position.line) if value is not None else None


def attempt(checker: Checker, node: tree.Assign) -> Evaluate | None:
    """`x ?= y` lets x refer to the instance of y if that implements the interface of x, and to nothing if not."""
    call = _query_of(checker, node.value, node.target)
    return Evaluate(call, line=node.position.line) if call is not None else None


def reference_to(checker: Checker, node: tree.Expression, kind: PointerType) -> Expression | None:
    """Return a reference to a variable, for REF= and for an input; None after a message."""
    if isinstance(node, tree.Literal) and node.value == 0:
        return Constant(0, kind)
    place = checker.place(node)
    if place is None:
        return None
    if not writing.has_cell(place):
        checker.context.say(
            node, f"{text(node)} has no address of its own", "a variable", "copy it into a variable first"
        )
        return None
    if isinstance(place.type, OpenArrayType):
        checker.context.say(node, f"{text(node)} is {a(place.type)}", "an element of it")
        return None
    is_derived = dispatch.derives(checker.context.project, place.type, kind.to)
    if place.type != kind.to and not is_derived and not _has_room(place.type, kind.to):
        checker.context.say(node, f"{text(node)} is {a(place.type)}", f"a variable of type {kind.to} for the {kind}")
        return None
    return AddressOf(place, kind)


def _has_room(given: Type, wanted: Type) -> bool:
    """True for a text in which each text of another type has room."""
    if not isinstance(given, StringType) or not isinstance(wanted, StringType):
        return False
    return given.is_wide is wanted.is_wide and given.length >= wanted.length


def _reference(checker: Checker, node: tree.Expression, *, may_be_interface: bool = False) -> Place | None:
    """Return the place of the reference itself; None after a message."""
    place = places.itself(checker, node)
    if place is None or (isinstance(place, Place) and place.type is UNKNOWN):
        return None
    if isinstance(place, Place) and isinstance(place.type, PointerType) and place.type.is_reference:
        return place
    if isinstance(place, Place) and isinstance(place.type, InterfaceType) and may_be_interface:
        return place
    checker.context.say(node, f"{text(node)} is not a reference", "a variable that is declared as REFERENCE TO")
    return None


def _value_of(checker: Checker, node: tree.Expression) -> Expression | None:
    """Return a reference itself, also one that a call or a property gives; None after a message."""
    reading = properties.reading(checker, node) if checker.context.project.properties else None
    if reading:
        node = reading[0]
    if isinstance(node, tree.Call):
        value = checker.expression(node)
        if isinstance(value, Load) and isinstance(value.place, Target):
            return value.place.pointer
        if value is None or isinstance(value.type, InterfaceType):
            return value
    place = _reference(checker, node, may_be_interface=True)
    return Load(place) if place is not None else None


def _is_valid(checker: Checker, node: tree.Call) -> Expression | None:
    given = _argument(checker, node)
    named = checker.context.find(given.text) if isinstance(given, tree.Name) else None
    if isinstance(named, Variable) and named.section is Section.IN_OUT and given is not None:
        passed = checker.place(given)
        reference: Expression | None = AddressOf(passed, Elementary.DWORD) if passed is not None else None
    else:
        reference = _value_of(checker, given) if given is not None else None
    if reference is None:
        return None
    number = Convert(reference, Elementary.DWORD)
    return Binary(Operator.NE, number, Constant(0, Elementary.DWORD), Elementary.BOOL)


def _ref(checker: Checker, node: tree.Call) -> Expression | None:
    """REF of the standard is the address of a variable, with its type."""
    given = _argument(checker, node)
    place = checker.place(given) if given is not None else None
    return reference_to(checker, given, PointerType(place.type)) if place is not None and given is not None else None


def _argument(checker: Checker, node: tree.Call) -> tree.Expression | None:
    if len(node.arguments) == 1 and node.arguments[0].value is not None:
        return node.arguments[0].value
    checker.context.say(node, f"{text(node.called)} with {len(node.arguments)} arguments", "one argument")
    return None


def _query(checker: Checker, node: tree.Call) -> Expression | None:
    """__QUERYINTERFACE(from, into) lets `into` refer to the instance if that implements the interface of `into`."""
    values = [argument.value for argument in node.arguments if argument.value is not None]
    if len(values) != 2:
        checker.context.say(
            node, f"{text(node.called)} with {len(node.arguments)} arguments", "two variables of interfaces"
        )
        return None
    return _query_of(checker, *values)


def _query_of(checker: Checker, given: tree.Expression, into: tree.Expression) -> CallFunction | None:
    source, target = checker.place(given), checker.target(into)
    if source is None or target is None:
        return None
    kind = target.type
    if not isinstance(kind, InterfaceType) or not isinstance(source.type, InterfaceType | BlockType):
        wrong, place = (given, source) if isinstance(kind, InterfaceType) else (into, target)
        checker.context.say(wrong, f"{text(wrong)} is {a(place.type)}", "a variable of an interface")
        return None
    address = Load(source) if isinstance(source.type, InterfaceType) else AddressOf(source, Elementary.DWORD)
    function, (parameter, result) = dispatch.query(checker.context.project, kind)
    return CallFunction(function, ((parameter, Convert(address, Elementary.DWORD)), (result, target)), Elementary.BOOL)


def _query_pointer(checker: Checker, node: tree.Call) -> Expression | None:
    """__QUERYPOINTER(from, into) lets `into` point to the instance if that is one of the block that it points to."""
    values = [argument.value for argument in node.arguments if argument.value is not None]
    if len(values) != 2:
        what = f"{text(node.called)} with {len(node.arguments)} arguments"
        checker.context.say(node, what, "a variable of an interface, and a pointer to a function block")
        return None
    address, target = checker.expression(values[0]), checker.target(values[1])
    if address is None or target is None:
        return None
    if not isinstance(address.type, InterfaceType):
        checker.context.say(values[0], f"{text(values[0])} is {a(address.type)}", "a variable of an interface")
        return None
    kind = target.type
    if not isinstance(kind, PointerType) or kind.is_reference or not isinstance(kind.to, BlockType):
        what = f"{text(values[1])} is {a(kind)}"
        checker.context.say(values[1], what, "a pointer to a function block, POINTER TO Block")
        return None
    function, (parameter, result) = dispatch.query_pointer(checker.context.project, kind)
    return CallFunction(function, ((parameter, Convert(address, Elementary.DWORD)), (result, target)), Elementary.BOOL)


def _pou_name(checker: Checker, node: tree.Call) -> Expression | None:
    """__POUNAME() is the name of the unit whose code it is in, `Tank.Fill` in a method."""
    pou = checker.context.pou
    if node.arguments or pou is None:
        checker.context.say(node, f"{text(node.called)} with {len(node.arguments)} arguments", "no argument")
        return None
    name = ".".join(part.partition("@")[0] for part in pou.name.split("."))
    return Constant(name, StringType(max(len(name), 1)))


def _position(checker: Checker, node: tree.Call) -> Expression | None:
    """__POSITION() is the place in the text where it is, `Line 7, Column 3 (Impl)`."""
    if node.arguments:
        checker.context.say(node, f"{text(node.called)} with {len(node.arguments)} arguments", "no argument")
        return None
    line, column = node.called.position
    shown = f"Line {line}, Column {column} (Impl)"
    return Constant(shown, StringType(len(shown)))


FUNCTIONS: Final[dict[str, Callable[[Checker, tree.Call], Expression | None]]] = {
    "REF": _ref,
    "__ISVALIDREF": _is_valid,
    "__POSITION": _position,
    "__POUNAME": _pou_name,
    "__QUERYINTERFACE": _query,
    "__QUERYPOINTER": _query_pointer,
    "__VARINFO": var_info.of,
}
QUERIES: Final = frozenset({"__QUERYINTERFACE", "__QUERYPOINTER"})
"""The functions whose result may be left alone."""
