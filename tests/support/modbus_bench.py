"""A Modbus device on a bus of any kind, and masters that speak to it in raw bytes.

Checksums come from pymodbus, so that ours are not their own judge.
"""

import os
import socket
import tempfile
import tty
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from hub_bench import LoopBench
from modbus_cases import SETTINGS, TABLE
from pymodbus.framer import FramerAscii, FramerRTU
from raw_end import RawEnd

from fieldrig.clock import MS, VirtualClock
from fieldrig.hub.hub import LocalHub
from fieldrig.storage.store import MemoryStore
from fieldrig.testing import RecordedLink
from fieldrig_bus.modbus.kind import ModbusBus
from fieldrig_bus.modbus.line import ModbusAscii, ModbusAsciiSettings, ModbusRtu, ModbusRtuSettings
from fieldrig_bus.modbus.message import ModbusMessage, ModbusRequest, ModbusResponse
from fieldrig_bus.modbus.tcp import ModbusTcp, ModbusTcpSettings
from fieldrig_bus.modbus.virtual import ModbusVirtual, ModbusVirtualSettings
from fieldrig_bus.wires import Signal
from fieldrig_devices.modbus.device import ModbusDevice, ModbusDeviceSettings

T = TypeVar("T")
BAUD = 115200


def device_settings(folder: Path, table: str = TABLE, **settings: Any) -> ModbusDeviceSettings:
    (folder / "table.yaml").write_text(table)
    entries = {"table": "table.yaml", **SETTINGS, **settings}
    entries = {key: value for key, value in entries.items() if value is not None}
    return ModbusDeviceSettings.model_validate(entries, context={"folder": folder})


class Wire(RawEnd):
    """Raw bytes to and from one end."""

    def __init__(self, bench: "RealBench", fd: int, close: Callable[[], None]) -> None:
        super().__init__(bench, fd, close)
        self._bench = bench

    def be_quiet(self) -> None:
        """Leave the silence that separates two frames on a serial line."""
        self._bench.be_quiet()

    def read_end(self) -> bytes:
        """Return everything up to the end of the connection."""
        self.until_closed()
        return bytes(self.received)


class RealBench(LoopBench):
    """A hub with a device in its process, on a loop that runs while the test pumps it."""

    def __init__(self, bus: ModbusBus, run: Path, settings: ModbusDeviceSettings) -> None:
        super().__init__()
        self.run = run
        self.hub = LocalHub(bus, self.clock, run)
        self.wires: RecordedLink[Signal] = RecordedLink()
        self.store = MemoryStore()
        self.device = ModbusDevice(self.clock, settings, [self.hub.join("device")], self.store, self.wires)
        self._ends: list[Wire] = []
        try:
            self.loop.run_until_complete(self.hub.open(serve=False))
        except BaseException:
            super().close()
            raise
        self.device.start()

    @property
    def port(self) -> int:
        number: int = self.hub._ports[0].number  # the only port there is
        return number

    def connect(self) -> Wire:
        end = socket.create_connection(("127.0.0.1", self.port))
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        wire = Wire(self, end.fileno(), end.close)
        self._ends.append(wire)
        return wire

    def open_pty(self, name: str = "line") -> Wire:
        fd = os.open(self.run / name, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(fd)
        wire = Wire(self, fd, lambda: os.close(fd))
        self._ends.append(wire)
        return wire

    def be_quiet(self) -> None:
        """Ten milliseconds without a character on the line: only the clock can say so.

        The time passes in pieces, so that the hub sees some of them if the host was busy during the others.
        """
        for _ in range(5):
            self._pass(2 * MS)

    def _pass(self, time_ns: int) -> None:
        until_ns = self.clock.now_ns() + time_ns
        self.pump(lambda: self.clock.now_ns() >= until_ns)

    def in_thread(self, work: Callable[[], T]) -> T:
        """Run a foreign, blocking master while the hub runs here."""
        with ThreadPoolExecutor(1) as pool:
            future = pool.submit(work)
            self.pump(future.done)
            return future.result()

    def close(self) -> None:
        for end in self._ends:
            end.close()
        self.loop.run_until_complete(self.hub.close())
        super().close()


@contextmanager
def real_bench(bus: ModbusBus, table: str = TABLE, **settings: Any) -> Iterator[RealBench]:
    with tempfile.TemporaryDirectory(prefix="fieldrig-") as folder:
        bench = RealBench(bus, Path(folder), device_settings(Path(folder), table, **settings))
        try:
            yield bench
        finally:
            bench.close()


def tcp_bus(**settings: Any) -> ModbusTcp:
    return ModbusTcp("mb", ModbusTcpSettings(listen="127.0.0.1:0", **settings))


def rtu_bus(**settings: Any) -> ModbusRtu:
    return ModbusRtu("mb", ModbusRtuSettings(**{"pty": "line", "baud": BAUD, **settings}))


def ascii_bus(**settings: Any) -> ModbusAscii:
    return ModbusAscii("mb", ModbusAsciiSettings(**{"pty": "line", "baud": BAUD, **settings}))


def mbap(transaction: int, unit: int, pdu: bytes) -> bytes:
    return transaction.to_bytes(2, "big") + b"\x00\x00" + (len(pdu) + 1).to_bytes(2, "big") + bytes((unit,)) + pdu


def rtu(unit: int, pdu: bytes) -> bytes:
    body = bytes((unit,)) + pdu
    return body + FramerRTU.compute_CRC(body).to_bytes(2, "big")


def ascii_(unit: int, pdu: bytes) -> bytes:
    body = bytes((unit,)) + pdu
    return b":" + (body + bytes((FramerAscii.compute_LRC(body),))).hex().upper().encode() + b"\r\n"


class Master:
    """Send requests and compare; a request that has no answer is followed by one that has."""

    MARK = bytes.fromhex("08 0000 5A5A")

    def __init__(self, wire: Wire, frame: Callable[[int, bytes], bytes]) -> None:
        self._wire, self._frame = wire, frame

    def ask(self, request: str, unit: int = 1) -> None:
        self._wire.write(self._frame(unit, bytes.fromhex(request)))

    def expect(self, response: str, unit: int = 1) -> None:
        wanted = self._frame(unit, bytes.fromhex(response))
        got = self._wire.read(len(wanted))
        assert got == wanted, f"{got.hex(' ')} instead of {wanted.hex(' ')}; open: {self._wire.is_open}"

    def exchange(self, request: str, response: str, unit: int = 1) -> None:
        self.ask(request, unit)
        if response:
            self.expect(response, unit)
        else:
            self._wire.be_quiet()
            self._wire.write(self._frame(1, self.MARK))
            self.expect(self.MARK.hex(), 1)


class VirtualMaster:
    """A master on `modbus.virtual`."""

    def __init__(self, folder: Path, bus: ModbusVirtualSettings, **settings: Any) -> None:
        self.clock = VirtualClock()
        self.model = ModbusVirtual("mb", bus).model()
        self._handlers: dict[str, Callable[[ModbusMessage], None]] = {}
        self.heard: list[tuple[int, ModbusMessage]] = []
        self.deliveries: list[Any] = []
        device_link = VirtualLink(self, "device")
        self.device = ModbusDevice(self.clock, device_settings(folder, **settings), [device_link], MemoryStore())
        self.device.start()
        self.link = VirtualLink(self, "master")
        self.link.on_receive(lambda message: self.heard.append((self.clock.now_ns(), message)), ())

    def join(self, member: str, handler: Callable[[ModbusMessage], None]) -> None:
        self._handlers[member] = handler

    def run(self) -> None:
        """Run until nothing is being sent."""
        while True:
            wishes = [wish for wish in (self.model.next_ns(), self.clock.next_ns()) if wish is not None]
            if not wishes:
                return
            now_ns = min(wishes)
            self.clock.advance_to(now_ns)
            for delivery in self.model.collect(now_ns):
                self.deliveries.append(delivery)
                for receiver in delivery.receivers:
                    self._handlers[receiver](delivery.message)

    def exchange(self, request: str, response: str, unit: int = 1) -> None:
        self.heard.clear()
        self.link.send(ModbusRequest(unit, bytes.fromhex(request), 7))
        self.run()
        wanted = [ModbusResponse(unit, bytes.fromhex(response), 7)] if response else []
        assert [message for _, message in self.heard] == wanted


class VirtualLink:
    def __init__(self, bench: VirtualMaster, member: str) -> None:
        self._bench, self._member = bench, member
        bench.model.join(member)

    def send(self, message: ModbusMessage) -> None:
        self._bench.model.submit(self._bench.clock.now_ns(), self._member, message)

    def on_receive(self, handler: Callable[[ModbusMessage], None], interest: Any = None) -> None:
        self._bench.join(self._member, handler)
        self._bench.model.listen(self._bench.clock.now_ns(), self._member, interest)
