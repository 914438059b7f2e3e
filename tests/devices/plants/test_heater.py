"""A heater on its wires: the exponential of a heat capacity with a thermal resistance, its switch, faults, settings."""

from math import exp, log
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from fieldrig.clock import S, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.plants.heater import Heater, HeaterSettings

BODY: dict[str, Any] = {"power_w": 200.0, "heat_capacity_j_per_k": 100.0, "resistance_k_per_w": 1.0}
"""At 100 % it ends at 220 degC, with a time constant of 100 s."""


class Bench:
    """A heater, its wires, and the hands of a clock."""

    def __init__(self, **settings: Any) -> None:
        self.clock = VirtualClock()
        self.wires = RecordedLink[Signal]()
        self.plant = Heater(self.clock, "oven", HeaterSettings(**{**BODY, **settings}), self.wires)
        self.plant.start()

    def power(self, signal: Signal) -> None:
        self.wires.deliver(signal)

    def wait(self, seconds: float) -> None:
        self.clock.advance_to(self.clock.now_ns() + round(seconds * S))

    def point(self, key: str) -> Any:
        return self.plant.points()[key].read()


@pytest.mark.parametrize(
    ("signal", "final"),
    [
        (Pwm("oven.power", 50, frequency=10), 120.0), (Signal("oven.power", 25.0, "%"), 70.0),
        (Signal("oven.power", True), 220.0), (Signal("oven.power", 400), 220.0), (Signal("oven.power", -5), 20.0),
    ],
)  # fmt: skip
def test_the_temperature_is_the_exponential(signal: Signal, final: float) -> None:
    bench = Bench()
    bench.power(signal)
    bench.wait(150)
    assert bench.point("temperature") == pytest.approx(final + (20 - final) * exp(-1.5))
    bench.wait(10_000)
    assert bench.point("temperature") == pytest.approx(final, abs=0.01)


def test_the_published_line_is_within_its_tolerance() -> None:
    bench = Bench(tolerance_k=0.1)
    bench.power(Pwm("oven.power", 80, frequency=10))
    for _ in range(200):
        bench.wait(3.7)
        motion = next(signal for signal in reversed(bench.wires.sent) if isinstance(signal, Motion))
        assert abs(motion.at(bench.clock.now_ns()) - bench.point("temperature")) <= 0.1001
    assert len(bench.wires.sent) < 200


def test_a_steady_heater_needs_no_work() -> None:
    bench = Bench()
    bench.power(Signal("oven.power", True))
    bench.wait(3_000)
    assert bench.clock.next_ns() is None


def test_the_switch_closes_and_opens_at_the_instant_of_its_limit() -> None:
    bench = Bench(limit_degc=120.0)
    bench.power(Signal("oven.power", True))
    instant_ns = 100 * log(2) * S
    bench.clock.advance_to(round(instant_ns) - 1_000)
    assert bench.point("over") is False
    bench.clock.advance_to(round(instant_ns) + 1_000)
    assert bench.point("over") is True
    assert [signal.value for signal in bench.wires.sent if signal.name == "oven.over"] == [False, True]


def test_heat_that_is_taken_away_cools_the_body() -> None:
    bench = Bench()
    bench.power(Signal("oven.power", 50))
    bench.wires.deliver(Signal("oven.load", 60.0, "W"))
    bench.wait(5_000)
    assert bench.point("temperature") == pytest.approx(60.0, abs=0.01)


@pytest.mark.parametrize(("what", "final"), [("broken", 20.0), ("stuck", 220.0)])
def test_faults(what: str, final: float) -> None:
    bench = Bench()
    bench.power(Signal("oven.power", 50))
    number = bench.plant.add_fault({"what": what})
    bench.wait(5_000)
    assert bench.point("temperature") == pytest.approx(final, abs=0.01)
    bench.plant.clear_fault(number)
    bench.wait(5_000)
    assert bench.point("temperature") == pytest.approx(120.0, abs=0.01)


@given(st.lists(st.tuples(st.floats(0, 100), st.floats(0.001, 500)), max_size=10))
def test_the_temperature_stays_within_what_its_power_allows(steps: list[tuple[float, float]]) -> None:
    bench = Bench(limit_degc=100.0, tolerance_k=1.0)
    for duty, seconds in steps:
        bench.power(Pwm("oven.power", duty, start_ns=bench.clock.now_ns(), frequency=100))
        bench.wait(seconds)
        assert 20.0 - 1e-9 <= bench.point("temperature") <= 220.0 + 1e-9


@pytest.mark.parametrize(
    "wrong",
    [{"power_w": 0}, {"heat_capacity_j_per_k": -1}, {"resistance_k_per_w": 1e9}, {"ambient_degc": -300.0},
     {"tolerance_k": 0}],
)  # fmt: skip
def test_settings_that_do_not_fit_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        HeaterSettings(**{**BODY, **wrong})
