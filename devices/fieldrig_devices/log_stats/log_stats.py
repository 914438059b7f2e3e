"""The statistics of a log, in one reading and constant memory."""

from collections import OrderedDict
from collections.abc import Iterable
from typing import Final

from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.codec import decode
from fieldrig_bus.modbus.message import DamagedAnswer, ModbusResponse
from fieldrig_devices.canopen.names import CanopenNames
from fieldrig_devices.dialogues import ModbusDialogues, ModbusExchange
from fieldrig_devices.dialogues.modbus_dialogues import is_address
from fieldrig_devices.log_stats.answers import Answers
from fieldrig_devices.log_stats.can_stats import CanStats
from fieldrig_devices.log_stats.series import Series
from fieldrig_devices.modbus.names import ModbusNames
from fieldrig_devices.named_logs.named_log import NamedLog
from fieldrig_devices.named_logs.servers import Servers

BITRATE: Final = 250_000
DATA_BITRATE: Final = 2_000_000
"""Bit rates in bit/s for a log that does not say them."""
MOST_BUSES: Final = 256
MOST_UNITS: Final = 5_000
"""Units of a network that are distinguished."""
MOST_SENDERS: Final = 1_000
"""Senders of a bus that are distinguished."""


class UnitStats:
    """The figures of one unit of one server."""

    def __init__(self, unit: int, server: str) -> None:
        self.unit, self.server = unit, server
        self.answers = Answers()
        self.requests = Series()


class ModbusStats:
    """Counts the messages of one Modbus bus, or of a network."""

    def __init__(self, names: ModbusNames) -> None:
        self.names = names
        self.units: dict[tuple[str, int], UnitStats] = {}
        """The units of each server; its address is empty where there are no addresses."""
        self._dialogues, self._servers = ModbusDialogues(), Servers()
        self._early: set[int] = set()
        """Open requests whose server is not known yet, by their numbers in the log."""

    def take(self, number: int, entry: TraceEntry) -> None:
        for dialogue in self._dialogues.take(number, entry):
            if isinstance(dialogue, ModbusExchange):
                self._count(dialogue)
            else:
                self._stray(entry)
        if (request := self._dialogues.request) is None:
            return
        server = self._servers.known(entry.sender)
        if server is None:
            self._early.add(number)
        else:
            self._unit(server, request.unit).requests.add(entry.time_ns, len(request.pdu))

    def close(self) -> None:
        """Count what is open at the end of the log."""
        for dialogue in self._dialogues.unfinished():
            if isinstance(dialogue, ModbusExchange):
                self._count(dialogue)

    def _count(self, exchange: ModbusExchange) -> None:
        unit = self._unit(self._servers.server_of(exchange), exchange.unit)
        unit.answers.take_modbus(exchange)
        if exchange.entries[0] in self._early:
            self._early.remove(exchange.entries[0])
            unit.requests.add(exchange.begin_ns, len(exchange.request))

    def _stray(self, entry: TraceEntry) -> None:
        message = decode(entry.data)
        if isinstance(message, ModbusResponse | DamagedAnswer):
            self._unit(entry.sender if is_address(entry.sender) else "", message.unit).answers.strays += 1

    def _unit(self, server: str, unit: int) -> UnitStats:
        key = server, unit
        if key not in self.units and len(self.units) >= MOST_UNITS:
            key = "", unit
        return self.units.setdefault(key, UnitStats(unit, key[0]))


class BusStats:
    """Counts the messages of one bus: by sender, and by what its family knows."""

    def __init__(self, name: str, family: str, of_family: CanStats | ModbusStats | None) -> None:
        self.name, self.family, self.of_family = name, family, of_family
        self.all = Series()
        self.senders: dict[str, Series] = {}

    def take(self, number: int, entry: TraceEntry) -> None:
        self.all.add(entry.time_ns, len(entry.data))
        sender = self.senders.get(entry.sender)
        if sender is None and len(self.senders) < MOST_SENDERS:
            sender = self.senders[entry.sender] = Series()
        if sender is not None:
            sender.add(entry.time_ns, len(entry.data))
        if self.of_family is not None:
            self.of_family.take(number, entry)

    def close(self) -> None:
        if self.of_family is not None:
            self.of_family.close()


class LogStats:
    """The statistics of all buses of a log."""

    def __init__(self, names: NamedLog, bitrate: int | None = None, data_bitrate: int | None = None) -> None:
        """The bit rates are in bit/s; without them, those of `BITRATE` and `DATA_BITRATE` are assumed."""
        self._names = names
        self.bitrate, self.data_bitrate = bitrate or BITRATE, data_bitrate or DATA_BITRATE
        self.is_assumed = bitrate is None
        """True if the bit rate was not given."""
        self.buses: OrderedDict[tuple[str, str], BusStats] = OrderedDict()
        self.first_ns = self.last_ns = self.count = 0

    def read(self, entries: Iterable[TraceEntry]) -> None:
        """Count all messages of a log."""
        for number, entry in enumerate(entries):
            bus = self.buses.get((entry.bus, entry.family)) or self._new(entry)
            if bus is not None:
                bus.take(number, entry)
            self.first_ns = entry.time_ns if not self.count else min(self.first_ns, entry.time_ns)
            self.last_ns = max(self.last_ns, entry.time_ns)
            self.count += 1
        for bus in self.buses.values():
            bus.close()

    @property
    def duration_ns(self) -> int:
        return self.last_ns - self.first_ns

    def _new(self, entry: TraceEntry) -> BusStats | None:
        if len(self.buses) >= MOST_BUSES:
            return None
        namer = self._names.namer(entry.bus, entry.family)
        of_family: CanStats | ModbusStats | None = None
        if isinstance(namer, CanopenNames):
            of_family = CanStats(namer, self.bitrate, self.data_bitrate)
        elif isinstance(namer, ModbusNames):
            of_family = ModbusStats(namer)
        bus = self.buses[entry.bus, entry.family] = BusStats(entry.bus, entry.family, of_family)
        return bus
