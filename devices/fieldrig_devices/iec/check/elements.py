"""Parts of a value: bits, elements of arrays, what is behind a pointer, and characters of strings."""

from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import (
    check_functions,
    constants,
    open_arrays,
    writing,
)
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.operators import integer_of, plain
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.check.untyped import Untyped
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import (
    AddressOf,
    Binary,
    Bit,
    Constant,
    Convert,
    Element,
    Expression,
    Load,
    OpenElement,
    Operator,
    Place,
    Target,
)
from fieldrig_devices.iec.types import (
    SCALAR,
    ArrayType,
    OpenArrayType,
    PointerType,
    StringType,
    SubrangeType,
    Type,
)

PARTS: Final = {"B": Elementary.BYTE, "W": Elementary.WORD, "D": Elementary.DWORD, "L": Elementary.LWORD}
"""The types of the parts of a value, by the letter behind %."""


def bit_of(checker: Checker, node: tree.BitOf) -> Place | None:
    owner = checker.place(node.of)
    if owner is None:
        return None
    kind = owner.type.base if isinstance(owner.type, SubrangeType) else owner.type
    if not isinstance(kind, Elementary) or not kind.is_integer:
        checker.context.say(node, f"{text(node.of)} is {a(owner.type)} and has no bits", "an integer or bit string")
        return None
    if node.size:
        return _part_of(checker, node, owner, kind)
    if node.number >= kind.bits:
        checker.context.say(node, f"{kind} has no bit {node.number}", f"0 to {kind.bits - 1}")
        return None
    return Bit(owner, node.number)


def _part_of(checker: Checker, node: tree.BitOf, owner: Place, kind: Elementary) -> Place | None:
    """A byte or word of a larger value, which is in memory with its lowest byte first."""
    part = PARTS[node.size]
    count = kind.size // part.size
    if count < 2 or node.number >= count:
        expected = f"%{node.size}0 to %{node.size}{count - 1}" if count > 1 else "a smaller part"
        checker.context.say(node, f"{kind} has no part %{node.size}{node.number}", expected)
        return None
    if not writing.has_cell(owner):
        checker.context.say(node, f"{text(node.of)} has no parts", "a variable", "copy it into a variable first")
        return None
    offset = Constant(node.number * part.size, Elementary.DWORD)
    where = Binary(Operator.ADD, AddressOf(owner, Elementary.DWORD), offset, Elementary.DWORD)
    return Target(where, part)


def index(checker: Checker, node: tree.Index) -> Place | None:
    place: Place | None = checker.place(node.of)
    for position, index in enumerate(node.indices):
        value = checker.expression(index)
        if place is None:
            return None
        kind = place.type
        if _is_indexed(checker.context, kind) and value is not None:
            place = _behind(checker.context, place, value, index)
            continue
        if isinstance(kind, OpenArrayType):
            opened = _open_element(checker.context, place, kind, value, index) if value is not None else None
            if opened is None:
                return None
            place = opened
            continue
        if not isinstance(kind, ArrayType):
            what = f"{text(node.of)} is {a(kind)}, not an array"
            if position:
                what = f"the array {text(node.of)} has {position} dimension{'s' * (position > 1)}"
            checker.context.say(
                node, what, f"{position} {'indices' if position > 1 else 'index'}" if position else "an array"
            )
            return None
        made = _subscript(checker.context, value, kind, index) if value is not None else None
        if made is None:
            return None
        limits = (check_functions.limit(kind.low), check_functions.limit(kind.high))
        made = check_functions.index(checker.context, made, *limits, index)
        place = Element(place, made, kind.low, kind.high, kind.element.size, kind.element)
        if not isinstance(kind.element, SCALAR):
            checker.context.project.elements.append(place)
    return place


def _open_element(
    context: Context, array: Place, kind: OpenArrayType, value: Expression, node: tree.Node
) -> OpenElement | None:
    """The element of an ARRAY[*]."""
    number = _subscript(context, value, ArrayType(Elementary.DINT.low, Elementary.DINT.high, kind.element), node)
    if number is None:
        return None
    low, high = open_arrays.ends(kind)
    return OpenElement(array, check_functions.index(context, number, low, high, node), kind, kind.element)


def _is_indexed(context: Context, kind: Type) -> bool:
    """True for pointers and strings in the dialects in which they have elements."""
    dialect = context.project.dialect
    is_text = isinstance(kind, StringType)
    return (dialect.indexes_pointers and (is_text or isinstance(kind, PointerType))) or (
        dialect.has_characters_of_strings and is_text
    )


def _behind(context: Context, place: Place, value: Expression, node: tree.Node) -> Place | None:
    """The element of a pointer or string, whose number counts from 0; that of a string in the standard from 1."""
    kind, part = place.type, place.type
    if isinstance(kind, StringType) and not context.project.dialect.indexes_pointers:
        part = Elementary.WCHAR if kind.is_wide else Elementary.CHAR
        number = _subscript(context, value, ArrayType(1, kind.length, part), node)
        if number is not None and not isinstance(number, Constant):
            number = Convert(
                constants.converted(number, Elementary.DINT), SubrangeType(Elementary.DINT, 1, kind.length)
            )
        in_front = Constant(part.size, Elementary.DWORD)
        start: Expression = Binary(Operator.SUB, AddressOf(place, Elementary.DWORD), in_front, Elementary.DWORD)
    elif isinstance(kind, StringType):
        part = Elementary.WORD if kind.is_wide else Elementary.BYTE
        number = _subscript(context, value, ArrayType(0, kind.length, part), node)
        start = AddressOf(place, Elementary.DWORD)
    else:
        assert isinstance(kind, PointerType)
        part = kind.to
        number = _subscript(context, value, ArrayType(Elementary.DINT.low, Elementary.DINT.high, part), node)
        start = Convert(check_functions.address(context, Load(place), node), Elementary.DWORD)
    if number is None:
        return None
    stride = Constant(part.size, Elementary.DINT)
    if not isinstance(part, SCALAR):
        context.project.strides.append((stride, part))
    steps = Binary(Operator.MUL, constants.converted(number, Elementary.DINT), stride, Elementary.DINT)
    offset = constants.converted(steps, Elementary.DWORD)
    return Target(Binary(Operator.ADD, start, offset, Elementary.DWORD), part)


def _subscript(context: Context, value: Expression, kind: ArrayType, node: tree.Node) -> Expression | None:
    if type(value) is Untyped and not value.is_real:
        value = Constant(value.value, Elementary.DINT)
    value = constants.whole(value)
    if integer_of(value) is None:
        context.say(node, f"the index is {a(value.type)}", "an integer")
        return None
    if isinstance(value, Constant) and not kind.low <= int(value.value) <= kind.high:
        context.say(node, f"the index {value.value} is outside the array", f"{kind.low} to {kind.high}")
        return None
    return plain(value)
