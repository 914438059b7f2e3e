"""Whatever is read is the value at the instant of reading, for every device; and reading changes nothing.

One law goes over every kind of device: what a point shows at an instant without any event is what it shows right after
an event has brought the device to that instant.  Beside it stand closed solutions, where there are any.
"""

import struct
from collections.abc import Callable, Iterator
from importlib.metadata import entry_points
from math import floor, tau
from pathlib import Path
from typing import Any

import pytest

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, US
from fieldrig.config.rig_file import from_dict, load
from fieldrig.device import Value
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_bus.wires import WiresModel

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

# A rig that has every kind, and in which all that can move does.
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


def set_going(rig: Rig) -> None:
    """Everything that a person could move by its points."""
    rig.set("motor", "load_torque", PULL_NM)
    rig.set("rolling", "load_torque", -1.5)
    rig.set("drive", "load_torque", -0.5)
    rig.set("smart", "led1.blink", True)
    for pin, value in (("Velocity", 10_000), ("Acceleration", 500), ("Deceleration", 500), ("Execute", True)):
        rig.set("scu", f"MoveVelocity.{pin}", value)


def shipped(name: str) -> Callable[[Path], Rig]:
    return lambda folder: Rig(load(CONFIGS / name))


def press_everything(rig: Rig) -> None:
    """Pull at each axis, and let the tank run: what a person can do in any of the rigs."""
    for device in rig.config.devices:
        keys = rig.keys(device)
        if "load_torque" in keys:
            rig.set(device, "load_torque", -2.0)
        if "6411:01" in keys:
            rig.set(device, "6411:01", 6_000)


RIGS: dict[str, tuple[Callable[[Path], Rig], Callable[[Rig], None]]] = {
    "every kind": (lambda folder: Rig(from_dict(whole(folder))), set_going),
    **{path.name: (shipped(path.name), press_everything) for path in sorted(CONFIGS.glob("*-virtual.yaml"))},
}
LONG = {"packaging-line-virtual.yaml"}
APART = {
    "slow_cycles",  # counts events, and a device that got one has one more
    "adc1",  # a winder tells its load cell once a step: that is the wire's own tolerance
}


@pytest.fixture(params=[pytest.param(name, marks=[pytest.mark.long] if name in LONG else []) for name in RIGS])
def moving(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Rig]:
    make, set_it_going = RIGS[request.param]
    with make(tmp_path) as rig:
        rig.run_until(150 * MS)
        set_it_going(rig)
        yield rig


def values(rig: Rig) -> dict[str, Value]:
    return {
        f"{device}/{key}": rig.get(device, key)
        for device in rig.config.devices
        for key in rig.keys(device)
        if key not in APART
    }


def stir(rig: Rig) -> None:
    """Give every device an event at the present instant, with all that its wires carry, as it was published last."""
    for model in rig._models.values():
        if isinstance(model, WiresModel):
            for driver, signal in list(model._present.values()):
                model.submit(rig.now_ns, driver, signal)
    rig.run_until(rig.now_ns)
    for device in rig.config.devices:
        with rig._present(device):
            pass


def differences(first: dict[str, Value], other: dict[str, Value]) -> dict[str, tuple[Value, Value]]:
    assert first.keys() == other.keys()
    return {key: (value, other[key]) for key, value in first.items() if not is_same(value, other[key])}


def is_same(first: Value, other: Value) -> bool:
    if isinstance(first, float) and isinstance(other, float):
        return first == pytest.approx(other, rel=1e-9, abs=1e-9)
    return first == other


def test_every_kind_of_device_is_in_the_law() -> None:
    kinds = {entry.name for entry in entry_points(group="fieldrig.devices")}
    assert kinds == {device["kind"] for device in DEVICES.values()}


@pytest.mark.long
def test_what_is_read_without_an_event_is_what_an_event_would_show(moving: Rig) -> None:
    for pause_ns in (61_300 * US, 333 * US, 2_250 * US, 17_777 * US, 1_900 * US):
        moving.run_until(moving.now_ns + pause_ns)
        shown = values(moving)
        stir(moving)
        assert not differences(shown, values(moving)), f"at {moving.now_ns} ns"


@pytest.mark.parametrize("name", ["every kind", "arp-cell-virtual.yaml", "lab-virtual.yaml"])
@pytest.mark.long
def test_a_rig_that_is_read_gives_the_same_trace(name: str, tmp_path: Path) -> None:
    make, set_it_going = RIGS[name]

    def trace(pauses_ns: list[int]) -> tuple[list[tuple[int, str, str, bytes]], dict[str, Value]]:
        lines: list[tuple[int, str, str, bytes]] = []

        def on_delivery(bus: Bus[Any], delivery: Delivery[Any]) -> None:
            lines.append((delivery.time_ns, bus.name, delivery.sender, bus.encode(delivery.message)))

        with make(tmp_path) as rig:
            rig.on_delivery = on_delivery
            rig.run_until(150 * MS)
            set_it_going(rig)
            for pause_ns in pauses_ns:
                rig.run_until(rig.now_ns + pause_ns)
                values(rig)
            rig.run_until(400 * MS)
            return lines, values(rig)

    undisturbed = trace([])
    assert len(undisturbed[0]) > 10
    assert trace([1_370 * US] * 100) == undisturbed


# ---- closed solutions


@pytest.mark.long
@pytest.mark.parametrize("processes", ["one", pytest.param("each", marks=pytest.mark.system)])
def test_card_and_motor_show_a_steady_torque_as_it_has_moved_them(tmp_path: Path, processes: str) -> None:
    data = whole(tmp_path, "motor", "card") | {"processes": processes}
    with Rig(from_dict(data)) as rig:
        rig.run_until(10 * MS)
        rig.set("motor", "load_torque", PULL_NM)
        rig.run_until(510 * MS)
        angle, speed = PULLED / 2 * 0.5**2, PULLED * 0.5
        assert rig.get("motor", "position") == pytest.approx(angle)
        assert rig.get("motor", "speed") == pytest.approx(speed)
        assert rig.get("motor", "encoder") == rig.get("card", "encoder1") == floor(angle * 4000 / tau)
        rig.run_until(510 * MS + 700 * US)  # between two loops of the card
        angle = PULLED / 2 * 0.5007**2
        assert rig.get("card", "encoder1") == floor(angle * 4000 / tau)


def pulled_counts(seconds: float) -> float:
    return PULLED / 2 * seconds**2 * 4000 / tau


def test_object_tied_to_a_moving_wire_is_read_as_it_is_now(tmp_path: Path) -> None:
    """Read it by SDO, by a point, and in a TPDO that a SYNC triggers."""
    data = whole(tmp_path, "motor", "sensor")
    data["devices"]["sensor"]["objects"] = {"1800:02": 1}
    with Rig(from_dict(data)) as rig:
        master, frames = rig.attach("master"), list[CanFrame]()
        can = master.link("can1")
        can.on_receive(frames.append)
        rig.run_until(10 * MS)
        can.send(CanFrame(0x000, bytes.fromhex("01 06")))
        rig.run_until(10 * MS)
        rig.set("motor", "load_torque", PULL_NM)
        rig.run_until(410 * MS + 300 * US)
        assert rig.get("sensor", "6130:01") == pytest.approx(pulled_counts(0.4003), rel=1e-6)
        can.send(CanFrame(0x606, bytes.fromhex("40 30 61 01 00 00 00 00")))
        rig.run_until(411 * MS)
        answer = next(frame for frame in frames if frame.identifier == 0x586)
        arrived_s = 0.4003 + 0.000_222  # 111 bits at 500 kbit/s at most
        assert real_of(answer.data[4:]) == pytest.approx(pulled_counts(arrived_s), rel=1e-3)
        assert real_of(answer.data[4:]) > pulled_counts(0.4003)


def real_of(data: bytes) -> float:
    (value,) = struct.unpack("<f", data)
    return float(value)


def test_register_that_shows_a_moving_wire_is_read_as_it_is_now(tmp_path: Path) -> None:
    with Rig(from_dict(whole(tmp_path, "motor", "tank", "panel"))) as rig:
        client, answers = rig.attach("client"), list[ModbusRequest | ModbusResponse]()
        modbus = client.link("modbus")
        modbus.on_receive(answers.append)
        rig.run_until(10 * MS)
        rig.set("motor", "load_torque", PULL_NM)
        rig.run_until(410 * MS)
        assert rig.get("panel", "position") == round(pulled_counts(0.4))
        modbus.send(ModbusRequest(1, bytes.fromhex("04 0000 0002"), 1))
        rig.run_until(411 * MS)
        (answer,) = answers
        assert answer.pdu[:2] == bytes.fromhex("04 04")
        assert int.from_bytes(answer.pdu[2:], "big") == round(pulled_counts(0.4))


@pytest.mark.long
def test_encoder_parameter_of_a_controller_is_read_as_it_is_now(tmp_path: Path) -> None:
    with Rig(from_dict(whole(tmp_path, "motor", "max4", "belt"))) as rig:
        rig.run_until(3_000 * MS)
        rig.set("motor", "load_torque", PULL_NM)
        rig.run_until(3_401 * MS + 100 * US)  # between two cycles of its real-time process
        assert rig.get("max4", "line.Position") == pytest.approx(pulled_counts(0.4011), rel=1e-6)
        assert rig.get("max4", "line.Velocity") == pytest.approx(PULLED * 0.4011 * 4000 / tau, rel=1e-6)
