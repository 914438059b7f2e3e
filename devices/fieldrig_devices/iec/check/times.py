"""Arithmetic with times and dates, as far as CoDeSys V2.3 and edition 3 of the standard have it.

TIME + TIME, TIME - TIME (wrapping around; the manual does not define negative times), TIME * number, TIME / number;
DT and TOD plus or minus TIME; the difference of two DATE, DT or TOD.  DATE and DT count seconds, the others count
milliseconds.  The long types of edition 3 have the same operations, and count nanoseconds.
"""

from typing import Final

from fieldrig_devices.iec.check import constants
from fieldrig_devices.iec.program import COMPARISONS, Constant, Expression, Operator
from fieldrig_devices.iec.types import LONGER, UNITS_NS, Elementary

_DURATIONS: Final = (Elementary.TIME, Elementary.LTIME)
_DAY_MS: Final = 86_400_000
_MOMENTS: Final = (Elementary.DT, Elementary.TOD, Elementary.LDT, Elementary.LTOD)


def _duration(kind: Elementary) -> Elementary:
    """Return the type of a difference of two dates of this type."""
    return Elementary.TIME if kind in LONGER else Elementary.LTIME


def _number(kind: Elementary) -> Elementary:
    """Return the type in which the numbers behind times of this type are computed."""
    return Elementary.DWORD if kind in LONGER else Elementary.LINT


def of_the_same_type(operator: Operator, left: Expression, right: Expression, kind: Elementary) -> Expression | None:
    if kind in _DURATIONS and operator in (Operator.ADD, Operator.SUB):
        return constants.binary(operator, left, right, kind)
    if kind not in _DURATIONS and operator is Operator.SUB:
        number, duration = _number(kind), _duration(kind)
        difference = constants.binary(
            operator, constants.converted(left, number), constants.converted(right, number), number
        )
        units = UNITS_NS[kind] // UNITS_NS[duration]
        return constants.converted(_times(difference, units, Operator.MUL), duration)
    return None


def of_two_types(operator: Operator, left: Expression, right: Expression) -> Expression | None:
    first, second = left.type, right.type
    assert isinstance(first, Elementary)
    assert isinstance(second, Elementary)
    if LONGER.get(first) is second:
        return _of_the_longer_type(operator, constants.converted(left, second), right, second)
    if LONGER.get(second) is first:
        return _of_the_longer_type(operator, left, constants.converted(right, first), first)
    if operator in (Operator.ADD, Operator.SUB) and first in _MOMENTS and second is _duration(first):
        return _moved(operator, left, right)
    if operator is Operator.ADD and second in _MOMENTS and first is _duration(second):
        return _moved(operator, right, left)
    if operator is Operator.MUL and second in _DURATIONS:
        left, right, first, second = right, left, second, first
    right = constants.whole(right)
    second = right.type
    assert isinstance(second, Elementary)
    if first in _DURATIONS and operator in (Operator.MUL, Operator.DIV):
        return _scaled(operator, left, right, second)
    return None


def _of_the_longer_type(operator: Operator, left: Expression, right: Expression, kind: Elementary) -> Expression | None:
    if operator in COMPARISONS:
        return constants.binary(operator, left, right, Elementary.BOOL)
    return of_the_same_type(operator, left, right, kind)


def _times(value: Expression, factor: int, operator: Operator) -> Expression:
    return value if factor == 1 else constants.binary(operator, value, Constant(factor, value.type), value.type)


def _moved(operator: Operator, moment: Expression, by: Expression) -> Expression:
    kind = moment.type
    assert isinstance(kind, Elementary)
    number, units = _number(kind), UNITS_NS[kind] // UNITS_NS[_duration(kind)]
    distance, start = _times(constants.converted(by, number), units, Operator.DIV), constants.converted(moment, number)
    if kind is Elementary.TOD:  # what is before midnight belongs to the day before
        distance = _times(distance, _DAY_MS, Operator.MOD)
        start = _times(start, _DAY_MS, Operator.ADD)
    return constants.converted(constants.binary(operator, start, distance, number), kind)


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
