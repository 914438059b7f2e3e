"""The functions of the standard that are arithmetic with times and dates under a name of their own.

Source: IEC 61131-3:2013, table 34.  Each is an operator that takes operands of these types only; None is any number.
"""

from collections.abc import Iterator, Mapping
from typing import Final

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import Operator

_E = Elementary
Timed = tuple[Operator, Elementary, Elementary | None]


def _of(time: Elementary, date: Elementary, clock: Elementary, moment: Elementary) -> Iterator[tuple[str, Timed]]:
    """Yield the functions for one set of types: the short ones, or the long ones."""
    yield f"ADD_{time}", (Operator.ADD, time, time)
    yield f"SUB_{time}", (Operator.SUB, time, time)
    yield f"MUL_{time}", (Operator.MUL, time, None)
    yield f"DIV_{time}", (Operator.DIV, time, None)
    yield f"SUB_{date}_{date}", (Operator.SUB, date, date)
    for kind in (clock, moment):
        yield f"ADD_{kind}_{time}", (Operator.ADD, kind, time)
        yield f"SUB_{kind}_{time}", (Operator.SUB, kind, time)
        yield f"SUB_{kind}_{kind}", (Operator.SUB, kind, kind)


TIMED: Final[Mapping[str, Timed]] = {
    **dict(_of(_E.TIME, _E.DATE, _E.TOD, _E.DT)),
    **dict(_of(_E.LTIME, _E.LDATE, _E.LTOD, _E.LDT)),
    "MULTIME": (Operator.MUL, _E.TIME, None),
    "DIVTIME": (Operator.DIV, _E.TIME, None),
}
"""The functions by their names in capitals."""
