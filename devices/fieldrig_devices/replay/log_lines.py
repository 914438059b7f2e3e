"""The messages of a log as the buses of a rig have them: Modbus on serial lines, and the servers of a network.

Answers in a capture of a serial line have had their time on it.  Where the port of a rig takes that time, and its
members do not, an answer is expected when its frame began.
"""

from collections.abc import Iterable, Iterator, Mapping

from fieldrig.config.rig_file import RigConfig
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.codec import decode
from fieldrig_bus.modbus.framing import LineTiming
from fieldrig_bus.modbus.kind import ModbusBus
from fieldrig_bus.modbus.message import ModbusResponse
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

    lines = RtuLines(is_read_by_rig)
    captured = _without_line(lines, lines.of(noted() if given else entries), config, given)
    for entry in ModbusServers(bus_of).of(captured):
        seen.add(entry.bus)
        yield entry


def _without_line(
    lines: RtuLines, entries: Iterable[TraceEntry], config: RigConfig, given: Mapping[str, str]
) -> Iterator[TraceEntry]:
    """Yield the messages; answers of captured lines are earlier by their frames, but not before their requests."""
    timings, asked_ns = dict[str, LineTiming | None](), dict[str, int]()
    for entry in entries:
        bus = entry.bus
        if entry.family != "modbus" or not lines.carries_modbus(bus):
            yield entry
            continue
        if bus not in timings:
            timings[bus] = _timing_of(bus, config, given)
        timing = timings[bus]
        message = decode(entry.data)  # it was encoded from the bytes of the line
        if timing is None or not isinstance(message, ModbusResponse):
            asked_ns[bus] = entry.time_ns
            yield entry
            continue
        began_ns = entry.time_ns - timing.frame_ns(len(message.pdu))
        yield entry._replace(time_ns=max(began_ns, asked_ns.get(bus, began_ns)))


def _timing_of(bus: str, config: RigConfig, given: Mapping[str, str]) -> LineTiming | None:
    name = bus_in(config, bus, "modbus", given)
    of_rig = config.buses[name].bus if name in config.buses else None
    return of_rig.timing_at_port if isinstance(of_rig, ModbusBus) else None
