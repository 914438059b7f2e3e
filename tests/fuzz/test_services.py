"""Corrupted requests of HTTP and commands of FTP, and corrupted bytes at COM1, have no effect but the specified one."""

import random
from collections.abc import Callable
from http import HTTPStatus

import pytest
from com1_bench import CARRIER, CONNECT, OK, READY, Com1Bench
from spoiling import spoilt
from tcp_client import ServedConnection

from fieldrig.clock import S, VirtualClock
from fieldrig.storage.store import MemoryStore
from fieldrig_devices.connections.connection import Serve
from fieldrig_devices.ftp import server as ftp
from fieldrig_devices.ftp.login import FtpLogin
from fieldrig_devices.http import server as http
from fieldrig_devices.http.messages import Request, Response, refusal
from fieldrig_devices.max4.storage.disk import FlashDisk
from fieldrig_devices.max4.storage.ftp_files import FtpFiles

pytestmark = pytest.mark.system

SEED = 2026
GET = b"GET /values?of=belt.Position HTTP/1.1\r\nHost: plc\r\nContent-Length: 3\r\n\r\nabc"
CHUNKED = b"HEAD /%41.HTM HTTP/1.1\r\nHost: plc\r\nTransfer-Encoding: chunked\r\n\r\n5;a=b\r\nabcde\r\n0\r\n\r\n"
LOGIN = b"USER service\r\nPASS pacdrive\r\n"
FILES = b"EPSV\r\nSTOR A.HTM\r\nRNFR A.HTM\r\nRNTO B.HTM\r\nSIZE B.HTM\r\nDELE B.HTM\r\nABOR\r\n"


def _http(clock: VirtualClock) -> Serve:
    return http.serving(clock, _answer)


def _answer(request: Request) -> Response:
    assert request.path.startswith("/")
    return refusal(HTTPStatus.NOT_FOUND)


def _ftp(clock: VirtualClock) -> Serve:
    return ftp.serving(clock, FtpFiles(FlashDisk(MemoryStore(), 65_536)), FtpLogin("service", "pacdrive"))


SERVICES: dict[str, tuple[Callable[[VirtualClock], Serve], list[bytes], bytes]] = {
    "http": (_http, [GET, CHUNKED, GET * 3], b"HTTP/1.1 "),
    "ftp": (_ftp, [LOGIN + FILES, LOGIN, FILES], b"220 "),
}


@pytest.mark.parametrize("name", SERVICES)
def test_a_service_answers_the_next_client(name: str, inputs_a_target: int) -> None:
    make, seeds, begin = SERVICES[name]
    chance = random.Random(f"{SEED}/{name}")
    clock = VirtualClock()
    serve = make(clock)
    for _ in range(inputs_a_target):
        connection = ServedConnection(serve)
        connection.session.received(spoilt(chance, seeds))
        if connection.serve_extra is not None:
            data = ServedConnection(connection.serve_extra)
            data.send(b"data")
            data.end()
        connection.end()
        assert connection.is_closed
        arrived = connection.take()
        assert arrived == b"" or arrived.startswith(begin)
        clock.advance_to(clock.now_ns() + 20 * S)
    assert clock.next_ns() is None or clock.advance_to(clock.now_ns() + 400 * S) > clock.now_ns()


@pytest.mark.share(0.2)
def test_com1_finds_its_modem_again(inputs_a_target: int) -> None:
    chance = random.Random(f"{SEED}/com1")
    bench = Com1Bench()
    for _ in range(inputs_a_target):
        bench.says(chance.choice([READY, CARRIER]), spoilt(chance, [OK, CONNECT, b"AT&F E0\r" + OK])).run(0.3)
    bench.says(READY).run(60)
    bench.port.end()
    bench.port.boot(bench.parameters)
    assert bench.offline().states[0] == 6
