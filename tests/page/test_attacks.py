"""A page under attack: junk, strangers and a thousand connections, while the rig runs on."""

import asyncio
import http.client
import socket
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from in_loop import in_loop
from lamp_rig import KINDS, lamp_rig
from page_addresses import WITH_PAGE, addresses
from running_rig import RunningRig, until
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from fieldrig.system.descriptors import ensure_for
from fieldrig.testing import free_port
from fieldrig_page.connections import LIMITS
from fieldrig_page.live import MOST_SOCKETS

pytestmark = [pytest.mark.system, pytest.mark.long]

MANY = 1_000


@pytest.fixture(scope="module")
def rig() -> Iterator[RunningRig]:
    with RunningRig(lamp_rig(), KINDS, f"--set=ui.listen=127.0.0.1:{free_port()}", environment=WITH_PAGE) as running:
        yield running.until_ready()


def place(rig: RunningRig) -> tuple[str, int]:
    parts = urlsplit(addresses(rig)["operate"])
    assert parts.hostname is not None
    assert parts.port is not None
    return parts.hostname, parts.port


def cookie(rig: RunningRig) -> dict[str, str]:
    token = addresses(rig)["operate"].partition("token=")[2]
    return {"Cookie": f"fieldrig-{place(rig)[1]}={token}"}


def status_of(rig: RunningRig) -> int:
    """Return the status of a request of a user."""
    line = http.client.HTTPConnection(*place(rig), timeout=60)
    line.request("GET", "/api/v1/status", headers=cookie(rig))
    status = line.getresponse().status
    line.close()
    return status


def socket_of(rig: RunningRig) -> connect:
    host, port = place(rig)
    return connect(f"ws://{host}:{port}/live", origin=f"http://{host}:{port}", additional_headers=cookie(rig))  # type: ignore[arg-type]


def test_a_thousand_silent_connections_keep_no_user_out(rig: RunningRig) -> None:
    ensure_for(0)
    before = rig.status()["processes"]
    silent = [socket.create_connection(place(rig), timeout=60) for _ in range(MANY)]
    try:
        assert status_of(rig) == 200
        after = rig.status()["processes"]
        assert {name: process["pid"] for name, process in after.items()} == {
            name: process["pid"] for name, process in before.items()
        }
        page = rig.status()["ui"]
        assert page["restarts"] == 0
        assert len(list(Path(f"/proc/{page['pid']}/fd").iterdir())) < LIMITS.connections
    finally:
        for connection in silent:
            connection.close()
    assert rig.json("status")["client_limits"]["ui"]["connections over the limit"] >= MANY - LIMITS.connections


@in_loop
async def test_a_thousand_sockets_are_bounded_and_those_that_are_in_go_on(rig: RunningRig) -> None:
    found = await asyncio.gather(*(socket_of(rig) for _ in range(MANY)), return_exceptions=True)
    opened = [one for one in found if isinstance(one, ClientConnection)]
    assert 0 < len(opened) <= MOST_SOCKETS
    assert len(await opened[0].recv()) > 0
    assert rig.status()["ui"]["restarts"] == 0
    await asyncio.gather(*(one.close() for one in opened))
    assert await asyncio.to_thread(status_of, rig) == 200


@in_loop
async def test_a_message_over_the_limit_closes_its_own_socket(rig: RunningRig) -> None:
    async with socket_of(rig) as other, socket_of(rig) as attacker:
        await other.recv()
        await attacker.recv()
        await attacker.send(bytes(1 << 20))
        with pytest.raises(ConnectionClosed) as closed:
            await attacker.recv()
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1009  # message too big (RFC 6455, 7.4.1)
        assert (await other.ping()) is not None


@in_loop
async def test_strangers_are_refused_before_a_socket_opens(rig: RunningRig) -> None:
    host, port = place(rig)
    for headers, origin in (({}, f"http://{host}:{port}"), (cookie(rig), "http://evil.example"), (cookie(rig), None)):
        with pytest.raises(InvalidStatus) as refused:
            await connect(f"ws://{host}:{port}/live", origin=origin, additional_headers=headers)  # type: ignore[arg-type]
        assert refused.value.response.status_code == 403


@pytest.mark.parametrize(
    "junk",
    [
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",  # the begin of TLS
        b"GET / HTTP/1.1\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n",
        b"GET /%ff%fe?token=%ff HTTP/1.1\r\nHost: a\r\nCookie: \xff\xfe\r\n\r\n",
        b"POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 99999999999\r\n\r\n",
        b"GET / HTTP/1.1\r\n" + b"X: " + b"y" * 200_000,
        b"\0" * 10_000,
    ],
)
def test_junk_on_a_connection_is_answered_or_dropped(rig: RunningRig, junk: bytes) -> None:
    with socket.create_connection(place(rig), timeout=60) as line:
        answer = b""
        try:
            line.sendall(junk)
            line.shutdown(socket.SHUT_WR)
            while part := line.recv(65536):
                answer += part
        except TimeoutError:
            raise
        except OSError:
            pass  # it may be reset at any byte, and then it has no end to shut down
        assert b" 200 " not in answer.partition(b"\r\n")[0]
    assert status_of(rig) == 200


@in_loop
async def test_what_a_client_does_wrong_leaves_no_traceback_in_the_log(rig: RunningRig) -> None:
    """A request that ended in its middle, and a text that is not UTF-8, looked like faults of the server."""
    host, port = place(rig)
    head = f"POST /api/v1/rig/stop HTTP/1.1\r\nHost: {host}:{port}\r\nCookie: {cookie(rig)['Cookie']}\r\n"
    with socket.create_connection((host, port), timeout=60) as line:
        line.sendall(f"{head}Content-Length: 100\r\n\r\n".encode())
        assert status_of(rig) == 200  # the server has begun to read it
    async with socket_of(rig) as live:
        await live.recv()
        await live.send(b"\xff", text=True)
        await live.wait_closed()
    assert status_of(rig) == 200
    log = rig.run / "log/_ui.log"
    until(lambda: "UTF-8" in log.read_text())
    assert "Traceback" not in log.read_text()
