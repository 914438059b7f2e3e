"""The front of a Modbus device: its discrete inputs and coils as terminals, and its registers with their units."""

from collections.abc import Mapping
from typing import Final

from fieldrig.device import Point
from fieldrig.front import Clamp, Front, Group, Part, Plate, part_of
from fieldrig_bus.modbus.identification import Identification

_MOST: Final = 64
"""Most terminals, and most registers, on a front; a table may have thousands."""


def front_of(points: Mapping[str, Point], its: Identification) -> Front:
    """Return the front of a device with these points; its name plate is that of function 43/14."""
    terminals: list[Part] = []
    registers: list[Part] = []
    for key, point in points.items():
        if min(len(terminals), len(registers)) >= _MOST:
            break
        value = point.read()
        if isinstance(value, bool):
            is_set = point.write is not None
            terminals.append(Clamp(key, key, point.about, side="in" if is_set else "out", is_set=is_set))
        else:
            registers.append(part_of(key, point))
    groups = [(terminals, "terminals"), (registers, "registers")]
    model = its.model_name or its.product_name or its.product_code
    return Front(Plate(its.vendor_name, model), [Group(parts[:_MOST], title) for parts, title in groups if parts])
