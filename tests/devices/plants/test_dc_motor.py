"""A small DC motor on its wires: run-up and coasting by the laws of constant acceleration, pulses, stops and faults."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from fieldrig.clock import MS, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.wires import Signal
from fieldrig_devices.plants.dc_motor import DcMotorPlant, DcMotorSettings


class Bench:
    def __init__(self, **settings: Any) -> None:
        self.clock, self.wires = VirtualClock(), RecordedLink[Signal]()
        data = DcMotorSettings(increase_wire="inc", decrease_wire="dec", **settings)
        self.motor = DcMotorPlant(self.clock, "m", data, self.wires)
        self.motor.start()

    def contact(self, wire: str, on: bool, time_ms: float = 0) -> None:
        self.wires.deliver(Signal(wire, on))
        self.clock.advance_to(self.clock.now_ns() + round(time_ms * MS))

    def get(self, key: str) -> Any:
        return self.motor.points()[key].read()

    def rises(self) -> int:
        """Rising edges of the pulses since the last call."""
        return sum(signal.name == "m.pulse" and bool(signal.value) for signal in self.wires.take())


def test_the_motor_runs_up_in_50_ms_and_coasts_to_rest_in_40() -> None:
    bench = Bench(initial_position=0.25)
    bench.wires.take()
    bench.contact("inc", True, 25)
    assert bench.get("speed") == pytest.approx(50)
    assert bench.get("position") == pytest.approx(0.25 + 0.625)
    bench.contact("inc", True, 75)
    assert bench.get("position") == pytest.approx(0.25 + 2.5 + 5)
    bench.contact("inc", False, 20)
    assert bench.get("speed") == pytest.approx(50)
    bench.contact("inc", False, 100)
    assert (bench.get("speed"), bench.get("position")) == (0, pytest.approx(0.25 + 2.5 + 5 + 2))
    assert bench.rises() == 9
    assert bench.clock.next_ns() is None, "a motor at rest costs nothing"


def test_both_contacts_are_as_none() -> None:
    bench = Bench()
    bench.contact("inc", True)
    bench.contact("dec", True, 500)
    assert (bench.get("direction"), bench.get("speed")) == (0, 0)


def test_the_zero_switch_is_closed_between_its_ends() -> None:
    bench = Bench(initial_position=5.25, zero_from=-2.0, zero_to=0.0)
    seen = []
    bench.contact("dec", True)
    for _ in range(12):
        bench.clock.advance_to(bench.clock.now_ns() + 10 * MS)
        seen.append(bench.get("zero"))
    edges = [signal.value for signal in bench.wires.take() if signal.name == "m.zero"]
    assert edges == [False, True, False]
    assert True in seen


def test_a_mechanical_stop_ends_the_motion_until_the_motor_turns_back() -> None:
    bench = Bench(initial_position=0.25, low_stop=-3.0)
    bench.contact("dec", True, 500)
    assert (bench.get("speed"), bench.get("position")) == (0, -3)
    bench.contact("dec", False, 100)
    bench.contact("dec", True, 100)
    assert bench.get("position") == -3
    bench.contact("dec", False)
    bench.contact("inc", True, 100)
    assert bench.get("position") == pytest.approx(-3 + 2.5 + 5)


def test_a_blocked_motor_stands_and_goes_on_when_it_is_free() -> None:
    bench = Bench()
    bench.contact("inc", True, 100)
    number = bench.motor.add_fault({"what": "blocked"})
    before = bench.get("position")
    bench.contact("inc", True, 200)
    assert bench.get("position") == before
    bench.motor.clear_fault(number)
    bench.contact("inc", True, 100)
    assert bench.get("position") == pytest.approx(before + 7.5)


def test_without_pulses_the_motor_turns_and_the_sensor_stays() -> None:
    bench = Bench()
    bench.motor.add_fault({"what": "no_pulses"})
    bench.wires.take()
    bench.contact("inc", True, 500)
    assert bench.get("position") > 60
    assert bench.wires.take() == []


def test_a_welded_contact_turns_the_motor_on() -> None:
    bench = Bench()
    number = bench.motor.add_fault({"what": "welded"})
    bench.contact("inc", True, 100)
    bench.contact("inc", False, 100)
    assert bench.get("speed") == 100
    bench.motor.clear_fault(number)
    bench.contact("inc", False, 100)
    assert bench.get("speed") == 0


def test_a_motor_that_is_pushed_gives_pulses_at_rest() -> None:
    bench = Bench(initial_position=0.25)
    bench.wires.take()
    bench.motor.add_fault({"what": "pushed", "pulses_per_s": -10.0, "duration_ms": 500})
    bench.clock.advance_to(490 * MS)
    assert bench.get("position") == pytest.approx(0.25 - 4.9)
    bench.clock.advance_to(1_000 * MS)
    assert bench.get("speed") == 0


@pytest.mark.parametrize(
    "settings",
    [{"low_stop": 30.0}, {"low_stop": 1.0, "high_stop": 0.0}, {"zero_from": 1.0}, {"pulses_per_s": 0.0}],
)
def test_settings_that_can_not_be_are_refused(settings: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        DcMotorSettings.model_validate({"increase_wire": "a", "decrease_wire": "b", **settings})


@given(
    st.lists(st.tuples(st.sampled_from(["inc", "dec"]), st.booleans(), st.integers(0, 200)), max_size=15),
    st.sampled_from([0.0, 50.0]),
)
def test_edges_and_position_agree_for_any_contacts(steps: list[tuple[str, bool, int]], ramp_ms: float) -> None:
    bench = Bench(initial_position=0.25, low_stop=-10.0, high_stop=10.0, run_up_ms=ramp_ms, coast_ms=ramp_ms)
    before = bench.get("position")
    for wire, on, time_ms in steps:
        bench.contact(wire, on, time_ms)
        now = bench.get("position")
        assert -10 <= now <= 10
        assert abs(now - before) <= 0.1001 * time_ms, "100 pulses per second at most"
        level = bench.get("pulse")
        assert level is (now % 1 < 0.5) or min(now % 0.5, 0.5 - now % 0.5) < 1e-6
        before = now


def test_pulses_as_segments_say_when_they_rose_and_how_many_there_were() -> None:
    bench = Bench(output="segments", initial_position=0.25, low_stop=-10.0)
    (first,) = [signal for signal in bench.wires.take() if signal.name == "m.pulse"]
    assert isinstance(first, PulseTrain)
    assert (first.sent, first.count) == (0, 0)
    bench.contact("inc", True, 100)  # 2.5 pulses on the ramp, and 5 behind it
    bench.contact("inc", False, 100)  # 2 pulses
    pulses = [signal for signal in bench.wires.take() if isinstance(signal, PulseTrain)]
    assert [pulse.sent for pulse in pulses] == list(range(9))
    assert {(pulse.frequency, pulse.count, pulse.direction) for pulse in pulses} == {(100, 1, 1)}
    instants = [pulse.start_ns for pulse in pulses]
    assert instants[3] - instants[2] == pytest.approx(10 * MS, abs=1)
    bench.contact("dec", True, 400)
    pulses = [signal for signal in bench.wires.take() if isinstance(signal, PulseTrain)]
    assert {pulse.direction for pulse in pulses} == {-1}
    assert pulses[-1].at(bench.clock.now_ns()) == pytest.approx(bench.get("position"), abs=1)
