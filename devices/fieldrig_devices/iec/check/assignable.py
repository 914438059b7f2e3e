"""Which value may become a value of another type by itself, and the message with the function to write if it may not.

This is the rule for assignments, arguments, start values and everything else that has a type to fill (PD-367).
"""

from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.any_types import DESCRIPTION
from fieldrig_devices.iec.check import any_inputs, check_functions, constants, dispatch, implicit
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.project import UNKNOWN
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.check.untyped import Untyped
from fieldrig_devices.iec.elementary import SHORT_TIMES, Elementary, Family
from fieldrig_devices.iec.library.integers import cut
from fieldrig_devices.iec.library.reals import single
from fieldrig_devices.iec.program import AddressOf, Component, Constant, Convert, Expression, Load
from fieldrig_devices.iec.types import (
    ArrayType,
    BlockType,
    EnumType,
    InterfaceType,
    ObjectType,
    PointerType,
    StringType,
    StructType,
    SubrangeType,
    Type,
)


def convert(context: Context, value: Expression, kind: Type, at: tree.Node) -> Expression | None:
    """Return the value as one of type `kind`; None after a message."""
    if kind is UNKNOWN or value.type is UNKNOWN:
        return None
    if kind is DESCRIPTION and value.type is not DESCRIPTION:
        return any_inputs.described(context, value, at)
    if type(value) is Untyped:
        return _literal(context, value, kind, at)
    source = value.type
    if source is kind:
        is_refused = type(kind) is BlockType and not context.project.dialect.copies_blocks
        return _no_instance(context, value, at) if is_refused else value
    if isinstance(kind, StringType) and isinstance(source, StringType) and kind.is_wide is source.is_wide:
        return value
    if source == kind:
        return value
    if isinstance(kind, StringType) and source is (Elementary.WCHAR if kind.is_wide else Elementary.CHAR):
        return constants.converted(value, kind)
    if isinstance(source, StringType) and kind is (Elementary.WCHAR if source.is_wide else Elementary.CHAR):
        return _character(context, value, kind, at)
    if isinstance(source, SubrangeType):
        return convert(context, constants.converted(value, source.base), kind, at)
    if isinstance(source, EnumType) and not isinstance(kind, EnumType):
        return convert(context, constants.converted(value, source.base), kind, at)
    if isinstance(kind, Elementary):
        return _elementary(context, value, kind, at)
    if isinstance(kind, SubrangeType):
        return _subrange(context, value, kind, at)
    if isinstance(kind, EnumType):
        return _enumeration(context, value, kind, at)
    if isinstance(kind, InterfaceType):
        return _interface(context, value, kind, at)
    if isinstance(kind, PointerType) and _is_address(context, source):
        return _pointer(value, kind)
    if isinstance(source, StructType) and isinstance(value, Load) and str(kind).casefold() in source.above:
        return Load(Component(value.place, 0, kind))  # what it begins with
    return _no(context, value, kind, at)


def _character(context: Context, value: Expression, kind: Type, at: tree.Node) -> Expression | None:
    """Return a constant of one character as such."""
    if isinstance(value, Constant) and len(str(value.value)) == 1:
        return constants.converted(value, kind)
    return _no(context, value, kind, at)


def _no_instance(context: Context, value: Expression, at: tree.Node) -> Expression | None:
    context.say(
        at, f"{text(at)} is an instance of {value.type} and cannot be copied", "a variable without a function block"
    )
    return None


def _interface(context: Context, value: Expression, kind: InterfaceType, at: tree.Node) -> Expression | None:
    """Return an instance of a block that implements an interface, or a variable of an interface that extends it."""
    source = value.type
    if isinstance(value, Constant) and value.value == 0:
        return Constant(0, kind)
    if isinstance(source, InterfaceType) and dispatch.extends(context.project, source, kind):
        return constants.converted(value, kind)
    block = source.pou if isinstance(source, BlockType) else None
    if isinstance(value, Load) and block is not None and dispatch.implements(context.project, block, kind):
        return AddressOf(value.place, kind)
    if isinstance(source, BlockType | InterfaceType):
        context.say(at, f"{text(at)} is {a(source)}", f"an instance of a block that implements {kind}")
        return None
    return _no(context, value, kind, at)


def _is_address(context: Context, kind: Type) -> bool:
    """True for pointers and integers; programs of today's tools compute with addresses of 64 bits, too."""
    most = 8 if context.project.dialect.has_long_addresses else 4
    return isinstance(kind, PointerType) or (isinstance(kind, Elementary) and kind.is_integer and kind.size <= most)


_OF_ADDRESSES: Final = frozenset({Elementary.DWORD, Elementary.UDINT, Elementary.DINT})
_OF_LONG_ADDRESSES: Final = frozenset({Elementary.LWORD, Elementary.ULINT, Elementary.LINT})


def _pointer(value: Expression, kind: PointerType) -> Expression:
    if isinstance(value, AddressOf):
        return AddressOf(value.place, kind)
    return constants.converted(value, kind)


def _elementary(context: Context, value: Expression, kind: Elementary, at: tree.Node) -> Expression | None:
    source = value.type
    is_long = kind in _OF_LONG_ADDRESSES and context.project.dialect.has_long_addresses
    if isinstance(source, PointerType) and (kind in _OF_ADDRESSES or is_long):
        return constants.converted(value, kind)
    if not isinstance(source, Elementary):
        return _no(context, value, kind, at)
    allowed = implicit.WIDENS if context.mixes_integers else implicit.STRICT
    if (source, kind) not in allowed:
        return _no(context, value, kind, at)
    if kind is Elementary.REAL and not implicit.is_exact(source, kind) and not isinstance(value, Constant):
        context.note(at, f"a REAL does not hold every {source}: 7 digits are kept", f"use {source}_TO_REAL({text(at)})")
    return constants.converted(value, kind)


def _subrange(context: Context, value: Expression, kind: SubrangeType, at: tree.Node) -> Expression | None:
    base = convert(context, value, kind.base, at)
    if isinstance(base, Constant):
        if not kind.low <= int(base.value) <= kind.high:
            context.say(at, f"{base.value} is outside the subrange", f"{kind.low} to {kind.high}")
            return None
        return Constant(base.value, kind)
    return Convert(check_functions.in_subrange(context, base, kind, at), kind) if base is not None else None


def _enumeration(context: Context, value: Expression, kind: EnumType, at: tree.Node) -> Expression | None:
    if isinstance(value.type, EnumType):
        is_same = value.type.values is kind.values  # one of the two is the input of a library's block
        return constants.converted(value, kind) if is_same else _no(context, value, kind, at)
    number = convert(context, value, kind.base, at)
    is_strict = kind.is_strict and not context.is_library
    if is_strict and number is not None and not isinstance(constants.folded(number), Constant):
        context.say(at, f"{text(at)} is no value of {kind}, which is strict", _values(kind))
        return None
    if isinstance(number, Constant):
        if (is_strict or not kind.takes_any) and number.value not in kind.values.values():
            context.say(at, f"{number.value} is no value of {kind}", _values(kind))
            return None
        return Constant(number.value, kind)
    return Convert(number, kind) if number is not None else None


def own_value(context: Context, value: Constant, wanted: Type | None, at: tree.Node) -> Constant:
    """Return a constant where a type is wanted: a name that several enumerations have means the value of that one."""
    if not isinstance(at, tree.Name) or not isinstance(wanted, EnumType) or not isinstance(value.type, EnumType):
        return value
    if value.type is wanted or not context.project.dialect.repeats_enumeration_values:
        return value
    numbers = context.project.values_of(wanted).items()
    own = (Constant(number, wanted) for name, number in numbers if context.key(name) == context.key(at.text))
    return next(own, value)


def _values(kind: EnumType) -> str:
    shown = [f"{name} ({number})" for name, number in kind.values.items()]
    return ", ".join(shown[:8]) + (", ..." if len(shown) > 8 else "")


# ---- constants without a type


def _literal(context: Context, value: Untyped, kind: Type, at: tree.Node) -> Expression | None:
    given = value.value
    assert not isinstance(given, str)
    if isinstance(kind, SubrangeType):
        return _subrange(context, value, kind, at)
    if isinstance(kind, EnumType):
        return _enumeration(context, value, kind, at)
    if isinstance(kind, InterfaceType) and given != 0:
        return _no(context, value, kind, at)
    if isinstance(kind, PointerType) and not value.is_real:
        address = _literal(context, value, Elementary.DWORD, at)
        return Constant(address.value, kind) if isinstance(address, Constant) else None
    if not isinstance(kind, Elementary):
        return _no(context, value, kind, at)
    if kind.is_real:
        return _real(context, value, kind, at)
    if value.is_real:
        return _no(context, value, kind, at)
    number = int(given)
    if kind.is_integer and value.is_pattern and 0 <= number < 2**kind.bits:
        return Constant(cut(number, kind), kind)
    if kind.is_integer or (kind.family is Family.TIME and context.project.dialect.allows_numbers_as_times):
        if kind.low <= number <= kind.high:
            return Constant(number, kind)
        context.say(at, f"{number} does not fit {kind}", f"{kind.low} to {kind.high}")
        return None
    if kind is Elementary.BOOL and number in (0, 1):
        return Constant(bool(number), kind)
    return _no(context, value, kind, at)


def _real(context: Context, value: Untyped, kind: Elementary, at: tree.Node) -> Expression | None:
    assert not isinstance(value.value, str)
    try:
        given = float(value.value)
    except OverflowError:
        given = float("inf")
    number = single(given) if kind is Elementary.REAL else given
    if number in (float("inf"), float("-inf")):
        context.say(
            at, f"{text(at)} does not fit {kind}", f"at most {'3.4E38' if kind is Elementary.REAL else '1.7E308'}"
        )
        return None
    return Constant(number, kind)


# ---- messages


def _no(context: Context, value: Expression, kind: Type, at: tree.Node) -> Constant | None:
    source = value.type
    if type(value) is Untyped:
        context.say(at, f"the number {value.value} is no {kind}", str(kind), _literal_hint(value, kind, at))
    else:
        context.say(at, f"{_value(at)} is {a(source)}", str(kind), _hint(source, kind, at))
    return None


def _value(at: tree.Node) -> str:
    return text(at) or "the value"


def _literal_hint(value: Untyped, kind: Type, at: tree.Node) -> str:
    if kind in SHORT_TIMES and not value.is_real:
        return f"write T#{value.value}ms for milliseconds"
    if kind is Elementary.BOOL:
        return "write TRUE or FALSE, or compare: x <> 0"
    if isinstance(kind, StringType):
        quote = '"' if kind.is_wide else "'"
        return f"write {quote}{value.value}{quote} for text"
    if isinstance(kind, Elementary) and kind.is_integer and value.is_real:
        return f"use REAL_TO_{kind}({text(at)}), which rounds, or TRUNC({text(at)})"
    return ""


def _hint(source: Type, kind: Type, at: tree.Node) -> str:
    if isinstance(source, ArrayType | PointerType) and isinstance(kind, Elementary | StringType):
        return (
            f"choose an element: {text(at) or 'x'}[...]"
            if isinstance(source, ArrayType)
            else f"{text(at) or 'p'}^ is what it points to"
        )
    if isinstance(source, ObjectType) and isinstance(kind, Elementary):
        return f"{text(at)}.logAdr is its logical address"
    before, after = _conversion_name(source), _conversion_name(kind)
    if isinstance(source, EnumType) and isinstance(kind, EnumType):
        return f"write a value of {kind}"
    if not before or not after:
        return ""
    shown = f"{before}_TO_{after}({text(at) or '...'})"
    if isinstance(source, Elementary) and isinstance(kind, Elementary):
        if source.is_integer and kind.is_integer:
            return f"use {shown} if cutting is meant"
        if source.is_real and kind.is_integer:
            return f"use {shown}, which rounds, or TRUNC"
        if source is Elementary.LREAL and kind is Elementary.REAL:
            return f"use {shown} if 7 digits are enough"
    return f"use {shown}"


def _conversion_name(kind: Type) -> str:
    if isinstance(kind, SubrangeType | EnumType):
        return kind.base.name
    return kind.name if isinstance(kind, StringType) else str(kind) if isinstance(kind, Elementary) else ""
