"""The specific behaviour of each port of a serial line, beyond what all of them promise."""

import asyncio
import errno
import os
import socket
import sys
import termios
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

import pytest
import serial
import uvloop
from patience import PATIENCE_S
from pydantic import ValidationError

from fieldrig.clock import MS, Timer
from fieldrig.errors import BusError
from fieldrig.hub.hub import LocalHub
from fieldrig.loop.real_clock import RealClock
from fieldrig_bus.serial.bus import SerialBus
from fieldrig_bus.serial.message import Break, ControlLines, Format, SerialMessage
from fieldrig_bus.serial.pty import OFF_NS, SerialPty, SerialPtySettings
from fieldrig_bus.serial.rfc2217 import SerialRfc2217, SerialRfc2217Settings
from fieldrig_bus.serial.tcp import SerialTcp, SerialTcpSettings

pytestmark = pytest.mark.system

OFF = ControlLines(dtr=False, rts=False)
ON = ControlLines()


class LateClock(RealClock):
    """The clock of a host with much to do."""

    late_ns_each = 0
    """How late each timer is."""

    def call_at(self, when_ns: int, action: Callable[[], None]) -> Timer:
        return super().call_at(when_ns + self.late_ns_each, action)


class Bench:
    """A device that receives everything on one line, which a hub runs."""

    def __init__(self, run: Path) -> None:
        self.run = run
        self.clock = LateClock(asyncio.get_running_loop())
        self.heard: list[SerialMessage] = []
        self._hubs: list[LocalHub] = []

    async def open(self, bus: SerialBus) -> LocalHub:
        hub = LocalHub(bus, self.clock, self.run)
        link = hub.join("device")
        link.on_receive(self.heard.append, ("data", "lines", "format", "break"))
        self.send = link.send
        await hub.open(serve=False)
        self._hubs.append(hub)
        return hub

    async def close(self) -> None:
        for hub in self._hubs:
            await hub.close()
        self.clock.close()

    async def until(self, is_so: Callable[[], bool]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not is_so():
                await asyncio.sleep(0.001)

    def data(self) -> bytes:
        return b"".join(message for message in self.heard if isinstance(message, bytes))


def on_both_loops(test: Callable[..., Coroutine[Any, Any, None]]) -> Any:
    """Run a test with a `Bench` and fixtures, once with asyncio and once with uvloop, as a rig's processes do."""

    @pytest.mark.parametrize("new_loop", [asyncio.new_event_loop, uvloop.new_event_loop], ids=["asyncio", "uvloop"])
    def run(new_loop: Any, tmp_path: Path, free_port: int) -> None:
        async def opened() -> None:
            bench = Bench(tmp_path)
            try:
                await test(bench, free_port)
            finally:
                await bench.close()

        with asyncio.Runner(loop_factory=new_loop) as runner:
            runner.run(opened())

    run.__name__, run.__doc__ = test.__name__, test.__doc__
    return run


def tcp(port: int, **settings: Any) -> SerialTcp:
    return SerialTcp("com1", SerialTcpSettings(listen=f"127.0.0.1:{port}", **settings))


def connect(port: int) -> socket.socket:
    return socket.create_connection(("127.0.0.1", port), 20)


def refuses(port: int) -> bool:
    with socket.socket() as client:
        return client.connect_ex(("127.0.0.1", port)) == errno.ECONNREFUSED


async def read(client: socket.socket, count: int) -> bytes:
    return await asyncio.to_thread(client.recv, count)


async def is_hung_up(client: socket.socket) -> bool:
    try:
        return await read(client, 1) == b""
    except ConnectionResetError:  # the data that it had sent were not read any more
        return True


@on_both_loops
async def test_lines_show_whether_a_tcp_client_is_there(bench: Bench, free_port: int) -> None:
    await bench.open(tcp(free_port))
    with connect(free_port):
        await bench.until(lambda: bench.heard[-1:] == [ON])
    await bench.until(lambda: bench.heard == [OFF, ON, OFF])


@on_both_loops
async def test_second_tcp_client_is_refused(bench: Bench, free_port: int) -> None:
    await bench.open(tcp(free_port))
    with connect(free_port) as first, connect(free_port) as second:
        await asyncio.to_thread(second.sendall, b"second")
        assert await is_hung_up(second)
        first.sendall(b"first")
        await bench.until(lambda: bench.data() == b"first")


@on_both_loops
async def test_a_connection_is_refused_while_the_fault_is_on_and_others_stay(bench: Bench, free_port: int) -> None:
    hub = await bench.open(tcp(free_port))
    with connect(free_port) as client:
        await bench.until(lambda: bench.heard[-1:] == [ON])
        numbers = [hub.add_fault({"what": "refuse"}) for _ in range(2)]
        await bench.until(lambda: refuses(free_port))
        assert hub.faults()[numbers[0]]["applied"] == 1
        client.sendall(b"first")
        await bench.until(lambda: bench.data() == b"first")
        hub.clear_fault(numbers[0])
        await asyncio.sleep(0)
        assert refuses(free_port), "another fault is still on"
    hub.clear_fault(numbers[1])
    await bench.until(lambda: not refuses(free_port))
    with connect(free_port) as client:
        client.sendall(b"again")
        await bench.until(lambda: bench.data() == b"firstagain")


@on_both_loops
async def test_a_fault_from_the_start_refuses_connections_for_its_time(bench: Bench, free_port: int) -> None:
    fault = {"what": "refuse", "duration_ms": 200}
    hub = await bench.open(tcp(free_port, faults=[fault]))
    await bench.until(lambda: refuses(free_port) or hub.faults()[1]["state"] == "over")
    await bench.until(lambda: hub.faults()[1]["state"] == "over" and not refuses(free_port))


@on_both_loops
async def test_a_connection_is_cut_when_the_next_bytes_pass(bench: Bench, free_port: int) -> None:
    hub = await bench.open(tcp(free_port, baud=1_000_000))
    with connect(free_port) as client:
        await bench.until(lambda: bench.heard[-1:] == [ON])
        hub.add_fault({"what": "cut", "count": 1})
        bench.send(b"lost")
        assert await is_hung_up(client)
        await bench.until(lambda: bench.heard[-1:] == [OFF])
    with connect(free_port) as client:
        await bench.until(lambda: bench.heard[-1:] == [ON])
        bench.send(b"there")
        assert await read(client, 5) == b"there"


@on_both_loops
async def test_tcp_client_that_comes_again_gets_the_line(bench: Bench, free_port: int) -> None:
    await bench.open(tcp(free_port, baud=1_000_000))
    for number in range(10):
        with connect(free_port) as client:
            client.sendall(bytes((number,)))
            await bench.until(lambda number=number: bench.data().endswith(bytes((number,))))  # type: ignore[misc]


@on_both_loops
async def test_flood_of_a_tcp_client_is_held_up_and_not_lost(bench: Bench, free_port: int) -> None:
    await bench.open(tcp(free_port, baud=2_000_000))
    flood = os.urandom(100_000)
    with connect(free_port) as client:
        await asyncio.to_thread(client.sendall, flood)
        await bench.until(lambda: len(bench.data()) >= len(flood))
    assert bench.data() == flood


@on_both_loops
async def test_line_dials_a_server_and_again_when_it_has_gone(bench: Bench, free_port: int) -> None:
    await bench.open(SerialTcp("com1", SerialTcpSettings(dial=f"127.0.0.1:{free_port}")))
    with socket.create_server(("127.0.0.1", free_port)) as server:
        for _ in range(2):
            there, _ = await asyncio.to_thread(server.accept)
            with there:
                there.sendall(b"x")
                await bench.until(lambda: bench.heard[-1] == b"x")
                bench.send(b"y")
                assert await read(there, 1) == b"y"
            await bench.until(lambda: bench.heard[-1] == OFF)


@on_both_loops
async def test_close_hangs_up(bench: Bench, free_port: int) -> None:
    hub = await bench.open(tcp(free_port))
    with connect(free_port) as client:
        await bench.until(lambda: bench.heard[-1:] == [ON])
        await hub.close()
        assert await is_hung_up(client)
    with pytest.raises(ConnectionRefusedError):
        connect(free_port)


@on_both_loops
async def test_address_in_use_is_said_with_what_to_do(bench: Bench, free_port: int) -> None:
    await bench.open(tcp(free_port))
    with pytest.raises(BusError, match=r"cannot listen at 127\.0\.0\.1:\d+") as fault:
        await bench.open(tcp(free_port))
    assert "choose another port" in fault.value.remedy


@pytest.mark.skipif(sys.platform == "win32", reason="no ptys on Windows")
@on_both_loops
async def test_pty_follows_the_clients_baud_rate(bench: Bench, free_port: int) -> None:
    await bench.open(SerialPty("com1", SerialPtySettings(baud=9600)))
    path = bench.run / "serial/com1"
    client = os.open(path, os.O_RDWR | os.O_NOCTTY)
    try:
        os.write(client, b"a")
        await bench.until(lambda: bench.heard == [OFF, ON, b"a"])
        attributes = termios.tcgetattr(client)
        attributes[4] = attributes[5] = termios.B19200
        termios.tcsetattr(client, termios.TCSANOW, attributes)
        os.write(client, b"b")
        await bench.until(lambda: bench.heard == [OFF, ON, b"a", Format(19200), b"b"])
    finally:
        os.close(client)


ON_LINUX = pytest.mark.skipif(sys.platform != "linux", reason="Linux reports who opens a pty")


@ON_LINUX
@on_both_loops
async def test_lines_show_whether_a_program_has_the_pty_open(bench: Bench, free_port: int) -> None:
    await bench.open(SerialPty("com1", SerialPtySettings(baud=19200)))
    client = os.open(bench.run / "serial/com1", os.O_RDWR | os.O_NOCTTY)
    await bench.until(lambda: bench.heard == [OFF, ON])  # though it only listens
    bench.send(b"R")
    assert await asyncio.to_thread(os.read, client, 10) == b"R"
    os.close(client)
    await bench.until(lambda: bench.heard == [OFF, ON, OFF])


@ON_LINUX
@on_both_loops
async def test_lines_go_off_after_the_last_byte_of_a_program(bench: Bench, free_port: int) -> None:
    await bench.open(SerialPty("com1", SerialPtySettings(baud=19200)))
    client = os.open(bench.run / "serial/com1", os.O_RDWR | os.O_NOCTTY)
    os.write(client, b"A" * 200)  # 104 ms
    os.close(client)
    await bench.until(lambda: bench.heard[-1] == OFF and len(bench.heard) > 1)
    assert bench.heard[:2] == [OFF, ON]
    assert bench.data() == b"A" * 200


@ON_LINUX
@on_both_loops
async def test_lines_go_off_after_the_last_byte_on_a_late_host_too(bench: Bench, free_port: int) -> None:
    bench.clock.late_ns_each = 15 * MS  # the line is idle for 5 ms each time
    await bench.open(SerialPty("com1", SerialPtySettings(baud=19200)))
    client = os.open(bench.run / "serial/com1", os.O_RDWR | os.O_NOCTTY)
    os.write(client, b"A" * 190)  # 99 ms, in five portions: the last is on the line when its time is over
    os.close(client)
    await bench.until(lambda: bench.heard[-1] == OFF and len(bench.heard) > 1)
    assert bench.data() == b"A" * 190


@ON_LINUX
@on_both_loops
async def test_lines_are_off_for_a_while_before_the_next_program_is_heard(bench: Bench, free_port: int) -> None:
    instants_ns: dict[int, int] = {}
    await bench.open(SerialPty("com1", SerialPtySettings(baud=1_000_000)))
    path = bench.run / "serial/com1"
    client = os.open(path, os.O_RDWR | os.O_NOCTTY)
    await bench.until(lambda: bench.heard == [OFF, ON])
    os.close(client)
    client = os.open(path, os.O_RDWR | os.O_NOCTTY)  # at once, before the port has noticed anything
    os.write(client, b"ATZ\r")
    await bench.until(lambda: bench.heard == [OFF, ON, OFF])
    bench.send(b"NO CARRIER")  # for the first program

    def is_heard() -> bool:
        instants_ns.setdefault(len(bench.heard), bench.clock.now_ns())
        return bench.data() == b"ATZ\r"

    await bench.until(is_heard)
    bench.send(b"O")
    assert await asyncio.to_thread(os.read, client, 1) == b"O"
    os.close(client)
    assert bench.heard[:5] == [OFF, ON, OFF, ON, b"ATZ\r"]
    assert instants_ns[max(instants_ns)] - instants_ns[3] > OFF_NS - 50 * MS  # the test looks each ms, or later


@pytest.mark.skipif(sys.platform == "win32", reason="no ptys on Windows")
@on_both_loops
async def test_flood_into_a_pty_is_held_up_and_not_lost(bench: Bench, free_port: int) -> None:
    path = bench.run / "elsewhere"
    await bench.open(SerialPty("com1", SerialPtySettings(baud=1_000_000, path="elsewhere")))
    flood = os.urandom(50_000)
    with path.open("wb", buffering=0) as client:
        written = asyncio.to_thread(
            lambda: sum(client.write(flood[at : at + 1000]) or 0 for at in range(0, 50_000, 1000))
        )
        assert await written == len(flood)
        await bench.until(lambda: len(bench.data()) >= len(flood))
    assert bench.data() == flood


@pytest.mark.filterwarnings("ignore:set(Daemon|Name):DeprecationWarning")  # in pyserial
@on_both_loops
async def test_pyserial_sets_the_format_and_gets_the_modem_lines(bench: Bench, free_port: int) -> None:
    await bench.open(SerialRfc2217("com1", SerialRfc2217Settings(listen=f"127.0.0.1:{free_port}")))
    bench.send(ControlLines(dtr=True, rts=False))
    url = f"rfc2217://127.0.0.1:{free_port}"
    port = await asyncio.to_thread(serial.serial_for_url, url, 19200, bytesize=7, parity="E", stopbits=2, timeout=20)
    try:
        await bench.until(lambda: Format(19200, 7, "E", 2) in bench.heard)
        assert (port.cts, port.dsr, port.cd, port.ri) == (False, True, True, False)
        await asyncio.to_thread(setattr, port, "baudrate", 300)
        await bench.until(lambda: Format(300, 7, "E", 2) in bench.heard)
        await asyncio.to_thread(setattr, port, "rtscts", True)  # held, as RTS of this end is off
        await asyncio.to_thread(port.write, b"held")
        bench.send(ControlLines(ri=True))
        await bench.until(lambda: port.cts and port.ri)
        await bench.until(lambda: bench.data() == b"held")
        with pytest.raises(ValueError, match="remote rejected value"):
            await asyncio.to_thread(setattr, port, "stopbits", 1.5)
    finally:
        await asyncio.to_thread(port.close)
    await bench.until(lambda: bench.heard[-2:] == [Format(), OFF])


@on_both_loops
async def test_rfc2217_port_accepts_any_bytes(bench: Bench, free_port: int) -> None:
    await bench.open(SerialRfc2217("com1", SerialRfc2217Settings(listen=f"127.0.0.1:{free_port}", paced=False)))
    with connect(free_port) as client:
        client.sendall(b"\xff\xf0\xff\xfa\xff\xf0\xff\xfa\x2c\x01\xff\xf0\xff\xfa\x2c\x05\x05\xff\xf0\xff\xfc\xf1")
        client.sendall(b"still here")
        await bench.until(lambda: bench.data() == b"still here")
    await bench.until(lambda: any(isinstance(message, Break) for message in bench.heard))
    assert bench.heard[-1] == OFF


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ({}, "either listen: host:port or dial: host:port"),
        ({"listen": "127.0.0.1:1", "dial": "127.0.0.1:2"}, "either listen: host:port or dial: host:port"),
        ({"listen": "5000"}, "expected host:port"),
        ({"listen": "127.0.0.1:1", "baud": 0}, "greater than or equal to 1"),
        ({"listen": "127.0.0.1:1", "parity": "X"}, "'N', 'E' or 'O'"),
        ({"listen": "127.0.0.1:1", "speed": 9600}, "Extra inputs"),
    ],
)
def test_wrong_settings_are_refused(settings: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValidationError, match=complaint):
        SerialTcpSettings.model_validate(settings)


def test_tools_are_lines_to_copy() -> None:
    run = Path("run")
    lines = [
        tool.line
        for bus in (
            SerialPty("com1", SerialPtySettings(baud=19200)),
            tcp(5001),
            SerialRfc2217("com3", SerialRfc2217Settings(listen="127.0.0.1:5002")),
        )
        for tool in bus.tools(run)
    ]
    assert "python -m serial.tools.miniterm run/serial/com1 19200" in lines
    assert "python -m serial.tools.miniterm socket://127.0.0.1:5001 9600" in lines
    assert "python -m serial.tools.miniterm rfc2217://127.0.0.1:5002 9600" in lines
