"""IP of a call ends in the kernel: the wrapper of configs/teleservice.yaml in a network of its own, with TUN."""

import os
import signal
import socket
from collections.abc import Iterator
from pathlib import Path
from urllib.request import urlopen

import pytest
from dialled import Dialled, dialled
from network_namespace import addresses, devices, listening, network_namespace, routes, why_not
from patience import PATIENCE_S
from pymodbus.client import ModbusTcpClient
from running_rig import AskedRig, until

from fieldrig.testing import free_port

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(bool(why_not()), reason=why_not()),
]

RIG = Path(__file__).parents[2] / "configs" / "teleservice.yaml"
LOGIN = ("--user", "service", "--password", "pacdrive")
OFFLINE = 6  # Com1UserState
CONTROLLER = "190.200.100.100"
MAP_IDENTIFIER = 0x4D34  # register 0


@pytest.fixture(scope="module")
def network() -> Iterator[None]:
    with network_namespace():
        yield


@pytest.fixture(scope="module")
def rig(network: None) -> Iterator[AskedRig]:
    with AskedRig(RIG, None, "--set", "buses.relay.ip=kernel") as rig:
        rig.until_ready()
        until(lambda: rig.get("max4/Com1UserState") == OFFLINE)
        yield rig


def packets(rig: AskedRig) -> float:
    return float(rig.ask("bus/relay/status")["packets"])


def page(port: int, path: str = "/AXES.HTM") -> bytes:
    with urlopen(f"http://127.0.0.1:{port}{path}", timeout=PATIENCE_S) as answer:
        body: bytes = answer.read()
    return body


def test_the_kernel_serves_the_call_and_nothing_of_it_is_left(rig: AskedRig) -> None:
    pages, registers, closed = free_port(), free_port(), free_port()
    files = free_port()
    forwards = [f"{pages}:80", f"{registers}:502", f"{closed}:22", f"{files}:21"]
    ways = [word for way in forwards for word in ("--forward", way)]
    assert devices() == {"lo", "fieldrig0"}
    assert CONTROLLER not in addresses()
    with (
        socket.create_server(("127.0.0.1", 22)),
        dialled(str(rig.folder / "run/teleservice/modem"), *LOGIN, *ways) as dial,
    ):
        dial.until("Ctrl-C hangs up.")
        assert f"{CONTROLLER} peer 190.200.100.101/32" in addresses()
        assert [line.split()[:3] for line in routes()] == [["190.200.100.101", "dev", "fieldrig0"]]
        assert b">infeed</td>" in page(pages)
        with socket.create_connection(("127.0.0.1", files), timeout=PATIENCE_S) as control:
            assert control.recv(4) == b"220 "  # the server speaks first
        with ModbusTcpClient("127.0.0.1", port=registers, timeout=PATIENCE_S, retries=0) as client:
            assert client.read_holding_registers(0, count=1).registers == [MAP_IDENTIFIER]
        assert packets(rig) > 10
        assert listening() <= {"127.0.0.1", CONTROLLER}
        # Another program of this host is no service of the controller, and the controller is none of this host.
        with socket.create_connection(("127.0.0.1", closed), timeout=PATIENCE_S) as client_socket:
            assert client_socket.recv(1) == b""
        with socket.create_connection((CONTROLLER, 80), timeout=PATIENCE_S) as client_socket:
            assert client_socket.recv(1) == b""
        end(dial)
    until(lambda: CONTROLLER not in addresses())
    assert routes() == []


def test_a_killed_process_leaves_no_address(rig: AskedRig) -> None:
    with dialled(str(rig.folder / "run/teleservice/modem"), *LOGIN) as dial:
        dial.until("Ctrl-C hangs up.")
        assert CONTROLLER in addresses()
        os.kill(rig.pid("max4"), signal.SIGKILL)
        until(lambda: CONTROLLER not in addresses())
        assert routes() == []


def end(dial: Dialled) -> None:
    dial.process.send_signal(signal.SIGINT)
    code, said = dial.end()
    assert code == 0, said
