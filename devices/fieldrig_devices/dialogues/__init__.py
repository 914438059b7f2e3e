"""Dialogues of a log: SDO transfers and Modbus exchanges, put together from its messages."""

from collections.abc import Iterable, Iterator

from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.canopen.pdo_maps import PdoMaps as PdoMaps
from fieldrig_devices.dialogues.dialogue import Dialogue as Dialogue
from fieldrig_devices.dialogues.dialogue import Stray as Stray
from fieldrig_devices.dialogues.modbus_dialogues import ModbusDialogues as ModbusDialogues
from fieldrig_devices.dialogues.modbus_exchange import ModbusExchange as ModbusExchange
from fieldrig_devices.dialogues.sdo_dialogues import SdoDialogues as SdoDialogues
from fieldrig_devices.dialogues.sdo_transfer import SdoTransfer as SdoTransfer


def dialogues(entries: Iterable[TraceEntry]) -> Iterator[Dialogue]:
    """Yield the dialogues of a log in the order in which they end; those that do not end come last."""
    sdo, modbus = SdoDialogues(), ModbusDialogues()
    for number, entry in enumerate(entries):
        yield from sdo.take(number, entry)
        yield from modbus.take(number, entry)
    yield from sdo.unfinished()
    yield from modbus.unfinished()
