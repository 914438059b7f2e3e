"""The points that a program drives: the pins of the channels' blocks that it sets, and the outputs that it writes.

Someone else's value for them would be gone in the next cycle, so each face refuses it.
"""

from collections.abc import Iterable, Mapping

from fieldrig_devices.hmiscu import panel
from fieldrig_devices.hmiscu.io import place_of
from fieldrig_devices.iec.written import Written


def driven_names(written: Written, instances: Mapping[str, str], terminals: Iterable[str]) -> frozenset[str]:
    """Return the points that the program drives, in small letters, such as `pto00.reseterror` and `dq0`.

    `instances` are the names of the channels' blocks, and `terminals` those of all outputs.
    """
    known = {name.casefold() for name in instances}
    names = {f"{instance}.{pin}" for instance, pin in written.pins if instance in known}
    places = {name.casefold(): place_of(name) for name in terminals}
    names |= {name for name, place in places.items() if (place.byte, max(place.bit, 0)) in written.bits}
    lamps = (number for number in range(panel.LAMPS) if (panel.AREA_BYTE, number) in written.bits)
    return frozenset(names | {f"panel.lamp{number + 1}" for number in lamps})
