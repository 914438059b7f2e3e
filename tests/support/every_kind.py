"""A rig that has every kind of device, and in which all that can move does."""

from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
CONFIGS = ROOT / "configs"
PLATE = str(CONFIGS / "plates/sm-100-30-080.yaml")
WIRES = {"wires": "wires"}
MOTOR = {"kind": "plant.servo", "links": WIRES, "rated_torque_nm": 1.0, "motor_inertia_kg_m2": 0.001}
"""Acceleration without friction: 960 rad/s2 for a load of -0.96 N m."""
PULL_NM, PULLED = -0.96, 960.0
FILM = {
    "role": "unwinder", "core_radius_m": 0.05, "initial_radius_m": 0.2, "core_inertia_kg_m2": 0.05,
    "thickness_m": 0.0001, "width_m": 0.5, "modulus_pa": 5e8, "torque_nm_at_10_v": 50.0,
    "load_cell": {"rated_force_n": 1000.0}, "line_wire": "motor.encoder", "line_m_per_count": 1e-6,
}  # fmt: skip
TANK = {
    "area_m2": 0.25, "height_m": 2.0, "outlet_area_m2": 0.0002, "pump_flow_m3_per_s": 0.001, "initial_level_m": 1.79,
    "initial_outlet_percent": 70,
}  # fmt: skip
TABLE = """
about: shaft and tank
input_registers:
  - {address: 0, name: position, type: s32, unit: count, wire: motor.encoder}
  - {address: 2, name: level, type: f32, unit: m, wire: tank.level}
  - {address: 4, name: runs, type: u32, source: {kind: uptime, unit_ms: 1}}
"""
IO32 = str(CONFIGS / "eds/io32.eds")
SENSOR = str(CONFIGS / "eds/level-sensor.eds")

APPLICATION = """
APPLICATION NAME = law V1.00; BASIC_PAM_CYCLE = 3; END
NODE NOD_Servo; ADDRESS = 1; TYPE = ST1; END
AXIS AXI_Servo; NODE = NOD_Servo; PULSES_PER_UNIT = 1000000.0; TRAVEL_SPEED = 500.0; ACCELERATION = 9000.0;
  INITIAL_POSITION = 0.0; POSITION_PERIOD = 4294.967296; END
PAM_ANALOG_OUTPUT PAO_Probe; UNITS_PER_VOLT = 2000.0; OFFSET = 0.0; ADDRESS = 0; END
VME DUALPORT SPECS DEFAULT_PERIOD = 1; MASTER_READY_TIMEOUT = NONE; MASTER_CONFIGURATION_TIMEOUT = NONE;
  MASTER_INACTIVITY_TIMEOUT = NONE; END_SPECS OUTPUT REAL_VAR DOR_Place; END_DUALPORT
INTERNAL FLAG_VAR IFV_Begin;
TASK TSK_Law; SPECS CYCLES = 1; END_SPECS
  EVENTS ON_EVENT IFV_Begin XEQ_SEQUENCE SEQ_Law; END_EVENTS
  SEQUENCE SEQ_Law;
    AXI_Servo <- power_on;
    CONDITION AXI_Servo ? ready;
    AXI_Servo <- run(400.0);
    LOOP
      WAIT_TIME 5;
      DOR_Place <- AXI_Servo ? position;
      PAO_Probe <- DOR_Place;
    END_LOOP !IFV_Begin;
  END_SEQUENCE
  POWERON IFV_Begin <- set; END_POWERON
END_TASK
"""
DEVICES: dict[str, dict[str, Any]] = {
    "motor": MOTOR,
    "roll": {"kind": "plant.winder", "links": WIRES, **FILM},
    "tank": {"kind": "plant.tank", "links": WIRES, **TANK},
    "card": {
        "kind": "arp", "links": {**WIRES, "can": "can0"}, "number": 1,
        "signals": {"encoder1": "motor.encoder", "encoder2": "roll.encoder", "adc1": "roll.load_cell"},
    },
    "terminal": {"kind": "terminal.tr", "model": "TR4", "node_id": 20, "links": {"can": "can0"}},
    "io": {
        "kind": "canopen.node", "node_id": 5, "eds": IO32, "links": {**WIRES, "can": "can1"},
        "signals": {"6401:01": {"wire": "motor.encoder", "unit": "count", "scale": 10.0}},
    },
    "sensor": {
        "kind": "canopen.node", "node_id": 6, "eds": SENSOR, "links": {**WIRES, "can": "can1"},
        "signals": {"6130:01": {"wire": "motor.encoder", "unit": "count"}},
    },
    "drive": {"kind": "cia402.drive", "node_id": 8, "links": {**WIRES, "can": "can1"}},
    "bridge": {"kind": "can.bridge", "links": {"a": "can0", "b": "can1"}},
    "panel": {"kind": "modbus.device", "links": {**WIRES, "modbus": ["modbus"]}, "turnaround_ms": 0},
    "plate": {"kind": "sm.encoder", "name_plate": PLATE, "links": {**WIRES, "line": "line"}},
    "modem": {"kind": "modem", "links": {"line": "com", "telephone": "exchange"}},
    "belt": {"kind": "mc4", "ring_address": 1, "motor": {"name_plate": PLATE}, "links": {**WIRES, "ring": "ring"}},
    "rolling": {  # no ring: it rolls out as its load says
        "kind": "mc4", "ring_address": 2, "motor": {"name_plate": PLATE}, "links": {**WIRES, "ring": "idle"},
        "load": {"coulomb_nm": 0.1}, "shaft_wire": "plate.shaft",
    },
    "servo": {
        "kind": "st1", "ring_address": 1, "links": {**WIRES, "ring": "pamring"}, "second_wire": "rolling.position",
    },
    "conveyor": {
        "kind": "plant.conveyor", "links": WIRES, "length_m": 2.0, "roller_radius_m": 0.05, "product_m": 0.2,
        "pitch_m": 0.3, "drive_wire": "rolling.position", "sensors": {"infeed": {"at_m": 0.5}},
    },
    "pulses": {"kind": "pulse.generator", "links": WIRES, "frequency": 1_733.0, "run": True},
    "pwm": {"kind": "pulse.generator", "links": WIRES, "waveform": "pwm", "frequency": 100.0, "run": True},
    "counter": {"kind": "pulse.counter", "links": WIRES, "a_wire": "pulses.pulse", "compare": 300},
    "stepper": {
        "kind": "plant.stepper", "links": WIRES, "pulse_wire": "pulses.pulse", "start_hz": 2_000.0,
        "pull_out": [(0.0, 2.0), (100.0, 1.0)], "motor_inertia_kg_m2": 0.0001,
    },
    "follower": {"kind": "plant.pulse-servo", "links": WIRES, "pulse_wire": "pulses.pulse"},
    "oven": {
        "kind": "plant.heater", "links": WIRES, "power_wire": "pwm.pwm", "power_w": 200.0,
        "heat_capacity_j_per_k": 10.0, "resistance_k_per_w": 1.0, "limit_degc": 30.0,
    },
    "scu": {
        "kind": "hmiscu", "model": "HMISCU6B5", "links": WIRES, "channel_0": {"mode": "pto"},
        "terminals": {
            "AI0": {"wire": "tank.level", "unit": "m", "low": 0.0, "high": 2.0},
            "TI0": {"wire": "motor.encoder", "unit": "count"}, "FQ0": "scu.pulse",
        },
    },
    "weather": {
        "kind": "plant.signals", "links": WIRES,
        "signals": {
            "rain": {"source": {"kind": "random_walk", "low": 0.0, "high": 9.0, "step": 1.0, "step_ms": 3.0}},
            "sun": {"source": {"kind": "sine", "low": 0.0, "high": 9.0, "period_ms": 97.0, "every_ms": 1.0}},
        },
    },
    "cams": {
        "kind": "plant.cam-switches", "links": WIRES, "position_wire": "rolling.position",
        "switches": {"zero": {"low": 3.0, "high": 3.5, "every": 6.25}},
    },
    "pam": {
        "kind": "pam", "application": "", "links": {**WIRES, "ring": "pamring", "modbus": ["modbus"]},
        "analog_wires": ["pam.probe"], "access": {"unit_id": 3},
    },
    "plc": {"kind": "pam.vme-master", "application": "", "unit_id": 3, "links": {"modbus": "modbus"}},
    "guide": {"kind": "plant.dc-motor", "links": WIRES, "increase_wire": "pwm.pwm", "decrease_wire": "scu.pulse"},
    "smart": {
        "kind": "smart_io", "links": {**WIRES, "modbus": ["modbus"], "can": "can1"},
        "terminals": {"in101": "guide.pulse", "in102": "pulses.pulse"}, "modbus": {"unit_id": 2},
        "can_slave": {"node_id": 7},
    },
    "max4": {
        "kind": "max4", "links": {**WIRES, "ring": "ring"}, "drives": {"belt": {"ring_address": 1}},
        "master_encoders": {"line": "motor.encoder"},
    },
}  # fmt: skip
BUSES: dict[str, dict[str, Any]] = {
    "wires": {"kind": "wires.virtual"},
    "can0": {"kind": "can.virtual", "bitrate": 500_000},
    "can1": {"kind": "can.virtual", "bitrate": 500_000},
    "modbus": {"kind": "modbus.virtual"},
    "line": {"kind": "serial.virtual"},
    "com": {"kind": "serial.virtual"},
    "exchange": {"kind": "telephone.virtual", "numbers": {"modem": "100"}},
    "ring": {"kind": "ring.virtual"},
    "idle": {"kind": "ring.virtual"},
    "pamring": {"kind": "pamring.virtual"},
}


def whole(folder: Path, *names: str) -> dict[str, Any]:
    """The rig of all kinds, or those devices of it."""
    (folder / "shaft.yaml").write_text(TABLE)
    devices = {name: dict(DEVICES[name]) for name in names or DEVICES}
    (folder / "app.pam").write_text(APPLICATION)
    for name in {"pam", "plc"} & devices.keys():
        devices[name]["application"] = str(folder / "app.pam")
    if "panel" in devices:
        devices["panel"]["table"] = str(folder / "shaft.yaml")
    linked = {bus for device in devices.values() for value in device["links"].values() for bus in _each(value)}
    return {
        "time": "virtual", "seed": 7,
        "buses": {name: bus for name, bus in BUSES.items() if name in linked}, "devices": devices,
    }  # fmt: skip


def _each(value: str | list[str]) -> list[str]:
    return [value] if isinstance(value, str) else value
