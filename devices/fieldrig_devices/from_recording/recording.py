"""A recording in one pass: what it shows of each of its buses."""

from collections import Counter
from pathlib import Path
from typing import Final

from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read
from fieldrig_devices.dialogues.modbus_servers import bus_of_server
from fieldrig_devices.dialogues.power_on import HEAD, rig_instant_ns
from fieldrig_devices.dialogues.rtu_line import RtuLine
from fieldrig_devices.from_recording.can_log import CanLog
from fieldrig_devices.from_recording.modbus_log import ModbusLog

MOST_BUSES: Final = 32
BusLog = CanLog | ModbusLog
_LOGS: Final[dict[str, type[CanLog] | type[ModbusLog]]] = {"can": CanLog, "modbus": ModbusLog, "serial": ModbusLog}


class Recording:
    """The buses of a file, by their names, and what no rig can be made of."""

    def __init__(self, file: Path) -> None:
        """Read the file.  UsageError if it cannot be read, or has no message."""
        self.file = file
        self.buses: dict[str, BusLog] = {}
        self.others: Counter[str] = Counter()
        """Messages of other families, by family."""
        self.count = self.end_ns = 0
        self.odd = Oddities()
        """Oddities of the file."""
        self.lines: list[str] = []
        """Serial lines with another protocol than Modbus."""
        self.left_out = 0
        """Messages of buses that are too many."""
        self._lines: dict[str, tuple[RtuLine, int]] = {}
        """Serial lines, with their numbers of messages."""
        head: list[TraceEntry] = []
        for number, entry in enumerate(read(file, odd=self.odd)):
            if number < HEAD:
                head.append(entry)
            self.count += 1
            self.end_ns = max(self.end_ns, entry.time_ns)
            self._take(number, entry)
        if not self.count:
            remedy = "record the bus while it works, from the start of the machine on"
            raise UsageError(f"{file} has no message", "\n".join((*map(str, self.odd), remedy)))
        self.start_ns = rig_instant_ns(head)
        """The instant at which a rig that plays this recording is switched on."""
        self._end()

    def _take(self, number: int, entry: TraceEntry) -> None:
        log = self._log(entry)
        if log is None:
            return
        if entry.family != "serial":
            log.take(number, entry)
            return
        line, count = self._lines.get(entry.bus) or (RtuLine(), 0)
        self._lines[entry.bus] = line, count + 1
        if isinstance(log, ModbusLog):
            log.take_bytes(entry)
        for message in line.take(entry):
            log.take(number, message)

    def _log(self, entry: TraceEntry) -> BusLog | None:
        log = self.buses.get(entry.bus)
        if log is not None:
            return log
        make = _LOGS.get(entry.family)
        if make is None:
            self.others[entry.family] += 1
            return None
        if len(self.buses) >= MOST_BUSES:
            self.left_out += 1
            return None
        log = self.buses[entry.bus] = make()
        return log

    def _end(self) -> None:
        for log in self.buses.values():
            log.end(self.start_ns, self.end_ns)
        for bus, (line, count) in self._lines.items():
            log = self.buses[bus]
            if isinstance(log, ModbusLog) and not any(unit.answers for unit in log.units.values()):
                del self.buses[bus]
                self.others["serial"] += count
                self.lines.append(bus)
            elif line.skipped:
                self.odd.report("bytes that are in no frame of Modbus are left out", f", on {bus}")
        self.buses = {
            name: log
            for bus, of_bus in self.buses.items()
            for name, log in ((bus, of_bus), *_servers(bus, of_bus))
            if not (log is of_bus and isinstance(log, ModbusLog) and log.servers and not log.units)
        }


def _servers(bus: str, log: BusLog) -> list[tuple[str, BusLog]]:
    """Return the servers of a network, each as a bus of its own."""
    if not isinstance(log, ModbusLog):
        return []
    return [(bus_of_server(bus, address), server) for address, server in log.servers.items()]
