"""The front of a Modbus device: its discrete inputs and coils as terminals, and its registers with their units."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

from fieldrig.device import Point
from fieldrig.front import Clamp, Front, Group, Part, Plate, part_of
from fieldrig_bus.modbus.identification import Identification

_MOST: Final = 64
"""Most terminals, and most registers, on a front; a table may have thousands."""


def front_of(points: Mapping[str, Point], its: Identification, units: Sequence[int]) -> Front:
    """Return the front of a device with these points; its name plate is that of function 43/14.

    The keys of a device with several units begin with the unit, which then has groups of its own.
    """
    heads = {f"{unit_id}/": f"unit {unit_id}: " for unit_id in units} if len(units) > 1 else {"": ""}
    groups: dict[str, list[Part]] = {}
    left = {"terminals": _MOST, "registers": _MOST}
    for key, point in points.items():
        if not any(left.values()):
            break
        head = key[: key.index("/") + 1] if len(units) > 1 else ""
        label = key.removeprefix(head)
        value = point.read()
        sort = "terminals" if isinstance(value, bool) else "registers"
        if left[sort] == 0:
            continue
        left[sort] -= 1
        is_set = point.write is not None
        part = (
            Clamp(label, key, point.about, side="in" if is_set else "out", is_set=is_set)
            if sort == "terminals"
            else replace(part_of(key, point), label=label)
        )
        groups.setdefault(f"{heads[head]}{sort}", []).append(part)
    titles = [f"{head}{sort}" for head in heads.values() for sort in left]
    model = its.model_name or its.product_name or its.product_code
    return Front(Plate(its.vendor_name, model), [Group(groups[title], title) for title in titles if title in groups])
