"""ADR, SIZEOF, INDEXOF and the functions of references, whose arguments are no values."""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import (
    constants,
    heap,
    library_names,
    open_arrays,
    references,
    writing,
)
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.project import UNKNOWN, Entity
from fieldrig_devices.iec.check.sizes import Sizes
from fieldrig_devices.iec.check.texts import text
from fieldrig_devices.iec.check.untyped import integer
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import (
    AddressOf,
    Binary,
    Cell,
    Constant,
    Expression,
    Operator,
    Place,
    Pou,
    Variable,
)
from fieldrig_devices.iec.types import OpenArrayType, StructType, Type


def _one_argument(checker: Checker, node: tree.Call) -> tree.Expression | None:
    if len(node.arguments) == 1 and node.arguments[0].value is not None:
        return node.arguments[0].value
    checker.context.say(node, f"{text(node.called)} with {len(node.arguments)} arguments", "one argument")
    return None


def address_of(checker: Checker, place: Place, at: tree.Node) -> Expression | None:
    """Return the address of a checked place, as a DWORD (PD-358)."""
    if not writing.has_cell(place):
        checker.context.say(
            at,
            f"{text(at)} has no address of its own",
            "a variable",
            "copy it into a variable first",
        )
        return None
    return AddressOf(place, Elementary.DWORD)


def _adr(checker: Checker, node: tree.Call) -> Expression | None:
    given = _one_argument(checker, node)
    place = _cell_of(checker, given) if given is not None else None
    return address_of(checker, place, given) if place is not None and given is not None else None


def _cell_of(checker: Checker, node: tree.Expression) -> Place | None:
    """The place of an argument, also of a constant, which has a cell too."""
    entity = checker.context.find(node.text) if isinstance(node, tree.Name) else None
    if isinstance(entity, Variable) and entity.is_constant:
        return Cell(entity, entity.type)
    return checker.place(node)


def _sizeof(checker: Checker, node: tree.Call) -> Expression | None:
    given = _one_argument(checker, node)
    if given is None:
        return None
    written = _written_type(checker, given)
    if written is not None:
        return _size(checker, given, written) if written is not UNKNOWN else None
    named = library_names.without_library(checker.context, given)
    if isinstance(named, tree.Name) and _may_be_type(checker.context.find(named.text)):
        kind = checker.context.project.named_type(named.text)
        if kind is not None:
            return _size(checker, given, kind)
    component = _component_type(checker, named)
    if component is not None:
        return _size(checker, given, component)
    if isinstance(named, tree.Name | tree.Member):
        entity = checker.meaning(given)
        if isinstance(entity, Place) and isinstance(entity.type, OpenArrayType):
            return _size_of_open(checker, given, entity.type)
        if entity is None:
            return None
    value = checker.expression(given)
    return _size(checker, given, value.type) if value is not None else None


def _written_type(checker: Checker, node: tree.Expression) -> Type | None:
    """Return a type that is no name alone, as in `SIZEOF(STRING(80))` or `SIZEOF(POINTER TO Pump)`; None for others."""
    is_text = isinstance(node, tree.Call) and text(node.called).upper() in ("STRING", "WSTRING")
    is_pointer = isinstance(node, tree.Unary) and node.operator == "POINTER TO"
    spec = heap.spec_of(node) if is_text or is_pointer else None
    specs = checker.context.project.specs
    return specs.resolve(spec, checker.context) if spec is not None and specs is not None else None


def _component_type(checker: Checker, node: tree.Expression) -> Type | None:
    """Return the type of a component of a type, as in `SIZEOF(Pair.first)`; None for anything else."""
    if not isinstance(node, tree.Member) or not checker.context.project.dialect.has_references:
        return None
    if isinstance(node.of, tree.Name):
        is_type = _may_be_type(checker.context.find(node.of.text))
        kind = checker.context.project.named_type(node.of.text) if is_type else None
    else:
        kind = _component_type(checker, node.of)
    field = kind.fields.get(checker.context.key(node.name)) if isinstance(kind, StructType) else None
    return field.type if field is not None else None


def _size_of_open(checker: Checker, at: tree.Node, kind: OpenArrayType) -> Expression | None:
    """Return the size of an ARRAY[*], which is that of the array that the call has passed."""
    count: Expression = Constant(1, Elementary.DINT)
    element: Type = kind
    while isinstance(element, OpenArrayType):
        low, high = open_arrays.ends(element)
        length = Binary(Operator.SUB, high, low, Elementary.DINT)
        length = Binary(Operator.ADD, length, Constant(1, Elementary.DINT), Elementary.DINT)
        count, element = Binary(Operator.MUL, count, length, Elementary.DINT), element.element
    size = _size(checker, at, element)
    if size is None:
        return None
    size = constants.converted(size, Elementary.DINT)
    return constants.converted(Binary(Operator.MUL, count, size, Elementary.DINT), Elementary.UDINT)


def _may_be_type(entity: Entity | None) -> bool:
    """True for a name that means nothing else than a type."""
    return entity is None or (isinstance(entity, Pou) and entity.kind.has_instances)


def _size(checker: Checker, at: tree.Node, kind: Type) -> Expression | None:
    if kind in checker.context.project.unfinished:
        checker.context.say(at, f"the size of {kind} depends on itself", "the size of another type")
        return None
    return integer(Sizes(checker.context.project).of(kind))


def _indexof(checker: Checker, node: tree.Call) -> Expression | None:
    given = _one_argument(checker, node)
    meaning = checker.meaning(given) if given is not None else None
    if meaning is None or given is None:
        return None
    if not isinstance(meaning, Pou):
        checker.context.say(given, f"{text(given)} is not a POU", "a program, function or function block")
        return None
    return integer(list(checker.context.project.pous.values()).index(meaning))


SPECIAL: Final[dict[str, Callable[[Checker, tree.Call], Expression | None]]] = {
    "ADR": _adr,
    "SIZEOF": _sizeof,
    "XSIZEOF": _sizeof,
    "INDEXOF": _indexof,
    **references.FUNCTIONS,
}
