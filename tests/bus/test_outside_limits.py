"""The promises of every port about clients that want too much: silent ones, many of one host, a flood of messages.

The rows are the ports by which outsiders come in.  A row has the settings, the first complete message of a client, and
valid messages to flood it with.
"""

import asyncio
import json
import logging
import socket
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from in_loop import in_loop
from strangers import Stranger, hello, hub_of

from fieldrig.hub import LocalHub
from fieldrig.hub_wire import Kind, pack
from fieldrig_bus.modbus.message import ClientConnected
from fieldrig_bus.net import ServingPort, TcpServer
from fieldrig_bus.serial import outside
from fieldrig_bus.serial.message import ControlLines
from fieldrig_bus.tcp.message import Connected, Ended

pytestmark = [pytest.mark.system, pytest.mark.long]

HERE, ELSEWHERE = "127.0.0.1", "127.0.0.2"
MOST_SENT = 24 << 20
"""Bytes that the system may keep of a client: its own buffer and that of the port, which grow to some MB each."""
QUIET_S = 1.0
PATIENCE_S = 20.0

READ = bytes.fromhex("0001 0000 0006 01 03 0000 000a")  # Modbus TCP: ten registers of unit 1
READ_ASCII = b":01030000000AF2\r\n"  # the same on a line (Modbus over serial line V1.02, 2.5.2)
HELLO = bytes.fromhex("48454c46 20000000 00000000 ffff0000 ffff0000 00000000 00000000 ffffffff")
"""OPC 10000-6, table 54: the first message, without an endpoint."""
GET = b"GET / HTTP/1.1\r\n\r\n"


@dataclass(frozen=True)
class Row:
    """One port."""

    kind: str
    settings: dict[str, Any]
    first: bytes
    flood: bytes
    interest: Any = None
    """The interest of a device of the bus."""
    is_line: bool = False
    """True if one client at a time is on the line."""
    may_only_listen: bool = False
    heard_by_device: bool = False
    """True if only the device knows when a message is complete."""
    port: int = 0
    """The place of the port among those of the bus."""


CAN = {"socketcand": "127.0.0.1:0", "slcan": {"listen": "127.0.0.1:0"}, "bitrate": 125_000}
ROWS = {
    "modbus tcp": Row("modbus.tcp", {"listen": "127.0.0.1:0"}, READ, READ, [1]),
    "modbus line": Row("modbus.ascii", {"listen": "127.0.0.1:0"}, READ_ASCII, READ_ASCII, [1]),
    "socketcand": Row("can.hub", CAN, b"< open bus0 >", b"< send 123 8 1 2 3 4 5 6 7 8 >"),
    "lawicel": Row("can.hub", CAN, b"V\r", b"O\rt12381122334455667788\r", port=1),
    "http": Row(
        "tcp.server", {"listen": {"http": "127.0.0.1:0"}}, GET, GET, ["http"], heard_by_device=True,
    ),
    "opc ua": Row("opcua.server", {"listen": "127.0.0.1:0"}, HELLO, HELLO, heard_by_device=True),
    "serial tcp": Row("serial.tcp", {"listen": "127.0.0.1:0"}, b"x", b"text\r\n", is_line=True, may_only_listen=True),
    "rfc 2217": Row("serial.rfc2217", {"listen": "127.0.0.1:0"}, b"x", b"text\r\n", is_line=True, may_only_listen=True),
    "telephone": Row(
        "telephone.exchange",
        {"numbers": {"device": "7"}, "incoming": [{"listen": "127.0.0.1:0", "number": "7"}]},
        b"x", b"text\r\n", may_only_listen=True,
    ),
}  # fmt: skip


@asynccontextmanager
async def opened(row: Row, run: Path, has_device: bool = True) -> AsyncIterator[tuple[LocalHub, TcpServer]]:
    """Return the hub of the port, and its server."""
    async with hub_of(row.kind, run, **row.settings) as hub:
        if has_device and row.interest is not None:
            hub.join("device").on_receive(lambda _message: None, row.interest)
        ports = [port for port in hub._ports if isinstance(port, ServingPort)]
        (server,) = ports[row.port].servers()
        yield hub, server


def connected(server: TcpServer, host: str = HERE) -> socket.socket:
    """Return a connection from this address of this machine."""
    client = socket.socket()
    client.bind((host, 0))
    client.connect(("127.0.0.1", server.port))
    client.setblocking(False)
    return client


def is_there(server: TcpServer, client: socket.socket) -> bool:
    """Return whether the port has let this client in, and has not closed it."""
    name = client.getsockname()
    return any(
        each.transport.get_extra_info("peername") == name and not each.transport.is_closing()
        for each in server.connections
    )


async def until(condition: Any) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while not condition():
            await asyncio.sleep(0.005)


async def speak(row: Row, server: TcpServer, client: socket.socket) -> None:
    """Send the first message, and let it be one that is complete for the port."""
    await asyncio.get_running_loop().sock_sendall(client, row.first)
    if row.heard_by_device:  # no device here: say it in its place
        await until(lambda: is_there(server, client))
        name = client.getsockname()
        for each in server.connections:
            if each.transport.get_extra_info("peername") == name:
                each.heard()


@pytest.mark.parametrize("name", ROWS)
@in_loop
async def test_silent_connections_keep_nobody_out(
    name: str, tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    row = ROWS[name]
    monkeypatch.setattr(outside, "SILENT_S", 0.0)
    with caplog.at_level(logging.WARNING):
        async with opened(row, tmp_path) as (hub, server):
            silent = []
            for _ in range(300):
                silent.append(connected(server))
                await asyncio.sleep(0)
            # Where silence is allowed, a quarter of the places is for others.
            listens = row.may_only_listen and not row.is_line
            client = connected(server, ELSEWHERE if listens else HERE)
            await speak(row, server, client)
            await until(lambda: is_there(server, client))
            figures = hub.statistics()
            assert any(count and limit.startswith("connections") for limit, count in figures.items()), figures
            assert len(server.connections) <= 101
            for each in (*silent, client):
                each.close()
    assert any("connections" in record.getMessage() for record in caplog.records)


@pytest.mark.parametrize("name", [name for name, row in ROWS.items() if not row.is_line])
@in_loop
async def test_one_host_leaves_places_for_others(name: str, tmp_path: Path) -> None:
    row = ROWS[name]
    async with opened(row, tmp_path) as (_, server):
        greedy = []
        for _ in range(120):
            client = connected(server)
            greedy.append(client)
            for _ in range(5):  # turns of the loop in which the port decides about it
                await asyncio.sleep(0)
            if is_there(server, client):
                await speak(row, server, client)
        modest = connected(server, ELSEWHERE)
        await until(lambda: is_there(server, modest))
        assert sum(is_there(server, client) for client in greedy) <= server.door._limits.of_a_peer
        for client in (*greedy, modest):
            client.close()


@pytest.mark.parametrize("name", [name for name, row in ROWS.items() if not row.may_only_listen])
@in_loop
async def test_the_first_message_has_its_time(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    row = ROWS[name]
    async with opened(row, tmp_path) as (hub, server):
        silent, speaking = connected(server), connected(server)
        await until(lambda: is_there(server, silent) and is_there(server, speaking))
        await speak(row, server, speaking)
        await until(lambda: len(server.door._silent) == 1)
        monkeypatch.setattr(server.door, "_now_s", lambda: time.monotonic() + 31)
        server._on_timer()
        await until(lambda: not is_there(server, silent))
        assert is_there(server, speaking)
        assert hub.statistics()["connections without a message"] == 1.0
        silent.close()
        speaking.close()


FTP = Row("tcp.server", {"listen": {"ftp": "127.0.0.1:0"}}, b"USER a\r\n", b"DELE A.HTM\r\n", ["ftp"])
STATES = (ClientConnected, ControlLines, Connected, Ended)
"""What a device hears of a client that has not sent a message yet."""
TEXT_PORTS = {**{name: row for name, row in ROWS.items() if name != "http"}, "ftp": FTP}


REQUESTS = (b"POST / HTTP/1.1", b"post / http/1.1", b"QUERY /a HTTP/1.1")


@pytest.mark.parametrize("name", TEXT_PORTS)
@in_loop
async def test_a_browser_that_was_sent_here_is_not_obeyed(name: str, tmp_path: Path) -> None:
    """A page of any site can make a browser send a header of its own, and behind it what the page likes."""
    row = TEXT_PORTS[name]
    async with opened(row, tmp_path) as (hub, server):
        heard: list[Any] = []
        hub.on_delivery = heard.append
        for count, line in enumerate(REQUESTS, 1):
            browser = connected(server)
            await until(lambda: is_there(server, browser))  # noqa: B023  it is called before the next round
            header = line + b"\r\nHost: 127.0.0.1\r\nContent-Type: text/plain\r\n\r\n"
            await asyncio.get_running_loop().sock_sendall(browser, header + row.first + row.flood * 100)
            await until(lambda: not is_there(server, browser))  # noqa: B023
            assert hub.statistics()["requests of HTTP"] == count
            browser.close()
        assert [each for each in heard if each.sender.startswith(("tcp:", "socketcand", "lawicel"))
                and not isinstance(each.message, STATES)] == []  # fmt: skip


@pytest.mark.parametrize("name", ROWS)
@in_loop
async def test_a_flood_of_valid_messages_waits_in_the_client(name: str, tmp_path: Path) -> None:
    """A device that does not read what is for it, and a client that does not read its answers."""
    row = ROWS[name]
    async with opened(row, tmp_path, has_device=False) as (hub, server):
        device = await Stranger.at(tmp_path / "bus0.sock")
        device.say(hello("device"))
        if row.interest is not None:
            device.say(pack(Kind.LISTEN, 0, json.dumps(row.interest).encode()))
        await until(lambda: "device" in hub._members)
        client = connected(server)
        client.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 16)
        sent, quiet_s = client.send(row.first), time.monotonic()
        flood = memoryview(row.flood * (1 + (1 << 16) // len(row.flood)))
        place = 0
        while time.monotonic() - quiet_s < QUIET_S and sent <= MOST_SENT:
            try:
                taken = client.send(flood[place : place + (1 << 15)])
            except BlockingIOError:
                await asyncio.sleep(0.001)
            else:
                place = (place + taken) % len(row.flood)
                sent, quiet_s = sent + taken, time.monotonic()
                await asyncio.sleep(0)
        assert sent <= MOST_SENT
        assert "device" in hub._members
        assert is_there(server, client)
        client.close()
        device.close()
