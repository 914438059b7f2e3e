"""The drive of configs/drive.yaml, driven by masters that are not ours: python canopen and npm's canopen."""

import json
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import canopen
import pytest
from doc_pages import page_named
from ring_process import PatientNode402
from running_rig import RunningRig, until

from fieldrig_devices.cia402 import EDS

pytestmark = [pytest.mark.real, pytest.mark.timeout(400)]

ROOT = Path(__file__).parents[2]
RIG = ROOT / "configs" / "drive.yaml"
PAGE = page_named("cia402-drive.md")
MASTER = Path(__file__).parent / "node" / "drive.js"
PORT = 29569
TURN = 1_000_000
PATIENCE = """
from canopen.profiles.p402 import BaseNode402
BaseNode402.TIMEOUT_SWITCH_STATE_SINGLE = 1.0
BaseNode402.TIMEOUT_SWITCH_OP_MODE = BaseNode402.TIMEOUT_SWITCH_STATE_FINAL = BaseNode402.TIMEOUT_CHECK_TPDO = 20.0
"""
"""Gives a busy host time; the program itself is unchanged."""


@pytest.fixture(scope="module")
def running() -> Iterator[RunningRig]:
    with RunningRig(RIG, None) as rig:
        yield rig.until_ready()
        assert rig.end(signal.SIGINT) == 0, rig.output()


@pytest.fixture
def axis(running: RunningRig) -> Iterator[Any]:
    """The node as after power-on, operational, with its state machine set up."""
    network = canopen.Network()
    network.connect(interface="socketcand", channel="can0", host="127.0.0.1", port=PORT)
    axis: Any = PatientNode402(3, str(EDS))  # type: ignore[no-untyped-call]  # as python canopen is
    network.add_node(axis)
    axis.nmt.state = "RESET"
    assert axis.sdo[0x1000].raw == 0x0002_0192
    axis.nmt.state = "OPERATIONAL"
    axis.setup_402_state_machine()
    yield axis
    axis.sdo[0x6040].raw = 0
    network.disconnect()


def enable(axis: Any, mode: str) -> None:
    axis.op_mode = mode
    axis.state = "OPERATION ENABLED"
    assert axis.state == "OPERATION ENABLED"
    assert axis.op_mode == mode


def test_the_program_of_the_page_moves_it_verbatim(running: RunningRig, tmp_path: Path) -> None:
    found = re.search(r"```python file move_axis\.py\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert found is not None
    before = float(running.value("axis/position"))
    done = subprocess.run(
        [sys.executable, "-c", PATIENCE + found[1]], capture_output=True, text=True, timeout=90, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "the axis is at" in done.stdout
    assert float(running.value("axis/position")) - before == pytest.approx(6.283, abs=0.01)  # a turn of the roller


def test_python_canopen_homes_it_by_its_own_method(axis: Any, running: RunningRig) -> None:
    axis.sdo[0x6098].raw = 19
    assert axis.homing(timeout=60, restore_op_mode=False)
    place = float(running.value("axis/position")) % 6.283185307179586
    assert place == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize(
    ("mode", "index", "target", "speed_rpm"),
    [("PROFILED VELOCITY", 0x60FF, 5 * TURN, 300), ("CYCLIC SYNCHRONOUS VELOCITY", 0x60FF, 2 * TURN, 120)],
)
def test_python_canopen_turns_it_at_a_speed(
    axis: Any, running: RunningRig, mode: str, index: int, target: int, speed_rpm: float
) -> None:
    enable(axis, mode)
    axis.sdo[index].raw = target
    until(lambda: abs(float(running.value("axis/speed")) - speed_rpm) < speed_rpm / 20)
    axis.sdo[index].raw = 0
    until(lambda: abs(float(running.value("axis/speed"))) < 1)


@pytest.mark.parametrize("mode", ["PROFILED TORQUE", "CYCLIC SYNCHRONOUS TORQUE"])
def test_python_canopen_gives_it_a_torque(axis: Any, running: RunningRig, mode: str) -> None:
    enable(axis, mode)
    axis.sdo[0x6071].raw = 50
    until(lambda: float(running.value("axis/speed")) > 30)
    axis.sdo[0x6071].raw = 0
    axis.state = "SWITCHED ON"


@pytest.mark.parametrize("mode", ["CYCLIC SYNCHRONOUS POSITION", "INTERPOLATED POSITION"])
def test_python_canopen_leads_it_by_positions(axis: Any, mode: str) -> None:
    enable(axis, mode)
    if mode == "INTERPOLATED POSITION":
        axis.sdo[0x60C2][1].raw = 20
        axis.controlword = 0x1F
    begin = axis.sdo[0x6064].raw
    for step in range(1, 21):
        if mode == "INTERPOLATED POSITION":
            axis.sdo[0x60C1][1].raw = begin + step * 500
        else:
            axis.sdo[0x607A].raw = begin + step * 500
    until(lambda: abs(axis.sdo[0x6064].raw - begin - 10_000) < 100)


def test_python_canopen_turns_it_as_an_inverter(axis: Any, running: RunningRig) -> None:
    enable(axis, "VELOCITY")
    axis.sdo[0x6042].raw = 240
    axis.controlword = 0x7F
    until(lambda: abs(float(running.value("axis/speed")) - 240) < 10)
    axis.controlword = 0x0F
    until(lambda: abs(float(running.value("axis/speed"))) < 1)


def test_python_canopen_sees_a_fault_and_resets_it(axis: Any, running: RunningRig) -> None:
    enable(axis, "PROFILED VELOCITY")
    axis.sdo[0x60FF].raw = 2 * TURN
    assert running.tool("fault", "axis", "overtemperature", "duration_ms=1500").returncode == 0
    until(lambda: axis.state == "FAULT")
    assert axis.sdo[0x603F].raw == 0x4310
    assert [error.code for error in axis.emcy.log if error.code] == [0x4310]

    def is_reset() -> bool:
        with suppress(RuntimeError):  # while the motor is too hot
            axis.reset_from_fault()
        return bool(axis.state == "OPERATION ENABLED")

    until(is_reset)


def test_npm_s_canopen_moves_it_by_pdo_and_sync(running: RunningRig) -> None:
    node = shutil.which("node")
    if node is None or not (MASTER.parent / "node_modules").is_dir():
        pytest.skip("npm's canopen is not installed: npm ci in tests/real/node")
    done = subprocess.run(
        [node, MASTER, str(PORT), "can0", "3"], capture_output=True, text=True, timeout=90, check=False
    )
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout)
    assert seen["deviceType"] == 0x0002_0192
    assert seen["states"] == [0x21, 0x23, 0x27]
    assert seen["moved"] == pytest.approx(2 * TURN, abs=2_000)
    assert seen["positions"] > 20, "TPDO 3 answers each SYNC"
