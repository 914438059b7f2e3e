"""The names for a log: of a rig file, or of the EDS files and register tables of single nodes and units."""

from typing import Any

from fieldrig.cli.message_words import bus_of
from fieldrig.config.rig_file import RigConfig
from fieldrig.traces.names import Named, Namer, namer_of
from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.canopen.names import CanopenNames, KnownNode
from fieldrig_devices.modbus.names import KnownUnit, ModbusNames
from fieldrig_devices.named_logs.descriptions import Files, of_bus, read_eds, read_registers
from fieldrig_devices.registers.described import HasTables
from fieldrig_devices.registers.named import NamedRegisters
from fieldrig_devices.registers.table import load_table


class NamedLog:
    """Makes the namer of each bus of a log.

    A bus of the log is that of the rig with its name, or the only one of its family.  The files describe nodes and
    units of all buses that the rig does not have.
    """

    def __init__(
        self, eds: Files | None = None, registers: Files | None = None, config: RigConfig | None = None
    ) -> None:
        """`eds` has EDS or DCF files by node-ID, `registers` register tables by unit.

        ConfigError with the mistakes of all files, and UsageError for one that cannot be read.
        """
        self._eds: Files = eds or {}
        self._config = config
        self._tables = {place: NamedRegisters(table) for place, table in read_registers(registers or {}).items()}
        read_eds(self._eds)  # so that all mistakes are reported before the log is read

    def namer(self, bus: str, family: str) -> Namer:
        """Return a new namer for a bus of the log."""
        known = self._bus_in_rig(bus, family)
        if known is not None and self._config is not None:
            return namer_of(self._config, known)
        if family == "can":
            nodes = of_bus(read_eds(self._eds), bus)
            return CanopenNames({node_id: KnownNode(f"node {node_id}", found) for node_id, found in nodes.items()})
        if family == "modbus":
            units = of_bus(self._tables, bus)
            return ModbusNames({unit: KnownUnit(f"unit {unit}", table) for unit, table in units.items()})
        return _Plain(family)

    @property
    def tables(self) -> list[tuple[int, NamedRegisters]]:
        """The register tables that are known, with their units: those of the files, and those of the rig."""
        found = [(unit, table) for (_, unit), table in self._tables.items()]
        for device in () if self._config is None else self._config.devices.values():
            if isinstance(device.settings, HasTables):
                found += [
                    (unit.unit_id, NamedRegisters(load_table(unit.table))) for unit in device.settings.register_tables()
                ]
        return found

    def is_in_rig(self, bus: str, family: str) -> bool:
        """Return whether a bus of the log is one of the rig, which then knows what it carries."""
        return self._bus_in_rig(bus, family) is not None

    def bitrate(self) -> int | None:
        """Return the bit rate of the CAN buses of the rig, in bit/s; None without a rig, or if they differ."""
        buses = () if self._config is None else self._config.buses.values()
        rates = {getattr(entry.bus.settings, "bitrate", None) for entry in buses if entry.bus.family == "can"}
        rate = rates.pop() if len(rates) == 1 else None
        return rate if isinstance(rate, int) else None

    def _bus_in_rig(self, bus: str, family: str) -> str | None:
        if self._config is None:
            return None
        known = self._config.buses.get(bus)
        if known is not None and known.bus.family == family:
            return bus
        fitting = [name for name, entry in self._config.buses.items() if entry.bus.family == family]
        return fitting[0] if len(fitting) == 1 else None


class _Plain:
    """Names nothing; messages are shown as their bus does."""

    def __init__(self, family: str) -> None:
        self._bus = bus_of(family)

    def __call__(self, message: Any, sender: str = "") -> Named:
        return Named("", "", repr(message) if self._bus is None else self._bus.show(message))


def decoded(entry: TraceEntry) -> Any:
    """Return the message of an entry; ValueError if its bytes are none, or if no bus of its family is known."""
    bus = bus_of(entry.family)
    if bus is None:
        raise ValueError(f"no bus of the family {entry.family} is known")
    return bus.decode(entry.data)
