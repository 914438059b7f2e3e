"""Faults that begin at a milestone: when a point has a value, whatever changes it, and wherever the fault acts."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict
from fieldrig.errors import ControlError
from fieldrig.faults.condition import condition_of
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.wires import Signal

ROOT = Path(__file__).parents[3]
LAB: dict[str, Any] = {
    "time": "virtual",
    "buses": {"can0": {"kind": "can.virtual", "acknowledge": "always"}, "wires": {"kind": "wires.virtual"}},
    "devices": {
        "io": {
            "kind": "canopen.node",
            "node_id": 5,
            "eds": str(ROOT / "configs/eds/io32.eds"),
            "objects": {"1017:00": 10},
            "links": {"can": "can0", "wires": "wires"},
        },
        "tank": {
            "kind": "plant.tank",
            "area_m2": 0.25,
            "height_m": 2.0,
            "outlet_area_m2": 0.0002,
            "pump_flow_m3_per_s": 0.001,
            "initial_level_m": 1.0,
            "initial_outlet_percent": 100,
            "links": {"wires": "wires"},
        },
    },
}
START = CanFrame(0, bytes.fromhex("01 05"))


def heartbeats(rig: Rig) -> list[int]:
    """The milliseconds of the heartbeats from now on."""
    found: list[int] = []
    node = rig.attach("listener")
    node.link("can0").on_receive(lambda _: found.append(rig.now_ns // MS), [(0x705, 0x7FF)])
    return found


def test_a_fault_of_a_bus_begins_when_a_device_is_in_a_state() -> None:
    with Rig(from_dict(LAB)) as rig:
        found = heartbeats(rig)
        number = rig.add_fault(
            "can0", {"what": "drop", "identifier": 0x705, "when": "io/nmt.state == operational", "duration_ms": 20}
        )
        rig.run_until(35 * MS)
        assert rig.faults("can0")[number]["state"] == "waiting"
        rig.attach("master").link("can0").send(START)
        rig.run_until(36 * MS)
        assert rig.faults("can0")[number]["state"] == "on"
        rig.run_until(75 * MS)
        assert found[-1] == 70
        assert not any(35 < ms < 60 for ms in found)
        assert (rig.faults("can0")[number]["applied"], rig.faults("can0")[number]["state"]) == (2, "over")


def test_a_device_loses_its_power_when_a_value_that_moves_by_itself_crosses_a_limit() -> None:
    with Rig(from_dict(LAB)) as rig:
        number = rig.add_fault("io", {"what": "power_off", "when": "tank/level < 0.99", "start_ms": 5})
        rig.until(lambda: float(rig.get("tank/level")) < 0.99, within=5 * S)
        assert rig.faults("io")[number]["state"] == "waiting"
        rig.run_for(7 * MS)  # a millisecond until it is seen, and 5 of start_ms
        assert rig.faults("io")[number]["state"] == "on"
        with pytest.raises(ControlError, match="switched off"):
            rig.get("io/nmt.state")


def test_a_fault_of_a_device_begins_at_the_instant_of_the_change() -> None:
    with Rig(from_dict(LAB)) as rig:
        rig.add_fault("io", {"what": "heartbeat_lost", "when": "io/6200:01 & 0x02 == 2"})
        found = heartbeats(rig)
        rig.run_until(55 * MS)
        rig.set("io/6200:01", 1)
        rig.run_until(75 * MS)
        rig.set("io/6200:01", 3)
        rig.run_until(200 * MS)
        assert found[-1] == 70


def test_a_condition_that_is_met_already_begins_the_fault_at_once() -> None:
    with Rig(from_dict(LAB)) as rig:
        number = rig.add_fault("wires", {"what": "stuck", "wire": "tank.level", "when": "tank/level > 0.5"})
        rig.run_for(0)
        assert rig.faults("wires")[number]["state"] == "on"


def test_a_rig_file_has_conditions_too_and_a_cleared_fault_waits_no_longer() -> None:
    data = {**LAB, "buses": {**LAB["buses"], "can0": {**LAB["buses"]["can0"]}}}
    data["buses"]["can0"]["faults"] = [{"what": "drop", "when": "io/nmt.state == operational"}]
    with Rig(from_dict(data)) as rig:
        found = heartbeats(rig)
        rig.attach("master").link("can0").send(START)
        rig.run_until(5 * S // 100)
        assert len(found) <= 1
    with Rig(from_dict(data)) as rig:
        rig.clear_fault("can0", 1)
        found = heartbeats(rig)
        rig.attach("master").link("can0").send(START)
        rig.run_until(5 * S // 100)
        assert len(found) >= 4


def test_a_fault_begins_when_a_wire_crosses_a_value() -> None:
    with Rig(from_dict(LAB)) as rig:
        rises = rig.add_fault("can0", {"what": "drop", "when": "wires/tank.level > 1.5"})
        falls = rig.add_fault("can0", {"what": "drop", "when": "wires/tank.level < 0.4"})
        rig.set("tank/level", 1.4)
        rig.run_until(1 * S)
        assert [rig.faults("can0")[number]["state"] for number in (rises, falls)] == ["waiting", "waiting"]
        rig.set("tank/level", 1.6)
        rig.run_for(1 * MS)
        assert [rig.faults("can0")[number]["state"] for number in (rises, falls)] == ["on", "waiting"]


def test_a_pulse_on_a_wire_that_is_over_at_once_begins_a_fault() -> None:
    with Rig(from_dict(LAB)) as rig:
        wire = rig.attach("bench").link("wires")
        wire.send(Signal("lamp", False))
        rig.run_for(1 * MS)
        fault = rig.add_fault("can0", {"what": "drop", "when": "wires/lamp == true"})
        wire.send(Signal("lamp", True))
        rig.step()
        wire.send(Signal("lamp", False))
        rig.run_for(1 * MS)
        assert rig.faults("can0")[fault]["state"] == "on"


def test_a_wire_that_a_device_drives_and_has_not_sent_yet_is_false() -> None:
    drive = {"kind": "cia402.drive", "node_id": 3, "links": {"can": "can0", "wires": "wires"}}
    with Rig(from_dict({**LAB, "devices": {"axis": drive}})) as rig:
        lifted = rig.add_fault("can0", {"what": "drop", "when": "wires/axis.brake == true"})
        closed = rig.add_fault("can0", {"what": "drop", "when": "wires/axis.brake == false", "duration_ms": 5})
        rig.run_until(100 * MS)
        assert (rig.faults("can0")[lifted]["state"], rig.faults("can0")[closed]["state"]) == ("waiting", "over")
        for word in (0x06, 0x07, 0x0F):
            rig.set("axis/6040:00", word)
            rig.run_for(50 * MS)
        assert rig.get("axis/brake")
        assert rig.faults("can0")[lifted]["state"] == "on"


@pytest.mark.parametrize(
    ("when", "wrong"),
    [
        ("io/nmt.stat == operational", "nmt.stat"),
        ("oi/nmt.state == operational", "no device 'oi'"),
        ("level > 3", "no condition"),
        ("io/nmt.state & x == 1", "no mask"),
        ("io/nmt.state == opertional", "when: io/nmt.state is never 'opertional'"),
        ("io/nmt.state == 5", "when: io/nmt.state is never 5"),
        ("tank/level > high", "when: tank/level is never 'high'"),
        ("tank/level > 1e999", "when: '1e999' is no value of a point"),
        ("tank/level < -.inf", "expected a finite number"),
        ("tank/high > 1", "when: tank/high is never > 1"),
        ("tank/high == 2", "when: tank/high is never == 2"),
        ("wires/tank.level > high", "when: wires/tank.level is never 'high'"),
        ("wires/tank.lebel > 1", "wires has no value of a signal 'tank.lebel'"),
        ("can0/load > 1", "can0 has no value of a signal 'load'"),
    ],
)
def test_a_condition_that_cannot_be_is_refused(when: str, wrong: str) -> None:
    with Rig(from_dict(LAB)) as rig:
        with pytest.raises(ControlError, match=wrong):
            rig.add_fault("can0", {"what": "drop", "when": when})
        assert rig.faults("can0") == {}


@pytest.mark.parametrize(
    ("text", "met", "not_met"),
    [
        ("a/b", [1, True, -0.5], [0, False]),
        ("a/b == 0x27", [39, 39.0], [38, "39"]),
        ("a/b & 0x6f == 0x27", [0x27, 0x1237], [0x2F, 0.5]),
        ("a/b >= 1.5", [1.5, 2], [1.4]),
        ("a/b != true", [False, 0], [True, 1]),
        ("a/2/x.y == operational", ["operational"], ["stopped", 3]),
        ("a/b < -3", [-4], [-3]),
        ("a/b>1", [2], [1]),
        ("a/b>=1.5", [1.5], [1.4]),
        ("a/6041:00&0x6f==0x27", [0x27], [0x2F]),
        ("a/x.y!=-3", [3], [-3]),
    ],
)
def test_what_a_condition_means(text: str, met: list[Any], not_met: list[Any]) -> None:
    condition = condition_of(text)
    assert [condition.is_met(value) for value in met] == [True] * len(met)
    assert [condition.is_met(value) for value in not_met] == [False] * len(not_met)


@given(st.text(max_size=60), st.one_of(st.booleans(), st.integers(), st.floats(), st.text(max_size=10)))
def test_any_text_is_a_condition_or_refused_and_any_value_meets_it_or_not(text: str, value: Any) -> None:
    try:
        condition = condition_of(text)
    except ValueError:
        return
    assert condition.is_met(value) in (True, False)
