"""Arithmetic with times and dates, as far as CoDeSys V2.3 and edition 3 of the standard have it.

TIME + TIME, TIME - TIME (wrapping around; the manual does not define negative times), TIME * number, TIME / number;
DT and TOD plus or minus TIME; the difference of two DATE, DT or TOD.  DATE and DT count seconds, the others count
milliseconds.  The long types of edition 3 have the same operations, and count nanoseconds.
"""

from typing import Final

from fieldrig_devices.iec.check import constants
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.elementary import (
    LONG_TIMES,
    LONGER,
    SHORT_TIMES,
    UNITS_NS,
    UNSIGNED,
    Elementary,
    are_twins,
    is_longer,
)
from fieldrig_devices.iec.program import COMPARISONS, Constant, Expression, Operator

_DURATIONS: Final = (*SHORT_TIMES, *LONG_TIMES)
_DAY_MS: Final = 86_400_000
_MOMENTS: Final = (Elementary.DT, Elementary.TOD, Elementary.LDT, Elementary.LTOD, Elementary.UNSIGNED_LDT)


def _duration(context: Context, kind: Elementary) -> Elementary:
    """Return the type of a difference of two dates of this type."""
    dialect = context.project.dialect
    return dialect.time if kind in LONGER else dialect.long_time


def _number(kind: Elementary) -> Elementary:
    """Return the type in which the numbers behind times of this type are computed."""
    if kind in UNSIGNED.values():
        return Elementary.ULINT
    return Elementary.DWORD if kind in LONGER and not kind.is_signed else Elementary.LINT


def is_negative(context: Context, operator: Operator, left: Expression, right: Expression) -> bool:
    """True for constants whose difference is below 0, in a dialect without negative times."""
    if operator is not Operator.SUB or context.project.dialect.allows_negative_times or context.is_library:
        return False
    has_time = left.type in (*LONGER, *LONGER.values(), *UNSIGNED.values())
    return has_time and isinstance(left, Constant) and isinstance(right, Constant) and left.value < right.value  # type: ignore[operator]


def is_scaled_below_zero(context: Context, operator: Operator, left: Expression, right: Expression) -> bool:
    """True for a duration times or by a negative constant, in a dialect without negative times."""
    if operator not in (Operator.MUL, Operator.DIV) or context.is_library:
        return False
    if operator is Operator.MUL and right.type in _DURATIONS:
        left, right = right, left
    if left.type not in _DURATIONS or context.project.dialect.allows_negative_times:
        return False
    number = constants.whole(right)
    is_nothing = isinstance(left, Constant) and left.value == 0
    return (
        isinstance(number, Constant) and isinstance(number.value, int | float) and number.value < 0 and not is_nothing
    )


def of_the_same_type(
    context: Context, operator: Operator, left: Expression, right: Expression, kind: Elementary
) -> Expression | None:
    if kind in _DURATIONS and operator in (Operator.ADD, Operator.SUB):
        return constants.binary(operator, left, right, kind)
    if kind not in _DURATIONS and operator is Operator.SUB:
        number, duration = _number(kind), _duration(context, kind)
        difference = constants.binary(
            operator, constants.converted(left, number), constants.converted(right, number), number
        )
        units = UNITS_NS[kind] // UNITS_NS[duration]
        return constants.converted(_times(difference, units, Operator.MUL), duration)
    return None


def of_two_types(context: Context, operator: Operator, left: Expression, right: Expression) -> Expression | None:
    first, second = left.type, right.type
    assert isinstance(first, Elementary)
    assert isinstance(second, Elementary)
    if (first in SHORT_TIMES and second in SHORT_TIMES) or are_twins(first, second):
        durations = context.project.dialect.durations
        kind = (
            durations[Elementary.TIME]
            if first in SHORT_TIMES
            else next(form for form in durations.values() if are_twins(form, first))
        )
        both = constants.converted(left, kind), constants.converted(right, kind)
        return _of_one_type(context, operator, *both, kind)
    if is_longer(first, second):
        return _of_one_type(context, operator, constants.converted(left, second), right, second)
    if is_longer(second, first):
        return _of_one_type(context, operator, left, constants.converted(right, first), first)
    if operator in (Operator.ADD, Operator.SUB) and first in _MOMENTS and _moves(first, second):
        return _moved(operator, left, right)
    if operator is Operator.ADD and second in _MOMENTS and _moves(second, first):
        return _moved(operator, right, left)
    if operator is Operator.MUL and second in _DURATIONS:
        left, right, first, second = right, left, second, first
    right = constants.whole(right)
    second = right.type
    assert isinstance(second, Elementary)
    if first in _DURATIONS and operator in (Operator.MUL, Operator.DIV):
        return _scaled(operator, left, right, second)
    return None


def _of_one_type(
    context: Context, operator: Operator, left: Expression, right: Expression, kind: Elementary
) -> Expression | None:
    if operator in COMPARISONS:
        return constants.binary(operator, left, right, Elementary.BOOL)
    return of_the_same_type(context, operator, left, right, kind)


def _times(value: Expression, factor: int, operator: Operator) -> Expression:
    return value if factor == 1 else constants.binary(operator, value, Constant(factor, value.type), value.type)


def _moves(moment: Elementary, duration: Elementary) -> bool:
    """True for a duration that counts as finely as the short or the long types of moments are moved by."""
    return duration in SHORT_TIMES if moment in LONGER else duration in LONG_TIMES


def _moved(operator: Operator, moment: Expression, by: Expression) -> Expression:
    kind, duration = moment.type, by.type
    assert isinstance(kind, Elementary)
    assert isinstance(duration, Elementary)
    if duration is Elementary.SIGNED_TIME:
        return _moved_back_and_forth(operator, moment, by, kind)
    number, units = _number(kind), UNITS_NS[kind] // UNITS_NS[duration]
    distance, start = _times(constants.converted(by, number), units, Operator.DIV), constants.converted(moment, number)
    if kind is Elementary.TOD:  # what is before midnight belongs to the day before, and a DWORD has no sign
        distance = _times(distance, _DAY_MS, Operator.MOD)
        start = _times(start, _DAY_MS, Operator.ADD)
    return constants.converted(constants.binary(operator, start, distance, number), kind)


def _moved_back_and_forth(operator: Operator, moment: Expression, by: Expression, kind: Elementary) -> Expression:
    """Move by a time that may be negative, in milliseconds with a sign; a TOD stays within its day."""
    number = Elementary.LINT
    units = UNITS_NS[kind] // UNITS_NS[Elementary.TIME]
    start = _times(constants.converted(moment, number), units, Operator.MUL)
    if kind is Elementary.TOD:  # what is before midnight belongs to the day before
        # 64 days more: a TIME is up to 25 days below zero, and MOD keeps the sign.
        start = _times(start, 2**6 * _DAY_MS, Operator.ADD)
    moved = constants.binary(operator, start, constants.converted(by, number), number)
    if kind is Elementary.TOD:
        moved = _times(moved, _DAY_MS, Operator.MOD)
    return constants.converted(_times(moved, units, Operator.DIV), kind)


def _scaled(operator: Operator, time: Expression, number: Expression, kind: Elementary) -> Expression | None:
    """An integer scales the number behind the time; a real number is computed in LREAL and rounded."""
    duration = time.type
    assert isinstance(duration, Elementary)
    if kind.is_integer:
        return constants.binary(operator, time, number, duration)
    if not kind.is_real:
        return None
    behind = _number(duration)
    real = constants.converted(constants.converted(time, behind), Elementary.LREAL)
    product = constants.binary(operator, real, constants.converted(number, Elementary.LREAL), Elementary.LREAL)
    return constants.converted(constants.converted(product, behind), duration)
