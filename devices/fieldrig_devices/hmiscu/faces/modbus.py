"""The controller as a Modbus server: one unit on any number of buses, TCP or serial lines.

Source: ours, as the manual describes no access to the blocks (digest section 13).  Registers and bits show the points
of a register table.  The table `blocks.yaml` has the pins of the blocks of a controller without a program, all
terminals and the panel; what this controller does not have does not exist there.  Values that are out of range are
accepted, and the block judges them.
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Final

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

BLOCKS: Final = Path(__file__).with_name("blocks.yaml")


class ModbusFaceSettings(PortSettings):
    """Settings of the server."""

    table: ConfigFile | None = Field(
        default=None,
        description="register table whose names are points: variables of the program, pins, terminals, panel; "
        "null: the pins of the blocks, the terminals and the panel",
    )
    refusal: Refusal = Field(
        default="server_failure", description="response to a value that a point refuses: exception 04, or 03"
    )
    identification: Identification = Field(
        default_factory=lambda: Identification(product_code="HMISCU", product_name="Magelis SCU"),
        description="response to function 43/14",
    )


class ModbusFace:
    """The server of one controller."""

    def __init__(
        self,
        clock: Clock,
        links: Sequence[Link[ModbusEvent]],
        settings: ModbusFaceSettings,
        find: Lookup,
        hear: Callable[[ModbusEvent], None],
    ) -> None:
        """`hear` is called with the messages that are no requests.

        ConfigError for entries of the table that have no point.
        """
        self.table = _table(settings.table, find)
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


def _table(path: Path | None, find: Lookup) -> Table:
    if path is None:
        return _present(load_table(BLOCKS), find)
    return load_table(path, lambda table: wrong_entries(table, find))


def _present(table: Table, find: Lookup) -> Table:
    """Return the entries of a table that have points."""
    there = {space: [entry for entry in table.entries(space) if find(entry.name) is not None] for space in SPACES}
    return table.model_copy(update=there)
