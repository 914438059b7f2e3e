"""The machine in containers, from outside: foreign masters on its buses, and containers that are killed."""

import json
import re
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.request import urlopen

import pytest
from canopen import RemoteNode
from compose_stack import FOLDER, OUTSIDE, Stack, compose_program, node_of, shut_in, stack_of
from dialled import Dialled, dialled
from lab_process import IO32, LEVEL_SENSOR
from pymodbus import FramerType
from pymodbus.client import ModbusTcpClient

from fieldrig.config.rig_file import load
from fieldrig.real.placement import placement
from fieldrig.testing import free_port
from fieldrig_devices.arp.can.face import EDS as CARD
from fieldrig_devices.max4.can.objects import EDS as AXES

pytestmark = [pytest.mark.docker, pytest.mark.timeout(3600)]

MACHINE = FOLDER / "machine.yaml"
INSIDE = ("ring", "pamring", "wires", "com1", "telephone", "relay", "ua")
PROFILED_POSITION = 1
OFFLINE, ONLINE = 6, 7  # Com1UserState: the modem is set up and waits for a call; in a call
MAP_IDENTIFIER = 0x4D34  # register 0
# CiA 402, figure 8: what brings an axis to Operation enabled, by what its status word has under the mask 6Fh.
NEXT_WORD = {0x40: 0x06, 0x60: 0x06, 0x21: 0x07, 0x31: 0x07, 0x23: 0x0F, 0x33: 0x0F}
ENABLED = (0x27, 0x37)
FILM_AXIS = 1100  # registers of the second axis
UNDER_CONTROL, REACHED = 4, 16


@pytest.fixture(scope="module")
def stack() -> Iterator[Stack]:
    with stack_of("compose.yaml", (*OUTSIDE, "page")) as stack:
        yield stack


@pytest.mark.parametrize("name", ["compose.yaml", "compose.lab.yaml", "compose.vcan.yaml"])
def test_compose_files_are_valid(name: str) -> None:
    done = subprocess.run(
        [*compose_program(), "-f", str(FOLDER / name), "config", "-q"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_every_part_has_a_container_and_is_shut_in(stack: Stack) -> None:
    containers = stack.containers()
    assert containers.keys() == {"rig", *placement(load(MACHINE))}
    assert [name for name, container in containers.items() if not shut_in(container)] == []


def test_every_bus_has_one_address_for_foreign_masters(stack: Stack) -> None:
    assert sorted(load(MACHINE).buses) == sorted((*OUTSIDE, *INSIDE))
    published = [
        int(binding["HostPort"])
        for container in stack.containers().values()
        for bindings in container["HostConfig"]["PortBindings"].values()
        for binding in bindings
    ]
    assert sorted(published) == sorted(stack.ports.values())


@pytest.mark.parametrize(
    ("bus", "node_id", "eds", "device_type"),
    [
        ("can0", 5, IO32, 401),
        ("can0", 6, LEVEL_SENSOR, 404),
        ("can1", 1, IO32, 401),
        ("can1", 2, IO32, 401),
        ("can2", 1, AXES, 402),
        ("can2", 20, IO32, 401),
    ],
)
def test_canopen_master_finds_the_nodes(stack: Stack, bus: str, node_id: int, eds: Path, device_type: int) -> None:
    with stack.network(bus, bus) as network:
        assert node_of(network, node_id, eds).sdo[0x1000].raw & 0xFFFF == device_type


@pytest.mark.parametrize(
    ("bus", "framer"),
    [
        ("mb_tcp", FramerType.SOCKET),
        ("mb_rtu", FramerType.RTU),
        ("modbus", FramerType.SOCKET),
        ("labels", FramerType.SOCKET),
        ("labels_rtu", FramerType.RTU),
        ("dualport", FramerType.SOCKET),
    ],
)
def test_modbus_master_is_answered(stack: Stack, bus: str, framer: FramerType) -> None:
    with ModbusTcpClient("127.0.0.1", port=stack.ports[bus], framer=framer, timeout=20) as client:
        assert not client.read_holding_registers(0, count=1, device_id=1).isError()


def test_one_output_of_the_panel_enables_drives_and_cards(stack: Stack) -> None:
    """The film's I108 on one bus, the wrapper's panel on another, and wires between them."""
    with stack.network("can2", "can2") as wrapper, stack.network("can1", "can1") as film:
        output = node_of(wrapper, 20, IO32).sdo[0x6200][1]
        inputs = [node_of(film, card, CARD).sdo[0x2012][1] for card in (11, 12)]
        for value in (0, 1):
            output.raw = value
            stack.until(lambda: {word.raw >> 7 & 1 for word in inputs} == {value}, f"I108 is {value}")  # noqa: B023


def test_canopen_master_moves_an_axis_and_the_modbus_master_another(stack: Stack) -> None:
    with stack.network("can2", "can2") as network:
        axes = node_of(network, 1, AXES)
        _enable(stack, axes)
        begin = axes.sdo[0x6064].raw
        axes.sdo[0x6081].raw = 5_000_000  # increments/s
        axes.sdo[0x607A].raw = begin + 1_000_000  # a turn
        axes.sdo[0x6040].raw = 0x1F
        stack.until(lambda: abs(axes.sdo[0x6064].raw - begin - 1_000_000) < 1_000, "the infeed has turned")
    with ModbusTcpClient("127.0.0.1", port=stack.ports["modbus"], timeout=20) as client:
        _enable_film(stack, client)
        # position; a turn, 5 turns/s, 50 turns/s2 up and down; -, -; go so far from where it is
        move = [0, 0, 1_000, 0, 5_000, 0, 50_000, 0, 50_000, 0, 0, 0, 2]
        assert not client.write_registers(FILM_AXIS + 1, move, device_id=1).isError()
        stack.until(lambda: _film(client) & REACHED > 0, "the film has moved")


def test_a_caller_dials_in_and_reaches_every_service_and_again_after_a_lost_line(stack: Stack, tmp_path: Path) -> None:
    """The caller's modem, the telephone network and the controller's modem are in a container of their own."""
    mine = tmp_path / "MINE.HTM"
    mine.write_text('State <pac value="MAx-4.Com1UserState">.')
    with _call(stack) as (call, pages, proxy, registers):
        assert b"Max4 boot" in _page(pages, "")  # the first entry of the message logger
        way = ["--socks5", f"127.0.0.1:{proxy}", "--user", "service:pacdrive", "-T", str(mine)]
        subprocess.run(["curl", "-sS", "-m", "300", *way, "ftp://190.200.100.100/"], check=True)
        assert _page(pages, "MINE.HTM") == f"State {ONLINE}.".encode()
        with ModbusTcpClient("127.0.0.1", port=registers, timeout=60, retries=0) as client:
            assert client.read_holding_registers(0, count=1).registers == [MAP_IDENTIFIER]
        assert stack.fieldrig("fault", "telephone", "cut", "line=caller_modem").returncode == 0
        code, said = call.end()
        assert code != 0, said
    assert stack.fieldrig("fault", "telephone", "--clear", "all").returncode == 0
    with _call(stack) as (_, pages, _, _):
        assert b"bytes free" in _page(pages, "")


def test_ip_of_a_call_ends_in_the_kernel_of_a_container_that_may_have_tun(stack: Stack) -> None:
    assert _packets(stack) == 0, "the controller's container may not"
    stack.compose("up", "-d", "--no-deps", "max4", over=("compose.tun.yaml",))
    stack.until_ready()
    with _call(stack) as (_, pages, _, registers):
        assert b"bytes free" in _page(pages, "")
        with ModbusTcpClient("127.0.0.1", port=registers, timeout=60, retries=0) as client:
            assert client.read_holding_registers(0, count=1).registers == [MAP_IDENTIFIER]
        assert _packets(stack) > 10
    stack.compose("up", "-d", "--no-deps", "max4")
    stack.until_ready()


def _packets(stack: Stack) -> int:
    """Return how many IP packets have passed between calls and the kernel."""
    status = json.loads(stack.fieldrig("status", "--json").stdout)
    return int(status["buses"]["relay"]["statistics"]["packets"])


@contextmanager
def _call(stack: Stack) -> Iterator[tuple[Dialled, int, int, int]]:
    """A call, with local ports for pages, as a proxy, and for registers."""
    stack.until(lambda: f"= {OFFLINE}" in stack.fieldrig("get", "max4/Com1UserState").stdout, "the modem is set up")
    pages, proxy, registers = free_port(), free_port(), free_port()
    ways = ("--forward", f"{pages}:80", "--socks", str(proxy), "--forward", f"{registers}:502")
    line = f"tcp://127.0.0.1:{stack.ports['caller']}"
    with dialled(line, "--user", "service", "--password", "pacdrive", *ways) as call:
        call.until("Ctrl-C hangs up")
        yield call, pages, proxy, registers


def _page(port: int, name: str) -> bytes:
    with urlopen(f"http://127.0.0.1:{port}/{name}", timeout=300) as answer:
        content: bytes = answer.read()
    return content


def test_drive_that_is_killed_comes_back_and_the_ring_with_it(stack: Stack) -> None:
    """The ring waits for an acknowledgement, as its manual says."""
    before = stack.restarts()
    stack.kill("outfeed")
    stack.until(lambda: stack.restarts()["outfeed"] > before["outfeed"], "outfeed is started again")
    stack.until_ready()
    with stack.network("can2", "can2") as network:
        axes = node_of(network, 1, AXES)
        assert re.search(r"\t(2560|2561)\t", stack.fieldrig("get", "max4/log").stdout)
        _enable(stack, axes)
        _enable(stack, axes, outfeed := 3)
        assert axes.sdo[0x6041 + 0x800 * outfeed].raw & 0x6F in ENABLED
    assert _others(stack.restarts(), "outfeed") == _others(before, "outfeed")


def test_controller_that_is_killed_comes_back_and_the_ring_with_it(stack: Stack) -> None:
    before = stack.restarts()
    stack.kill("max4")
    stack.until(lambda: stack.restarts()["max4"] > before["max4"], "max4 is started again")
    stack.until_ready()
    stack.until(lambda: "= up" in stack.fieldrig("get", "max4/ring.state").stdout, "the ring is up, unasked")
    stack.until(lambda: _is_ring_whole(stack), "all drives are in the ring")
    with stack.network("can2", "can2") as network:
        _enable(stack, node_of(network, 1, AXES))
    with ModbusTcpClient("127.0.0.1", port=stack.ports["modbus"], timeout=20) as client:
        _enable_film(stack, client)
    assert _others(stack.restarts(), "max4") == _others(before, "max4")


def test_one_check_of_docker_finds_all_of_it_healthy_and_misses_a_part_that_is_gone(stack: Stack) -> None:
    stack.until_healthy()
    assert stack.health().keys() == {"rig"}
    stack.compose("stop", "sensor")
    stack.until(lambda: stack.health()["rig"] == "unhealthy", "the rig is unhealthy without its sensor")
    stack.compose("start", "sensor")
    stack.until_healthy()


def _is_ring_whole(stack: Stack) -> bool:
    """Return whether no diagnosis is left.

    A drive that could not answer in time on a busy host is left out, and is back with an acknowledgement only while no
    axis is in use.
    """
    values = stack.fieldrig("get", "max4/ring.state", "max4/DiagCode").stdout
    if "= up" in values and re.search(r"DiagCode = 0\b", values):
        return True
    stack.fieldrig("set", "max4/command=quit")
    return False


def _enable(stack: Stack, axes: RemoteNode, axis: int = 0) -> None:
    """Enable the axis as a CiA 402 master does, with as many fault resets as it takes."""
    base = 0x800 * axis
    control, status = axes.sdo[0x6040 + base], axes.sdo[0x6041 + base]
    axes.sdo[0x6060 + base].raw = PROFILED_POSITION

    def is_enabled() -> bool:
        state = status.raw & 0x6F
        if state in ENABLED:
            return True
        if state & 0x08:
            control.raw = 0x00
            control.raw = 0x80
        elif state in NEXT_WORD:
            control.raw = NEXT_WORD[state]
        return False

    stack.until(is_enabled, f"axis {axis} is enabled")


def _enable_film(stack: Stack, client: ModbusTcpClient) -> None:
    """A controller with a diagnosis refuses until it is acknowledged."""

    def is_enabled() -> bool:
        if _film(client) & UNDER_CONTROL:
            return True
        stack.fieldrig("set", "max4/command=quit")
        client.write_register(FILM_AXIS, 0, device_id=1)
        client.write_register(FILM_AXIS, 1, device_id=1)
        return False

    stack.until(is_enabled, "the film is under control")


def _film(client: ModbusTcpClient) -> int:
    """Status word of the axis."""
    return int(client.read_holding_registers(FILM_AXIS + 23, device_id=1).registers[0])


def _others(restarts: dict[str, int], but: str) -> dict[str, int]:
    return {name: count for name, count in restarts.items() if name != but}
