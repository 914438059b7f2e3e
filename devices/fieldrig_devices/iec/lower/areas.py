"""Reading and writing %I, %Q and %M: tables of bytes, in which single bits have an address."""

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.layout import AREAS, kind_number
from fieldrig_devices.iec.lower.addresses import AreaAddress
from fieldrig_devices.iec.lower.emitter import Emitter
from fieldrig_devices.iec.lower.names import AREA_TABLES
from fieldrig_devices.iec.lower.values import Value, of_type
from fieldrig_devices.iec.types import StringType


def load(where: AreaAddress, kind: Elementary | StringType, emitter: Emitter) -> Value:
    table = AREA_TABLES[where.area]
    if kind is Elementary.BOOL:
        mask = 255 if where.bit < 0 else 1 << where.bit
        return Value(f"({table}[{where}] & {mask} != 0)", kind)
    if kind in (Elementary.BYTE, Elementary.USINT):
        return of_type(f"{table}[{where}]", kind)
    if kind in (Elementary.WORD, Elementary.UINT) and not where.terms:
        return of_type(f"({table}[{where.byte}] + {table}[{where.byte + 1}] * 256)", kind)
    return of_type(f"fetch({AREAS[where.area]} + {where}, {kind_number(kind)})", kind)


def store(where: AreaAddress, kind: Elementary | StringType, value: Value, emitter: Emitter) -> None:
    table = AREA_TABLES[where.area]
    is_output = where.area == "Q"
    if kind is Elementary.BOOL and where.bit >= 0:
        mask = 1 << where.bit
        emitter.add(
            f"{table}[{where}] = {table}[{where}] | {mask} if {value.text} else {table}[{where}] & {255 - mask}"
        )
    elif kind is Elementary.BOOL:
        emitter.add(f"{table}[{where}] = 1 if {value.text} else 0")
    elif kind in (Elementary.BYTE, Elementary.USINT):
        emitter.add(f"{table}[{where}] = {value.text}")
    else:
        emitter.add(f"put({AREAS[where.area]} + {where}, {kind_number(kind)}, {value.text})")
        return
    if is_output:
        emitter.add(f"on_output({where})")
