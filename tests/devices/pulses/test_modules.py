"""The pulse generator and the counter module as devices of a rig, by segments and by edges, alone and in processes."""

from typing import Any

import pytest
from pydantic import ValidationError

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict
from fieldrig.errors import ControlError
from fieldrig.virtual.rig import Rig
from fieldrig_bus.wires import Signal
from fieldrig_devices.pulses.counter_device import CounterSettings
from fieldrig_devices.pulses.generator import GeneratorSettings

LINKS = {"links": {"wires": "wires"}}
STEPPER = {
    "kind": "plant.stepper", "pulse_wire": "source.pulse", "direction_wire": "source.direction", "start_hz": 2_000.0,
    "pull_out": [(0.0, 2.0), (100.0, 1.0)], "motor_inertia_kg_m2": 0.0001, **LINKS,
}  # fmt: skip


def devices(output: str) -> dict[str, Any]:
    source = {"kind": "pulse.generator", "output": output, "direction_wire": "source.direction", **LINKS}
    counter = {
        "kind": "pulse.counter", "a_wire": "source.pulse", "b_wire": "source.direction", "compare": 25,
        "reset_wire": "panel.reset", **LINKS,
    }  # fmt: skip
    pwm = {"kind": "pulse.generator", "waveform": "pwm", "frequency": 100.0, "output": output, **LINKS}
    heater = {
        "kind": "plant.heater", "power_wire": "pwm.pwm", "power_w": 200.0, "heat_capacity_j_per_k": 10.0,
        "resistance_k_per_w": 1.0, **LINKS,
    }  # fmt: skip
    return {"source": source, "counter": counter, "axis": STEPPER, "pwm": pwm, "oven": heater}


def rig(output: str = "segments", **more: Any) -> Rig:
    wires = {"wires": {"kind": "wires.virtual"}}
    return Rig(from_dict({"time": "virtual", "seed": 1, "buses": wires, "devices": devices(output), **more}))


@pytest.mark.parametrize("output", ["segments", "edges"])
def test_generator_counter_and_stepper_agree(output: str) -> None:
    with rig(output) as bench:
        bench.run_until(10 * MS)
        bench.set("source", "count", 40)
        bench.set("source", "run", True)
        bench.run_until(10 * MS + 23_999_999)
        assert bench.get("counter", "value") == bench.get("source", "position") == 24
        assert bench.get("counter", "reached") is False
        bench.run_until(34 * MS)
        assert bench.get("counter", "reached") is True
        bench.run_until(100 * MS)
        assert bench.get("source", "run") is False
        bench.set("source", "direction", -1)
        bench.set("source", "count", 10)
        bench.set("source", "run", True)
        bench.run_until(200 * MS)
        assert bench.get("source", "sent") == 50
        assert bench.get("counter", "value") == bench.get("axis", "steps") == bench.get("source", "position") == 30
        assert bench.get("axis", "lost") == bench.get("axis", "missed") == 0


@pytest.mark.parametrize("output", ["segments", "edges"])
def test_pwm_heats(output: str) -> None:
    with rig(output) as bench:
        bench.set("pwm", "run", True)
        bench.set("pwm", "duty", 25)
        bench.run_until(100 * S if output == "segments" else 5 * S)
        if output == "segments":
            assert bench.get("oven", "temperature") == pytest.approx(70, abs=0.02)
        else:  # a mean of 25 %, with the ripple of the period of 10 ms
            assert bench.get("oven", "temperature") == pytest.approx(70 - 50 * 0.60653, abs=0.2)


def test_the_preset_is_loaded_by_an_input_and_by_a_point() -> None:
    with rig() as bench:
        panel = bench.attach("panel").link("wires")
        bench.set("source", "count", 40)
        bench.set("source", "run", True)
        bench.run_until(10_500_000)
        assert bench.get("counter", "value") == 11
        panel.send(Signal("panel.reset", True))
        bench.run_until(20_500_000)
        assert bench.get("counter", "value") == 10
        bench.set("counter", "value", -5)
        bench.run_until(30_500_000)
        assert bench.get("counter", "value") == 5


def test_wrong_values_of_points_are_refused() -> None:
    with rig() as bench:
        wrong: list[tuple[str, str, Any]] = [
            ("source", "frequency", 0), ("source", "direction", 0), ("source", "count", -1), ("pwm", "duty", 101),
            ("source", "rate", 1e13),
        ]  # fmt: skip
        for device, key, value in wrong:
            with pytest.raises(ControlError, match="expected"):
                bench.set(device, key, value)
        bench.set("source", "rate", -1_000_000)
        bench.set("source", "count", 100)
        with pytest.raises(ControlError, match="the frequency is zero before the last pulse begins"):
            bench.set("source", "run", True)


def trace(processes: str) -> list[tuple[int, str, bytes]]:
    """Everything on the wires while pulses and PWM go."""
    lines: list[tuple[int, str, bytes]] = []

    def on_delivery(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        lines.append((delivery.time_ns, delivery.sender, bus.encode(delivery.message)))

    with rig(processes=processes) as bench:
        bench.on_delivery(on_delivery)
        bench.set("pwm", "run", True)
        for count, direction in ((30, 1), (12, -1), (0, 1)):
            bench.set("source", "count", count)
            bench.set("source", "direction", direction)
            bench.set("source", "run", True)
            bench.run_until(bench.now_ns + 33_333_333)
        bench.set("source", "run", False)
        bench.run_until(200 * MS)
        assert bench.get("counter", "value") == bench.get("axis", "steps") == bench.get("source", "position")
    return lines


@pytest.mark.system
def test_one_process_and_many_give_the_same_trace() -> None:
    assert trace("one") == trace("each")


@pytest.mark.parametrize(
    ("model", "wrong"),
    [
        (GeneratorSettings, {"frequency": 0}), (GeneratorSettings, {"frequency": 1e8}),
        (GeneratorSettings, {"duty": 101}), (GeneratorSettings, {"waveform": "sine"}),
        (CounterSettings, {}), (CounterSettings, {"a_wire": "x", "mode": "up_down"}),
        (CounterSettings, {"a_wire": "x", "b_wire": "x"}), (CounterSettings, {"a_wire": "x", "multiplication": 3}),
        (CounterSettings, {"a_wire": "x", "mode": "incremental", "compare": 5}),
    ],
)  # fmt: skip
def test_settings_that_do_not_fit_are_refused(model: Any, wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        model(**wrong)
