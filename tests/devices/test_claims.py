"""Claims: one mechanism checks for all kinds that the needs of the devices on a bus are met, and do not conflict."""

from pathlib import Path
from typing import Any

import pytest
from winders import FILM

from fieldrig.config import kinds
from fieldrig.config.rig_file import from_dict, load
from fieldrig.errors import ConfigError
from fieldrig.settings import Settings

CONFIGS = Path(__file__).parents[2] / "configs"
IO = {"kind": "canopen.node", "eds": "eds/io32.eds", "links": {"can": "can0", "wires": "wires"}}
PUMP = {"kind": "modbus.device", "table": "registers/pump-drive.yaml", "links": {"modbus": "mb", "wires": "wires"}}
MAX4 = {"kind": "max4", "links": {"ring": "ring", "can": "can0", "modbus": "mb", "wires": "wires"}}
TANK = {
    "kind": "plant.tank",
    "links": {"wires": "wires"},
    "area_m2": 1.0,
    "height_m": 2.0,
    "outlet_area_m2": 0.001,
    "pump_flow_m3_per_s": 0.001,
}
SERVO = {
    "kind": "plant.servo",
    "links": {"wires": "wires"},
    "rated_torque_nm": 1.0,
    "motor_inertia_kg_m2": 0.001,
}
MODEM = {"kind": "modem", "links": {"line": "line", "telephone": "net"}}
ENCODER = {"kind": "sm.encoder", "name_plate": "plates/sm-100-30-080.yaml", "links": {"line": "line"}}
MC4 = {"kind": "mc4", "links": {"ring": "ring", "wires": "wires"}}
CARD = {"kind": "arp", "links": {"can": "can0", "wires": "wires", "user": "line"}}
TERMINAL = {"kind": "terminal.tr", "links": {"can": "can0"}}
CONVEYOR = {
    "kind": "plant.conveyor",
    "links": {"wires": "wires"},
    "length_m": 2.0,
    "roller_radius_m": 0.05,
    "product_m": 0.2,
    "drive_wire": "belt.position",
    "sensors": {"infeed": {"at_m": 0.5}},
}
ST1 = {"kind": "st1", "links": {"ring": "pamring", "wires": "wires"}}
SCU = {"kind": "hmiscu", "links": {"can": "can0", "modbus": ["mb"], "wires": "wires"}}
WINDER = {"kind": "plant.winder", "links": {"wires": "wires"}, "role": "unwinder", **FILM}

SMART_IO = {"kind": "smart_io", "links": {"can": "can0", "modbus": ["mb"], "wires": "wires"}}
DC_MOTOR = {"kind": "plant.dc-motor", "links": {"wires": "wires"}, "increase_wire": "i", "decrease_wire": "d"}
STEPPER = {
    "kind": "plant.stepper",
    "links": {"wires": "wires"},
    "pulse_wire": "b.pulse",
    "pull_out": [[0.0, 1.0]],
    "motor_inertia_kg_m2": 0.001,
}
PULSE_SERVO = {"kind": "plant.pulse-servo", "links": {"wires": "wires"}, "pulse_wire": "b.pulse"}
HEATER = {
    "kind": "plant.heater",
    "links": {"wires": "wires"},
    "power_w": 100.0,
    "heat_capacity_j_per_k": 100.0,
    "resistance_k_per_w": 1.0,
}
COUNTER = {"kind": "pulse.counter", "links": {"wires": "wires"}, "a_wire": "b.pulse"}
GENERATOR = {"kind": "pulse.generator", "links": {"wires": "wires"}}


def rig(**devices: Any) -> dict[str, Any]:
    buses = {
        "can0": "can.virtual", "mb": "modbus.virtual", "ring": "ring.virtual", "pamring": "pamring.virtual",
        "wires": "wires.virtual", "line": "serial.virtual", "line2": "serial.virtual", "net": "telephone.virtual",
    }  # fmt: skip
    return {
        "time": "virtual",
        "buses": {name: {"kind": kind} for name, kind in buses.items()},
        "devices": devices,
    }


def mistakes(data: dict[str, Any]) -> list[str]:
    try:
        from_dict(data, CONFIGS)
    except ConfigError as wrong:
        return [f"{mistake.key}: {mistake.what}" for mistake in wrong.mistakes]
    return []


# The kinds of what there is once on a bus: two devices that fit together, a change that makes them collide, and where.
TWICE: dict[str, tuple[dict[str, Any], dict[str, Any], str]] = {
    "a node of its own, and a Smart-IO": (
        {"a": {**IO, "node_id": 5}, "b": {**SMART_IO, "can_slave": {"node_id": 6}}},
        {"b": {**SMART_IO, "can_slave": {"node_id": 5}}},
        "devices.b.can_slave.node_id: node-ID 5 on can0 is taken by devices.a.node_id",
    ),
    "outputs of a Smart-IO and a DC motor": (
        {"a": {**SMART_IO, "terminals": {"out101": "a.x"}}, "b": DC_MOTOR},
        {"a": {**SMART_IO, "terminals": {"out101": "b.pulse"}}},
        "devices.b.pulse_wire: wire b.pulse on wires is taken by devices.a.terminals.out101",
    ),
    "two units of Modbus devices": (
        {"a": PUMP, "b": {**PUMP, "unit_id": 2, "links": {"modbus": "mb"}}},
        {"b": {**PUMP, "unit_id": 1, "links": {"modbus": "mb"}}},
        "devices.b.unit_id: unit 1 on mb is taken by devices.a.unit_id",
    ),
    "two nodes of a PAM": (
        {"a": {**ST1, "ring_address": 1}, "b": {**ST1, "ring_address": 2}},
        {"b": {**ST1, "ring_address": 1}},
        "devices.b.ring_address: ring address 1 on pamring is taken by devices.a.ring_address",
    ),
    "a tank and an output of an ST1": (
        {"a": TANK, "b": {**ST1, "ring_address": 1}},
        {"b": {**ST1, "ring_address": 1, "terminals": {"OUT9": "a.level"}}},
        "devices.b.terminals.OUT9: wire a.level on wires is taken by devices.a.level_wire",
    ),
    "one of several units, and a controller's": (
        {
            "a": MAX4,
            "b": {"kind": "modbus.device", "units": {"7": {"table": PUMP["table"]}}, "links": {"modbus": "mb"}},
        },
        {"a": {**MAX4, "modbus": {"unit_id": 7}}},
        "devices.b.units[7]: unit 7 on mb is taken by devices.a.modbus.unit_id",
    ),
    "two nodes": (
        {"a": {**IO, "node_id": 5}, "b": {**IO, "node_id": 6}},
        {"b": {**IO, "node_id": 5}},
        "devices.b.node_id: node-ID 5 on can0 is taken by devices.a.node_id",
    ),
    "a node and the axes of a MAx-4": (
        {"a": {**MAX4, "can_axes": {"node_ids": [4]}}, "b": {**IO, "node_id": 5}},
        {"b": {**IO, "node_id": 4}},
        "devices.b.node_id: node-ID 4 on can0 is taken by devices.a.can_axes.node_ids[0]",
    ),
    "a node and the MAx-4 as a master": (
        {"a": {**MAX4, "can_master": {"node_id": 100}}, "b": {**IO, "node_id": 5}},
        {"b": {**IO, "node_id": 100}},
        "devices.b.node_id: node-ID 100 on can0 is taken by devices.a.can_master.node_id",
    ),
    "a node and an ARP card": (
        {"a": CARD, "b": {**IO, "node_id": 5}},
        {"a": {**CARD, "parameters": {"general": {"5": 5}}}},
        "devices.b.node_id: node-ID 5 on can0 is taken by devices.a.parameters.general[5]",
    ),
    "a node and an HMISCU": (
        {"a": {**SCU, "can_slave": {"node_id": 4}}, "b": {**IO, "node_id": 5}},
        {"b": {**IO, "node_id": 4}},
        "devices.b.node_id: node-ID 4 on can0 is taken by devices.a.can_slave.node_id",
    ),
    "two HMISCU on one line": (
        {"a": SCU, "b": {**SCU, "modbus": {"unit_id": 2}}},
        {"b": SCU},
        "devices.b.modbus.unit_id: unit 1 on mb is taken by devices.a.modbus.unit_id",
    ),
    "a tank and an output of an HMISCU": (
        {"a": TANK, "b": SCU},
        {"b": {**SCU, "terminals": {"DQ0": "a.high"}}},
        "devices.b.terminals.DQ0: wire a.high on wires is taken by devices.a.high_wire",
    ),
    "a node and a terminal": (
        {"a": {**TERMINAL, "node_id": 20}, "b": {**IO, "node_id": 5}},
        {"b": {**IO, "node_id": 20}},
        "devices.b.node_id: node-ID 20 on can0 is taken by devices.a.node_id",
    ),
    "remote I/O with two masters": (
        {
            "a": {**CARD, "io_nodes": [3]},
            "b": {**CARD, "number": 2, "parameters": {"general": {"5": 40}}, "io_nodes": [4]},
        },
        {"b": {**CARD, "number": 2, "parameters": {"general": {"5": 40}}, "io_nodes": [4, 3]}},
        "devices.b.io_nodes[1]: master of node-ID 3 on can0 is taken by devices.a.io_nodes[0]",
    ),
    "two cards with one number on one line": (
        {"a": CARD, "b": {**CARD, "number": 2, "parameters": {"general": {"5": 40}}}},
        {"b": {**CARD, "number": 1, "parameters": {"general": {"5": 40}}}},
        "devices.b.number: card number 1 on line is taken by devices.a.number",
    ),
    "two ring addresses": (
        {"a": {**MC4, "ring_address": 1}, "b": {**MC4, "ring_address": 2}},
        {"b": {**MC4, "ring_address": 1}},
        "devices.b.ring_address: ring address 1 on ring is taken by devices.a.ring_address",
    ),
    "two masters of a ring": (
        {"a": MAX4, "b": {**IO, "node_id": 5}},
        {"b": {**MAX4, "links": {"ring": "ring"}}},
        "devices.b: master of the ring on ring is taken by devices.a",
    ),
    "two modems at one line": (
        {"a": MODEM, "b": {**MODEM, "links": {"line": "line2", "telephone": "net"}}},
        {"b": MODEM},
        "devices.b.kind: end of a modem on line is taken by devices.a.kind",
    ),
    "two encoders at one line": (
        {"a": {**ENCODER, "address": 0x40}, "b": {**ENCODER, "address": 0x41}},
        {"b": {**ENCODER, "address": 0x40}},
        "devices.b.address: HIPERFACE address 64 on line is taken by devices.a.address",
    ),
    "two objects that drive one wire": (
        {"a": {**IO, "node_id": 5, "signals": {"6200:01.0": "lamp", "6200:01.1": "horn"}}},
        {"a": {**IO, "node_id": 5, "signals": {"6200:01.0": "lamp", "6200:01.1": "lamp"}}},
        "devices.a.signals.6200:01.1: wire lamp on wires is taken by devices.a.signals.6200:01.0",
    ),
    "a tank and an object": (
        {"a": TANK, "b": {**IO, "node_id": 5, "signals": {"6200:01.0": "lamp"}}},
        {"b": {**IO, "node_id": 5, "signals": {"6200:01.0": "a.high"}}},
        "devices.b.signals.6200:01.0: wire a.high on wires is taken by devices.a.high_wire",
    ),
    "a register table and a servo": (
        {"a": PUMP, "b": SERVO},
        {"b": {**SERVO, "encoder_wire": "pump.speed"}},
        "devices.b.encoder_wire: wire pump.speed on wires is taken by devices.a.table",
    ),
    "switches of two servos": (
        {"a": {**SERVO, "switches": {"home": {"from_rad": 0.0, "to_rad": 1.0}}}, "b": SERVO},
        {"b": {**SERVO, "index_wire": "home"}},
        "devices.b.index_wire: wire home on wires is taken by devices.a.switches.home",
    ),
    "a drive and a card": (
        {"a": {**MC4, "ring_address": 1}, "b": CARD},
        {"b": {**CARD, "signals": {"O101": "a.brake"}}},
        "devices.b.signals.O101: wire a.brake on wires is taken by devices.a.brake_wire",
    ),
    "a conveyor and a controller": (
        {"a": CONVEYOR, "b": MAX4},
        {"b": {**MAX4, "outputs": {"O_bLamp": "a.infeed"}}},
        "devices.b.outputs.O_bLamp: wire a.infeed on wires is taken by devices.a.sensors.infeed",
    ),
    "a stepper and a pulse generator": (
        {"a": STEPPER, "b": GENERATOR},
        {"b": {**GENERATOR, "wire": "a.ready"}},
        "devices.b.wire: wire a.ready on wires is taken by devices.a.ready_wire",
    ),
    "a heater and a servo with a pulse input": (
        {"a": {**HEATER, "limit_degc": 90.0}, "b": PULSE_SERVO},
        {"b": {**PULSE_SERVO, "in_position_wire": "a.over"}},
        "devices.b.in_position_wire: wire a.over on wires is taken by devices.a.over_wire",
    ),
    "a counter and the direction of a generator": (
        {"a": {**COUNTER, "compare": 5}, "b": GENERATOR},
        {"b": {**GENERATOR, "direction_wire": "a.reached"}},
        "devices.b.direction_wire: wire a.reached on wires is taken by devices.a.compare_wire",
    ),
    "a winder and a controller": (
        {"a": {**WINDER, "dancer": {"mass_kg": 1.0, "force_n": 1.0, "travel_m": 0.1}}, "b": MAX4},
        {"b": {**MAX4, "outputs": {"O_bLamp": "a.dancer"}}},
        "devices.b.outputs.O_bLamp: wire a.dancer on wires is taken by devices.a.dancer.wire",
    ),
}


@pytest.mark.parametrize("case", TWICE)
def test_what_a_bus_has_room_for_once_is_refused_twice(case: str) -> None:
    fitting, change, expected = TWICE[case]
    assert mistakes(rig(**fitting)) == []
    assert mistakes(rig(**{**fitting, **change})) == [expected]


def test_two_buses_have_room_for_one_each() -> None:
    data = rig(a={**IO, "node_id": 5}, b={**IO, "node_id": 5, "links": {"can": "can1"}})
    data["buses"]["can1"] = {"kind": "can.virtual"}
    assert mistakes(data) == []


CLIENT = {**MAX4, "modbus_client": {"units": {"Pump": {"unit": 9}}}}


def test_a_unit_that_a_client_asks_must_be_served() -> None:
    assert mistakes(rig(a=CLIENT, b={**PUMP, "unit_id": 9})) == []
    assert mistakes(rig(a=CLIENT, b={**PUMP, "unit_id": 8})) == [
        "devices.a.modbus_client.units.Pump.unit: nothing on mb has unit 9"
    ]


def test_a_member_from_outside_may_serve_it_where_the_bus_says_so() -> None:
    data = rig(a=CLIENT)
    data["buses"]["mb"] |= {"servers": [9]}
    assert mistakes(data) == []


def test_its_own_unit_serves_no_client() -> None:
    assert mistakes(rig(a={**CLIENT, "modbus": {"unit_id": 9}})) == [
        "devices.a.modbus_client.units.Pump.unit: nothing on mb has unit 9"
    ]


@pytest.mark.parametrize(
    ("bus", "is_right"),
    [
        ({"kind": "modbus.tcp", "servers": {"9": "127.0.0.1:502"}}, True),
        ({"kind": "modbus.tcp", "servers": {"8": "127.0.0.1:502"}}, False),
        ({"kind": "modbus.rtu", "dial": "127.0.0.1:502", "servers": [9]}, True),
        ({"kind": "modbus.rtu", "dial": "127.0.0.1:502"}, False),
    ],
)
def test_a_unit_may_be_served_outside_where_the_bus_leads_to_it(bus: dict[str, Any], is_right: bool) -> None:
    data = rig(a={**CLIENT, "links": {"ring": "ring", "modbus": "mb"}})
    data["time"] = "real"
    data["buses"] = {"mb": bus, "ring": {"kind": "ring.zenoh"}}
    assert (mistakes(data) == []) is is_right


@pytest.mark.long
@pytest.mark.parametrize("file", sorted(CONFIGS.glob("*.yaml")), ids=lambda file: file.stem)
def test_shipped_rigs_fit(file: Path) -> None:
    assert load(file).devices


def test_every_kind_that_has_something_for_itself_says_so() -> None:
    """A kind without wires and without a number of its own has nothing to claim."""
    silent = [
        kind.name
        for kind in kinds.list_devices()
        if kinds.settings_model(kinds.find_device(kind.name)).claims is Settings.claims
    ]
    assert silent == ["can.bridge"]
