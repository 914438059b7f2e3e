"""A servo drive with a pulse input: its lag by the law of the position loop, its end, alarm and contacts."""

from math import exp, pi, tau
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.device import Value
from fieldrig.testing import RecordedLink
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.plants.following_model import Following
from fieldrig_devices.plants.pulse_servo import PulseServo, PulseServoSettings
from fieldrig_devices.pulses.output import PulseOutput

DRIVE: dict[str, Any] = {"pulse_wire": "pto.pulse", "pulses_per_turn": 1_000, "gain_per_s": 100.0}


class Bench:
    """A pulse output wired to a drive, and the hands of their clock."""

    def __init__(self, **settings: Any) -> None:
        self.clock = VirtualClock()
        self.wires = RecordedLink[Signal]()
        self.plant = PulseServo(self.clock, "axis", PulseServoSettings(**{**DRIVE, **settings}), self.wires)
        self.plant.start()
        self.output = PulseOutput(self.clock, self, "pto.pulse")
        self.output.start()

    def send(self, signal: Signal) -> None:
        self.wires.deliver(signal)

    def on_receive(self, handler: Any, interest: Any = None) -> None:
        """Nothing is received by the output."""

    def drive(self, wire: str, value: float) -> None:
        self.wires.deliver(Signal(wire, value))

    def wait(self, seconds: float) -> None:
        self.clock.advance_to(self.clock.now_ns() + round(seconds * S))

    def point(self, key: str) -> Any:
        return self.plant.points()[key].read()

    def write(self, key: str, value: Value) -> None:
        write = self.plant.points()[key].write
        assert write is not None
        write(value)

    def last(self, wire: str) -> Signal:
        return [signal for signal in self.wires.sent if signal.name == wire][-1]


def test_the_lag_is_the_speed_over_the_gain() -> None:
    bench = Bench()
    bench.output.send(20_000, count=None)
    bench.wait(0.03)
    assert bench.point("error") == pytest.approx(200 * (1 - exp(-3)))
    bench.wait(1)
    assert bench.point("error") == pytest.approx(200)
    assert bench.point("speed") == pytest.approx(20 * tau)
    assert bench.point("in_position") is False


def test_the_lag_of_a_ramp() -> None:
    bench = Bench()
    rate = 50_000
    bench.output.send(0, rate, 50_000)
    bench.wait(0.8)
    assert bench.point("error") == pytest.approx(rate * 0.8 / 100 - rate / 100**2)


def test_the_motor_arrives_at_the_last_pulse() -> None:
    bench = Bench(gear_ratio=2.0)
    bench.output.send(10_000, count=2_500)
    bench.wait(2)
    assert bench.point("position") == pytest.approx(2.5 * pi)
    assert bench.last("axis.position").value == pytest.approx(2.5 * pi)
    assert (bench.point("in_position"), bench.last("axis.in_position").value) == (True, True)
    bench.output.send(10_000, count=2_500, direction=-1)
    bench.wait(2)
    assert bench.point("position") == pytest.approx(0, abs=1e-6)
    assert bench.clock.next_ns() is None


def test_the_highest_speed_makes_the_error_grow() -> None:
    bench = Bench(highest_turns_per_s=10.0)
    bench.output.send(15_000, count=15_000)
    bench.wait(0.9)
    assert bench.point("speed") == pytest.approx(10 * tau)
    assert bench.point("error") == pytest.approx(100 * 0.5 + 5_000 * 0.9, rel=0.02)
    bench.wait(3)
    assert bench.point("position") == pytest.approx(15 * tau)


def test_an_error_that_is_too_large_is_an_alarm() -> None:
    bench = Bench(highest_turns_per_s=10.0, largest_error_pulses=1_000.0)
    bench.output.send(15_000, count=15_000)
    bench.wait(2)
    assert (bench.point("alarm"), bench.last("axis.ready").value) == (True, False)
    place = bench.point("position") / tau * 1_000
    assert place < 15_000
    assert bench.point("lost") == pytest.approx(15_000 - place)
    bench.drive("axis.reset", True)
    bench.output.send(5_000, count=500)
    bench.wait(1)
    assert bench.point("alarm") is False
    assert bench.point("position") / tau * 1_000 == pytest.approx(place + 500)


def test_a_jammed_motor_gives_an_alarm_by_its_following_error() -> None:
    bench = Bench(largest_error_pulses=500.0)
    bench.plant.add_fault({"what": "jam"})
    bench.output.send(1_000, count=None)
    bench.wait(0.499)
    assert bench.point("alarm") is False
    bench.wait(0.003)
    assert bench.point("alarm") is True
    assert bench.point("position") == 0


def test_a_person_at_the_bench_clears_the_alarm_of_a_fault() -> None:
    bench = Bench()
    number = bench.plant.add_fault({"what": "trip"})
    bench.plant.clear_fault(number)
    assert (bench.point("alarm"), bench.point("ready"), bench.point("reset")) == (True, False, False)
    bench.write("reset", True)
    assert (bench.point("alarm"), bench.point("reset")) == (False, True)
    assert (bench.last("axis.ready").value, bench.last("axis.alarm").value) == (True, False)
    bench.plant.clear_fault(bench.plant.add_fault({"what": "trip"}))
    bench.write("reset", True)
    assert bench.point("alarm") is True, "only a rising edge clears it"
    bench.write("reset", False)
    bench.write("reset", True)
    bench.output.send(1_000, count=100)
    bench.wait(1)
    assert bench.point("position") == pytest.approx(0.1 * tau)
    with pytest.raises(ValueError, match="expected"):
        bench.write("reset", "often")


def test_a_drive_without_enable_does_not_move() -> None:
    bench = Bench(enable_wire="axis.enable")
    bench.output.send(1_000, count=300)
    bench.wait(1)
    assert (bench.point("position"), bench.point("lost"), bench.point("ready")) == (0, 300, False)
    bench.drive("axis.enable", True)
    bench.output.send(1_000, count=100)
    bench.wait(1)
    assert bench.point("position") == pytest.approx(0.1 * tau)


@pytest.mark.long
def test_the_published_motion_is_within_its_tolerance() -> None:
    bench = Bench(tolerance_pulses=0.1, highest_turns_per_s=12.0)
    bench.output.send(0, 100_000, 2_000)
    for _ in range(400):
        bench.wait(0.001)
        motion = bench.last("axis.position")
        assert isinstance(motion, Motion)
        off = abs(motion.at(bench.clock.now_ns()) - bench.point("position")) / tau * 1_000
        assert off <= 0.1001


@pytest.mark.long
@given(
    st.lists(
        st.tuples(st.integers(1, 60_000), st.integers(0, 5_000), st.sampled_from((1, -1)), st.integers(0, 300 * MS)),
        max_size=6,
    )
)
def test_the_motor_is_where_the_pulses_say_when_it_stands(moves: list[tuple[int, int, int, int]]) -> None:
    bench = Bench(highest_turns_per_s=20.0, largest_error_pulses=1e9)
    for frequency, count, direction, pause_ns in moves:
        bench.output.send(frequency, count=count, direction=direction)
        bench.wait(pause_ns / S)
    bench.output.send()
    bench.wait(30)
    assert bench.point("position") / tau * 1_000 == pytest.approx(bench.output.train.value, abs=1e-5)
    assert bench.point("received") == bench.point("sent") == bench.output.train.sent


@given(
    st.floats(-1_000, 1_000), st.floats(-50_000, 50_000), st.floats(-1e6, 1e6), st.floats(0, 0.2),
    st.floats(1, 50_000),
)  # fmt: skip
def test_the_error_solves_the_equation_of_the_loop(
    error: float, speed: float, acceleration: float, seconds: float, highest: float
) -> None:
    """The derivative by differences: what the command adds less what the motor turns, until the limit changes."""
    loop = Following(error, speed, acceleration, 100.0, highest)
    if loop.seconds_to_change(seconds + 1e-5) < seconds + 1e-5:
        return
    slope = (loop.error_at(seconds + 1e-6) - loop.error_at(seconds)) / 1e-6
    expected = speed + acceleration * seconds - loop.motion_at(seconds)[0]
    assert slope == pytest.approx(expected, rel=1e-3, abs=20 + abs(acceleration) * 1e-4)


@pytest.mark.parametrize("wrong", [{"pulses_per_turn": 0}, {"gain_per_s": 0}, {"window_pulses": -1}, {"pulse_wire": 5}])
def test_settings_that_do_not_fit_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        PulseServoSettings(**{**DRIVE, **wrong})
