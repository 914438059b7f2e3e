"""The limits that services have of their own: the port counts and logs each."""

import asyncio
import logging
from contextlib import suppress
from http import HTTPStatus
from pathlib import Path

import pytest
from ftp_bench import Folder
from in_loop import in_loop
from patience import PATIENCE_S
from strangers import hub_of
from tcp_client import ServedConnection

from fieldrig.clock import S, VirtualClock
from fieldrig_bus.net import ServingPort
from fieldrig_devices.connections.connection import TOO_LONG, UNREAD, Serve
from fieldrig_devices.connections.face import TcpFace
from fieldrig_devices.ftp import server as ftp
from fieldrig_devices.ftp.login import FtpLogin
from fieldrig_devices.http import server as http
from fieldrig_devices.http.messages import Request, Response
from fieldrig_devices.pam.ports.access.s7 import serving_s7
from fieldrig_devices.pam.ports.access.word_service import serving_words
from fieldrig_devices.pam.ports.memory import Memory

CLOCK = VirtualClock()
GET = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
ISO_CONNECT = bytes.fromhex("03 00 00 16 11 e0 00 00 00 01 00 c1 02 01 00 c2 02 01 02 c0 01 0a")
S7_SETUP = bytes.fromhex("03 00 00 19 02 f0 80 32 01 00 00 00 00 00 08 00 00 f0 00 00 01 00 01 01 e0")
S7_READ = bytes.fromhex("03 00 00 1f 02 f0 80 32 01 00 00 00 01 00 0e 00 00 04 01 12 0a 10 02 00 c8 00 01 84 00 00 00")
WORDS_READ = bytes.fromhex("52 0000 0400")
LOGIN = b"USER a\r\nPASS b\r\n"
ENOUGH = 1_000


def page(_request: Request) -> Response:
    return Response(HTTPStatus.OK, bytes(10_000), "text/html")


SERVICES: dict[str, Serve] = {
    "ftp": ftp.serving(CLOCK, Folder(), FtpLogin("a", "b", lambda _: None)),
    "http": http.serving(CLOCK, page),
    "s7": serving_s7(Memory(), 1, "big"),
    "dualport": serving_words(Memory()),
}


@pytest.mark.parametrize(
    ("service", "begin", "message"),
    [
        ("ftp", b"", b"NOOP\r\n"),
        ("http", b"", GET),
        ("s7", ISO_CONNECT + S7_SETUP, S7_READ),
        ("dualport", b"", WORDS_READ),
    ],
)
def test_a_client_that_reads_nothing_is_closed(service: str, begin: bytes, message: bytes) -> None:
    client = ServedConnection(SERVICES[service], is_taking=False)
    client.send(begin)
    for _ in range(ENOUGH):
        client.send(message * 10)
    assert client.limit == UNREAD


@pytest.mark.parametrize(
    ("service", "sent", "limit"),
    [
        ("ftp", LOGIN + b"EPSV\r\nLIST\r\n" + b"NOOP\r\n" * 65, ftp.TOO_MANY_LINES),
        ("ftp", b"X" * 1025, TOO_LONG),
        ("ftp", b"USER a\r\nPASS c\r\n" * 3, ftp.TOO_MANY_FAILURES),
        ("http", b"GET / HTTP/1.1\r\nHost: localhost\r\nX: " + b"x" * (1 << 15) + b"\r\n\r\n", TOO_LONG),
        ("http", b"GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 70000\r\n\r\n" + bytes(70_000), TOO_LONG),
    ],
)
def test_a_limit_of_the_protocol_has_its_name(service: str, sent: bytes, limit: str) -> None:
    client = ServedConnection(SERVICES[service])
    client.send(sent)
    CLOCK.advance_to(CLOCK.now_ns() + 20 * S)  # a wrong login is answered later
    assert client.limit == limit


@pytest.mark.parametrize("sent", [b"QUIT\r\n", b"GET / HTTP/1.1\r\n", b""])
def test_an_end_that_is_no_limit_has_none(sent: bytes) -> None:
    client = ServedConnection(SERVICES["ftp"])
    client.send(sent)
    CLOCK.advance_to(CLOCK.now_ns() + 301 * S)
    assert client.is_closed
    assert client.limit == ""


@in_loop
async def test_the_port_counts_and_logs_a_limit(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async with hub_of("tcp.server", tmp_path, listen={"ftp": "127.0.0.1:0"}) as hub:
        TcpFace(hub.join("plc"), {"ftp": SERVICES["ftp"]}).open()
        (port,) = [port for port in hub._ports if isinstance(port, ServingPort)]
        (server,) = port.servers()
        with caplog.at_level(logging.WARNING):
            async with asyncio.timeout(PATIENCE_S):
                reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
                writer.write(b"USER a\r\nPASS wrong\r\n" + b"NOOP\r\n" * 100)  # a wrong login is answered later
                with suppress(ConnectionResetError):  # as not all that the client sent was read
                    await reader.read()
                writer.close()
        assert hub.statistics()[ftp.TOO_MANY_LINES] == 1.0
        assert [each for each in caplog.records if ftp.TOO_MANY_LINES in each.getMessage()]
