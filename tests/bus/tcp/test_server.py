"""`tcp.server` with real sockets, and a device that returns what it gets in capitals."""

import asyncio
import socket
import struct
import time
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest
from patience import PATIENCE_S
from pydantic import ValidationError

from fieldrig.errors import BusError
from fieldrig.hub.hub import LocalHub
from fieldrig.loop.pace import Pace
from fieldrig.loop.real_clock import RealClock
from fieldrig_bus.tcp.listeners import TcpPort
from fieldrig_bus.tcp.server import TcpServerBus, TcpSettings
from fieldrig_devices.connections.connection import Connection
from fieldrig_devices.connections.face import TcpFace

pytestmark = pytest.mark.system


class Capitals:
    """A session that answers in capitals.

    It opens an extra port at `p`, two at `pp`, connects to the client at `to` and a port, and closes at `q`.
    """

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self.has_ended = self.was_lost = self.was_drained = False
        SESSIONS.append(self)

    def received(self, data: bytes) -> None:
        self.connection.write(data.upper())
        for _ in range(data.count(b"p")):
            self.connection.listen(lambda port: self.connection.write(b" %d." % port), Capitals)
        if data.startswith(b"to "):
            self.connection.connect(int(data[3:]), lambda: self.connection.write(b" no."), self._accept)
        if data == b"q":
            self.connection.close()
        if data.startswith(b"much"):
            self.connection.write(bytes(4_000_000))

    def _accept(self, connection: Connection) -> "Capitals":
        self.connection.stop_listening()
        return Capitals(connection)

    def drained(self) -> None:
        self.was_drained = True

    def ended(self) -> None:
        self.has_ended = True
        self.connection.close()

    def lost(self) -> None:
        self.was_lost = True


SESSIONS: list[Capitals] = []


class Bench:
    def __init__(self, hub: LocalHub, port: TcpPort, face: TcpFace) -> None:
        self.hub, self.port, self.face = hub, port, face

    async def connect(self, number: int | None = None) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
        return await asyncio.open_connection("127.0.0.1", number or self.port.number("echo"))


def run(scene: Callable[[Bench], Awaitable[None]], folder: Path, **settings: object) -> None:
    async def running() -> None:
        bus = TcpServerBus("lan", TcpSettings.model_validate({"listen": {"echo": "127.0.0.1:0"}, **settings}))
        clock = RealClock(asyncio.get_running_loop())
        hub = LocalHub(bus, clock, folder)
        (port,) = bus.ports()
        assert isinstance(port, TcpPort)
        await port.open(hub)
        SESSIONS.clear()
        face = TcpFace(hub.join("device"), {"echo": Capitals})
        face.open()
        try:
            async with asyncio.timeout(PATIENCE_S):
                await scene(Bench(hub, port, face))
        finally:
            await port.close()
            clock.close()

    asyncio.run(running())


def test_a_connection_that_breaks_is_lost_and_not_ended(tmp_path: Path) -> None:
    async def scene(bench: Bench) -> None:
        reader, writer = await bench.connect()
        writer.write(b"a")
        await reader.readexactly(1)
        writer.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        writer.close()
        while not SESSIONS[0].was_lost:
            await asyncio.sleep(0.001)
        assert not SESSIONS[0].has_ended

    run(scene, tmp_path)


class Greeting(Capitals):
    def __init__(self, connection: Connection) -> None:
        super().__init__(connection)
        connection.write(b"hello")


def test_a_device_that_speaks_first_hears_that_all_was_taken(tmp_path: Path) -> None:
    async def scene(bench: Bench) -> None:
        bench.face.close()
        bench.hub.leave("device")
        TcpFace(bench.hub.join("device"), {"echo": Greeting}).open()
        reader, writer = await bench.connect()
        assert await reader.readexactly(5) == b"hello"
        while not SESSIONS[0].was_drained:
            await asyncio.sleep(0.001)
        writer.close()

    run(scene, tmp_path)


def test_several_clients_have_their_own_sessions(tmp_path: Path) -> None:
    async def scene(bench: Bench) -> None:
        clients = [await bench.connect() for _ in range(3)]
        for place, (_, writer) in enumerate(clients):
            writer.write(b"client %d" % place)
        for place, (reader, writer) in enumerate(clients):
            assert await reader.readexactly(8) == b"CLIENT %d" % place
            writer.close()

    run(scene, tmp_path)


def test_a_device_closes_after_its_answer(tmp_path: Path) -> None:
    async def scene(bench: Bench) -> None:
        reader, writer = await bench.connect()
        writer.write(b"q")
        assert await reader.read() == b"Q"
        writer.close()

    run(scene, tmp_path)


def test_a_client_that_has_sent_everything_still_gets_its_answer(tmp_path: Path) -> None:
    async def scene(bench: Bench) -> None:
        reader, writer = await bench.connect()
        writer.write(b"much")
        writer.write_eof()
        assert len(await reader.read()) == 4_000_004
        assert SESSIONS[0].has_ended
        writer.close()

    run(scene, tmp_path)


def test_a_client_that_reads_nothing_stops_the_device_and_nobody_else(tmp_path: Path) -> None:
    async def scene(bench: Bench) -> None:
        reader, writer = await bench.connect()
        writer.transport.pause_reading()  # type: ignore[attr-defined]
        for _ in range(20):
            writer.write(b"much")
            other, sender = await bench.connect()
            sender.write(b"x")
            assert await other.readexactly(1) == b"X"
            sender.close()
        assert SESSIONS[0].connection.unsent > 1_000_000
        writer.transport.abort()
        del reader

    run(scene, tmp_path)


def test_a_connection_too_many_is_closed(tmp_path: Path) -> None:
    async def scene(bench: Bench) -> None:
        _, writer = await bench.connect()
        reader, second = await bench.connect()
        assert await reader.read() == b""
        for open_one in (writer, second):
            open_one.close()

    run(scene, tmp_path, max_connections=1)


def test_an_extra_port_is_a_further_connection_of_the_client(tmp_path: Path) -> None:
    async def scene(bench: Bench) -> None:
        reader, writer = await bench.connect()
        writer.write(b"p")
        number = int((await reader.readuntil(b"."))[1:-1])
        extra, sender = await bench.connect(number)
        sender.write(b"more")
        assert await extra.readexactly(4) == b"MORE"
        SESSIONS[0].connection.stop_listening()
        sender.write(b"q")
        assert await extra.read() == b"Q"
        with pytest.raises(ConnectionRefusedError):
            await bench.connect(number)
        for open_one in (writer, sender):
            open_one.close()

    run(scene, tmp_path)


def test_of_two_extra_ports_the_last_one_counts(tmp_path: Path) -> None:
    async def scene(bench: Bench) -> None:
        reader, writer = await bench.connect()
        writer.write(b"pp")
        first, second = [int((await reader.readuntil(b".")).strip(b"P .")) for _ in range(2)]
        with pytest.raises(ConnectionRefusedError):
            await bench.connect(first)
        extra, sender = await bench.connect(second)
        sender.write(b"more")
        assert await extra.readexactly(4) == b"MORE"
        for open_one in (writer, sender):
            open_one.close()

    run(scene, tmp_path)


def test_a_device_connects_to_its_client(tmp_path: Path) -> None:
    """FTP in active mode."""

    async def scene(bench: Bench) -> None:
        arrived: asyncio.Future[tuple[asyncio.StreamReader, asyncio.StreamWriter]] = asyncio.Future()
        listener = await asyncio.start_server(lambda *ends: arrived.set_result(ends), "127.0.0.1", 0)
        number = listener.sockets[0].getsockname()[1]
        _reader, writer = await bench.connect()
        writer.write(b"to %d" % number)
        extra, sender = await arrived
        sender.write(b"more")
        assert await extra.readexactly(4) == b"MORE"
        listener.close()
        for open_one in (writer, sender):
            open_one.close()

    run(scene, tmp_path)


def test_a_client_that_does_not_listen_is_not_reached(tmp_path: Path) -> None:
    async def scene(bench: Bench) -> None:
        reader, writer = await bench.connect()
        with socket.create_server(("127.0.0.1", 0)) as closed:
            number = closed.getsockname()[1]
        writer.write(b"to %d" % number)
        assert await reader.readuntil(b" no.") == b"TO %d no." % number
        writer.close()

    run(scene, tmp_path)


def test_a_device_that_leaves_closes_its_connections(tmp_path: Path) -> None:
    async def scene(bench: Bench) -> None:
        reader, writer = await bench.connect()
        writer.write(b"a")
        assert await reader.readexactly(1) == b"A"
        bench.hub.leave("device")
        bench.hub.carry()
        assert await reader.read() == b""
        writer.close()

    run(scene, tmp_path)


def test_a_port_that_is_taken_is_refused_at_the_start(tmp_path: Path) -> None:
    async def scene(bench: Bench) -> None:
        taken = TcpPort({"echo": f"127.0.0.1:{bench.port.number('echo')}"}, 1, None)
        with pytest.raises(BusError, match="cannot listen"):
            await taken.open(LocalHub(bench.hub.bus, bench.hub.clock, tmp_path))

    run(scene, tmp_path)


@pytest.mark.parametrize(
    "wrong",
    [{"listen": {}}, {"listen": {"HTTP": "127.0.0.1:1"}}, {"listen": {"http": "nowhere"}}, {"extra_ports": [9, 5]}],
)
def test_wrong_settings_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        TcpSettings.model_validate(wrong)


def test_a_device_that_has_more_gets_rid_of_it_while_the_process_makes_its_clients_wait(tmp_path: Path) -> None:
    """The port reports in one message all that was taken meanwhile, and in its handling the device sends more."""

    async def scene(bench: Bench) -> None:
        for server in bench.port.servers():
            server.pace = Pace(bench.hub.clock, slice_ns=1)
        reader, writer = await bench.connect()
        writer.write(b"much")
        assert await reader.readexactly(4_000_004) == b"MUCH" + bytes(4_000_000)
        while not SESSIONS[0].was_drained:
            await asyncio.sleep(0.001)
        writer.close()

    run(scene, tmp_path)


class Noted(Pace):
    """A pace that notes since when its clients waited for what was answered."""

    def __init__(self, bench: Bench) -> None:
        super().__init__(bench.hub.clock, slice_ns=1)  # its clients have to wait for their turn
        self.asked_ns: list[int] = []

    def answered(self, asked_ns: int, *, has_turnaround: bool = True) -> None:
        self.asked_ns.append(asked_ns)
        super().answered(asked_ns, has_turnaround=has_turnaround)


def test_the_time_between_two_requests_is_no_work_of_the_process(tmp_path: Path) -> None:
    """It would count as taken by outsiders, who would have to wait for it, and their wait would count in turn."""

    async def scene(bench: Bench) -> None:
        pace = Noted(bench)
        for server in bench.port.servers():
            server.pace = pace
        reader, writer = await bench.connect()
        for letter in b"abc":
            sent_ns = time.monotonic_ns()
            writer.write(bytes([letter]))
            await reader.readexactly(1)
            assert pace.asked_ns
            assert min(pace.asked_ns) >= sent_ns
            pace.asked_ns.clear()
            await asyncio.sleep(0.001)  # the device has heard that its answer is taken
            pace.asked_ns.clear()
        writer.close()

    run(scene, tmp_path)
