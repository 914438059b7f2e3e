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
from every_kind import DEVICES, PULL_NM, PULLED, whole
from shipped import RIGS as SHIPPED
from shipped import in_virtual_time

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, US
from fieldrig.config.rig_file import from_dict
from fieldrig.device import Value
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_bus.wires import WiresModel


def set_going(rig: Rig) -> None:
    """Everything that a person could move by its points."""
    rig.set("motor", "load_torque", PULL_NM)
    rig.set("rolling", "load_torque", -1.5)
    rig.set("drive", "load_torque", -0.5)
    rig.set("smart", "led1.blink", True)
    for pin, value in (("Velocity", 10_000), ("Acceleration", 500), ("Deceleration", 500), ("Execute", True)):
        rig.set("scu", f"MoveVelocity.{pin}", value)


def shipped(name: str) -> Callable[[Path], Rig]:
    return lambda folder: Rig(in_virtual_time(name))


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
    **{file: (shipped(file), press_everything) for file in SHIPPED},
}
LONG = {"packaging-line.yaml"}
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
    for model in rig._engine.models.values():
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


@pytest.mark.parametrize("name", ["every kind", "arp-cell.yaml", "lab.yaml"])
@pytest.mark.long
def test_a_rig_that_is_read_gives_the_same_trace(name: str, tmp_path: Path) -> None:
    make, set_it_going = RIGS[name]

    def trace(pauses_ns: list[int]) -> tuple[list[tuple[int, str, str, bytes]], dict[str, Value]]:
        lines: list[tuple[int, str, str, bytes]] = []

        def on_delivery(bus: Bus[Any], delivery: Delivery[Any]) -> None:
            lines.append((delivery.time_ns, bus.name, delivery.sender, bus.encode(delivery.message)))

        with make(tmp_path) as rig:
            rig.on_delivery(on_delivery)
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
