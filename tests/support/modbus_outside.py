"""A hub whose bus leads to servers outside, a client in the rig, and those servers played by hand in raw bytes."""

import os
import socket
import tempfile
import tty
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from hub_bench import LoopBench
from raw_end import RawEnd

from fieldrig.hub.hub import LocalHub
from fieldrig_bus.modbus.kind import ModbusBus
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse


class OutsideBench(LoopBench):
    def __init__(self, bus: ModbusBus, run: Path) -> None:
        super().__init__()
        self.run = run
        self.hub = LocalHub(bus, self.clock, run)
        self.client = self.hub.join("plc")
        self.heard: list[ModbusResponse] = []
        self.client.on_receive(self.heard.append, ())
        self._exchange = 0
        self.ends: list[End] = []
        try:
            self.loop.run_until_complete(self.hub.open(serve=False))
        except BaseException:
            super().close()
            raise

    def ask(self, unit: int, pdu: str) -> int:
        """The exchange that the response will have."""
        self._exchange += 1
        request = ModbusRequest(unit, bytes.fromhex(pdu), self._exchange)
        self.in_loop(lambda: self.client.send(request))
        return self._exchange

    def in_loop(self, action: Callable[[], None]) -> None:
        """Run in the loop, as everything in a process of a rig does."""

        async def acting() -> None:
            action()

        if self.loop.is_running():
            action()
        else:
            self.loop.run_until_complete(acting())

    def answers(self) -> list[tuple[int, int, str]]:
        """Unit, exchange and PDU of every response so far."""
        return [(item.unit, item.exchange, item.pdu.hex(" ")) for item in self.heard]

    def expect(self, count: int = 1) -> list[tuple[int, int, str]]:
        """Wait for `count` responses, and take them."""
        self.pump(lambda: len(self.heard) >= count)
        answers = self.answers()
        self.heard.clear()
        return answers

    def wait_ms(self, ms: float) -> None:
        """Wait, where only the clock shows that nothing came."""
        until_ns = self.clock.now_ns() + round(ms * 1e6)
        self.pump(lambda: self.clock.now_ns() >= until_ns)

    def close(self) -> None:
        for end in self.ends:
            end.close()
        self.loop.run_until_complete(self.hub.close())
        super().close()


class End(RawEnd):
    """One end of a connection or line of a server outside the rig."""

    def __init__(self, bench: OutsideBench, fd: int, close: Callable[[], None]) -> None:
        super().__init__(bench, fd, close)
        self._bench = bench
        bench.ends.append(self)

    def read(self, size: int) -> bytes:
        """Wait for `size` bytes and return them; it is an error if the connection ends before."""
        self._bench.pump(lambda: len(self.received) >= size)
        return super().read(size)


class Listener:
    """The listening socket of a server outside the rig, which can be closed and opened again on its port."""

    def __init__(self) -> None:
        self._socket = self._open(0)
        self.port: int = self._socket.getsockname()[1]

    @property
    def address(self) -> str:
        return f"127.0.0.1:{self.port}"

    def accept(self, bench: OutsideBench) -> End:
        found: list[socket.socket] = []

        def is_there() -> bool:
            try:
                found.append(self._socket.accept()[0])
            except BlockingIOError:
                return False
            return True

        bench.pump(is_there)
        end = found[0]
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return End(bench, end.fileno(), end.close)

    def is_asked(self) -> bool:
        """True if a client tries to connect; it is disconnected."""
        try:
            self._socket.accept()[0].close()
        except BlockingIOError:
            return False
        return True

    def shut(self) -> None:
        self._socket.close()

    def again(self) -> None:
        self._socket = self._open(self.port)

    @staticmethod
    def _open(port: int) -> socket.socket:
        listener = socket.socket()
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(("127.0.0.1", port))
        listener.listen()
        listener.setblocking(False)
        return listener


def open_pty(bench: OutsideBench, name: str) -> End:
    """Open the line's pty as a server does that uses it as its port."""
    fd = os.open(bench.run / name, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(fd)
    return End(bench, fd, lambda: os.close(fd))


@contextmanager
def outside_bench(bus: ModbusBus) -> Iterator[OutsideBench]:
    with tempfile.TemporaryDirectory(prefix="fieldrig-") as folder, closing(OutsideBench(bus, Path(folder))) as bench:
        yield bench


@contextmanager
def listener() -> Iterator[Listener]:
    listener = Listener()
    try:
        yield listener
    finally:
        listener.shut()
