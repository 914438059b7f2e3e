"""Reads whose answers the recording has, for the test beside the rig."""

from collections.abc import Iterator
from typing import Final

from fieldrig_devices.canopen.variable import FIRST_APPLICATION_INDEX
from fieldrig_devices.from_recording.node_model import NodeModel
from fieldrig_devices.from_recording.parts import ReadBack

MOST_OF_A_NODE: Final = 8
EXPEDITED: Final = range(1, 5)
"""Sizes of the values that an SDO answer itself has."""
CHANGING: Final = frozenset({0x1001, 0x1002, 0x1003, 0x1010, 0x1011})
"""Objects of CiA 301 that the node changes."""


def sdo_read_backs(bus: str, model: NodeModel) -> Iterator[ReadBack]:
    """Yield reads of objects that stay as they are, with the data of the answers."""
    count = 0
    for (index, subindex), log in model.log.objects.there().items():
        variable = model.dictionary.get(index, subindex)
        if variable is None or log.first is None or len(log.first) not in EXPEDITED or variable.key in model.columns:
            continue
        is_computed = model.is_drive and index >= FIRST_APPLICATION_INDEX
        if index in CHANGING or is_computed or log.is_moved or variable.data != log.first or log.aborts:
            continue
        request = bytes((0x40, *index.to_bytes(2, "little"), subindex, 0, 0, 0, 0))
        yield ReadBack(bus, model.node_id, request.hex(" "), log.first.hex(" "))
        count += 1
        if count == MOST_OF_A_NODE:
            return
