"""The objects of a drive that a recording says nothing of: those of our own drive."""

from collections.abc import Collection, Iterator
from typing import Final

from fieldrig_devices.canopen.cob_id import is_valid
from fieldrig_devices.canopen.datatypes import DATA_TYPES, Integer
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds import reader
from fieldrig_devices.canopen.eds.source import NODE_ID
from fieldrig_devices.canopen.emcy import COB_ID as EMCY_COB_ID
from fieldrig_devices.canopen.variable import FIRST_APPLICATION_INDEX, Access, Variable
from fieldrig_devices.cia402.objects import Row
from fieldrig_devices.from_recording.object_rules import Value
from fieldrig_devices.from_recording.objects import Key

OF_DRIVES: Final = frozenset({0x1001, 0x1003, 0x1005, 0x1006, 0x100C, 0x100D, 0x1014, 0x1017})
"""Objects of CiA 301 without which the services of a drive would be missing."""
PDOS: Final = range(0x1400, 0x1C00)
"""Parameters of PDOs."""


def drive_rows(dictionary: Dictionary, taken: Collection[Key], refused: frozenset[int]) -> Iterator[Row]:
    """Yield the objects of our own drive, without those that are `taken`, and those that the drive has refused.

    `dictionary` is that of our own EDS for node `reader.CHECKED_AS`.
    """
    has_pdos = any(index in PDOS for index, _ in taken)
    for variable in dictionary:
        index = variable.index
        is_needed = index >= FIRST_APPLICATION_INDEX or index in OF_DRIVES or (index in PDOS and not has_pdos)
        if is_needed and index not in refused and (index, variable.subindex) not in taken:
            yield _row(variable, refused)


def _row(variable: Variable, refused: frozenset[int]) -> Row:
    number = next(number for number, known in DATA_TYPES.items() if known is variable.type)
    low, high = (None if limit is None else int(limit) for limit in (variable.low, variable.high))
    return Row(
        variable.index,
        variable.subindex,
        variable.name,
        number,
        "rww" if variable.is_mappable and variable.access is Access.RW else variable.access.value,  # none was in a TPDO
        _start(variable, refused),
        variable.is_mappable,
        low,
        high,
    )


def _start(variable: Variable, refused: frozenset[int]) -> Value:
    if not isinstance(variable.type, Integer):
        return ""
    index, start = variable.index, int(variable.value)
    if index in PDOS and start >> 16 in refused:
        return 0
    is_service = index == EMCY_COB_ID or (index in PDOS and not index & 0x200 and variable.subindex == 1)
    if is_service and start & 0x7F == reader.CHECKED_AS and is_valid(start):
        return f"{NODE_ID}+{start - reader.CHECKED_AS:#x}"
    return start
