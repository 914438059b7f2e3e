"""Nodes on a CAN bus of a rig: found by their kind, connected by wires, the same in one process or many."""

from typing import Any

import pytest
from canopen_bench import EDS

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.errors import RigError
from fieldrig.pytest_plugin import RigMaker
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame

START_ALL = CanFrame(0x000, bytes.fromhex("01 00"))
VALVE_TO_1500 = CanFrame(0x305, bytes.fromhex("dc 05 00 00 00 00 00 00"))


def plant(**changes: Any) -> dict[str, Any]:
    """A rig in which the sensor (node 6) measures the valve output of the I/O module (node 5), in millimetres."""
    links = {"can": "can0", "wires": "wires"}
    level = {"wire": "level", "unit": "m", "scale": 0.001}
    return {
        "time": "virtual",
        "buses": {"can0": {"kind": "can.virtual", "bitrate": 500_000}, "wires": {"kind": "wires.virtual"}},
        "devices": {
            "io": {
                "kind": "canopen.node",
                "node_id": 5,
                "eds": str(EDS / "io32.eds"),
                "objects": {"1017:00": 100},
                "signals": {"6411:01": level},
                "links": links,
            },
            "sensor": {
                "kind": "canopen.node",
                "node_id": 6,
                "eds": str(EDS / "level-sensor.eds"),
                "signals": {"9130:01": level},
                "links": links,
            },
        },
        **changes,
    }


def run(rig: Rig) -> None:
    master = rig.attach("master").link("can0")
    rig.run_until(1 * MS)
    master.send(START_ALL)
    rig.run_until(5 * MS)
    master.send(VALVE_TO_1500)
    rig.run_until(300 * MS)


def test_what_a_master_writes_to_one_node_another_measures(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(plant())
    run(rig)
    assert rig.get("sensor", "9130:01") == 1500
    assert rig.get("io", "nmt.state") == "operational"


def traced(**changes: Any) -> list[tuple[int, str, str]]:
    lines = []

    def on_delivery(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        lines.append((delivery.time_ns, delivery.sender, bus.show(delivery.message)))

    with Rig(from_dict(plant(**changes)), on_delivery) as rig:
        run(rig)
    return lines


@pytest.mark.system
def test_nodes_in_processes_of_their_own_send_the_same(fieldrig_rig: RigMaker) -> None:
    lines = traced()
    assert [sender for _, sender, _ in lines].count("io") >= 4
    assert traced(processes="each") == lines


def test_mistake_in_a_rig_file_is_named_with_its_key() -> None:
    wrong = plant()
    wrong["devices"]["io"]["signals"] = {"6200:09": "lamp"}
    with pytest.raises(RigError, match=r"(?s)io.*the EDS has no 6200:09; object 6200h has"):
        from_dict(wrong)


def test_signals_without_wires_are_refused(fieldrig_rig: RigMaker) -> None:
    wrong = plant()
    wrong["devices"]["io"]["links"] = {"can": "can0"}
    with pytest.raises(RigError, match="io has signals but no wires"):
        fieldrig_rig(wrong)
