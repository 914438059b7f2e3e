"""The messages of a log as the buses of a rig have them: Modbus on serial lines, and the servers of a network."""

from collections.abc import Iterable, Iterator, Mapping

from fieldrig.config.rig_file import RigConfig
from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.dialogues.modbus_servers import ModbusServers, bus_of_server, plain_bus
from fieldrig_devices.dialogues.rtu_lines import RtuLines
from fieldrig_devices.replay.log_names import bus_in


def lines_of(
    entries: Iterable[TraceEntry], config: RigConfig, given: Mapping[str, str], seen: set[str]
) -> Iterator[TraceEntry]:
    """Yield the messages of a log; `given` are the buses of the rig by those of the log, or by servers.

    The names by which a bus of the log may be given are put into `seen`.
    """

    def is_read_by_rig(line: str) -> bool:
        named = config.buses.get(given.get(line, line))
        return bus_in(config, line, "serial") is not None if named is None else named.bus.family != "modbus"

    def bus_of(bus: str, server: str) -> str | None:
        name = bus_of_server(bus, server)
        host, _, _ = server.rpartition(":")
        seen.update((name, server, host))
        for asked in (name, server, host):
            if asked in given:
                return given[asked]
        plain = plain_bus(name)
        return plain if plain in config.buses else None

    def noted() -> Iterator[TraceEntry]:
        for entry in entries:
            seen.add(entry.bus)
            yield entry

    for entry in ModbusServers(bus_of).of(RtuLines(is_read_by_rig).of(noted() if given else entries)):
        seen.add(entry.bus)
        yield entry
