"""Each fault of a device is in the traces of its buses: when it begins and is over, or at each use of it."""

from collections.abc import Callable
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS
from fieldrig.config import kinds
from fieldrig.config.rig_file import from_dict
from fieldrig.faults import note
from fieldrig.faults.note import FaultNote
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame

ROOT = Path(__file__).parents[3]
RIG: dict[str, Any] = {
    "time": "virtual",
    "buses": {"can0": {"kind": "can.virtual", "acknowledge": "always"}, "wires": {"kind": "wires.virtual"}},
    "devices": {
        "io": {
            "kind": "canopen.node",
            "node_id": 5,
            "eds": str(ROOT / "configs/eds/io32.eds"),
            "links": {"can": "can0", "wires": "wires"},
        },
        "tank": {
            "kind": "plant.tank",
            "area_m2": 0.25,
            "height_m": 2.0,
            "outlet_area_m2": 0.0002,
            "pump_flow_m3_per_s": 0.001,
            "links": {"wires": "wires"},
        },
    },
}
Line = tuple[int, str, str, str]


def traced(act: Callable[[Rig], object], **settings: Any) -> list[Line]:
    """The milliseconds, bus, device and text of each note of a fault."""
    lines: list[Line] = []

    def on_delivery(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        if isinstance(delivery.message, FaultNote):
            lines.append((delivery.time_ns // MS, bus.name, delivery.sender, bus.show(delivery.message)))

    with Rig(from_dict({**RIG, **settings}), on_delivery) as rig:
        act(rig)
    return lines


@pytest.mark.parametrize("processes", ["one", pytest.param("each", marks=pytest.mark.system)])
def test_a_state_is_noted_when_it_begins_and_when_it_is_over(processes: str) -> None:
    def act(rig: Rig) -> None:
        rig.run_until(5 * MS)
        rig.add_fault("tank", {"what": "leak", "start_ms": 10, "duration_ms": 20})
        cleared = rig.add_fault("tank", {"what": "blocked_outlet"})
        rig.run_until(50 * MS)
        rig.clear_fault("tank", cleared)

    assert traced(act, processes=processes) == [
        (5, "wires", "tank", "fault 2: blocked_outlet"),
        (15, "wires", "tank", "fault 1: leak"),
        (35, "wires", "tank", "fault 1: over"),
        (50, "wires", "tank", "fault 2: over"),
    ]


def test_a_loss_of_power_is_noted_on_every_bus_and_other_faults_once_only() -> None:
    def act(rig: Rig) -> None:
        rig.add_fault("tank", {"what": "leak"})
        rig.add_fault("io", {"what": "power_off", "start_ms": 3, "duration_ms": 4})
        rig.add_fault("tank", {"what": "power_off", "duration_ms": 4})
        rig.run_until(50 * MS)

    assert sorted(traced(act)) == [
        (0, "wires", "tank", "fault 1: leak"),
        (0, "wires", "tank", "fault 2: power_off"),
        (3, "can0", "io", "fault 1: power_off"),
        (3, "wires", "io", "fault 1: power_off"),
        (4, "wires", "tank", "fault 2: over"),
        (7, "can0", "io", "fault 1: over"),
        (7, "wires", "io", "fault 1: over"),
    ]


def test_a_fault_of_messages_is_noted_at_each_use() -> None:
    def act(rig: Rig) -> None:
        rig.add_fault("io", {"what": "sdo_silence", "count": 2})
        master = rig.attach("master").link("can0")
        for ms in (10, 20, 30):
            rig.run_until(ms * MS)
            master.send(CanFrame(0x605, bytes.fromhex("40 00 10 00 00 00 00 00")))
        rig.run_until(50 * MS)

    assert [line for line in traced(act) if line[1] == "can0"] == [
        (10, "can0", "io", "fault 1: sdo_silence"),
        (20, "can0", "io", "fault 1: sdo_silence"),
    ]


def test_a_fault_from_the_start_is_noted_and_so_is_its_condition() -> None:
    devices = {**RIG["devices"], "tank": {**RIG["devices"]["tank"], "faults": [{"what": "leak", "start_ms": 7}]}}

    def act(rig: Rig) -> None:
        rig.add_fault("tank", {"what": "blocked_outlet", "when": "io/nmt.state == operational"})
        rig.run_until(10 * MS)
        rig.attach("master").link("can0").send(CanFrame(0, b"\x01\x00"))
        rig.run_until(50 * MS)

    assert traced(act, devices=devices) == [
        (7, "wires", "tank", "fault 1: leak"),
        (10, "wires", "tank", "fault 2: blocked_outlet"),
    ]


@pytest.mark.parametrize("kind", sorted(point.name for point in entry_points(group="fieldrig.buses")))
@given(number=st.integers(0, 0xFFFF_FFFF), what=st.text(min_size=1, max_size=note.LONGEST))
def test_the_trace_of_every_kind_of_bus_can_have_the_faults_of_its_members(kind: str, number: int, what: str) -> None:
    bus: Any = kinds.find_bus(kind)
    assert bus.notes_faults
    fault = FaultNote(number, what.encode(errors="replace").decode())
    assert bus.decode(bus.encode(fault)) == fault
    assert bus.show(fault) == f"fault {number}: {fault.what}"
