"""The controller as Modbus client and CANopen master: values of other units and nodes are variables of its program."""

from pathlib import Path
from typing import Any

import pytest
from device_of import device_of

from fieldrig.clock import MS, S
from fieldrig.errors import ConfigError
from fieldrig.pytest_plugin import RigMaker
from fieldrig_bus.wires import Signal
from fieldrig_devices.hmiscu.device import Hmiscu

CONFIGS = Path(__file__).parents[4] / "configs"
PROGRAM = """
VAR_GLOBAL
    g_rLevel : REAL;
    g_uiLevel : UINT;
    g_uiSpeed : UINT := 250;
    g_bRun : BOOL;
    g_byIn : BYTE;
    g_dwOut : DWORD;                    (* four bytes of outputs *)
    g_bPump, g_bPanel : BOOL;
    g_sText : STRING;
END_VAR
PROGRAM PLC_PRG
g_rLevel := UINT_TO_REAL(g_uiLevel) / 1000.0;
g_dwOut := BYTE_TO_DWORD(g_byIn);
g_bPump := FieldbusIsRunning('Pump');
g_bPanel := FieldbusIsRunning('Panel');
END_PROGRAM
"""
CLIENT = {
    "timeout_ms": 50,
    "pause_ms": 200,
    "units": {
        "Pump": {
            "unit": 9,
            "reads": [{"what": "input_registers", "address": 0, "values": [{"name": "g_uiLevel"}], "every_ms": 50}],
            "writes": [
                {"address": 0, "values": [{"name": "g_uiSpeed"}]},
                {"what": "coils", "address": 0, "values": [{"name": "g_bRun", "type": "bool"}]},
            ],
        }
    },
}
MASTER = {
    "nodes": {
        "Panel": {
            "node_id": 5,
            "inputs": {1: [{"name": "g_byIn", "type": "u8"}]},
            "outputs": {1: [{"name": "g_dwOut", "type": "u32"}]},
        }
    }
}


def rig_of(folder: Path, **settings: Any) -> dict[str, Any]:
    program = folder / "masters.st"
    program.write_text(PROGRAM)
    return {
        "time": "virtual",
        "buses": {
            "mb": {"kind": "modbus.virtual"},
            "can0": {"kind": "can.virtual"},
            "wires": {"kind": "wires.virtual"},
        },
        "devices": {
            "scu": {
                "kind": "hmiscu",
                "links": {"modbus": ["mb"], "can": "can0"},
                "program": str(program),
                "modbus_client": CLIENT,
                "can_master": MASTER,
                **settings,
            },
            "pump": {
                "kind": "modbus.device",
                "unit_id": 9,
                "table": str(CONFIGS / "registers/pump-drive.yaml"),
                "links": {"modbus": ["mb"], "wires": "wires"},
            },
            "panel": {
                "kind": "canopen.node",
                "node_id": 5,
                "eds": str(CONFIGS / "eds/io32.eds"),
                "links": {"can": "can0", "wires": "wires"},
                "signals": {"6000:01.2": "button", "6200:01.2": "lamp"},
            },
        },
    }


@pytest.mark.long
def test_values_of_a_modbus_unit_are_variables_of_the_program(tmp_path: Path, fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(rig_of(tmp_path))
    rig.run_until(200 * MS)
    assert (rig.get("pump", "speed_set"), rig.get("pump", "run"), rig.get("scu", "g_bPump")) == (25.0, False, True)
    rig.set("scu", "g_bRun", True)
    rig.set("scu", "g_uiSpeed", 400)
    rig.set("pump", "ramp_time", 7.0)
    level = rig.attach("plant").link("wires")
    level.send(Signal("tank.level", 1.234, "m"))
    rig.run_until(400 * MS)
    assert (rig.get("pump", "speed_set"), rig.get("pump", "run")) == (40.0, True)
    assert rig.get("scu", "g_rLevel") == pytest.approx(1.234)


@pytest.mark.long
def test_a_lost_unit_gives_zeros_and_the_program_knows(tmp_path: Path, fieldrig_rig: RigMaker) -> None:
    data = rig_of(tmp_path)
    del data["devices"]["pump"]
    data["buses"]["mb"]["servers"] = [9]
    rig = fieldrig_rig(data)
    rig.set("scu", "g_uiLevel", 7)
    rig.run_until(1 * S)
    assert (rig.get("scu", "g_bPump"), rig.get("scu", "g_uiLevel")) == (False, 0)
    errors = rig.get("scu", "modbus_client/Pump/errors")
    assert int(errors) >= 3
    assert device_of(rig, "scu", Hmiscu).troubles()["modbus_client/Pump/errors"] == errors


def test_the_master_starts_a_node_and_exchanges_its_pdos(tmp_path: Path, fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(rig_of(tmp_path))
    rig.run_until(500 * MS)
    assert (rig.get("panel", "nmt.state"), rig.get("scu", "g_bPanel")) == ("operational", True)
    hands = rig.attach("hands").link("wires")
    hands.send(Signal("button", True))
    rig.run_until(600 * MS)
    assert (rig.get("scu", "g_byIn"), rig.get("panel", "6200:01")) == (4, 4)


def test_slave_and_master_share_the_bus(tmp_path: Path, fieldrig_rig: RigMaker) -> None:
    nodes = {**MASTER["nodes"], "Self": {"node_id": 20, "heartbeat_ms": 0}}
    rig = fieldrig_rig(rig_of(tmp_path, can_slave={"node_id": 20}, can_master={"nodes": nodes}))
    rig.run_until(2 * S)
    assert rig.get("scu", "can/nmt.state") == "operational"
    assert rig.get("scu", "g_bPanel") is True


WRONG = [
    ({"modbus_client": {"link": 2, "units": {}}}, r"modbus_client\.link: expected 1 to 1"),
    (
        {"modbus_client": {"units": {"P": {"unit": 9, "reads": [{"address": 0, "values": [{"name": "g_no"}]}]}}}},
        r"modbus_client\.units\.P: expected a point of the controller, got g_no",
    ),
    (
        {"modbus_client": {"units": {"P": {"unit": 9, "writes": [{"address": 0, "values": [{"name": "g_sText"}]}]}}}},
        "expected a number or a bit, got the text g_sText",
    ),
    (
        {"can_master": {"nodes": {"N": {"node_id": 5, "inputs": {1: [{"name": "plc.state", "type": "u8"}]}}}}},
        r"can_master\.nodes\.N: expected a point of the controller, got plc\.state",
    ),
    (
        {"can_master": {"nodes": {"N": {"node_id": 5, "inputs": {1: [{"name": "g_dwOut", "type": "u32"}]}}}}},
        r"can_master\.nodes\.N: expected a variable that the program only reads, got g_dwOut",
    ),
    ({"links": {"modbus": ["mb"]}}, r"can_master: expected links\.can beside it"),
]


@pytest.mark.parametrize(("settings", "wrong"), WRONG)
def test_values_that_have_no_point_are_refused_at_the_start(
    tmp_path: Path, fieldrig_rig: RigMaker, settings: dict[str, Any], wrong: str
) -> None:
    data = rig_of(tmp_path, **settings)
    with pytest.raises((ConfigError, ValueError), match=wrong):
        fieldrig_rig(data)
