"""A ring in real time runs on while strangers are at its page: its cycles go on, and no process starts again."""

import http.client
import socket
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from page_addresses import WITH_PAGE, addresses
from running_rig import RunningRig, until

from fieldrig.system.descriptors import ensure_for
from fieldrig.testing import free_port

pytestmark = [pytest.mark.system, pytest.mark.long]

RING = Path(__file__).parents[2] / "configs" / "ring.yaml"
MANY = 1_000
JUNK = (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", b"GET / HTTP/1.1\r\nX: " + b"y" * 200_000, b"\0" * 10_000)


@pytest.fixture(scope="module")
def ring() -> Iterator[RunningRig]:
    listening = ("ui.listen", "buses.can0.socketcand", "buses.modbus.listen")
    options = [f"--set={key}=127.0.0.1:{free_port()}" for key in listening]
    with RunningRig(RING, None, *options, environment=WITH_PAGE) as running:
        running.until_ready()
        until(lambda: running.value("max4/ring.state") == "up")
        yield running


def cycles(ring: RunningRig) -> int:
    """Return the number of cycles so far."""
    return int(ring.ask("bus/ring/status")["cycles"])


def test_a_ring_runs_on_beside_a_thousand_connections_and_junk(ring: RunningRig) -> None:
    ensure_for(0)
    parts = urlsplit(addresses(ring)["operate"])
    assert parts.hostname is not None
    assert parts.port is not None
    place = parts.hostname, parts.port
    before = {name: process["pid"] for name, process in ring.status()["processes"].items()}
    with ExitStack() as open_ones:
        for number in range(MANY):
            line = open_ones.enter_context(socket.create_connection(place, timeout=60))
            if number % 10 == 0:
                try:
                    line.sendall(JUNK[number // 10 % len(JUNK)])
                except OSError:
                    continue  # it may be closed at any byte
        begin = cycles(ring)
        until(lambda: cycles(ring) > begin + 100)
        stranger = http.client.HTTPConnection(*place, timeout=60)
        stranger.request("POST", "/api/v1/rig/stop", headers={"Origin": "http://evil.example"})
        assert stranger.getresponse().status == 403
        stranger.close()
    assert {name: process["pid"] for name, process in ring.status()["processes"].items()} == before
    assert ring.value("max4/ring.state") == "up"
    assert ring.status()["ui"]["restarts"] == 0
