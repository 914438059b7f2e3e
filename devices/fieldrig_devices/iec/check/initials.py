"""Start values: constants for every type, lists for arrays, named fields for structures and instances."""

from collections.abc import Sequence
from math import prod
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import startup
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.expressions import Expressions
from fieldrig_devices.iec.check.project import UNKNOWN, Start
from fieldrig_devices.iec.check.properties import name_to_write
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.program import Cell
from fieldrig_devices.iec.tree import Section
from fieldrig_devices.iec.types import (
    ArrayType,
    BlockType,
    InitialValue,
    ObjectType,
    StringType,
    StructType,
    Type,
)
from fieldrig_devices.languages.mistakes import Code

DEEPEST: Final = 40
"""Constants of which each is needed for the one before."""


def compute(start: Start, context: Context) -> None:
    """Work out the start value of one variable, once."""
    if start.is_done:
        return
    if context.project.depth >= DEEPEST:
        context.say(start.initial, f"constants depend on one another more than {DEEPEST} deep", "a value")
        start.is_done = True
        return
    if start.is_busy:
        context.say(start.initial, f"{start.variable.name} is defined by itself", "a constant")
        return
    start.is_busy = True
    context.project.depth += 1
    reports, before = context.project.reports, len(context.project.reports.mistakes)
    start.variable.initial = value(start.initial, start.variable.type, context)
    if start.variable.initial is None and startup.may_compute(context.project, start):
        new = reports.mistakes[before:]
        if any(mistake.code is Code.NOT_CONSTANT for mistake in new):
            reports.withdraw(before)
            context.project.computed[start.variable] = start
    context.project.depth -= 1
    start.is_done = True


def value(node: tree.Initial, kind: Type, context: Context) -> InitialValue | None:
    """Return the start value for a type; None after a message."""
    if kind is UNKNOWN:
        return None
    if isinstance(kind, ArrayType):
        return _array(node, kind, context)
    if isinstance(kind, StructType | BlockType):
        if isinstance(node, tree.StructInitial):
            return _fields(node, kind, context)
        if context.project.dialect.computes_starts and isinstance(node, tree.Name | tree.Member):
            return _of_variable(node, kind, context)
        context.say(node, f"a start value of {kind} without brackets", "(component := value, ...)")
        return None
    if isinstance(node, tree.StructInitial | tree.ArrayInitial):
        context.say(node, f"a list as the start value of {kind}", "one value")
        return None
    if isinstance(kind, ObjectType):
        context.say(node, f"a start value for a reference to {kind}", "no start value")
        return None
    constant = Expressions(context).constant_as(node, kind)
    if constant is None:
        return None
    if isinstance(kind, StringType) and isinstance(constant.value, str) and len(constant.value) > kind.length:
        context.note(node, f"the text has {len(constant.value)} characters and is cut to {kind.length}")
        return constant.value[: kind.length]
    return constant.value


# ---- structures


def _of_variable(node: tree.Name | tree.Member, kind: StructType | BlockType, context: Context) -> InitialValue | None:
    """Return the start value of a constant with the same type; what a variable has is known at run time only."""
    place = Expressions(context).place(node)
    if place is None:
        return None
    if place.type is not kind:
        context.say(node, f"{text(node)} is {a(place.type)}", str(kind))
        return None
    variable = place.variable if isinstance(place, Cell) else None
    if variable is None or not variable.is_constant:
        context.say(node, f"{text(node)} is not constant", "a value in brackets", code=Code.NOT_CONSTANT)
        return None
    start = context.project.starts.get(variable)
    if start is not None:
        context.project.compute(start)
    return variable.initial if start is not None else {}


def _fields(node: tree.StructInitial, kind: StructType | BlockType, context: Context) -> InitialValue | None:
    made: dict[str, InitialValue] = {}
    is_whole = True
    for field in node.fields:
        name = context.key(field.name)
        field_type = _field_type(kind, name)
        if field_type is None and _has_property(kind, context.key(name_to_write(field.name))):
            what = f"the property {field.name} is not constant"
            context.say(field, what, "a variable of the function block", code=Code.NOT_CONSTANT)
            is_whole = False
            continue
        if field_type is None:
            known = list(kind.fields) if isinstance(kind, StructType) else []
            hint = context.project.reports.closest(field.name, known)
            context.say(
                field, f"{kind} has no component {field.name}", ", ".join(known[:8]) or "an input or variable", hint
            )
            is_whole = False
            continue
        if name in made:
            context.say(field, f"{field.name} has two start values", "one value for each component")
        start = value(field.value, field_type, context)
        if start is None:
            is_whole = False
        else:
            made[name] = start
    return made if is_whole else None


def _has_property(kind: Type, writer: str) -> bool:
    return isinstance(kind, BlockType) and kind.pou is not None and writer in kind.pou.methods


def _field_type(kind: StructType | BlockType, name: str) -> Type | None:
    if isinstance(kind, StructType):
        field = kind.fields.get(name)
        return field.type if field is not None else None
    variable = kind.pou.variables.get(name) if kind.pou is not None else None
    is_known = variable is not None and variable.section not in (Section.IN_OUT, Section.TEMP)
    return variable.type if variable is not None and is_known else None


# ---- arrays


def _array(node: tree.Initial, kind: ArrayType, context: Context) -> InitialValue | None:
    """All elements have a start value or none (PD-361), unless the dialect fills the rest.

    Several dimensions are filled from one flat list.
    """
    elements: Sequence[tree.Initial | tree.Repeated] = node.elements if isinstance(node, tree.ArrayInitial) else (node,)
    counts, inner = [kind.count], kind.element
    is_nested = any(isinstance(getattr(part, "value", part), tree.ArrayInitial) for part in elements)
    while isinstance(inner, ArrayType) and not is_nested:
        counts.append(inner.count)
        inner = inner.element
    wanted = prod(counts)
    flat = _flat(elements, inner, wanted, context)
    if flat is None:
        return None
    if len(flat) < wanted and context.project.dialect.fills_arrays:
        return _nested(flat, counts)
    if len(flat) != wanted:
        context.say(
            node, f"{len(flat)} start values for {wanted} elements", "a value for every element or for none (PD-361)"
        )
        return None
    return _nested(flat, counts)


def _nested(flat: list[InitialValue], counts: Sequence[int]) -> list[InitialValue]:
    """Return the rows of an array of several dimensions, of which the last one may be incomplete."""
    for count in reversed(counts[1:]):
        flat = [flat[first : first + count] for first in range(0, len(flat), count)]
    return flat


def _flat(
    elements: Sequence[tree.Initial | tree.Repeated], inner: Type, most: int, context: Context
) -> list[InitialValue] | None:
    made: list[InitialValue] = []
    is_whole = True
    for part in elements:
        count, content = _repetition(part, context)
        start = value(content, inner, context) if content is not None else None
        if count is None or start is None:
            is_whole = False
        elif not 0 <= count <= most:
            context.say(part, f"{count} repetitions in an array of {most} elements", f"0 to {most}")
            return None
        else:
            made += [start] * count
    return made if is_whole else None


def _repetition(part: tree.Initial | tree.Repeated, context: Context) -> tuple[int | None, tree.Initial | None]:
    """The number and the value of `3(7)`, which looks like a call if the number is a named constant."""
    if isinstance(part, tree.Repeated):
        return Expressions(context).constant_integer(part.count), part.value
    if isinstance(part, tree.Call) and len(part.arguments) == 1:
        variable = _named(part.called, context)
        if variable is not None and getattr(variable, "is_constant", False):
            return Expressions(context).constant_integer(part.called), part.arguments[0].value
    return 1, part


def _named(node: tree.Expression, context: Context) -> object:
    """Return what a name means, also one with that of its list of global variables in front; None for anything else."""
    if isinstance(node, tree.Member) and isinstance(node.of, tree.Name):
        listed = context.project.lists.get(context.key(node.of.text), {}).get(context.key(node.name))
        return context.project.find(listed) if listed is not None else None
    return context.find(node.text) if isinstance(node, tree.Name) else None
