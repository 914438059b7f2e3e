"""The operation data of a drive as points: its parameters and measured values by IDN, such as `S-0-0104`.

A value is in the unit of the datum, with its decimals; a list of IDNs is a text.  A write is judged as one of the
master over the service channel: by limits, by the phases in which the datum is protected, and by the cyclic telegrams.
Commands are read only, because a master starts and ends them.
"""

from collections.abc import Callable, Iterator
from functools import partial

from fieldrig.device import Point, Value
from fieldrig.points.checks import number_in
from fieldrig_devices.sercos.datum import Datum, IdnTable
from fieldrig_devices.sercos.idn import READ_ONLY, Code, Format, ServiceError, idn_text

WORDS = {int(code): code.name.lower().replace("_", " ") for code in Code}


def idn_points(table: IdnTable, phase: Callable[[], int]) -> Iterator[tuple[str, Point]]:
    """Yield a point for each datum; `phase` returns the present phase of the ring."""
    for datum in table:
        attribute = datum.attribute
        is_number = not attribute.length.is_list
        is_writable = is_number and attribute.protected != READ_ONLY and not attribute.is_command
        scale = 10**attribute.decimals
        low, high = (None if limit is None else limit / scale for limit in (datum.minimum, datum.maximum))
        write = partial(_write, table, datum, phase, low, high) if is_writable else None
        kind = "text" if attribute.format is Format.TEXT else f"{attribute.format.name.lower()}, {_length(datum)}"
        yield idn_text(datum.idn), Point(partial(_read, datum), write, datum.unit, datum.name, (), kind, low, high)


def _length(datum: Datum) -> str:
    length = datum.attribute.length
    return f"list of {length.bytes} bytes each" if length.is_list else f"{length.bytes} bytes"


def _read(datum: Datum) -> Value:
    try:
        data = datum.present()
    except ServiceError:  # a master could not read it now
        data = datum.data
    return datum.shown(data)


def _write(
    table: IdnTable, datum: Datum, phase: Callable[[], int], low: float | None, high: float | None, value: Value
) -> None:
    number = round(number_in(value, low, high, datum.unit) * 10**datum.attribute.decimals)
    size = datum.attribute.length.bytes
    try:
        if phase() >= 3 and datum.idn in table.cyclic:
            raise ServiceError(Code.CYCLIC)
        datum.write(number.to_bytes(size, "little", signed=number < 0), phase())
    except ServiceError as refused:
        raise ValueError(f"the drive refuses it with {refused.code:04X}h, {WORDS.get(refused.code, '')}") from refused
    except OverflowError as cause:
        raise ValueError(f"expected a number that fits into {size} bytes, got {value!r}") from cause
