"""Rigs in real time as a user's tests start them: each with an endpoint of its own, and never another test's rig."""

import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
from running_rig import until

from fieldrig.clock import MS
from fieldrig.errors import ArgumentError, ControlError, RigError
from fieldrig.real import live_rig
from fieldrig.real.live_rig import LiveRig
from fieldrig.testing import free_port

pytestmark = pytest.mark.system

RIG = """
time: real
buses:
  wires: {kind: wires.hub}
devices:
  tank:
    kind: plant.tank
    area_m2: 1
    height_m: 2
    outlet_area_m2: 0
    pump_flow_m3_per_s: 0.001
    initial_level_m: 0.5
    links: {wires: wires}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    file = tmp_path / "tank.yaml"
    file.write_text(RIG)
    return file


def test_points_are_read_and_written_and_the_rig_ends_in_order(file: Path) -> None:
    with LiveRig(file, "devices.tank.initial_level_m=1.25") as rig:
        assert rig.get("tank", "level") == rig.get("tank/level") == 1.25
        rig.set("tank/level", 1.5)
        assert rig.get("tank/level") == 1.5
        assert rig.status()["processes"]["tank"]["state"] == "ready"
        assert (rig.run / "log" / "tank.log").exists()
    assert rig.process.returncode == 0


def test_signals_are_recorded_while_the_test_works(file: Path, tmp_path: Path) -> None:
    with LiveRig(file) as rig:
        with rig.record(["tank/level", "wires/tank.level"], 10 * MS) as recording:
            until(lambda: len(recording.values["tank/level"]) > 5)
            rig.set("tank/level", 1.5)
            until(lambda: recording.values["tank/level"][-1] == 1.5)
        levels = list(recording.values["tank/level"])
        changed = levels.index(1.5)
        assert levels == [0.5] * changed + [1.5] * (len(levels) - changed)
        times_ns = recording.times_ns["tank/level"]
        assert all(later - earlier >= 10 * MS for earlier, later in pairwise(times_ns))
        recording.write_csv(tmp_path / "tank.csv")
        assert "1.5" in (tmp_path / "tank.csv").read_text()
        recording.end()
        with pytest.raises(ControlError, match="tank has no value 'levle'"):
            rig.record("tank/levle")
        with pytest.raises(ArgumentError, match="record cannot have the rhythm 'often'"):
            rig.record("tank/level", "often")  # type: ignore[arg-type]  # a mistake


def test_faults_are_given_and_cleared_and_a_device_is_restarted(file: Path) -> None:
    with LiveRig(file) as rig:
        stuck = rig.add_fault("wires", {"what": "stuck", "wire": "tank.level", "value": 1})
        off = rig.add_fault("tank", {"what": "power_off"})
        assert rig.faults("wires")[stuck]["state"] == "on"
        with pytest.raises(ControlError, match="tank is switched off"):
            rig.get("tank/level")
        rig.clear_fault("tank", off)
        assert (rig.get("tank/level"), rig.faults("tank")) == (0.5, {})
        with pytest.raises(ControlError, match="no bus or device 'tonk'"):
            rig.faults("tonk")
        rig.set("tank/level", 1.25)
        leak = rig.add_fault("tank", {"what": "leak", "area_m2": 0.001, "start_ms": 10_000_000})
        rig.restart("tank")
        assert rig.get("tank/level") == 0.5
        assert (list(rig.faults("tank")), list(rig.faults("wires"))) == ([leak], [stuck])
        rig.restart("wires")
        assert rig.faults("wires") == {}
        with pytest.raises(ControlError, match="no process, device or bus 'tonk'"):
            rig.restart("tonk")


def test_a_fault_waits_for_a_point_of_its_process(file: Path) -> None:
    with LiveRig(file) as rig:
        fault = {"what": "drop_out", "wire": "tank.level", "when": "tank/level > 1"}
        given = rig.add_fault("wires", fault)
        cleared = rig.add_fault("wires", {**fault, "wire": "tank.empty"})
        rig.clear_fault("wires", cleared)
        off = rig.add_fault("tank", {"what": "power_off", "when": "tank/level > 1.5"})
        assert rig.faults("wires")[given]["state"] == rig.faults("tank")[off]["state"] == "waiting"
        rig.set("tank/level", 1.25)
        until(lambda: rig.faults("wires")[given]["state"] == "on")
        assert rig.faults("tank")[off]["state"] == "waiting"
        rig.set("tank/level", 1.75)
        until(lambda: rig.faults("tank")[off]["state"] == "on")
        with pytest.raises(ControlError, match="when: there is no device 'tonk'"):
            rig.add_fault("wires", {**fault, "when": "tonk/level > 1"})
        assert list(rig.faults("wires")) == [given]


def test_a_device_of_a_rig_in_virtual_time_is_restarted_in_its_process(file: Path) -> None:
    with LiveRig(file, "time=virtual", "speed=1") as rig:
        rig.set("tank/level", 1.25)
        rig.restart("tank")
        assert rig.get("tank/level") == 0.5


@pytest.mark.parametrize("process", ["tank", "hub"])
def test_a_fault_waits_for_a_wire(file: Path, process: str) -> None:
    """The hub of the wires is in the process of the tank, or in one of its own."""
    file.write_text(RIG.replace("{kind: wires.hub}", f"{{kind: wires.hub, process: {process}}}"), encoding="utf-8")
    with LiveRig(file) as rig:
        of_bus = rig.add_fault("wires", {"what": "drop_out", "wire": "tank.empty", "when": "wires/tank.level > 1"})
        of_device = rig.add_fault("tank", {"what": "leak", "area_m2": 0.001, "when": "wires/tank.level > 1"})
        assert rig.faults("wires")[of_bus]["state"] == rig.faults("tank")[of_device]["state"] == "waiting"
        rig.set("tank/level", 1.25)
        until(lambda: rig.faults("wires")[of_bus]["state"] == rig.faults("tank")[of_device]["state"] == "on")
        unsent = rig.add_fault("wires", {"what": "drop_out", "wire": "tank.empty", "when": "wires/tank.high == true"})
        assert rig.faults("wires")[unsent]["state"] == "waiting"
        with pytest.raises(ControlError, match=r"wires has no value of a signal 'tank\.levle'"):
            rig.add_fault("tank", {"what": "power_off", "when": "wires/tank.levle > 1"})


def test_a_fault_waits_for_a_point_of_another_process_also_after_its_restart(file: Path) -> None:
    file.write_text(
        RIG.replace("{kind: wires.hub}", "{kind: wires.hub, process: hub, faults: [FAULT]}").replace(
            "FAULT", "{what: drop_out, wire: tank.level, when: tank/level > 1}"
        ),
        encoding="utf-8",
    )
    with LiveRig(file) as rig:
        added = rig.add_fault("wires", {"what": "stuck", "wire": "tank.level", "value": 1, "when": "tank/level > 1.5"})
        cleared = rig.add_fault("wires", {"what": "stuck", "wire": "tank.empty", "value": 1, "when": "tank/level > 1"})
        rig.clear_fault("wires", cleared)
        with pytest.raises(ControlError, match="tank has no value 'levle'"):
            rig.add_fault("wires", {"what": "drop_out", "wire": "tank.level", "when": "tank/levle > 1"})
        rig.restart("tank")
        assert {fault["state"] for fault in rig.faults("wires").values()} == {"waiting"}
        rig.set("tank/level", 1.25)
        until(lambda: rig.faults("wires")[1]["state"] == "on")
        assert rig.faults("wires")[added]["state"] == "waiting"
        rig.set("tank/level", 1.75)
        until(lambda: rig.faults("wires")[added]["state"] == "on")
        assert list(rig.faults("wires")) == [1, added]


def test_a_rig_that_ends_at_its_start_says_why(file: Path) -> None:
    with pytest.raises(RigError, match=r"exit code 2 [^$]*initial_level_m"):
        LiveRig(file, "devices.tank.initial_level_m=high")


def test_another_rig_at_the_endpoint_is_not_taken_for_its_own(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with LiveRig(file) as first:
        port = int(first.endpoint.rpartition(":")[2])
        monkeypatch.setattr(live_rig, "free_port", lambda: port)
        with pytest.raises(RigError, match="ended with exit code"):
            LiveRig(file)
        assert first.get("tank", "level") == 0.5


def test_two_rigs_of_one_file_run_side_by_side(file: Path) -> None:
    with LiveRig(file, "devices.tank.initial_level_m=0.1") as shallow, LiveRig(file) as other:
        assert (shallow.get("tank", "level"), other.get("tank", "level")) == (0.1, 0.5)


def test_a_port_is_given_to_one_process_only() -> None:
    ports = {free_port() for _ in range(20)}
    assert len(ports) == 20
    code = "from fieldrig.testing import free_port; print(*(free_port() for _ in range(20)))"
    there = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ports.isdisjoint(map(int, there.stdout.split()))
