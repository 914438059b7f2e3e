"""PyTrinamic's `TmcmNode` and its programs for CANopen, as the wheel has them, at a drive with the names of their EDS.

`TmcmNode` has a state machine of its own, and the modes of `TmcmNode.ModeOfOperation`.  The programs open a PEAK
adapter; here that name of python-can leads to the bus of a rig in virtual time, where their waits take none.
"""

import runpy
import time
from collections.abc import Callable, Iterator
from importlib.metadata import files
from pathlib import Path
from typing import Any

import can
import canopen
import pytest
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError
from pytrinamic.modules.canopen_node import TmcmNode
from running_rig import RunningRig, until

from fieldrig import Rig, from_dict, virtual_time
from fieldrig.testing import free_port
from fieldrig_bus.can.interface import FieldrigBus
from fieldrig_devices.cia402 import EDS

pytestmark = [pytest.mark.real, pytest.mark.timeout(400)]

NODE, TURN = 1, 1_000_000
ADAPTER = "PCAN_USBBUS1"
BUS = ADAPTER.lower()
NAMES = {
    "6040": "Controlword 1", "6041": "Statusword 1", "6060": "Modes of Operation 1", "607A": "Target Position 1",
    "6081": "Profile Velocity in pp-mode 1", "6083": "Profile Acceleration 1", "6084": "Profile Deceleration 1",
    "60FF": "Target Velocity 1",
}  # fmt: skip
OWN = (
    "Absolute Max Current 1", "Switch Parameters 1", "Profile start velocity 1", "Profile A1 1", "Profile V1 1",
    "Profile D1 1", "Ramp Wait Time 1", "End velocity 1",
)  # fmt: skip
"""Objects that the programs write and our EDS lacks; any place will do, as the programs ask by name."""
MASTER: Any = TmcmNode
DRIVE = {"kind": "cia402.drive", "node_id": NODE}
KNOWN: Any = TmcmNode.ModeOfOperation


class Adapter(FieldrigBus):
    """The bus that python-can opens for a PEAK adapter, which is one of the rig."""

    def __init__(self, channel: str, **options: Any) -> None:
        super().__init__(channel=channel.lower(), **options)


def with_their_names(text: str) -> str:
    """Return our EDS with the names by which the programs ask for objects, and with the objects of their maker."""
    lines, section = [], ""
    for line in text.replace("[ManufacturerObjects]\nSupportedObjects=0\n", "").splitlines():
        if line.startswith("["):
            section = line.strip("[]")
        is_name = line.startswith("ParameterName=") and section in NAMES
        lines.append(f"ParameterName={NAMES[section]}" if is_name else line)
    lines += ["", "[ManufacturerObjects]", f"SupportedObjects={len(OWN)}"]
    lines += [f"{number}=0x{0x2000 + number:04X}" for number in range(1, len(OWN) + 1)]
    for number, name in enumerate(OWN, 1):
        lines += ["", f"[{0x2000 + number:04X}]", f"ParameterName={name}", "ObjectType=0x7", "DataType=0x0007"]
        lines += ["AccessType=rw", "DefaultValue=0", "PDOMapping=0"]
    return "\n".join([*lines, ""])


@pytest.fixture(scope="module")
def eds(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("trinamic") / "TMCM-1240.eds"
    file.write_text(with_their_names(EDS.read_text("utf-8")), "utf-8")
    return file


@pytest.fixture
def rig(eds: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Rig]:
    """A rig whose bus is where the programs expect a PEAK adapter, and their EDS where they look for it."""
    monkeypatch.chdir(eds.parent)
    monkeypatch.setitem(can.interfaces.BACKENDS, "pcan", (__name__, Adapter.__name__))
    with virtual_drive(eds) as rig:
        yield rig


def virtual_drive(eds: Path, **keys: str) -> Rig:
    buses = {BUS: {"kind": "can.virtual", "bitrate": 1_000_000}}
    devices = {"axis": {**DRIVE, "eds": str(eds), "links": {"can": BUS}, **keys}}
    return Rig(from_dict({"time": "virtual", "buses": buses, "devices": devices}))


def play(rig: Rig, program: str) -> None:
    """Run a program of the wheel in the virtual time of the rig."""
    (file,) = [file for file in files("pytrinamic") or () if file.name == program]
    with virtual_time(rig):
        runpy.run_path(str(file.locate()), run_name="__main__")


@pytest.mark.filterwarnings("ignore:.*bustype.*:DeprecationWarning")
def test_their_program_for_profile_position_runs_as_it_is(rig: Rig, capsys: pytest.CaptureFixture[str]) -> None:
    play(rig, "tmcm_1240_profile_position_mode_demo.py")
    assert rig.get("axis/6064:00") == 200_000
    said = capsys.readouterr().out.splitlines()
    assert said == ["Motor starts rotating ", "Operation enabled", "Motor Stoped ", "Switch on disable"]


@pytest.mark.filterwarnings("ignore:.*bustype.*:DeprecationWarning")
def test_their_program_for_profile_velocity_runs_as_it_is(rig: Rig) -> None:
    play(rig, "tmcm_1240_profile_velocity_mode_demo.py")
    # 10 s at 50 000 units a second
    assert rig.get("axis/6064:00") == pytest.approx(500_000, rel=0.02)
    assert rig.get("axis/state") == "switch on disabled"


@pytest.fixture(scope="module")
def running(eds: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[RunningRig, int]]:
    port = free_port()
    rig_file = f"""
time: real
buses:
  can0: {{kind: can.hub, bitrate: 1000000, socketcand: "127.0.0.1:{port}"}}
devices:
  axis:
    kind: cia402.drive
    node_id: {NODE}
    eds: {eds}
    links: {{can: can0}}
    switches: {{home: {{low: 0.5, high: 0.8, every: 6.283185307179586}}}}
"""
    with RunningRig(rig_file, None) as rig:
        yield rig.until_ready(), port


@pytest.fixture
def node(running: tuple[RunningRig, int], eds: Path) -> Iterator[Any]:
    """Their node, enabled by their state machine, in real time."""
    network = canopen.Network()
    network.connect(interface="socketcand", channel="can0", host="127.0.0.1", port=running[1])
    node = MASTER(NODE, str(eds))
    network.add_node(node)
    node.sdo.RESPONSE_TIMEOUT = 5.0
    node.nmt.state = "RESET"
    until(lambda: node.sdo["Statusword 1"].raw & 0x40)
    node.nmt.state = "OPERATIONAL"
    yield node
    node.sdo["Target Velocity 1"].raw = 0
    node.shutdown()
    network.disconnect()


def by_set_point(node: Any, way: int = TURN) -> Callable[[], bool]:
    target = place(node) + way
    node.sdo["Target Position 1"].raw = target
    node.sdo["Controlword 1"].raw = TmcmNode.Cmd.ENABLE_OPERATION | TmcmNode.Cmd.NEW_SET_POINT
    return lambda: abs(place(node) - target) < 10


def by_speed(node: Any) -> Callable[[], bool]:
    node.sdo["Target Velocity 1"].raw = 2 * TURN
    return lambda: abs(node.sdo[0x606C].raw - 2 * TURN) < TURN // 20


def by_homing(node: Any) -> Callable[[], bool]:
    node.sdo[0x6098].raw = 19
    node.sdo["Controlword 1"].raw = TmcmNode.Cmd.ENABLE_OPERATION | 0x10
    return lambda: node.sdo["Statusword 1"].raw & 0x3400 == 0x1400


def by_position(node: Any) -> Callable[[], bool]:
    begin = place(node)
    for step in range(1, 21):
        node.sdo["Target Position 1"].raw = begin + step * 500
    return lambda: abs(place(node) - begin - 10_000) < 10


def by_torque(node: Any) -> Callable[[], bool]:
    node.sdo[0x6071].raw = 50
    return lambda: node.sdo[0x606C].raw > TURN


def place(node: Any) -> int:
    return int(node.sdo[0x6064].raw)


MOVES: dict[int, Callable[[Any], Callable[[], bool]]] = {
    KNOWN.PROFILE_POSITION_MODE: by_set_point,
    KNOWN.PROFILE_VELOCITY_MODE: by_speed,
    KNOWN.HOMING_MODE: by_homing,
    KNOWN.CYCLIC_SYNCHRONOUS_POSITION_MODE: by_position,
    KNOWN.CYCLIC_SYNCHRONOUS_VELOCITY_MODE: by_speed,
    KNOWN.CYCLIC_SYNCHRONOUS_TORQUE_MODE: by_torque,
}


def test_every_mode_that_their_node_knows_is_moved() -> None:
    known = {value for name, value in vars(KNOWN).items() if not name.startswith("_")}
    assert known - {KNOWN.NO_MODE} == set(MOVES)


@pytest.mark.parametrize("mode", MOVES)
def test_their_node_moves_the_drive(node: Any, mode: int) -> None:
    node.sdo["Modes of Operation 1"].raw = mode
    node.go_to_operation_enabled()
    assert node.get_state() == "Operation enabled"
    until(MOVES[mode](node))
    node.shutdown()
    assert node.get_state() == "Switch on disable"


def test_their_node_gets_out_of_a_fault(node: Any, running: tuple[RunningRig, int]) -> None:
    node.sdo["Modes of Operation 1"].raw = KNOWN.PROFILE_VELOCITY_MODE
    node.go_to_operation_enabled()
    assert running[0].tool("fault", "axis", "error", "code=0x7305", "duration_ms=1").returncode == 0
    until(lambda: node.get_state() == "Fault")
    node.go_to_operation_enabled()
    assert node.get_state() == "Operation enabled"


MOVED = ["enabled", "moved by 200000", "Fault", "enabled again"]
# As docs/devices/drive-personalities.md says.
WITH_PERSONALITY = {
    "step-by-step": MOVED,
    "runs-ahead": MOVED,
    "mains-inverter": ["SdoAbortedError"],  # it has no profile position
    "robot-joint": ["SdoCommunicationError"],  # the first SDO is lost
    "own-units": ["enabled", "moved by 0", "Fault", "enabled again"],  # 607Dh 0/0 allows position 0 only
    "late-and-thin": MOVED,
}


@pytest.mark.parametrize("personality", WITH_PERSONALITY)
def test_their_node_at_a_drive_with_a_personality(eds: Path, personality: str) -> None:
    seen = []
    with virtual_drive(eds, personality=personality) as rig, virtual_time(rig, limit_s=60):
        network: Any = canopen.Network()
        network.connect(interface="fieldrig", channel=BUS)
        node = MASTER(NODE, str(eds))
        network.add_node(node)
        try:
            node.nmt.wait_for_bootup(10)
            time.sleep(0.1)
            node.nmt.state = "OPERATIONAL"
            node.sdo["Modes of Operation 1"].raw = KNOWN.PROFILE_POSITION_MODE
            node.go_to_operation_enabled()
            seen.append("enabled")
            begin = place(node)
            by_set_point(node, 200_000)
            time.sleep(5)
            seen.append(f"moved by {place(node) - begin}")
            rig.add_fault("axis", {"what": "error", "code": 0x7305, "duration_ms": 1})
            time.sleep(1)
            seen.append(node.get_state())
            node.go_to_operation_enabled()
            seen.append("enabled again")
        except (SdoAbortedError, SdoCommunicationError) as error:
            seen.append(type(error).__name__)
        network.disconnect()
    assert seen == WITH_PERSONALITY[personality]


def test_their_node_does_not_know_what_it_sees_just_after_a_boot_up(eds: Path) -> None:
    """It asks for the state before the drive has left *not ready to switch on*, for which it has no way."""
    with virtual_drive(eds) as rig, virtual_time(rig):
        network: Any = canopen.Network()
        network.connect(interface="fieldrig", channel=BUS)
        node = MASTER(NODE, str(eds))
        network.add_node(node)
        node.nmt.wait_for_bootup(10)
        with pytest.raises(KeyError, match="Not ready to switch on"):
            node.go_to_operation_enabled()
        time.sleep(0.001)
        node.go_to_operation_enabled()
        network.disconnect()
