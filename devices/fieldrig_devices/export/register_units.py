"""The register tables of a rig: which unit of which device has which table, and at which buses."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from fieldrig.config.rig_file import RigConfig
from fieldrig_devices.registers.described import HasTables
from fieldrig_devices.registers.table import Table, load_table


class UnitTable(NamedTuple):
    """The table of one or several units of a device, which have the same file."""

    device: str
    units: tuple[int, ...]
    buses: tuple[str, ...]
    file: Path
    table: Table

    @property
    def name(self) -> str:
        """A name for files, such as `meters-10`."""
        return f"{self.device}-{self.units[0]}"


def unit_tables(config: RigConfig) -> Iterator[UnitTable]:
    """Yield the tables in the order of the rig file."""
    for name, entry in config.devices.items():
        if not isinstance(entry.settings, HasTables):
            continue
        buses = tuple(
            bus for linked in entry.links.values() for bus in linked if config.buses[bus].bus.family == "modbus"
        )
        units: dict[Path, list[int]] = {}
        for unit in entry.settings.register_tables():
            units.setdefault(unit.table, []).append(unit.unit_id)
        for file, ids in units.items():
            yield UnitTable(name, tuple(ids), buses, file, load_table(file))
