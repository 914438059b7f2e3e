"""ros_canopen's Motor402, unchanged, moves a drive in all its modes, as the table of drive-personalities.md says.

No registry has it, so the test is collected only where `ROS_CANOPEN` is the folder of a checkout; it was at 21a98882.
It needs Debian's g++, libconsole-bridge-dev, and libboost-{thread,chrono,system,atomic}-dev.
"""

import os
import subprocess
from pathlib import Path

import pytest
from running_rig import RunningRig

from fieldrig.testing import free_port
from fieldrig_devices.cia402 import EDS

pytestmark = [pytest.mark.real, pytest.mark.timeout(600)]

PROGRAM = Path(__file__).parent / "ros" / "drive.cpp"
SOURCES = (
    *(f"canopen_master/src/{name}.cpp" for name in ("emcy", "node", "objdict", "pdo", "sdo")),
    "canopen_402/src/motor.cpp", "socketcan_interface/src/string.cpp",
)  # fmt: skip
INCLUDES = ("canopen_402/include", "canopen_master/include", "socketcan_interface/include", ".")
LIBRARIES = ("boost_thread", "boost_chrono", "boost_system", "boost_atomic", "console_bridge", "pthread")
RIG = """
time: real
buses:
  can0: {{kind: can.hub, bitrate: 1000000, socketcand: "127.0.0.1:{port}"}}
devices:
  axis:
    kind: cia402.drive
    node_id: 3
    links: {{can: can0}}
    switches: {{home: {{low: 5.0, high: 6.0}}}}
    {manner}
"""


@pytest.fixture(scope="module")
def master(tmp_path_factory: pytest.TempPathFactory) -> Path:
    checkout, folder = Path(os.environ["ROS_CANOPEN"]).absolute(), tmp_path_factory.mktemp("ros")
    (folder / "class_loader").mkdir()
    # A plug-in of ROS registers itself with it; here the master is called by name.
    (folder / "class_loader/class_loader.hpp").write_text(
        "#define CLASS_LOADER_REGISTER_CLASS(derived, base)\n", "utf-8"
    )
    command = [
        "g++", "-std=c++17", "-w", f"-I{folder}", *(f"-I{checkout / name}" for name in INCLUDES), str(PROGRAM),
        *(str(checkout / name) for name in SOURCES), *(f"-l{name}" for name in LIBRARIES), "-o", str(folder / "drive"),
    ]  # fmt: skip
    subprocess.run(command, check=True)
    return folder / "drive"


def said(master: Path, manner: str, method: int, heartbeat_ms: int = 0) -> list[str]:
    port = free_port()
    with RunningRig(RIG.format(port=port, manner=manner), None) as rig:
        rig.until_ready()
        command = [str(master), f"127.0.0.1:{port}:can0", str(EDS), "3", str(method), str(heartbeat_ms)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    return [line for line in done.stdout.splitlines() if line]


def test_it_homes_and_moves_the_drive_in_every_mode_and_recovers_it(master: Path) -> None:
    assert said(master, "", 24, heartbeat_ms=100) == [
        "init: ready", *(f"mode {mode}: moves" for mode in (1, 2, 3, 4, 7, 8, 9, 10)),
        "halt: Motor operation is not enabled", "recover: ",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "method", "error"),
    [
        ("step-by-step", 24, "Could not enable motor"),
        ("runs-ahead", 35, "could not reset node"),
        ("mains-inverter", 0, "1601sub1"),
        ("robot-joint", 0, "could not reset node"),
        ("own-units", 37, "could not prepare homing"),
        ("late-and-thin", 0, "6502sub0"),
    ],
)
def test_what_it_says_of_drives_that_differ(master: Path, name: str, method: int, error: str) -> None:
    lines = said(master, f"personality: {name}\n    behaviour: {{boot_up_ms: 0}}", method)
    assert error in "\n".join(lines)
    assert not any(line.startswith("mode") for line in lines)
