"""A log is played in real time: to a rig that is started for it, and to one that runs."""

from pathlib import Path
from typing import Any

import pytest
from recorded_logs import MS, recorded

from fieldrig import LiveRig, Rig, S, load
from fieldrig.testing import free_port
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can import CanFrame
from fieldrig_bus.modbus import ModbusRequest
from fieldrig_devices.replay import replay

pytestmark = [pytest.mark.system, pytest.mark.long]

LAB, DRIVE = (Path(__file__).parents[2] / "configs" / name for name in ("lab.yaml", "drive.yaml"))
PATIENT: dict[str, Any] = {
    "time_tolerance_ns": 20 * S,
    "timeout_ns": 20 * S,
    "leave_out": ["heartbeat", "TPDO*"],
}
"""The host decides when a message arrives, and how many come by themselves; what answers say does not depend on it."""


def master(rig: Rig) -> None:
    link = rig.attach("plc").link
    rig.run_until(100 * MS)
    link("can0").send(CanFrame(0, bytes.fromhex("01 00")))
    for number in range(5):
        rig.run_for(50 * MS)
        link("can0").send(CanFrame(0x606, bytes.fromhex("40 00 10 00 00 00 00 00")))
        link("mb_tcp").send(ModbusRequest(1, bytes.fromhex("03 0000 0002"), number))
        link("mb_rtu").send(ModbusRequest(1, bytes.fromhex("04 0000 0001"), number))
    rig.run_for(100 * MS)


@pytest.fixture(scope="module")
def log() -> list[TraceEntry]:
    return recorded(LAB, master)


def overrides() -> list[str]:
    """Ports that no other rig has."""
    return [
        f"control=tcp/127.0.0.1:{free_port()}",
        f"buses.can0.socketcand=127.0.0.1:{free_port()}",
        f"buses.mb_tcp.listen=127.0.0.1:{free_port()}",
    ]


def test_a_rig_is_started_for_the_log_and_answers_as_in_the_log(log: list[TraceEntry]) -> None:
    result = replay(log, load(LAB, overrides()), speed=2.0, **PATIENT)
    assert result.differences == []
    assert result.played == 16
    assert result.compared >= 15


def test_the_rig_that_runs_is_taken(log: list[TraceEntry], tmp_path: Path) -> None:
    changed = [*overrides(), f"run={tmp_path / 'run'}"]
    with LiveRig(LAB, *changed[1:], "devices.tank.initial_level_m=0.6") as live:
        config = load(LAB, [*changed, f"control={live.endpoint}"])
        result = replay(log, config, speed=4.0, **PATIENT)
    words = [each.words for each in result.differences]
    assert "unit 1 (drive) answered level with 0.6 m, the log says 0.5 m (in 5 messages, by at most 0.1)" in words


def test_a_drive_that_boots_in_the_rig_that_is_started_is_waited_for() -> None:
    """The log begins in the middle of operation; the drive answers 1.5 s after its power came."""

    def poll(rig: Rig) -> None:
        can = rig.attach("plc").link("can0")
        rig.run_for(2 * S)
        for _ in range(4):
            can.send(CanFrame(0x603, bytes.fromhex("40 41 60 00 00 00 00 00")))
            rig.run_for(100 * MS)

    log = [entry._replace(sender="") for entry in recorded(DRIVE, poll) if entry.data[:2] in (b"\x03\x06", b"\x83\x05")]
    own = [f"control=tcp/127.0.0.1:{free_port()}", f"buses.can0.socketcand=127.0.0.1:{free_port()}"]
    slow = load(DRIVE, [*own, "devices.axis.behaviour={boot_up_ms: 1500}"])
    result = replay(log, slow, speed=1.0, **PATIENT)
    assert (result.differences, result.played) == ([], 4)
    [held] = [note for note in result.notes if "held back" in note]
    assert held.endswith("until node 3 (axis) had booted")
