"""Receivers of pulses and PWM take whatever a wire may carry: nothing raises, and all of their points can be read."""

from collections.abc import Callable
from fractions import Fraction
from math import isfinite
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import S, VirtualClock
from fieldrig.device import Device
from fieldrig.testing import RecordedLink
from fieldrig_bus.signals.codec import check_sent
from fieldrig_bus.signals.pulse_train import FASTEST_HZ, STEEPEST_HZ_PER_S, PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.plants.heater import Heater, HeaterSettings
from fieldrig_devices.plants.pulse_servo import PulseServo, PulseServoSettings
from fieldrig_devices.plants.stepper import Stepper
from fieldrig_devices.plants.stepper_settings import StepperSettings
from fieldrig_devices.pulses.counter_device import CounterModule, CounterSettings

WIRE = "in"
STEPPER: dict[str, Any] = {"pulse_wire": WIRE, "pull_out": [(0.0, 1.0), (10.0, 0.1)], "motor_inertia_kg_m2": 0.001}
HEATER: dict[str, Any] = {
    "power_wire": WIRE,
    "power_w": 9.0,
    "heat_capacity_j_per_k": 9.0,
    "resistance_k_per_w": 9.0,
    "limit_degc": 50,
}
DEVICES: dict[str, Callable[[VirtualClock, RecordedLink[Signal]], Device]] = {
    "stepper": lambda clock, wires: Stepper(clock, "x", StepperSettings(**STEPPER), wires),
    "blind stepper": lambda clock, wires: Stepper(
        clock, "x", StepperSettings(**STEPPER, detects_loss=False, direction_wire="direction"), wires
    ),
    "servo": lambda clock, wires: PulseServo(clock, "x", PulseServoSettings(pulse_wire=WIRE), wires),
    "counter": lambda clock, wires: CounterModule(clock, "x", CounterSettings(a_wire=WIRE, compare=9), wires),
    "encoder": lambda clock, wires: CounterModule(clock, "x", CounterSettings(a_wire=WIRE, mode="incremental"), wires),
    "heater": lambda clock, wires: Heater(clock, "x", HeaterSettings(**HEATER), wires),
}

WIDEST = (1 << 63) - 1
INSTANTS = st.integers(-S, 10 * S) | st.sampled_from((-WIDEST, WIDEST))
HZ = st.sampled_from((Fraction(1, WIDEST), FASTEST_HZ, 1_000)) | st.integers(1, FASTEST_HZ)
RATES = st.sampled_from((0, 0, Fraction(1, WIDEST), STEEPEST_HZ_PER_S, -STEEPEST_HZ_PER_S)) | st.integers(
    -(10**6), 10**6
)
TRAINS = st.builds(
    PulseTrain,
    st.just(WIRE),
    st.sampled_from((0, 2, -2)),
    start_ns=INSTANTS,
    frequency=HZ,
    rate=RATES,
    count=st.none() | st.integers(0, 1_000) | st.just(WIDEST),
    direction=st.sampled_from((1, -1)),
    phase=st.sampled_from((0, Fraction(1, 3), Fraction(WIDEST - 1, WIDEST))),
    sent=st.sampled_from((2, 1_000, WIDEST - 1)),
    epoch_ns=st.sampled_from((0, 5)),
)
SIGNALS = st.one_of(
    TRAINS,
    st.builds(Pwm, st.just(WIRE), st.integers(0, 100), start_ns=INSTANTS, frequency=HZ),
    st.builds(Signal, st.just(WIRE), st.booleans() | st.integers(-9, 9) | st.floats(allow_nan=False)),
    st.builds(Motion, st.just(WIRE), st.floats(-1e9, 1e9), time_ns=st.just(0), speed=st.floats(-1e9, 1e9)),
)


def can_be_sent(signal: Signal) -> bool:
    try:
        check_sent(signal)
    except ValueError:
        return False
    return True


@pytest.mark.long
@pytest.mark.parametrize("kind", DEVICES)
@settings(max_examples=40)
@given(steps=st.lists(st.tuples(SIGNALS.filter(can_be_sent), st.integers(0, 10**8)), max_size=8))
def test_anything_on_the_wire(kind: str, steps: list[tuple[Signal, int]]) -> None:
    clock, wires = VirtualClock(), RecordedLink[Signal]()
    device = DEVICES[kind](clock, wires)
    device.start()
    for signal, after_ns in steps:
        wires.deliver(signal)
        first = {key: point.read() for key, point in device.points().items()}
        assert {key: point.read() for key, point in device.points().items()} == first
        assert all(isfinite(value) for value in first.values() if isinstance(value, float))
        events, until_ns = 0, clock.now_ns() + after_ns
        while (next_ns := clock.next_ns()) is not None and next_ns <= until_ns:
            clock.advance_to(next_ns)
            events += 1
            assert events < 3_000
        clock.advance_to(until_ns)
    for signal in wires.sent:
        check_sent(signal)
