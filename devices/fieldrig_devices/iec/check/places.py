"""The meaning of a name or a path such as belt.axis[3].pos: a place in memory, a constant, a POU or an enumeration."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import (
    access,
    check_functions,
    dispatch,
    elements,
    enable,
    library_names,
    methods,
    properties,
)
from fieldrig_devices.iec.check.checker import Checker, Meaning
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.located import located
from fieldrig_devices.iec.check.project import UNKNOWN
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import (
    AddressOf,
    Bit,
    CallFunction,
    Cell,
    Component,
    Constant,
    Element,
    Expression,
    Kept,
    Load,
    OpenElement,
    Parameter,
    Place,
    Pou,
    Result,
    Space,
    Target,
    This,
    Variable,
)
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import (
    SCALAR,
    ArrayType,
    BlockType,
    EnumType,
    InterfaceType,
    ObjectType,
    PointerType,
    StructType,
    Type,
)

LOGICAL_ADDRESS: Final = "logadr"
"""The component of every configuration object that is its logical address (PD-025)."""


def meaning(checker: Checker, node: tree.Expression) -> Meaning | None:
    """Return what the name or path means; None after a message."""
    named = itself(checker, node)
    kind = named.type if isinstance(named, Place) else None
    if isinstance(named, Place) and isinstance(kind, PointerType) and kind.is_reference:
        return Target(check_functions.address(checker.context, Load(named), node), kind.to)
    return named


def itself(checker: Checker, node: tree.Expression) -> Meaning | None:
    """Return the same, but a REFERENCE TO itself instead of what it refers to."""
    reading = properties.reading(checker, node) if checker.context.project.properties else None
    if reading is not None:
        return _result(checker, reading[0]) if reading else None
    node = library_names.without_library(checker.context, node)
    find = _MEANINGS.get(type(node))
    if find is not None:
        return find(checker, node)
    checker.context.say(node, f"{text(node)} is a value", "a variable")
    return None


def _name(checker: Checker, node: tree.Name) -> Meaning | None:
    context = checker.context
    entity = context.find(node.text)
    if type(entity) is Variable:
        if context.project.guards and not access.allows_variable(context, entity, node):
            return None
        return variable(context, entity)
    if entity is None:
        action = context.block.actions.get(context.key(node.text)) if context.block is not None else None
        if action is not None:
            return action
        if methods.is_this(context, node) and not methods.is_super(context, node):
            return _this(context)
        if node.text.upper() == "NULL" and context.project.dialect.has_references:
            return Constant(0, Elementary.DWORD)
        own = enable.meaning(context, node.text)
        hint = enable.hint(context, node.text)
        if hint:
            context.say(node, f"{node.text} is not declared", "a name from a declaration", hint)
        elif own is None:
            context.say_unknown(node, node.text)
        return own
    assert not isinstance(entity, Variable)
    is_called = isinstance(entity, Pou) and entity.kind is not PouKind.PROGRAM
    if is_called and context.key(node.text) in context.project.enumerated:
        return _enumerated(context, node.text)
    return entity


def _enumerated(context: Context, name: str) -> Constant:
    """Return the value of an enumeration whose name is that of a POU too."""
    kind = context.project.enumerated[context.key(name)][0]
    numbers = context.project.values_of(kind).items()
    return next(Constant(number, kind) for known, number in numbers if context.key(known) == context.key(name))


def variable(context: Context, declared: Variable) -> Place | Constant | None:
    """Return the cell of a variable; its value if it is a constant with one."""
    kind = declared.type
    if declared.is_constant and isinstance(kind, SCALAR) and not declared.is_reference:
        value = context.project.constant_of(declared)
        return Constant(value, kind) if value is not None else None
    if declared.location is not None:
        return declared.location
    return Cell(declared, kind)


# ---- components


def _member(checker: Checker, node: tree.Member) -> Meaning | None:
    if methods.is_this(checker.context, node.of):
        return _own(checker.context, node)
    listed = _of_list(checker.context, node)
    if listed is not None:
        return variable(checker.context, listed)
    owner = _owner(checker, node)
    if owner is None:
        return None
    match owner:
        case EnumType():
            return _value_of(checker.context, owner, node)
        case Pou() if owner.kind is PouKind.PROGRAM and owner.instance is not None and owner.owner is None:
            instance = owner.instance
            return _pin(checker.context, Cell(instance, instance.type), owner, node)
        case Pou():
            checker.context.say(
                node, f"{owner.name} is {a(owner.kind.value)}, not a variable", "an instance in front of the point"
            )
            return None
        case Constant():
            return _of_object(checker.context, owner, owner.type, node)
    kind = owner.type
    if isinstance(kind, StructType):
        return _field(checker.context, owner, kind, node)
    if isinstance(kind, BlockType) and kind.pou is not None:
        return _pin(checker.context, owner, kind.pou, node)
    if isinstance(kind, InterfaceType):
        known = [
            name.partition("@")[0] for name in checker.context.project.facades[checker.context.key(str(kind))].methods
        ]
        hint = checker.context.project.reports.closest(node.name, known)
        checker.context.say(node, f"{kind} has no method or property {node.name}", ", ".join(known[:8]), hint)
        return None
    return _named_bit(checker, node) or _of_object(checker.context, Load(owner), kind, node)


def _named_bit(checker: Checker, node: tree.Member) -> Meaning | None:
    """Return the bit with the number of a constant, `word.ready`; None for anything else."""
    declared = checker.context.find(node.name)
    if type(declared) is not Variable or not declared.is_constant or not checker.context.project.dialect.has_named_bits:
        return None
    number = checker.context.project.constant_of(declared)
    return meaning(checker, tree.BitOf(node.of, number, position=node.position)) if type(number) is int else None


def _own(context: Context, node: tree.Member) -> Meaning | None:
    """The meaning of `THIS^.name`: a variable or an action of the instance whose code runs."""
    source, name = context.source, context.key(node.name)
    assert source is not None
    declared = (source.outer or source).names.get(name)
    if declared is not None and not context.is_temporary_of_block(name):
        return variable(context, declared) if access.allows_variable(context, declared, node) else None
    action = context.block.actions.get(name) if context.block is not None else None
    if action is None and not context.project.lacks_base(context.block):
        context.say(node, f"{text(node)} is not declared", "a variable, action or method of the function block")
    return action


def _this(context: Context) -> Place | None:
    block = context.block
    assert block is not None
    assert block.type is not None
    return Cell(block.instance, block.type) if block.instance is not None else This(block.type)


def _of_list(context: Context, node: tree.Member) -> Variable | None:
    """The variable that `list.variable` means; None if the name in front is no list of global variables."""
    if not context.project.lists:
        return None
    front = library_names.without_library(context, node.of)
    if not isinstance(front, tree.Name) or context.find(front.text) is not None:
        return None
    name = context.key(node.name)
    full = context.project.lists.get(context.key(front.text), {}).get(name)
    entity = context.project.find(full) if full is not None else None
    return entity if isinstance(entity, Variable) else None


def _owner(checker: Checker, node: tree.Member) -> Meaning | None:
    """The meaning in front of the point; also a type, whose enumeration value follows.

    A variable without components may have the name of the type.
    """
    named = library_names.without_library(checker.context, node.of)
    if isinstance(named, tree.Name):
        kind, known = (
            checker.context.project.types.get(checker.context.key(named.text)),
            checker.context.find(named.text),
        )
        if isinstance(kind, EnumType) and (known is None or isinstance(getattr(known, "type", None), SCALAR)):
            return kind
    owner = meaning(checker, node.of)
    return None if isinstance(owner, Place) and owner.type is UNKNOWN else owner


def _value_of(context: Context, kind: EnumType, node: tree.Member) -> Constant | None:
    for name, number in context.project.values_of(kind).items():
        if context.key(name) == context.key(node.name):
            return Constant(number, kind)
    context.say(node, f"{kind} has no value {node.name}", ", ".join(list(kind.values)[:8]))
    return None


def _field(context: Context, owner: Place, kind: StructType, node: tree.Member) -> Place | None:
    field = kind.fields.get(context.key(node.name))
    if field is None:
        known = kind.fields
        hint = context.project.reports.closest(node.name, known) or _it_has(list(known))
        context.say(node, f"{kind} has no component {node.name}", "a component of the structure", hint)
        return None
    stored = Elementary.BYTE if field.bit >= 0 else field.type
    place: Place
    if kind.is_union:
        place = Target(AddressOf(owner, Elementary.DWORD), stored)
    else:
        place = Component(owner, field.offset, stored)
        context.project.components.append((place, field))
    return Bit(place, field.bit) if field.bit >= 0 else place


def _it_has(names: Sequence[str]) -> str:
    return f"it has {', '.join(names[:8])}" if names else "it has none"


def _pin(context: Context, owner: Place, pou: Pou, node: tree.Member) -> Meaning | None:
    """A variable of an instance: inputs and outputs of a function block, every variable of a program."""
    declared = pou.variables.get(context.key(node.name))
    if declared is None or enable.is_implicit(context, pou, declared):
        # Those that extend a block have their ENO elsewhere.
        declared = enable.of_instance(context, pou, node.name) if dispatch.general(owner) is None else None
    if declared is None:
        action = pou.actions.get(context.key(node.name))
        if action is not None:
            return action
        if context.project.lacks_base(pou):
            return None
        known = [pin for pin in pou.variables.values() if pin.section in (Section.INPUT, Section.OUTPUT)]
        pins = [pin.name for pin in known]
        callable_names = [name for name in pou.methods if "@" not in name]
        hint = context.project.reports.closest(node.name, [*pins, *callable_names]) or _it_has(pins)
        context.say(node, f"{pou.name} has no variable {node.name}", "an input or output", hint)
        return None
    if pou.kind is PouKind.CLASS and not access.is_open(context.project, declared) and context.extension is None:
        guard = context.project.guards.get(declared)
        if guard is None:
            return None  # its section has a message
        word = guard.word
        hint = "declare it in VAR PUBLIC, or write a method that returns it"
        context.say(node, f"{declared.name} is {word} in {pou.name}", "a variable in VAR PUBLIC", hint)
        return None
    is_inside = pou.kind is PouKind.FUNCTION_BLOCK and declared.section not in (Section.INPUT, Section.OUTPUT)
    is_readable = context.project.dialect.reads_locals and not access.is_hidden(context.project, declared)
    is_readable = is_readable or context.extension is not None  # a test sees what is inside
    is_inside = is_inside and not access.is_open(context.project, declared) and not is_readable
    if is_inside or declared.section in (Section.IN_OUT, Section.TEMP):
        context.say(
            node,
            f"{declared.name} is {a(declared.section.value)} of {pou.name} and not known outside",
            "an input or output of the instance",
            "declare it as VAR_OUTPUT to read it from outside",
        )
        return None
    if declared.is_constant or declared.location is not None:
        return variable(context, declared)
    return Component(owner, 0, declared.type, declared)


def _of_object(context: Context, owner: Expression, kind: Type, node: tree.Member) -> Place | Constant | None:
    if not isinstance(kind, ObjectType):
        context.say(
            node, f"{text(node.of)} is {a(kind)} and has no components", "a structure, an instance or an object"
        )
        return None
    if context.key(node.name) == LOGICAL_ADDRESS:
        return _logical_address(owner)
    declared = kind.parameter(node.name)
    if declared is None:
        names = [parameter.name for parameter in kind.parameters]
        hint = context.project.reports.closest(node.name, [name.casefold() for name in names])
        context.say(node, f"{kind} has no parameter {node.name}", "a parameter of the object", hint)
        return None
    return Parameter(owner, kind, declared.number, declared.type, declared.is_slow, declared.is_writable)


def _logical_address(owner: Expression) -> Place | Constant:
    if isinstance(owner, Constant):
        return Constant(owner.value, Elementary.DINT)
    assert isinstance(owner, Load)
    return _as_number(owner.place)


def _as_number(place: Place) -> Place:
    """The same cell, read as the DINT that a reference to an object is."""
    if isinstance(place, Cell):
        return Cell(place.variable, Elementary.DINT)
    if isinstance(place, Component):
        return Component(place.of, place.offset, Elementary.DINT, place.variable)
    if isinstance(place, Element | OpenElement):
        return replace(place, type=Elementary.DINT)
    assert isinstance(place, Target)
    return Target(place.pointer, Elementary.DINT)


# ---- pointers, results, addresses


def _dereference(checker: Checker, node: tree.Dereference) -> Place | None:
    if methods.is_this(checker.context, node) and not methods.is_super(checker.context, node):
        return _this(checker.context)
    if isinstance(node.of, tree.Call):
        value = checker.expression(node.of)
        if value is None or not isinstance(value.type, PointerType) or isinstance(value.type, InterfaceType):
            pointer = checker.place(node.of) if value is not None else None
        else:
            return Target(check_functions.address(checker.context, value, node), value.type.to)
    else:
        pointer = checker.place(node.of)
    if pointer is None:
        return None
    if not isinstance(pointer.type, PointerType) or isinstance(pointer.type, InterfaceType):
        checker.context.say(node, f"{text(node.of)} is {a(pointer.type)}", "a pointer in front of ^")
        return None
    return Target(check_functions.address(checker.context, Load(pointer), node), pointer.type.to)


def _result(checker: Checker, node: tree.Call) -> Place | None:
    """The result of a call: what a reference refers to, or a structure or array of which a part is read."""
    value = checker.expression(node)
    if isinstance(value, Load):
        return value.place
    if isinstance(value, CallFunction) and isinstance(value.type, StructType | ArrayType):
        return Result(value)
    if value is not None and isinstance(value.type, BlockType) and checker.context.source is not None:
        return Kept(value, checker.context.hidden("result", value.type, Space.FRAME))
    if value is not None and isinstance(value.type, InterfaceType):
        return Target(value, value.type.to)
    if value is not None:
        checker.context.say(node, f"{text(node)} is a value", "a variable")
    return None


def _direct(checker: Checker, node: tree.Direct) -> Place | None:
    return located(node, checker.context)


_MEANINGS: Final[dict[type, Callable[[Checker, Any], Meaning | None]]] = {
    tree.Name: _name,
    tree.Member: _member,
    tree.BitOf: elements.bit_of,
    tree.Index: elements.index,
    tree.Dereference: _dereference,
    tree.Direct: _direct,
    tree.Call: _result,
}
