"""The arguments of standard functions that a 32-bit target has computed in its registers.

Arithmetic with smaller integers has 32 bits there, and its result is cut when it is stored or converted, not before:
CODESYS Online Help, "Operators", overflow and underflow in the data type; `TO_WORD(w + 1)` cuts, `TO_DINT(i + i)` does
not.  A shift works on all 32 bits of such a result, and on the bits of its type for a variable; a rotation always works
on the bits of the type.
"""

from collections.abc import Sequence
from typing import Final

from fieldrig_devices.iec.check import constants
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.untyped import Untyped
from fieldrig_devices.iec.elementary import Elementary, Family
from fieldrig_devices.iec.library import conversions
from fieldrig_devices.iec.library.arguments import plain, widens
from fieldrig_devices.iec.program import Constant, Expression
from fieldrig_devices.iec.types import Type

ARITHMETIC: Final = frozenset({"ABS", "EXPT"})
"""Functions that compute in 32 bits themselves."""
OF_THEIR_ARGUMENTS: Final = frozenset({*ARITHMETIC, "MAX", "MIN", "LIMIT", "SEL", "MUX", "MOVE", "SHL", "SHR"})
"""Functions whose result has the type of their arguments, and which have 32 bits where these have them."""


def whole_arguments(
    context: Context, name: str, values: Sequence[Expression], parameters: Sequence[Type]
) -> list[Expression] | None:
    """Return the arguments with all of their 32 bits; None if this makes no difference to the result."""
    whole = [constants.whole(value) for value in values]
    if name in ARITHMETIC and context.computes_in_32_bits:
        whole = [_wide(value, kind) for value, kind in zip(whole, parameters, strict=True)]
    return None if all(one is value for one, value in zip(whole, values, strict=True)) else whole


def _wide(value: Expression, kind: Type) -> Expression:
    """Return an argument of a smaller integer type in 32 bits."""
    if not isinstance(kind, Elementary) or not kind.is_integer or kind.size >= 4:
        return value
    register = constants.REGISTER[kind.family]
    return Constant(value.value, register) if type(value) is Untyped else constants.converted(value, register)


def conversion(name: str, values: Sequence[Expression]) -> tuple[str, Sequence[Expression]]:
    """Return a conversion with its argument of 32 bits: TO_DINT(a + b), and INT_TO_DINT(a + b), cut nothing before."""
    key = name.upper()
    source, target = _of_name(key)
    value = constants.whole(values[0]) if len(values) == 1 else None
    if target is None or value is None or value is values[0]:
        return name, values
    given, kind = values[0].type, value.type
    assert isinstance(kind, Elementary)
    if source is not None and (not widens(given, source) or not _has_sign_of(source, kind)):
        return name, values
    return f"TO_{target.name}", [value]


def _of_name(key: str) -> tuple[Elementary | None, conversions.Plain | None]:
    """Return the smaller integer that a name such as INT_TO_REAL begins with, and the target; TO_REAL has no source."""
    pair = conversions.pair(key)
    if pair is None:
        return None, next((conversions.named(key.removeprefix(head)) for head in _HEADS if key.startswith(head)), None)
    source, target = pair
    is_small = isinstance(source, Elementary) and source.is_integer and source.size < 4
    return (source, target) if is_small and isinstance(source, Elementary) else (None, None)


_HEADS: Final = ("TO_", "ANY_TO_")


def _has_sign_of(source: Elementary, register: Elementary) -> bool:
    return source.is_signed is register.is_signed


# ---- EXPT


def powers(
    context: Context, values: Sequence[Expression], wanted: Type | None
) -> tuple[Sequence[Expression], Elementary | None]:
    """Return the arguments of EXPT, and the type of its result if that is a real number.

    The result for integers is an integer where one is wanted (PacDrive manual 2803: `OUT` may be an INT), and otherwise
    a real number in CODESYS ("Permitted data types for the return value: REAL and LREAL"; TwinCAT: "return type is
    always LREAL").  EPAS-4 and edition 3, where a base that is an integer is our extension, have an integer unless a
    real number is wanted.
    """
    target = plain(wanted) if wanted is not None else None
    is_real = isinstance(target, Elementary) and target.is_real
    is_integer = isinstance(target, Elementary) and target.is_integer
    has_integers = all(_is_integer(value) for value in values)
    has_long = target is Elementary.LREAL and context.project.dialect.has_real_powers
    if len(values) != 2 or not (has_long or (has_integers and (is_real or _are_real(context, is_integer)))):
        return values, None
    if not all(_is_integer(value) or _is_real(value) for value in values):
        return values, None
    return [_long(value) for value in values], target if is_real and isinstance(
        target, Elementary
    ) else Elementary.LREAL


def _are_real(context: Context, is_integer_wanted: bool) -> bool:
    return context.project.dialect.has_real_powers and not context.is_library and not is_integer_wanted


def _is_integer(value: Expression) -> bool:
    if type(value) is Untyped:
        return not value.is_real
    kind = plain(value.type)
    return isinstance(kind, Elementary) and kind.is_integer


def _is_real(value: Expression) -> bool:
    kind = value.type
    return value.is_real if type(value) is Untyped else isinstance(kind, Elementary) and kind.family is Family.REAL


def _long(value: Expression) -> Expression:
    return (
        Constant(float(value.value), Elementary.LREAL)
        if type(value) is Untyped and not isinstance(value.value, str)
        else constants.converted(value, Elementary.LREAL)
    )
