"""Devices without power: off and on again by a fault and by `restart`, with devices in one process and in several."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.errors import ConfigError, ControlError
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame

ROOT = Path(__file__).parents[3]
LAB: dict[str, Any] = {
    "time": "virtual",
    "buses": {"can0": {"kind": "can.virtual", "bitrate": 125_000}, "wires": {"kind": "wires.virtual"}},
    "devices": {
        "io": {
            "kind": "canopen.node",
            "node_id": 5,
            "eds": str(ROOT / "configs/eds/io32.eds"),
            "objects": {"1017:00": 100},
            "links": {"can": "can0", "wires": "wires"},
        },
    },
}
HEARTBEAT, BOOT_UP = 0x705, b"\x00"


def heard(rig: Rig) -> list[tuple[int, bytes]]:
    """The milliseconds and data of the heartbeats from now on."""
    found: list[tuple[int, bytes]] = []
    node = rig.attach("master")

    def on_frame(frame: Any) -> None:
        if isinstance(frame, CanFrame):
            found.append((node.clock.now_ns() // MS, frame.data))

    node.link("can0").on_receive(on_frame, [(HEARTBEAT, 0x7FF)])
    return found


@pytest.fixture
def rig() -> Iterator[Rig]:
    with Rig(from_dict(LAB)) as rig:
        yield rig


def with_faults(*faults: Any) -> dict[str, Any]:
    return {**LAB, "devices": {"io": {**LAB["devices"]["io"], "faults": list(faults)}}}


@pytest.mark.long
def test_a_device_in_a_process_of_its_own_is_switched_too() -> None:
    with Rig(from_dict({**LAB, "processes": "each"})) as rig:
        found = heard(rig)
        rig.add_fault("io", {"what": "power_off", "start_ms": 50, "duration_ms": 100})
        rig.run_until(200 * MS)
        rig.restart("io")
        rig.run_until(202 * MS)
        assert found == [(0, BOOT_UP), (150, BOOT_UP), (200, BOOT_UP)]


def test_a_rig_file_may_leave_a_device_without_power() -> None:
    with Rig(from_dict(with_faults({"what": "power_off", "duration_ms": 40}))) as rig:
        found = heard(rig)
        rig.run_until(60 * MS)
        assert found == [(40, BOOT_UP)]


@pytest.mark.parametrize(
    ("faults", "wrong"),
    [
        ("power_off", "expected a list such as"),
        ([{"what": "jam"}], "there is no fault 'jam'|takes no faults"),
    ],
    ids=str,
)
def test_faults_of_a_rig_file_that_cannot_be_are_refused(faults: Any, wrong: str) -> None:
    data = {**LAB, "devices": {"io": {**LAB["devices"]["io"], "faults": faults}}}
    with pytest.raises(ConfigError, match=wrong):
        Rig(from_dict(data)).close()


def test_a_mistyped_loss_of_power_is_answered_with_its_name(rig: Rig) -> None:
    with pytest.raises(ControlError, match=r"there is no fault 'power_of'\n.*did you mean power_off\?"):
        rig.add_fault("io", {"what": "power_of"})


def test_a_device_without_power_is_silent_and_boots_when_it_is_back(rig: Rig) -> None:
    found = heard(rig)
    rig.run_until(250 * MS)
    number = rig.add_fault("io", {"what": "power_off", "duration_ms": 300})
    given = {"what": "power_off", "duration_ms": 300}
    assert rig.faults("io")[number] == {**given, "state": "on", "applied": 1, "left_ms": 300}
    rig.run_until(251 * MS - 1)
    assert rig.faults("io")[number]["left_ms"] == 300
    rig.run_until(549 * MS)
    assert rig.faults("io")[number]["left_ms"] == 1
    rig.run_until(700 * MS)
    assert found == [(0, BOOT_UP), (100, b"\x7f"), (200, b"\x7f"), (550, BOOT_UP), (650, b"\x7f")]
    assert rig.faults("io")[number]["state"] == "over"


def test_a_loss_of_power_that_begins_later_and_is_cleared(rig: Rig) -> None:
    found = heard(rig)
    number = rig.add_fault("io", {"what": "power_off", "start_ms": "150"})
    rig.run_until(400 * MS)
    assert [data for _, data in found] == [BOOT_UP, b"\x7f"]
    with pytest.raises(ControlError, match="io is switched off"):
        rig.get("io/nmt_state")
    with pytest.raises(ControlError, match="clear the fault"):
        rig.restart("io")
    rig.clear_fault("io", number)
    rig.run_until(450 * MS)
    assert [data for _, data in found[2:]] == [BOOT_UP]
    assert rig.faults("io") == {}


@pytest.mark.parametrize("processes", ["one", "each"])
def test_a_fault_of_a_device_without_power_acts_when_it_is_back(processes: str) -> None:
    """The node listens to other frames as long as it does not answer SDO requests."""
    with Rig(from_dict({**LAB, "processes": processes})) as rig:
        power = rig.add_fault("io", {"what": "power_off"})
        rig.run_until(50 * MS)
        cleared, kept = (rig.add_fault("io", {"what": what}) for what in ("sdo_abort", "heartbeat_lost"))
        rig.clear_fault("io", cleared)
        found = heard(rig)
        rig.run_until(100 * MS)
        assert found == []
        rig.clear_fault("io", power)
        rig.run_until(400 * MS)
        assert [data for _, data in found] == [BOOT_UP]
        rig.clear_fault("io", kept)
        rig.run_until(650 * MS)
        assert [data for _, data in found[1:]] == [b"\x7f"] * len(found[1:]) != []


def test_the_faults_that_there_are_have_the_loss_of_power_among_them(rig: Rig) -> None:
    with pytest.raises(ControlError, match=r"io: there is no fault 'power_of'\n *did you mean power_off"):
        rig.add_fault("io", {"what": "power_of"})
    with pytest.raises(ControlError, match=r"there are: sdo_abort.*, power_off"):
        rig.add_fault("io", {"what": "nonsense"})


def test_restart_is_a_power_cycle_at_one_instant(rig: Rig) -> None:
    found = heard(rig)
    rig.run_until(150 * MS)
    rig.restart("io")
    rig.run_until(160 * MS)
    assert [data for _, data in found] == [BOOT_UP, b"\x7f", BOOT_UP]


def test_two_faults_of_power_end_with_the_last_one() -> None:
    with Rig(from_dict(LAB)) as rig:
        rig.add_fault("io", {"what": "power_off", "duration_ms": 100})
        rig.add_fault("io", {"what": "power_off", "start_ms": 50, "duration_ms": 100})
        found = heard(rig)
        rig.run_until(149 * MS)
        assert found == []
        rig.run_until(152 * MS)
        assert [data for _, data in found] == [BOOT_UP]


def test_a_fault_of_power_has_only_its_keys() -> None:
    with Rig(from_dict(LAB)) as rig, pytest.raises(ControlError, match="days"):
        rig.add_fault("io", {"what": "power_off", "days": 7})
