"""A stepper on its wires: every step by the pulses, what is lost, alarm and contacts, and settings.

The instants are from the law of the pull-out torque: needed = load + friction + inertia x acceleration.
"""

from math import pi, tau
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.device import Value
from fieldrig.testing import RecordedLink
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.plants.stepper import Stepper
from fieldrig_devices.plants.stepper_settings import StepperSettings
from fieldrig_devices.pulses.output import PulseOutput

MOTOR: dict[str, Any] = {
    "pulse_wire": "pto.pulse", "pulses_per_turn": 1_000, "start_hz": 500.0,
    "pull_out": [(0.0, 2.0), (10.0, 2.0), (30.0, 1.0)], "motor_inertia_kg_m2": 0.001,
}  # fmt: skip
"""2 N m up to 10 kHz, and 1 N m at 30 kHz, where the curve ends."""


class Bench:
    """A pulse output wired to a stepper, and the hands of their clock."""

    def __init__(self, mode: Any = "segments", **settings: Any) -> None:
        self.clock = VirtualClock()
        self.wires = RecordedLink[Signal]()
        self.has_direction = "direction_wire" in settings
        self.plant = Stepper(self.clock, "axis", StepperSettings(**{**MOTOR, **settings}), self.wires)
        self.plant.start()
        self.output = PulseOutput(self.clock, self, "pto.pulse", mode, "pto.direction")
        self.output.start()

    def send(self, signal: Signal) -> None:
        if signal.name != "pto.direction" or self.has_direction:
            self.wires.deliver(signal)

    def on_receive(self, handler: Any, interest: Any = None) -> None:
        """Nothing is received by the output."""

    def drive(self, wire: str, value: float) -> None:
        self.wires.deliver(Signal(wire, value))

    def move(self, *segments: tuple[int, int, int], direction: int = 1) -> None:
        """Send segments one after the other: frequency, rate and count."""
        for frequency, rate, count in segments:
            train = self.output.send(frequency, rate, count, direction=direction)
            assert train.end_ns is not None
            self.clock.advance_to(train.end_ns)

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


@pytest.mark.long
@pytest.mark.parametrize("mode", ["segments", "edges"])
def test_the_load_is_where_the_pulses_say(mode: str) -> None:
    bench = Bench(mode, direction_wire="pto.direction", gear_ratio=2.0)
    bench.move((400, 0, 1_500))
    bench.wait(0.1)
    bench.move((400, 0, 250), direction=-1)
    bench.wait(1)
    assert bench.point("steps") == 1_250
    assert bench.point("position") == pytest.approx(1.25 * pi)
    assert bench.point("lost") == bench.point("missed") == 0
    assert bench.last("axis.position").value == pytest.approx(1.25 * pi)
    assert bench.point("ready") is True


def test_a_trapezoid_within_the_torque_loses_nothing() -> None:
    bench = Bench()
    bench.move((0, 100_000, 500), (10_000, 0, 4_000), (10_000, -100_000, 500))
    assert (bench.point("steps"), bench.point("lost"), bench.point("alarm")) == (5_000, 0, False)


def test_the_position_is_published_as_a_motion() -> None:
    bench = Bench()
    bench.output.send(0, 100_000, 500)
    bench.clock.advance_to(50 * MS)
    motion = bench.last("axis.position")
    assert isinstance(motion, Motion)
    assert motion.acceleration == pytest.approx(100 * tau)
    assert abs(motion.at(50 * MS) - bench.point("position")) < tau / 1_000
    assert bench.point("speed") == pytest.approx(5 * tau)


def test_a_rate_beyond_the_torque_loses_every_pulse() -> None:
    bench = Bench()
    rate = 320_000  # 320 turns/s2 x tau x 0.001 kg m2 = 2.01 N m
    bench.move((0, rate, 100))
    assert (bench.point("steps"), bench.point("lost")) == (1, 99) or bench.point("lost") == 100
    assert (bench.point("alarm"), bench.point("ready"), bench.point("in_step")) == (True, False, False)


def test_a_ramp_falls_out_of_step_where_the_curve_says() -> None:
    bench = Bench(coulomb_nm=0.5, load_torque_nm=0.4)
    rate = 100_000
    needed = 0.9 + 0.001 * tau * 100  # N m
    limit_hz = 10_000 + (2 - needed) * 20_000
    bench.output.send(0, rate, 3_000)
    failed_ns = round(limit_hz / rate * S)
    bench.clock.advance_to(failed_ns - 1_000)
    assert bench.point("in_step") is True
    bench.clock.advance_to(failed_ns + 1_000)
    assert bench.point("in_step") is False
    steps = bench.point("steps")
    assert steps == pytest.approx(limit_hz**2 / 2 / rate, abs=2)
    bench.wait(1)
    assert bench.point("steps") == steps
    assert bench.point("lost") == 3_000 - steps


def test_a_load_that_grows_stalls_the_motor() -> None:
    bench = Bench()
    bench.output.send(500, count=None)
    bench.wait(1.0001)
    bench.drive("axis.load_torque", 2.1)
    assert bench.point("alarm") is True
    bench.wait(1)
    assert (bench.point("steps"), bench.point("lost")) == (501, 500)
    assert bench.point("received") == bench.point("sent") == 1_001


def test_a_jump_of_the_frequency_stalls_the_motor() -> None:
    bench = Bench()
    bench.output.send(501, count=10)
    assert bench.point("alarm") is True
    bench = Bench()
    bench.move((500, 0, 5), (1_000, 0, 5), (500, 0, 5), (400, 0, 5))
    assert bench.point("alarm") is False
    bench.move((400, 0, 5), direction=-1)
    assert bench.point("alarm") is True


@pytest.mark.long
@pytest.mark.parametrize("mode", ["segments", "edges"])
@pytest.mark.parametrize("direction", [1, -1])
def test_pulses_that_stop_or_slow_down_abruptly_stall_the_motor(mode: str, direction: int) -> None:
    """A jump down counts as a jump up does: 500 Hz here, from which a motor may stop, and not from more."""
    bench = Bench(mode, direction_wire="pto.direction")
    bench.move((500, 0, 20), direction=direction)
    bench.wait(1)
    assert (bench.point("alarm"), bench.point("lost"), bench.point("steps")) == (False, 0, 20 * direction)
    bench.move((500, 0, 5), (900, 0, 50), direction=direction)
    bench.wait(1)
    assert (bench.point("alarm"), bench.point("ready"), bench.point("in_step")) == (True, False, False)
    assert bench.point("lost") == 1_000 // 50
    assert abs(bench.point("steps")) + bench.point("lost") == bench.point("received") == 75
    bench = Bench(mode, direction_wire="pto.direction")
    bench.move((500, 0, 5), (1_000, 0, 50), (1_500, 0, 50), (900, 0, 50), direction=direction)
    bench.wait(1)
    assert bench.point("alarm") is True
    assert bench.point("lost") >= 50 - 2


@pytest.mark.parametrize("mode", ["segments", "edges"])
def test_a_drive_that_does_not_notice_an_abrupt_stop_is_off_by_a_pole_pair(mode: str) -> None:
    bench = Bench(mode, detects_loss=False)
    bench.move((500, 0, 5), (900, 0, 50))
    bench.wait(1)
    assert (bench.point("alarm"), bench.point("in_step"), bench.point("lost")) == (False, True, 20)
    bench.move((400, 0, 10))
    bench.wait(1)
    assert (bench.point("steps"), bench.point("lost"), bench.point("received")) == (45, 20, 65)


def test_a_drive_that_does_not_notice_goes_on_when_the_pulses_are_slow() -> None:
    bench = Bench(detects_loss=False)
    bench.move((5_000, 0, 100), (5_000, -50_000, 248))
    assert (bench.point("alarm"), bench.point("in_step")) == (False, True)
    assert bench.point("steps") + bench.point("lost") == 348
    assert bench.point("steps") == pytest.approx(248 - 247.5, abs=1)  # 247.5 periods until it is down to 500 Hz
    bench.move((400, 0, 10))
    assert bench.point("steps") + bench.point("lost") == 358


def test_reset_clears_the_alarm() -> None:
    bench = Bench()
    bench.move((5_000, 0, 10))
    bench.drive("axis.reset", True)
    assert (bench.last("axis.alarm").value, bench.last("axis.ready").value) == (False, True)
    bench.move((400, 0, 7))
    assert (bench.point("steps") + bench.point("lost"), bench.point("received")) == (17, 17)
    assert bench.point("lost") >= 9


def test_a_drive_without_enable_loses_the_pulses_and_says_so() -> None:
    bench = Bench(enable_wire="axis.enable")
    assert bench.last("axis.ready").value is False
    bench.move((400, 0, 5))
    bench.drive("axis.enable", True)
    assert bench.last("axis.ready").value is True
    bench.move((400, 0, 3))
    assert (bench.point("steps"), bench.point("lost")) == (3, 5)


def test_enable_while_fast_pulses_come_is_an_alarm() -> None:
    bench = Bench(enable_wire="axis.enable")
    bench.output.send(5_000, count=None)
    bench.drive("axis.enable", True)
    assert bench.point("alarm") is True


def test_clockwise_and_counter_clockwise_inputs() -> None:
    bench = Bench(mode="segments")
    bench.plant = Stepper(
        bench.clock, "axis", StepperSettings(**{**MOTOR, "mode": "cw_ccw", "ccw_wire": "pto.ccw"}), bench.wires
    )
    bench.plant.start()
    backwards = PulseOutput(bench.clock, bench, "pto.ccw")
    backwards.start()
    bench.move((400, 0, 9))
    backwards.send(400, count=4)
    bench.wait(1)
    assert (bench.point("steps"), bench.point("received")) == (5, 13)


@pytest.mark.parametrize(
    ("fault", "result"),
    [({"what": "jam"}, (0, 100, True)), ({"what": "weak", "percent": 10}, (0, 100, True)),
     ({"what": "weak", "percent": 90}, (100, 0, False)), ({"what": "trip"}, (0, 100, True))],
)  # fmt: skip
def test_faults(fault: dict[str, Any], result: tuple[int, int, bool]) -> None:
    bench = Bench(coulomb_nm=0.3)
    number = bench.plant.add_fault(fault)
    bench.move((400, 0, 100))
    assert (bench.point("steps"), bench.point("lost"), bench.point("alarm")) == pytest.approx(result, abs=1)
    bench.plant.clear_fault(number)
    bench.drive("axis.reset", True)
    assert bench.point("ready") is True


def test_a_sender_that_is_killed_and_started_again() -> None:
    bench = Bench()
    bench.output.send(400, count=None)
    bench.wait(0.1)
    bench.output = PulseOutput(bench.clock, bench, "pto.pulse")
    bench.output.start()
    bench.move((400, 0, 10))
    assert (bench.point("steps"), bench.point("restarts")) == (50, 1)


@pytest.mark.long
@given(
    st.lists(
        st.tuples(st.integers(1, 450), st.integers(0, 60), st.sampled_from((1, -1)), st.integers(0, 50 * MS)),
        max_size=5,
    )
)
def test_edges_and_segments_make_the_same_steps(moves: list[tuple[int, int, int, int]]) -> None:
    benches = [Bench(mode, direction_wire="pto.direction", start_hz=1_000.0) for mode in ("segments", "edges")]
    for frequency, count, direction, pause_ns in moves:
        for bench in benches:
            bench.move((frequency, 0, count), direction=direction)
            bench.wait(pause_ns / S)
        segments, edges = benches
        assert edges.point("steps") == segments.point("steps") == segments.output.train.at(segments.clock.now_ns())
        assert edges.point("lost") == segments.point("lost") == 0


@given(st.lists(st.tuples(st.integers(1, 40_000), st.integers(0, 400), st.sampled_from((1, -1)), st.booleans())))
def test_every_pulse_is_a_step_or_lost(moves: list[tuple[int, int, int, bool]]) -> None:
    bench = Bench(detects_loss=False)
    for frequency, count, direction, is_cut in moves:
        train = bench.output.send(frequency, count=count, direction=direction)
        assert train.end_ns is not None
        bench.clock.advance_to((train.start_ns + train.end_ns) // 2 if is_cut else train.end_ns)
        before = (bench.point("steps"), bench.point("lost"))
        assert (bench.point("steps"), bench.point("lost")) == before
    bench.output.send()
    assert bench.point("received") == bench.point("sent") == bench.output.train.sent
    assert 0 <= bench.point("lost") <= bench.point("received")
    assert abs(bench.point("steps")) <= bench.point("received") - bench.point("lost")


@pytest.mark.parametrize(
    "wrong",
    [
        {"pull_out": []}, {"pull_out": [(0.0, 1.0), (1.0, 2.0)]}, {"pull_out": [(1.0, 1.0), (1.0, 0.5)]},
        {"pull_out": [(0.0, -1.0)]}, {"mode": "cw_ccw"}, {"ccw_wire": "x"}, {"start_hz": 0.0},
        {"mode": "cw_ccw", "ccw_wire": "x", "direction_wire": "y"}, {"pulses_per_turn": 0}, {"highest_hz": 1e9},
    ],
)  # fmt: skip
def test_settings_that_do_not_fit_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        StepperSettings(**{**MOTOR, **wrong})
