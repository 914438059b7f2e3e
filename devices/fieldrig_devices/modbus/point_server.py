"""A device as a Modbus server: one unit on any number of buses whose registers and bits show points of the device."""

from collections.abc import Callable, Sequence
from functools import partial

from pydantic import Field

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig.settings import ConfigFile
from fieldrig_bus.modbus.identification import Identification
from fieldrig_bus.modbus.message import ModbusEvent, ModbusRequest
from fieldrig_bus.modbus.server import ModbusServer
from fieldrig_devices.modbus.port import ModbusPort, PortSettings
from fieldrig_devices.registers.live_table import Lookup, live_unit, wrong_entries
from fieldrig_devices.registers.table import SPACES, Table, load_table
from fieldrig_devices.registers.value import REFUSALS, Refusal


class PointServerSettings(PortSettings):
    """Settings of the server."""

    table: ConfigFile | None = Field(
        default=None, description="register table whose names are points; null: the table of this kind of device"
    )
    refusal: Refusal = Field(
        default="server_failure", description="response to a value that a point refuses: exception 04, or 03"
    )
    identification: Identification = Field(default_factory=Identification, description="response to function 43/14")


class PointServer:
    """The server of one device."""

    def __init__(
        self,
        clock: Clock,
        links: Sequence[Link[ModbusEvent]],
        settings: PointServerSettings,
        find: Lookup,
        hear: Callable[[ModbusEvent], None],
        default: Callable[[], Table],
    ) -> None:
        """`hear` is called with the messages that are no requests.

        `default` gives the table for settings that name none; its entries without a point do not exist.  ConfigError
        for entries of a table of the settings that have no point.
        """
        if settings.table is None:
            self.table = _present(default(), find)
        else:
            self.table = load_table(settings.table, lambda table: wrong_entries(table, find))
        unit = live_unit(self.table, find, REFUSALS[settings.refusal])
        for link in links:
            servers = {settings.unit_id: ModbusServer(unit, settings.identification)}
            port = ModbusPort(clock, link, servers, settings.turnaround_ns)
            link.on_receive(partial(_hear, port, hear), [settings.unit_id])


def _hear(port: ModbusPort, hear: Callable[[ModbusEvent], None], message: ModbusEvent) -> None:
    if isinstance(message, ModbusRequest):
        port.on_message(message)
    else:
        hear(message)


def _present(table: Table, find: Lookup) -> Table:
    """Return the entries of a table that have points."""
    there = {space: [entry for entry in table.entries(space) if find(entry.name) is not None] for space in SPACES}
    return table.model_copy(update=there)
