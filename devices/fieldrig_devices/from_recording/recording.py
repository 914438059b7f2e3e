"""A recording in one pass: what it shows of each of its buses."""

from collections import Counter
from pathlib import Path
from typing import Final

from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import is_time_of_day
from fieldrig.traces.trace_files import read
from fieldrig_devices.from_recording.can_log import CanLog
from fieldrig_devices.from_recording.modbus_log import ModbusLog

MOST_BUSES: Final = 32
BusLog = CanLog | ModbusLog
_LOGS: Final[dict[str, type[CanLog] | type[ModbusLog]]] = {"can": CanLog, "modbus": ModbusLog}


class Recording:
    """The buses of a file, by their names, and what no rig can be made of."""

    def __init__(self, file: Path) -> None:
        """Read the file.  UsageError if it cannot be read, or has no message."""
        self.file = file
        self.buses: dict[str, BusLog] = {}
        self.others: Counter[str] = Counter()
        """Messages of other families, by family."""
        self.odd = Oddities()
        """Oddities of the file."""
        self.left_out = 0
        """Messages of buses that are too many."""
        self.count = self.start_ns = self.end_ns = 0
        for number, entry in enumerate(read(file, odd=self.odd)):
            if not self.count:
                self.start_ns = entry.time_ns if is_time_of_day(entry.time_ns) else 0
            self.count += 1
            self.end_ns = max(self.end_ns, entry.time_ns)
            log = self.buses.get(entry.bus)
            if log is None:
                make = _LOGS.get(entry.family)
                if make is None:
                    self.others[entry.family] += 1
                    continue
                if len(self.buses) >= MOST_BUSES:
                    self.left_out += 1
                    continue
                log = self.buses[entry.bus] = make()
            log.take(number, entry)
        for log in self.buses.values():
            log.end(self.start_ns, self.end_ns)
        if not self.count:
            raise UsageError(
                f"{file} has no message", "record the bus while it works, from the start of the machine on"
            )
