"""ARRAY[*]: arguments that are arrays with any limits, and LOWER_BOUND and UPPER_BOUND.

Source: IEC 61131-3:2013, 6.5.3 and table 15.  They are inputs, outputs and in-outs of functions and methods, and
in-outs of function blocks.  All of them pass the array itself: of an input no copy is made, so no code may change it.
The caller also passes the limits, in two hidden variables for each dimension.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import constants
from fieldrig_devices.iec.check.checker import Checker, Types
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.operators import integer_of, plain
from fieldrig_devices.iec.check.project import UNKNOWN, PouSource
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.check.untyped import integer
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import (
    Cell,
    Constant,
    Element,
    Expression,
    Load,
    Place,
    Pou,
    Space,
    Variable,
)
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import ArrayType, OpenArrayType, Type

FUNCTIONS: Final = frozenset({"LOWER_BOUND", "UPPER_BOUND"})
LIMIT: Final = Elementary.DINT
"""The type of the limits, and of LOWER_BOUND and UPPER_BOUND where no other integer is wanted."""
_PLACES: Final = {
    PouKind.FUNCTION: (Section.INPUT, Section.OUTPUT, Section.IN_OUT),
    PouKind.FUNCTION_BLOCK: (Section.IN_OUT,),
}


# ---- declarations


def declared(types: Types, node: tree.Variable, section: Section, source: PouSource | None, context: Context) -> Type:
    """Return the type of a declared variable; with the variables for the limits of an ARRAY[*]."""
    allowed = _PLACES.get(source.pou.kind, ()) if source is not None else ()
    if source is None or section not in allowed:
        return types.resolve(node.type, context)
    kind, made = argument(types, node, source.pou, context)
    source.pou.variables |= {variable.name.casefold(): variable for variable in made}
    return kind


def argument(types: Types, node: tree.Variable, pou: Pou | None, context: Context) -> tuple[Type, list[Variable]]:
    """Return the type of an argument of a POU, or of an interface, and the variables for the limits of an ARRAY[*]."""
    spec, made = node.type, list[Variable]()
    if not isinstance(spec, tree.OpenArraySpec):
        return types.resolve(spec, context), made
    kind = types.resolve(spec.element, context)
    most = context.project.dialect.array_dimensions
    if spec.count > most:
        context.say(spec, f"an array of {spec.count} dimensions", f"1 to {most} dimensions (PD-361)")
        return UNKNOWN, made
    if kind is UNKNOWN:
        return UNKNOWN, made
    is_function = pou is None or pou.kind is PouKind.FUNCTION
    space, section = (Space.FRAME, Section.INPUT) if is_function else (Space.INSTANCE, Section.LOCAL)
    names = (f"${node.name}.{end}{number}" for number in range(1, spec.count + 1) for end in ("low", "high"))
    made = [Variable(name, LIMIT, space, section, position=node.position, file=context.file) for name in names]
    return _around(kind, made), made


def _around(kind: Type, made: Sequence[Variable]) -> Type:
    """Return the type of an array with these limits, the first dimension first."""
    for low, high in zip(made[-2::-2], made[::-2], strict=True):
        kind = OpenArrayType(kind, (low, high))
    return kind


def renew_limits(variable: Variable) -> list[Variable]:
    """Give the copy of an argument limits of its own, and return these; none if it is no ARRAY[*]."""
    kind, made = variable.type, list[Variable]()
    while isinstance(kind, OpenArrayType):
        made += [replace(limit) for limit in kind.limits]
        kind = kind.element
    variable.type = _around(kind, made)
    return made


# ---- arguments


def is_open(variable: Variable) -> bool:
    return isinstance(variable.type, OpenArrayType)


def fits(given: Type, wanted: Type) -> bool:
    """True if an array of one type is an argument of the other: it has as many dimensions, and the same elements."""
    while isinstance(wanted, OpenArrayType):
        if not isinstance(given, ArrayType | OpenArrayType):
            return False
        if isinstance(given, ArrayType) and (given.low < LIMIT.low or given.high > LIMIT.high):
            return False
        given, wanted = given.element, wanted.element
    return given == wanted


def limits(variable: Variable, place: Place) -> Iterator[tuple[Variable, Expression]]:
    """Yield the arguments for the limits of an ARRAY[*]; none for other variables."""
    wanted, given = variable.type, place.type
    while isinstance(wanted, OpenArrayType) and isinstance(given, ArrayType | OpenArrayType):
        yield from zip(wanted.limits, ends(given), strict=True)
        wanted, given = wanted.element, given.element


def ends(kind: ArrayType | OpenArrayType) -> tuple[Expression, Expression]:
    """Return the lowest and the highest index."""
    if isinstance(kind, ArrayType):
        return Constant(kind.low, LIMIT), Constant(kind.high, LIMIT)
    low, high = kind.limits
    return Load(Cell(low, LIMIT)), Load(Cell(high, LIMIT))


# ---- LOWER_BOUND and UPPER_BOUND


def bound(checker: Checker, node: tree.Call, wanted: Type | None) -> Expression | None:
    """Check LOWER_BOUND(array, dimension) or UPPER_BOUND, whose result is an integer of the type that is wanted."""
    name = text(node.called).upper()
    given = _array_and_dimension(checker, node, name)
    place = checker.place(given[0]) if given is not None else None
    index = checker.expression(given[1]) if given is not None else None
    if place is None or index is None or given is None:
        return None
    kinds = list(_dimensions(place.type))
    if not kinds:
        checker.context.say(given[0], f"{text(given[0])} is {a(place.type)}", "an array")
        return None
    if not isinstance(index, Constant) and all(isinstance(kind, OpenArrayType) for kind in kinds):
        return _in(_chosen(checker, kinds, index, given[1], is_high=name == "UPPER_BOUND"), wanted)
    number = checker.constant_integer(given[1])
    if number is None:
        return None
    if not 1 <= number <= len(kinds):
        expected = "1" if len(kinds) == 1 else f"1 to {len(kinds)}"
        checker.context.say(given[1], f"{text(given[0])} has no dimension {number}", expected)
        return None
    kind, is_high = kinds[number - 1], name == "UPPER_BOUND"
    if isinstance(kind, ArrayType):
        return integer(kind.high if is_high else kind.low)
    return _in(ends(kind)[is_high], wanted)


def _in(value: Expression | None, wanted: Type | None) -> Expression | None:
    is_integer = isinstance(wanted, Elementary) and wanted.is_integer
    return constants.converted(value, wanted) if value is not None and is_integer and wanted is not None else value


def _chosen(
    checker: Checker, kinds: Sequence[Type], index: Expression, node: tree.Expression, *, is_high: bool
) -> Expression | None:
    """Return a limit of the dimension with this number; other numbers are a fault at run time.

    The limits of all dimensions follow one another in memory, so they are an array themselves.
    """
    first = kinds[0]
    assert isinstance(first, OpenArrayType)
    if integer_of(index) is None:
        checker.context.say(node, f"the dimension is {a(index.type)}", "an integer")
        return None
    start = Cell(first.limits[is_high], LIMIT)
    return Load(Element(start, plain(index), 1, len(kinds), 2 * LIMIT.size, LIMIT))


def _dimensions(kind: Type) -> Iterator[ArrayType | OpenArrayType]:
    while isinstance(kind, ArrayType | OpenArrayType):
        yield kind
        kind = kind.element


def _array_and_dimension(
    checker: Checker, node: tree.Call, name: str
) -> tuple[tree.Expression, tree.Expression] | None:
    names = [argument.name.upper() for argument in node.arguments]
    values = [argument.value for argument in node.arguments if not argument.is_output]
    if len(values) == len(names) == 2 and names in (["", ""], ["ARR", "DIM"], ["DIM", "ARR"]):
        first, second = values if names[0] != "DIM" else reversed(values)
        if first is not None and second is not None:
            return first, second
    checker.context.say(node, f"{name} with other arguments than its own", f"{name}(array, 1)")
    return None
