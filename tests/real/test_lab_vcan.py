"""The lab on the kernel's CAN: can-utils, python canopen and npm's canopen on vcan0, and slcand at the hub's pty.

In user-mode Linux, where this runs if the kernel here has no vcan, a process takes a second to start.
"""

import json
import os
import re
import shutil
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Self

import can
import pytest
from canopen_network import BusOf
from lab_masters import IO, Pump, canopen_master, modbus_tcp, socketcand
from lab_process import LAB, LAB_ON_VCAN, LabProcess
from running_rig import until

pytestmark = [pytest.mark.real, pytest.mark.vcan]

VCAN0: BusOf = {"interface": "socketcan", "channel": "vcan0"}
START_TIMEOUT_S = 60
NODE = Path(__file__).parent / "node"


@pytest.fixture(scope="module")
def running_lab() -> Iterator[LabProcess]:
    """On vcan0."""
    with LabProcess(LAB_ON_VCAN, start_timeout_s=START_TIMEOUT_S) as lab:
        yield lab.until_ready()


@pytest.fixture
def lab(running_lab: LabProcess) -> LabProcess:
    running_lab.rest()
    return running_lab


def run(*command: str, limit_s: float = 60) -> str:
    if shutil.which(command[0]) is None:
        pytest.skip(f"{command[0]} is not installed")
    done = subprocess.run(command, capture_output=True, text=True, timeout=limit_s, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}{done.stderr}"
    return done.stdout


def listeners(channel: str) -> int:
    """Sockets that hear every frame; the lab's nodes hear only what is theirs."""
    lists = Path("/proc/net/can/rcvlist_all").read_text(encoding="utf-8")
    return len(re.findall(rf"^\s+{channel}\s", lists, re.MULTILINE))


class Candump:
    """can-utils' listener, which is listening when this is entered."""

    def __init__(self, channel: str) -> None:
        if shutil.which("candump") is None:
            pytest.skip("can-utils are not installed")
        before = listeners(channel)
        self._process = subprocess.Popen(["candump", "-L", channel], stdout=subprocess.PIPE, text=True)
        until(lambda: listeners(channel) > before)

    def until(self, *wanted: str) -> None:
        """Read on until frames such as 705#05 have come, in any order."""
        missing, frames = set(wanted), list[str]()
        assert self._process.stdout is not None
        while missing and (line := self._process.stdout.readline()):
            frames.append(line.split()[2])
            missing.discard(frames[-1])
        assert not missing, f"{missing} never came, but {frames}"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.communicate()


def cansend(channel: str, *frames: str) -> None:
    for frame in frames:
        run("cansend", channel, frame)


def test_can_utils_start_and_read_a_node(lab: LabProcess) -> None:
    with Candump("vcan0") as dump:
        cansend("vcan0", "000#8105")
        dump.until("705#00")
        cansend("vcan0", "605#4008100000000000")
        dump.until("585#43081000494F3332")  # IO32
        cansend("vcan0", "605#40F05F0000000000")
        dump.until("585#80F05F0000000206")  # no such object
        cansend("vcan0", "000#0105")
        dump.until("705#05")
        cansend("vcan0", "305#1027")
        dump.until("085#1082110208000000")  # too short a PDO: 2 bytes for 8


def test_can_utils_open_the_outlet_and_a_modbus_master_sees_the_tank_drain(lab: LabProcess) -> None:
    with modbus_tcp(lab) as client:
        pump = Pump(client)
        before_mm = pump.level_mm
        cansend("vcan0", "000#0105", "305#1027000000000000")
        until(lambda: pump.level_mm <= before_mm - 2)


def test_python_canopen_drives_the_lab(lab: LabProcess) -> None:
    with canopen_master(VCAN0) as master:
        master.reset()
        assert master.sensor.sdo[0x1008].raw == "Level sensor"
        master.io.sdo[0x6423].raw = True
        events = master.listen(0x280 + IO)
        master.start(master.io, master.sensor)
        with modbus_tcp(lab) as client:
            Pump(client).run(100)
        until(lambda: len(events) > 3)
        assert int.from_bytes(events[-1].data[:2], "little") > 5_000


def test_npm_canopen_drains_the_tank_by_pdos(lab: LabProcess) -> None:
    if not (NODE / "node_modules").is_dir():
        pytest.skip("npm's canopen is not installed: npm ci in tests/real/node")
    with canopen_master(VCAN0) as master:
        master.reset()
    levels = json.loads(run("node", str(NODE / "tank.js"), "vcan0", "5"))
    assert levels[0] == 500
    assert levels[-1] <= 495
    assert levels == sorted(levels, reverse=True)
    until(lambda: lab.get("tank/outlet") == 0)


def test_killed_node_boots_again(lab: LabProcess) -> None:
    restarts = lab.restarts("io")
    with Candump("vcan0") as dump:
        os.kill(lab.pids()["io"], signal.SIGKILL)
        dump.until("705#00")
    lab.until_back("io", restarts + 1)


def test_printed_lines_reach_the_nodes(lab: LabProcess) -> None:
    lines = lab.lines()
    assert lab.do(lines["io what it is"]) == "IO32"
    lab.do(lines["sensor start it"])
    until(lambda: lab.get("sensor/nmt.state") == "operational")


@pytest.fixture
def slcan0() -> Iterator[LabProcess]:
    """The lab with its hub, and a network device of it."""
    if shutil.which("slcand") is None:
        pytest.skip("can-utils are not installed")
    if Path("/proc/self/ns/net").readlink() != Path("/proc/1/ns/net").readlink():
        pytest.skip("slcan devices are in the first network only: run this in user-mode Linux")
    with LabProcess(LAB, start_timeout_s=START_TIMEOUT_S) as lab:
        lab.until_ready()
        command = "sudo slcand -o -c -s5 $(readlink -f run/lab/slcan) slcan0 && sudo ip link set slcan0 up"
        assert lab.lines()["can0 network device"] == command
        daemon = subprocess.Popen(["slcand", "-F", "-o", "-c", "-s5", str(lab.slcan_pty.resolve()), "slcan0"])
        try:
            until(Path("/sys/class/net/slcan0").exists)
            run("ip", "link", "set", "slcan0", "up")
            yield lab
        finally:
            daemon.terminate()
            daemon.wait()


def test_slcand_makes_a_network_device_of_the_hub(slcan0: LabProcess) -> None:
    with Candump("slcan0") as dump:
        cansend("slcan0", "000#8100")
        dump.until("705#00", "706#00")
        cansend("slcan0", "605#4008100000000000")
        dump.until("585#43081000494F3332")
    with canopen_master({"interface": "socketcan", "channel": "slcan0"}) as master:
        assert master.sensor.sdo[0x1008].raw == "Level sensor"
        master.io.sdo[0x6411][1].raw = 5_000
        until(lambda: slcan0.get("tank/outlet") == 50)
    with canopen_master(socketcand(slcan0)) as elsewhere, can.Bus("slcan0", "socketcan") as here:
        elsewhere.network.send_message(0x7F0, b"over the"[:8])
        heard = next(message for message in here if message.arbitration_id == 0x7F0)
        assert bytes(heard.data) == b"over the"
