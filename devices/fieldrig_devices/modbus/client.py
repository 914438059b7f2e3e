"""A Modbus client: exchanges values of a controller with registers and bits of other units.

Source: Modbus application protocol V1.1b3.  The client sends one request at a time, as a master on a serial line has
to, and repeats it if the response is late or wrong.  A unit that still does not respond is lost: the client reports it,
and tries again after a pause.  An exception is a response: it is counted, and the values stay as they are; but with 0A
and 0B a gateway reports that the unit did not respond.  Units are devices of the rig, or outside servers that the bus
reaches.  Left out: broadcasts, and functions other than 1 to 4, 15 and 16.
"""

import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

from fieldrig.clock import MS, Alarm, Clock
from fieldrig.link import Link
from fieldrig_bus.modbus.message import ModbusEvent, ModbusRequest, ModbusResponse
from fieldrig_devices.modbus.client_settings import (
    ClientUnitSettings,
    ModbusClientSettings,
    ReadSettings,
    WriteSettings,
)
from fieldrig_devices.registers.packed import Element, Packed

READ: Final = {"coils": 1, "discrete_inputs": 2, "holding_registers": 3, "input_registers": 4}
WRITE: Final = {"coils": 15, "holding_registers": 16}
EXCEPTION: Final = 0x80
EXCEPTION_SIZE: Final = 2
GATEWAY_EXCEPTIONS: Final = frozenset({0x0A, 0x0B})
_HEAD: Final = struct.Struct(">BHH")

Pack = Callable[[Sequence[Element], bool], Packed]
"""Returns the values of a message, which the client writes to the unit if the second argument is true."""


class _Exchange:
    """One message of a unit.  `due_ns` is the time of its next request, or None if none is due."""

    def __init__(self, unit: "ClientUnit", function: int, every_ms: int, due_ns: int | None) -> None:
        self.unit, self.function, self._every_ns, self.due_ns = unit, function, every_ms * MS, due_ns

    def request(self) -> bytes:
        raise NotImplementedError

    def accepts(self, answer: bytes) -> bool:
        """True if the response is valid; then its values are taken over."""
        raise NotImplementedError

    def put_off(self, now_ns: int) -> None:
        """Schedule the next request after a response."""
        self.due_ns = now_ns + self._every_ns if self._every_ns else None


class _Read(_Exchange):
    def __init__(self, unit: "ClientUnit", settings: ReadSettings, make: Pack, now_ns: int) -> None:
        super().__init__(unit, READ[settings.what], settings.every_ms, now_ns)
        self._is_bits = settings.what in ("coils", "discrete_inputs")
        values = settings.values
        count = len(values) if self._is_bits else sum(value.words for value in values)
        self._size = (count + 7) // 8 if self._is_bits else 2 * count
        self._request = _HEAD.pack(self.function, settings.address, count)
        self._data = make(values, False)
        self._heard: bytes | None = None

    def request(self) -> bytes:
        return self._request

    def accepts(self, answer: bytes) -> bool:
        if answer[:2] != bytes((self.function, self._size)) or len(answer) != 2 + self._size:
            return False
        self._heard = answer[2:]
        return True

    def take(self) -> None:
        if self._heard is None:
            return
        if self._is_bits:
            self._data.unpack(self._heard)
        else:
            self._data.unpack_registers(self._heard)
        self._heard = None

    def clear(self) -> None:
        self._heard = bytes(self._size)


class _Write(_Exchange):
    def __init__(self, unit: "ClientUnit", settings: WriteSettings, make: Pack) -> None:
        super().__init__(unit, WRITE[settings.what], settings.every_ms, None)
        self._is_bits = settings.what == "coils"
        values = settings.values
        count = len(values) if self._is_bits else sum(value.words for value in values)
        self._head = _HEAD.pack(self.function, settings.address, count)
        self._data = make(values, True)
        self._wanted = b""
        self._requested: bytes | None = None
        """The data of the last request, whether or not it was answered; None if the unit may have lost it."""

    def request(self) -> bytes:
        self._requested = self._wanted
        return self._head + bytes((len(self._wanted),)) + self._wanted

    def accepts(self, answer: bytes) -> bool:
        return answer == self._head

    def give(self, now_ns: int) -> None:
        self._wanted = self._data.packed() if self._is_bits else self._data.registers()
        if self._wanted != self._requested and not self.unit.is_lost:
            self.due_ns = now_ns if self.due_ns is None else min(self.due_ns, now_ns)

    def put_off(self, now_ns: int) -> None:
        super().put_off(now_ns)
        if self._wanted != self._requested:
            self.due_ns = now_ns

    def forget(self) -> None:
        """Write again, because the unit may have lost its values."""
        self._requested = None


class ClientUnit:
    """One unit that the client reads and writes."""

    def __init__(self, client: "ModbusClient", name: str, settings: ClientUnitSettings, make: Pack) -> None:
        self._client, self.name, self.settings = client, name, settings
        self.requests = self.errors = self.exceptions = self.last_exception = 0
        self.failures = 0
        """Number of consecutive requests without a valid response."""
        self.is_lost = False
        self.is_heard = False
        now_ns = client.clock.now_ns()
        self._reads = [_Read(self, read, make, now_ns) for read in settings.reads]
        self._writes = [_Write(self, write, make) for write in settings.writes]

    @property
    def is_running(self) -> bool:
        return self.is_heard and not self.is_lost

    @property
    def exchanges(self) -> Iterator[_Exchange]:
        yield from self._writes
        yield from self._reads

    def take(self) -> None:
        """Put what has been read into the controller."""
        for read in self._reads:
            read.take()

    def give(self) -> None:
        """Write what has changed in the controller, and begin what is due."""
        for write in self._writes:
            write.give(self._client.clock.now_ns())
        self._client.go_on()

    def lose(self) -> None:
        self.is_lost = True
        if self.settings.lost_inputs == "zero":
            for read in self._reads:
                read.clear()

    def come_back(self) -> None:
        self.is_lost = False
        for write in self._writes:
            write.forget()


class ModbusClient:
    """Sends requests on `link`; the owner of the link passes the messages that arrive to `hear`."""

    def __init__(
        self,
        clock: Clock,
        link: Link[ModbusEvent],
        settings: ModbusClientSettings,
        on_lost: Callable[[ClientUnit], None] = lambda unit: None,
        on_back: Callable[[ClientUnit], None] = lambda unit: None,
    ) -> None:
        self.clock, self._link, self._settings = clock, link, settings
        self._on_lost, self._on_back = on_lost, on_back
        self._units: Sequence[ClientUnit] = ()
        self._pending: _Exchange | None = None
        self._number = 0
        self._late = Alarm(clock)
        self._wake = Alarm(clock)

    def make_units(self, pack: Callable[[str], Pack]) -> Mapping[str, ClientUnit]:
        """Return a new unit for each one of the settings; `pack` returns what makes the values of a unit."""
        return {name: ClientUnit(self, name, unit, pack(name)) for name, unit in self._settings.units.items()}

    def begin(self, units: Sequence[ClientUnit]) -> None:
        """Ask these units from now on; the first `give` of a unit starts the requests."""
        self.stop()
        self._units = units

    def stop(self) -> None:
        self._pending = None
        self._units = ()
        self._late.stop()
        self._wake.stop()

    def hear(self, message: ModbusEvent) -> None:
        exchange = self._pending
        if not isinstance(message, ModbusResponse) or message.exchange != self._number or exchange is None:
            return  # a late response, or another message
        unit, pdu = exchange.unit, message.pdu
        if message.unit != unit.settings.unit:
            return
        self._late.stop()
        self._pending = None
        if len(pdu) == EXCEPTION_SIZE and pdu[0] == exchange.function | EXCEPTION:
            unit.exceptions += 1
            unit.last_exception = pdu[1]
            self._on_exception(exchange, pdu[1])
        elif exchange.accepts(pdu):
            self._on_answer(exchange)
            exchange.put_off(self.clock.now_ns())
        else:
            self._on_failure(exchange)
        self.go_on()

    def go_on(self) -> None:
        """Send the request that is due, or wait until one is."""
        if self._pending is not None:
            return
        waiting = [(exchange.due_ns, exchange) for exchange in self._exchanges() if exchange.due_ns is not None]
        if not waiting:
            self._wake.stop()
            return
        due_ns, exchange = min(waiting, key=lambda timed: timed[0])
        if due_ns <= self.clock.now_ns():
            self._send(exchange)
        else:
            self._wake.at(due_ns, self.go_on)

    def _exchanges(self) -> Iterator[_Exchange]:
        return (exchange for unit in self._units for exchange in unit.exchanges)

    def _send(self, exchange: _Exchange) -> None:
        unit = exchange.unit
        unit.requests += 1
        self._pending = exchange
        self._number = self._number + 1 & 0xFFFF
        self._late.after(self._settings.timeout_ms * MS, self._on_timeout)
        self._link.send(ModbusRequest(unit.settings.unit, exchange.request(), self._number))

    def _on_answer(self, exchange: _Exchange) -> None:
        unit = exchange.unit
        unit.failures = 0
        unit.is_heard = True
        if unit.is_lost:
            unit.come_back()
            self._on_back(unit)

    def _on_exception(self, exchange: _Exchange, code: int) -> None:
        if code in GATEWAY_EXCEPTIONS:
            self._on_failure(exchange)
        else:
            self._on_answer(exchange)
            exchange.due_ns = self.clock.now_ns() + self._settings.pause_ms * MS

    def _on_timeout(self) -> None:
        exchange, self._pending = self._pending, None
        assert exchange is not None
        self._on_failure(exchange)
        self.go_on()

    def _on_failure(self, exchange: _Exchange) -> None:
        unit = exchange.unit
        unit.errors += 1
        unit.failures += 1
        if unit.failures <= self._settings.retries:
            return  # the request is still due and is repeated
        again_ns = self.clock.now_ns() + self._settings.pause_ms * MS
        for other in unit.exchanges:
            if other.due_ns is not None:
                other.due_ns = max(other.due_ns, again_ns)
        if not unit.is_lost:
            unit.lose()
            self._on_lost(unit)
