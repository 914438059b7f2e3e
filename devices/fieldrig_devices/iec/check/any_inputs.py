"""Arguments for inputs of type ANY: a description of the variable, or of a hidden one with the value."""

from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.any_types import DESCRIPTION, class_of
from fieldrig_devices.iec.check import writing
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.untyped import Untyped
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.layout import storage
from fieldrig_devices.iec.program import (
    Cell,
    Constant,
    Description,
    Expression,
    Kept,
    Load,
    Place,
    Space,
    Variable,
)
from fieldrig_devices.iec.tree import Section
from fieldrig_devices.iec.types import Type

_LITERALS: Final = (Elementary.INT, Elementary.DINT, Elementary.LINT, Elementary.ULINT)
"""The types of an integer without one, of which the first that has the number is taken."""


def described(context: Context, value: Expression, at: tree.Node) -> Expression | None:
    """Return the description of a value; None after a message."""
    place = _place(context, value)
    if place is None:
        context.say(at, f"the {value.type} has no address for an ANY", "a variable")
        return None
    return Description(place, class_of(place.type), DESCRIPTION)


def _place(context: Context, value: Expression) -> Place | None:
    if isinstance(value, Load) and writing.has_cell(value.place):
        return value.place
    if isinstance(value, Constant):
        return _constant(context, value)
    if storage(value.type) is None or context.source is None:
        return None
    return Kept(value, context.hidden("any", value.type))


def _constant(context: Context, value: Constant) -> Place:
    """Return a hidden variable with a constant."""
    kind = _type_of(value)
    project = context.project
    name = f"$constant{len(project.globals)}"
    made = Variable(name, kind, Space.GLOBAL, Section.GLOBAL, value.value, is_constant=True)
    project.globals[context.key(name)] = made
    return Cell(made, kind)


def _type_of(value: Constant) -> Type:
    if type(value) is not Untyped:
        return value.type
    if value.is_real:
        return Elementary.LREAL
    return next(kind for kind in _LITERALS if kind.low <= int(value.value) <= kind.high or kind is _LITERALS[-1])
