"""The points that the pages name exist: those in the first column of tables whose heading is `point`."""

from typing import Any

import pytest
from doc_pages import PAGES, ROOT, code_in, rows

from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.node import LocalNode
from fieldrig.virtual.rig import Rig

BUSES = {
    "can": "can.virtual",
    "ring": "ring.virtual",
    "pamring": "pamring.virtual",
    "wires": "wires.virtual",
    "line": "serial.virtual",
    "telephone": "telephone.virtual",
}
PLATE = "plates/sm-100-30-080.yaml"
WIRES = {"wires": "wires"}
DEVICES: dict[tuple[str, str], dict[str, Any]] = {
    ("modem.md", "`modem`"): {"kind": "modem", "links": {"line": "line", "telephone": "telephone"}},
    ("arp-card.md", "Points"): {"kind": "arp", "links": {"can": "can"}},
    ("arp-terminal.md", "Points"): {"kind": "terminal.tr", "links": {"can": "can"}},
    ("canopen-node.md", "Points"): {
        "kind": "canopen.node", "node_id": 5, "eds": "eds/io32.eds", "links": {"can": "can"},
    },
    ("hmiscu.md", "Points"): {"kind": "hmiscu", "channel_0": {"mode": "pto"}, "links": WIRES},
    ("max4.md", "Objects and points"): {"kind": "max4", "links": {"ring": "ring"}},
    ("max4-plc.md", "Points"): {
        "kind": "max4", "program": "programs/lamp.st", "outputs": {"O_bEquipmentOnIndicatorH1": ""}, "links": WIRES,
    },
    ("cia402-drive.md", "Points"): {"kind": "cia402.drive", "node_id": 3, "links": {"can": "can"}},
    ("mc4.md", "Points"): {"kind": "mc4", "ring_address": 1, "motor": {"name_plate": PLATE}, "links": {"ring": "ring"}},
    ("st1.md", "Points"): {
        "kind": "st1", "ring_address": 1, "variables": {200: {"value": 0}}, "links": {"ring": "pamring"},
    },
    ("nameplate.md", "`sm.encoder`"): {"kind": "sm.encoder", "name_plate": PLATE, "links": {"line": "line"}},
    ("plants.md", "`plant.tank`"): {
        "kind": "plant.tank", "area_m2": 0.25, "height_m": 2.0, "outlet_area_m2": 0.0002,
        "pump_flow_m3_per_s": 0.001, "links": WIRES,
    },
    ("plants.md", "`plant.servo`"): {
        "kind": "plant.servo", "rated_torque_nm": 2.0, "motor_inertia_kg_m2": 0.001, "links": WIRES,
    },
    ("plants.md", "`plant.winder`"): {
        "kind": "plant.winder", "role": "unwinder", "core_radius_m": 0.05, "initial_radius_m": 0.2,
        "core_inertia_kg_m2": 0.05, "thickness_m": 0.0001, "width_m": 0.5, "torque_nm_at_10_v": 50.0,
        "load_cell": {"rated_force_n": 1000.0}, "dancer": {"mass_kg": 5.0, "force_n": 100.0, "travel_m": 0.2},
        "links": WIRES,
    },
    ("pulses.md", "`plant.stepper`"): {
        "kind": "plant.stepper", "pulse_wire": "p", "pull_out": [[0, 1]], "motor_inertia_kg_m2": 0.001, "links": WIRES,
    },
    ("pulses.md", "`plant.pulse-servo`"): {"kind": "plant.pulse-servo", "pulse_wire": "p", "links": WIRES},
    ("pulses.md", "`plant.heater`"): {
        "kind": "plant.heater", "power_w": 200, "heat_capacity_j_per_k": 100, "resistance_k_per_w": 1, "links": WIRES,
    },
    ("pulses.md", "`pulse.counter`"): {"kind": "pulse.counter", "a_wire": "p", "compare": 5, "links": WIRES},
    ("pulses.md", "`pulse.generator`"): {"kind": "pulse.generator", "links": WIRES},
    ("pam.md", "Points"): {"kind": "pam", "application": "programs/labeller.pam", "links": {"ring": "pamring"}},
    ("smart-io.md", "Points"): {
        "kind": "smart_io", "motors": [{"increase": 101, "decrease": 102, "zero": 102, "counter": 101}],
        "ring_address": 9, "links": {**WIRES, "ring": "pamring"},
    },
    ("plants.md", "`plant.dc-motor`"): {
        "kind": "plant.dc-motor", "increase_wire": "i", "decrease_wire": "d", "links": WIRES,
    },
    ("plants.md", "`plant.conveyor`"): {
        "kind": "plant.conveyor", "length_m": 2.0, "roller_radius_m": 0.05, "product_m": 0.2,
        "drive_wire": "belt.position", "links": WIRES,
    },
}  # fmt: skip
"""A device with every point that the table below this heading of the page names."""

WITH_MORE = ("can/", "plc/")
"""Beginnings of the keys of points that a device has only with a face on CAN, or with a program."""


def named_points() -> dict[tuple[str, str], set[str]]:
    """The points in the tables of all pages, by page and heading."""
    found: dict[tuple[str, str], set[str]] = {}
    for page in PAGES:
        for row in rows(page):
            if row.columns[0] == "point":
                found.setdefault((page.name, row.heading), set()).update(code_in(row.cells[0]))
    return found


def test_every_table_of_points_has_its_device() -> None:
    assert named_points().keys() == DEVICES.keys()


@pytest.mark.long
@pytest.mark.parametrize("table", DEVICES, ids=" ".join)
def test_the_points_of_a_table_exist(table: tuple[str, str]) -> None:
    device = DEVICES[table]
    buses = {name: {"kind": BUSES[name]} for name in device["links"].values()}
    rig = {"time": "virtual", "buses": buses, "devices": {"device": device}}
    with Rig(from_dict(rig, ROOT / "configs")) as running:
        known = running.keys("device").keys()
        node = running._engine.nodes["device"]
        assert isinstance(node, LocalNode)
        troubles = node.device.troubles().keys()
    assert named_points()[table] - known == set()
    assert troubles <= known
    assert {key for key in node.device.trouble_keys if not key.startswith(WITH_MORE)} <= known
    assert set(node.device.log_keys) <= known
