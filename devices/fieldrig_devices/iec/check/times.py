"""Arithmetic with times and dates, as far as CoDeSys V2.3 has it.

TIME + TIME, TIME - TIME (wrapping around; the manual does not define negative times), TIME * number, TIME / number;
DT and TOD plus or minus TIME; the difference of two DATE, DT or TOD.  DATE and DT count seconds, the others count
milliseconds.
"""

from typing import Final

from fieldrig_devices.iec.check import constants
from fieldrig_devices.iec.program import Constant, Expression, Operator
from fieldrig_devices.iec.types import Elementary

TIME, TOD, DT, DATE = Elementary.TIME, Elementary.TOD, Elementary.DT, Elementary.DATE
DWORD: Final = Elementary.DWORD
_MS_PER_UNIT: Final = {DATE: 1000, DT: 1000, TOD: 1}


def of_the_same_type(operator: Operator, left: Expression, right: Expression, kind: Elementary) -> Expression | None:
    if kind is TIME and operator in (Operator.ADD, Operator.SUB):
        return constants.binary(operator, left, right, TIME)
    if kind is not TIME and operator is Operator.SUB:
        difference = constants.binary(
            operator, constants.converted(left, DWORD), constants.converted(right, DWORD), DWORD
        )
        return constants.converted(_times(difference, _MS_PER_UNIT[kind], Operator.MUL), TIME)
    return None


def of_two_types(operator: Operator, left: Expression, right: Expression) -> Expression | None:
    first, second = left.type, right.type
    if operator in (Operator.ADD, Operator.SUB) and first in (DT, TOD) and second is TIME:
        return _moved(operator, left, right)
    if operator is Operator.ADD and first is TIME and second in (DT, TOD):
        return _moved(operator, right, left)
    if operator is Operator.MUL and second is TIME:
        left, right, first, second = right, left, second, first
    if first is TIME and operator in (Operator.MUL, Operator.DIV) and isinstance(second, Elementary):
        return _scaled(operator, left, right, second)
    return None


def _times(value: Expression, factor: int, operator: Operator) -> Expression:
    return value if factor == 1 else constants.binary(operator, value, Constant(factor, DWORD), DWORD)


def _moved(operator: Operator, moment: Expression, by: Expression) -> Expression:
    kind = moment.type
    assert isinstance(kind, Elementary)
    distance = _times(constants.converted(by, DWORD), _MS_PER_UNIT[kind], Operator.DIV)
    return constants.converted(constants.binary(operator, constants.converted(moment, DWORD), distance, DWORD), kind)


def _scaled(operator: Operator, time: Expression, number: Expression, kind: Elementary) -> Expression | None:
    """An integer scales the milliseconds; a real number is computed in LREAL and rounded."""
    if kind.is_integer:
        return constants.binary(operator, time, number, TIME)
    if not kind.is_real:
        return None
    real = constants.converted(constants.converted(time, DWORD), Elementary.LREAL)
    product = constants.binary(operator, real, constants.converted(number, Elementary.LREAL), Elementary.LREAL)
    return constants.converted(constants.converted(product, DWORD), TIME)
