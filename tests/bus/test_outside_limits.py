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
from patience import PATIENCE_S
from strangers import Stranger, hello, hub_of

from fieldrig.hub.hub import LocalHub
from fieldrig.hub.wire import Kind, pack
from fieldrig_bus.modbus.message import ClientConnected
from fieldrig_bus.net import Connection, ServingPort, TcpServer
from fieldrig_bus.serial import outside
from fieldrig_bus.serial.message import ControlLines
from fieldrig_bus.tcp.message import Connected, Ended

pytestmark = [pytest.mark.system, pytest.mark.long]

HERE, ELSEWHERE = "127.0.0.1", "127.0.0.2"
MOST_SENT = 24 << 20
"""Bytes that the system may keep of a client: its own buffer and that of the port, which grow to some MB each."""
QUIET = 50
"""Attempts to send in a row that fail while the port reads nothing, after which the client counts as stopped."""

READ = bytes.fromhex("0001 0000 0006 01 03 0000 000a")  # Modbus TCP: ten registers of unit 1
READ_ASCII = b":01030000000AF2\r\n"  # the same on a line (Modbus over serial line V1.02, 2.5.2)
HELLO = bytes.fromhex("48454c46 20000000 00000000 ffff0000 ffff0000 00000000 00000000 ffffffff")
"""OPC 10000-6, table 54: the first message, without an endpoint."""
GET = b"GET / HTTP/1.1\r\n\r\n"
ISO_CONNECT = bytes.fromhex("03 00 00 16 11 e0 00 00 00 01 00 c1 02 01 00 c2 02 01 02 c0 01 0a")  # RFC 1006, ISO 8073
S7_READ = bytes.fromhex("03 00 00 1f 02 f0 80 32 01 00 00 00 01 00 0e 00 00 04 01 12 0a 10 02 00 01 00 01 84 00 00 00")
WORDS_READ = bytes.fromhex("52 0000 000a")
"""Ten words of a DualPort memory (`word_service`)."""


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
    has_turns: bool = True
    """True if clients take turns message by message; otherwise by portions, or by what the line carries."""
    port: int = 0
    """The place of the port among those of the bus."""


def of_service(service: str, first: bytes, flood: bytes, *, has_turns: bool = True) -> Row:
    """Return the row of a service of a device by TCP."""
    settings = {"listen": {service: "127.0.0.1:0"}}
    return Row("tcp.server", settings, first, flood, [service], heard_by_device=True, has_turns=has_turns)


def of_line(kind: str) -> Row:
    """Return the row of a serial line, on which one client at a time is."""
    return Row(kind, {"listen": "127.0.0.1:0"}, b"x", b"text\r\n", is_line=True, may_only_listen=True, has_turns=False)


CAN = {"socketcand": "127.0.0.1:0", "slcan": {"listen": "127.0.0.1:0"}, "bitrate": 125_000}
ROWS = {
    "modbus tcp": Row("modbus.tcp", {"listen": "127.0.0.1:0"}, READ, READ, [1]),
    "modbus line": Row("modbus.ascii", {"listen": "127.0.0.1:0"}, READ_ASCII, READ_ASCII, [1], has_turns=False),
    "socketcand": Row("can.hub", CAN, b"< open bus0 >", b"< send 123 8 1 2 3 4 5 6 7 8 >"),
    "lawicel": Row("can.hub", CAN, b"V\r", b"O\rt12381122334455667788\r", port=1),
    "http": of_service("http", GET, GET),
    "ftp": of_service("ftp", b"USER a\r\n", b"DELE A.HTM\r\n"),
    "s7": of_service("s7", ISO_CONNECT, S7_READ, has_turns=False),
    "dualport": of_service("dualport", WORDS_READ, WORDS_READ, has_turns=False),
    "opc ua": Row("opcua.server", {"listen": "127.0.0.1:0"}, HELLO, HELLO, heard_by_device=True, has_turns=False),
    "serial tcp": of_line("serial.tcp"),
    "rfc 2217": of_line("serial.rfc2217"),
    "telephone": Row(
        "telephone.exchange",
        {"numbers": {"device": "7"}, "incoming": [{"listen": "127.0.0.1:0", "number": "7"}]},
        b"x", b"text\r\n", may_only_listen=True, has_turns=False,
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


def end_of(server: TcpServer, client: socket.socket) -> Connection | None:
    """Return the port's end of this connection, if the port has let it in and has not closed it."""
    name = client.getsockname()
    for each in server.connections:
        if each.transport.get_extra_info("peername") == name and not each.transport.is_closing():
            return each
    return None


def is_there(server: TcpServer, client: socket.socket) -> bool:
    return end_of(server, client) is not None


async def until(condition: Any) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while not condition():
            await asyncio.sleep(0.005)


async def speak(row: Row, server: TcpServer, client: socket.socket) -> None:
    """Send the first message, and let it be one that is complete for the port."""
    await asyncio.get_running_loop().sock_sendall(client, row.first)
    if row.heard_by_device:  # no device here: say it in its place
        await until(lambda: is_there(server, client))
        end = end_of(server, client)
        assert end is not None
        end.heard()


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


STATES = (ClientConnected, ControlLines, Connected, Ended)
"""The messages to a device about a client that has not sent one yet."""
REQUESTS = (b"POST / HTTP/1.1", b"post / http/1.1", b"QUERY /a HTTP/1.1")


@pytest.mark.parametrize("name", [name for name in ROWS if name != "http"])
@in_loop
async def test_a_browser_that_was_sent_here_is_not_obeyed(name: str, tmp_path: Path) -> None:
    """A page of any site can make a browser send a header of its own, and behind it what the page likes."""
    row = ROWS[name]
    async with opened(row, tmp_path) as (hub, server):
        heard: list[Any] = []
        hub.on_delivery(heard.append)
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
        await until(lambda: is_there(server, client))
        assert await sent_until_stopped(row, server, client) <= MOST_SENT
        assert "device" in hub._members
        assert is_there(server, client)
        client.close()
        device.close()


async def sent_until_stopped(row: Row, server: TcpServer, client: socket.socket) -> int:
    """Send messages until the port stops the client, or more than the system may keep; return how many bytes."""
    flood = memoryview(row.flood * (1 + (1 << 16) // len(row.flood)))
    sent, place, quiet = client.send(row.first), 0, 0
    while quiet < QUIET and sent <= MOST_SENT:
        end = end_of(server, client)
        try:
            taken = client.send(flood[place : place + (1 << 15)])
        except BlockingIOError:
            quiet = 0 if end is None or end.transport.is_reading() else quiet + 1
            await asyncio.sleep(0.001)
        else:
            place = (place + taken) % len(row.flood)
            sent, quiet = sent + taken, 0
            await asyncio.sleep(0)
    return sent


@pytest.mark.parametrize("name", [name for name, row in ROWS.items() if row.has_turns])
@in_loop
async def test_a_turn_of_a_client_is_for_one_message(name: str, tmp_path: Path) -> None:
    """Others wait for no more; `tests/kernel/outside/test_portions.py` shows the turns."""
    row = ROWS[name]
    async with opened(row, tmp_path) as (_, server):
        client = connected(server)
        await until(lambda: is_there(server, client))
        end = end_of(server, client)
        assert end is not None
        message = row.flood.removeprefix(b"O\r")
        assert end.end_of_first(message * 3) == len(message)
        assert end.end_of_first(message[:-1]) == len(message) - 1
        client.close()
