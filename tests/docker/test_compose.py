"""The lab in containers: built, started, and used from outside by a CANopen and a Modbus master."""

import json
import os
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import addresses
import can
import canopen
import pytest
from pymodbus import FramerType
from pymodbus.client import ModbusTcpClient

pytestmark = [pytest.mark.docker, pytest.mark.timeout(600)]

FOLDER = Path(__file__).parents[2] / "docker"
CONFIGS = FOLDER.parent / "configs"
PARTS = {"rig", "can0", "tank", "io", "sensor", "drive"}
READY_LIMIT_S = 90


@dataclass(frozen=True, slots=True)
class Stack:
    """One Compose project, and the ports of this machine where it can be reached."""

    project: str
    ports: Mapping[str, int]

    @property
    def environment(self) -> Mapping[str, str]:
        return {**os.environ, **{f"FIELDRIG_{name}_PORT": str(port) for name, port in self.ports.items()}}

    def compose(self, *arguments: str) -> str:
        command = [*_compose(), "-p", self.project, "-f", str(FOLDER / "compose.yaml"), *arguments]
        done = subprocess.run(command, env=self.environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout[-3000:]}{done.stderr[-3000:]}"
        return done.stdout

    def containers(self) -> dict[str, Any]:
        """What Docker says of each container, by the name of its service."""
        ids = self.compose("ps", "-q").split()
        inspected = json.loads(_docker("inspect", *ids))
        return {one["Config"]["Labels"]["com.docker.compose.service"]: one for one in inspected}

    def wait_until_healthy(self) -> None:
        give_up = time.monotonic() + READY_LIMIT_S
        while waiting := {name: _health(one) for name, one in self.containers().items() if _health(one) != "healthy"}:
            if time.monotonic() > give_up:
                pytest.fail(f"not healthy: {waiting}\n{self.compose('logs', '--no-color', '--tail=20')}")
            time.sleep(0.5)


@pytest.fixture(scope="module")
def stack() -> Iterator[Stack]:
    ports = {name: addresses.free_port() for name in ("SOCKETCAND", "SLCAN", "MODBUS", "RTU")}
    stack = Stack(f"fieldrig-test-{os.getpid()}", ports)
    try:
        stack.compose("build")
        stack.compose("up", "-d")
        stack.wait_until_healthy()
        yield stack
    finally:
        stack.compose("down", "--volumes")


def test_every_part_runs_and_is_shut_in(stack: Stack) -> None:
    containers = stack.containers()
    assert containers.keys() == PARTS
    for one in containers.values():
        host = one["HostConfig"]
        assert host["ReadonlyRootfs"]
        assert host["CapDrop"] == ["ALL"]
        assert "no-new-privileges:true" in host["SecurityOpt"]
        assert one["Config"]["User"] not in ("", "0", "root")
        published = [binding["HostIp"] for bindings in host["PortBindings"].values() for binding in bindings]
        assert set(published) <= {"127.0.0.1"}


def test_canopen_master_reads_back_what_it_writes(stack: Stack) -> None:
    with _io_node(stack) as node:
        assert node.sdo[0x1000].raw & 0xFFFF == 401
        outputs = node.sdo[0x6200][1]
        outputs.raw = 0xA5
        assert outputs.raw == 0xA5


def test_modbus_master_starts_the_pump_and_the_canopen_master_sees_the_tank_fill(stack: Stack) -> None:
    with _io_node(stack) as node, ModbusTcpClient("127.0.0.1", port=stack.ports["MODBUS"]) as drive:
        level_tenth_mm = node.sdo[0x6401][1]
        before = level_tenth_mm.raw
        assert not drive.write_register(0, 1000, device_id=1).isError()  # 100.0 %
        assert not drive.write_coil(0, True, device_id=1).isError()
        _wait_until(lambda: level_tenth_mm.raw >= before + 40)  # 4 mm, a second's worth
        assert not drive.write_coil(0, False, device_id=1).isError()


def test_what_has_a_pty_in_the_lab_has_a_port_here(stack: Stack) -> None:
    with ModbusTcpClient("127.0.0.1", port=stack.ports["RTU"], framer=FramerType.RTU) as drive:
        assert drive.read_coils(0, count=2, device_id=1).bits[:2] == [False, False]
    with can.Bus(f"socket://127.0.0.1:{stack.ports['SLCAN']}", "slcan", bitrate=250_000) as bus:
        bus.send(can.Message(arbitration_id=0x605, data=bytes.fromhex("40 00 10 00 00 00 00 00"), is_extended_id=False))
        _wait_until(lambda: _is_answer(bus.recv(1)))


def test_a_part_that_is_killed_comes_back(stack: Stack) -> None:
    before = stack.containers()["sensor"]["RestartCount"]
    kill_all = "import os, signal; os.kill(-1, signal.SIGKILL)"
    # its own exit code is left alone: the container may be gone before or after this command ends
    subprocess.run(["docker", "exec", stack.containers()["sensor"]["Id"], "python", "-c", kill_all], check=False)
    _wait_until(lambda: stack.containers()["sensor"]["RestartCount"] > before)
    stack.wait_until_healthy()


@pytest.mark.parametrize("name", ["compose.yaml", "compose.vcan.yaml"])
def test_compose_files_are_valid(name: str) -> None:
    done = subprocess.run(
        [*_compose(), "-f", str(FOLDER / name), "config", "-q"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


@contextmanager
def _io_node(stack: Stack) -> Iterator[canopen.RemoteNode]:
    """The I/O node as a master on this machine sees it, by socketcand."""
    with can.Bus("can0", "socketcand", host="127.0.0.1", port=stack.ports["SOCKETCAND"]) as bus:
        network = canopen.Network(bus)
        network.connect()
        try:
            yield network.add_node(5, str(CONFIGS / "eds" / "io32.eds"))
        finally:
            network.disconnect()


def _is_answer(message: can.Message | None) -> bool:
    """What object 1000h of the I/O node holds, by expedited SDO: 000F0191h."""
    return message is not None and bytes(message.data) == bytes.fromhex("43 00 10 00 91 01 0f 00")


def _wait_until(is_so: Callable[[], bool]) -> None:
    give_up = time.monotonic() + READY_LIMIT_S
    while not is_so():
        assert time.monotonic() < give_up
        time.sleep(0.5)


def _health(container: Mapping[str, Any]) -> str:
    return str(container["State"].get("Health", {}).get("Status", container["State"]["Status"]))


def _compose() -> list[str]:
    """Compose 2 if Docker has it, else the old program."""
    has_plugin = subprocess.run(["docker", "compose", "version"], capture_output=True, check=False).returncode == 0
    return ["docker", "compose"] if has_plugin or shutil.which("docker-compose") is None else ["docker-compose"]


def _docker(*arguments: str) -> str:
    return subprocess.run(["docker", *arguments], capture_output=True, text=True, check=True).stdout
