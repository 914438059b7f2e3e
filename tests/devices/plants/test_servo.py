"""The servo axis on its wires."""

import itertools
import math
from math import floor
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.device import Value
from fieldrig.testing import RecordedLink
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.plants.servo import Servo
from fieldrig_devices.plants.servo_settings import ServoSettings

AXIS = {"rated_torque_nm": 2.0, "motor_inertia_kg_m2": 0.001}
COUNTS_PER_RAD = 4000 / math.tau


class Bench:
    """An axis, its wires, and the hands of a clock."""

    def __init__(self, **settings: Any) -> None:
        self.clock = VirtualClock()
        self.wires = RecordedLink[Signal]()
        self.servo = Servo(self.clock, "x", ServoSettings(**{**AXIS, **settings}), self.wires)
        self.servo.start()

    def drive(self, name: str, value: float, unit: str = "V") -> None:
        self.wires.deliver(Signal(f"x.{name}", value, unit))

    def wait(self, seconds: float) -> None:
        self.clock.advance_to(self.clock.now_ns() + round(seconds * S))

    def point(self, key: str) -> Value:
        return self.servo.points()[key].read()

    def number(self, key: str) -> float:
        value = self.point(key)
        assert not isinstance(value, str)
        return value

    def push(self, key: str, value: Value) -> None:
        write = self.servo.points()[key].write
        assert write is not None
        write(value)

    @property
    def encoder(self) -> Motion:
        """The motion that was published last."""
        return next(signal for signal in reversed(self.wires.sent) if isinstance(signal, Motion))

    @property
    def count(self) -> float:
        """The present value of a counter at the wire."""
        return self.encoder.at(self.clock.now_ns())

    def changes(self, name: str) -> list[bool | float]:
        return [signal.value for signal in self.wires.sent if signal.name == name]


def test_axis_tells_its_encoder_and_listens_to_its_wires() -> None:
    bench = Bench()
    assert bench.wires.sent == [Motion("x.encoder", 0.0, "count", 0, 0.0, 0.0)]
    assert bench.wires.interest == ("x.reference", "x.load_torque", "x.blocked")


@pytest.mark.manual("ARP-002")
def test_reference_is_a_torque_and_neither_a_speed_nor_a_position() -> None:
    bench = Bench()
    bench.drive("reference", 5.0)
    assert bench.point("torque") == 1.0
    bench.wait(0.1)
    assert bench.point("speed") == pytest.approx(1.0 / 0.001 * 0.1)
    bench.wait(0.1)
    assert bench.point("speed") == pytest.approx(1.0 / 0.001 * 0.2)
    bench.drive("reference", 0.0)
    bench.wait(1.0)
    assert bench.point("speed") == pytest.approx(200.0)  # it coasts


@pytest.mark.manual("ARP-020")
@pytest.mark.parametrize(("lines", "counts"), [(1000, 4000), (512, 2048), (25000, 100000)])
def test_encoder_gives_four_counts_a_line(lines: int, counts: int) -> None:
    bench = Bench(encoder_lines=lines)
    bench.drive("reference", 1.0)
    bench.wait(math.sqrt(2 * math.tau / 200.0))  # one turn at 200 rad/s2
    assert bench.point("position") == pytest.approx(math.tau)
    assert bench.count == pytest.approx(counts)


def test_reference_is_limited_to_10_v() -> None:
    bench = Bench()
    bench.drive("reference", -24.0)
    assert (bench.point("reference"), bench.point("torque")) == (-10.0, -2.0)


def test_current_follows_its_reference_with_the_lag() -> None:
    bench = Bench(current_lag_ms=2.0)
    bench.drive("reference", 10.0)
    assert bench.point("torque") == 0.0
    bench.wait(0.002)
    assert bench.point("torque") == pytest.approx(2.0 * (1 - math.exp(-1)))


def test_gear_and_load_are_felt_at_the_motor() -> None:
    bench = Bench(load_inertia_kg_m2=0.1, gear_ratio=10.0, load_torque_nm=5.0)
    bench.drive("reference", 5.0)
    bench.wait(0.5)
    acceleration = (1.0 - 5.0 / 10) / (0.001 + 0.1 / 100)
    assert bench.point("speed") == pytest.approx(acceleration * 0.5 / 10)
    assert bench.count == pytest.approx(acceleration * 0.125 * COUNTS_PER_RAD)


def test_encoder_at_the_load_counts_its_turns() -> None:
    bench = Bench(gear_ratio=10.0, encoder_at="load", encoder_reversed=True)
    bench.drive("reference", 5.0)
    bench.wait(0.5)
    assert bench.count == pytest.approx(-1.0 / 0.001 * 0.125 / 10 * COUNTS_PER_RAD)
    assert bench.point("encoder") == floor(bench.count)


@pytest.mark.parametrize("volt", [0.0, 0.99, -0.99])
def test_axis_holds_within_its_dry_friction_and_says_nothing(volt: float) -> None:
    bench = Bench(coulomb_nm=0.2)
    bench.drive("reference", volt)
    assert bench.clock.next_ns() is None
    bench.wait(100)
    assert bench.point("position") == 0.0
    assert len(bench.wires.sent) == 1


def test_axis_runs_down_by_dry_friction_and_stands_still_at_once() -> None:
    bench = Bench(coulomb_nm=0.2)
    bench.drive("reference", 10.0)
    bench.wait(0.1)
    bench.drive("reference", 0.0)
    bench.wait(180 / 200 - 0.001)
    assert bench.point("speed") == pytest.approx(0.2)
    bench.wait(0.002)
    assert bench.point("speed") == 0.0
    assert (bench.encoder.speed, bench.encoder.acceleration) == (0.0, 0.0)
    assert bench.clock.next_ns() is None


def test_steady_axis_costs_nothing() -> None:
    bench = Bench(viscous_nm_s_per_rad=0.01, coulomb_nm=0.1, current_lag_ms=1.0)
    bench.drive("reference", 5.0)
    bench.wait(10)
    told = len(bench.wires.take())
    assert told < 400
    bench.wait(36_000)
    assert bench.wires.sent == []
    assert bench.point("speed") == pytest.approx((1.0 - 0.1) / 0.01)


def test_external_torque_pulls_down() -> None:
    bench = Bench(coulomb_nm=0.1)
    bench.push("load_torque", 0.3)
    bench.wait(0.1)
    assert bench.point("speed") == pytest.approx(-0.2 / 0.001 * 0.1)
    bench.drive("load_torque", 0.0, "N m")
    assert bench.point("load_torque") == 0.0
    bench.wait(1.0)
    assert bench.point("speed") == 0.0


@pytest.mark.parametrize("by_wire", [True, False])
def test_jammed_axis_stands_whatever_the_torque(by_wire: bool) -> None:
    bench = Bench()
    bench.drive("reference", 10.0)
    bench.wait(0.1)
    if by_wire:
        bench.drive("blocked", True, "")
    else:
        bench.push("blocked", True)
    place = bench.count
    assert place == pytest.approx(10 * COUNTS_PER_RAD)
    bench.wait(5)
    assert (bench.point("speed"), bench.point("torque"), bench.count) == (0.0, 2.0, place)
    bench.push("blocked", False)
    bench.wait(0.1)
    assert bench.point("speed") == pytest.approx(200.0)


def test_brake_holds_until_it_is_told_to_open() -> None:
    bench = Bench(brake_torque_nm=3.0, load_torque_nm=1.0)
    bench.drive("reference", 10.0)
    bench.wait(1)
    assert (bench.point("position"), bench.point("brake")) == (0.0, True)
    bench.drive("brake", True, "")
    bench.wait(0.1)
    assert bench.point("speed") == pytest.approx(100.0)
    bench.drive("brake", False, "")
    bench.drive("reference", 0.0)
    bench.wait(100 / 4000 + 0.001)
    assert bench.point("speed") == 0.0


def test_axis_meets_its_stop_dead_and_comes_back() -> None:
    bench = Bench(high_stop_rad=2.0, low_stop_rad=-1.0, gear_ratio=5.0)
    bench.drive("reference", 10.0)
    bench.wait(1)
    assert (bench.point("position"), bench.point("speed"), bench.point("at_stop")) == (2.0, 0.0, True)
    assert bench.count == pytest.approx(10 * COUNTS_PER_RAD)
    bench.drive("reference", -10.0)
    bench.wait(0.05)
    assert bench.point("position") == pytest.approx(2.0 - 2000 / 5 * 0.00125)
    assert bench.point("at_stop") is False


def test_switches_change_where_they_are() -> None:
    bench = Bench(switches={"home": {"from_rad": 1.0, "to_rad": 1.5}}, viscous_nm_s_per_rad=0.001)
    bench.drive("reference", 1.0)
    bench.wait(3)
    bench.drive("reference", -10.0)
    bench.wait(0.1)
    bench.drive("reference", -1.0)
    bench.wait(5)
    edges = [signal.value for signal in bench.wires.sent if signal.name == "home"]
    assert edges == [False, True, False, True, False]


def test_index_comes_once_a_turn_for_one_count() -> None:
    bench = Bench(index_wire="x.index")
    bench.drive("reference", 0.1)  # 20 rad/s2
    places = []
    while bench.number("position") < 5 * math.tau:
        seen = len(bench.changes("x.index"))
        due_ns = bench.clock.next_ns()
        assert due_ns is not None
        bench.clock.advance_to(due_ns)
        places += [bench.count] * (len(bench.changes("x.index")) - seen)
    edges = [edge for turn in range(6) for edge in (4000 * turn, 4000 * turn + 1)][1:-1]
    assert places == pytest.approx(edges, abs=1e-3)


moves = st.lists(
    st.tuples(
        st.sampled_from(["reference", "reference", "reference", "load_torque", "blocked", "brake"]),
        st.floats(-10, 10).map(lambda x: round(x, 2)),
        st.integers(1, 200 * MS),
    ),
    max_size=12,
)


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(
    moves,
    st.sampled_from([0.0, 0.05]),
    st.sampled_from([0.0, 0.001]),
    st.sampled_from([0.0, 0.7]),
    st.sampled_from([None, 3.0]),
)
def test_encoder_told_is_the_true_one_at_every_instant(
    moves: list[tuple[str, float, int]], coulomb: float, viscous: float, lag: float, stop: float | None
) -> None:
    bench = Bench(
        coulomb_nm=coulomb,
        viscous_nm_s_per_rad=viscous,
        current_lag_ms=lag,
        high_stop_rad=stop,
        brake_torque_nm=1.0,
        breakaway_nm=1.5 * coulomb,
    )
    before = 0.0
    for wire, value, pause_ns in moves:
        bench.drive(wire, value > -3 if wire in ("blocked", "brake") else value)
        for _ in range(20):
            bench.clock.advance_to(bench.clock.now_ns() + pause_ns // 20 + 1)
            true = bench.number("position") * COUNTS_PER_RAD
            assert abs(bench.count - true) <= 0.2501
            assert abs(true - before) <= COUNTS_PER_RAD * 12 * 2000 * 2.4 * (pause_ns // 20 + 1) / S + 1e-6
            before = true


def test_encoder_told_twice_joins_without_a_jump() -> None:
    bench = Bench(viscous_nm_s_per_rad=0.01, current_lag_ms=1.0)
    bench.drive("reference", 10.0)
    bench.wait(1)
    told = [signal for signal in bench.wires.sent if isinstance(signal, Motion)]
    assert all(
        abs(motion.at(following.time_ns) - following.value) <= 0.25 for motion, following in itertools.pairwise(told)
    )


@pytest.mark.parametrize("name", ["reference", "load_torque"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_on_a_wire_is_not_taken(name: str, value: float) -> None:
    bench = Bench()
    bench.drive(name, 1.0)
    before = bench.number(name)
    bench.drive(name, value)
    bench.wait(0.1)
    assert bench.number(name) == before == 1.0
    assert math.isfinite(bench.count)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"rated_torque_nm": 0.0}, "greater than 0"),
        ({"low_stop_rad": 1.0, "high_stop_rad": 0.0}, "above low_stop_rad"),
        ({"high_stop_rad": -1.0}, "outside the stops"),
        ({"coulomb_nm": 0.3, "breakaway_nm": 0.1}, "at least coulomb_nm"),
        ({"switches": {"home": {"from_rad": 1.0, "to_rad": 0.5}}}, "above from_rad"),
        ({"motor_inertia_kg_m2": math.inf}, "finite"),
        ({"load_inertia_kg_m2": 1e300}, "load_inertia_kg_m2 cannot be 1e\\+300"),
        ({"rated_torque_nm": 1e9}, r"too large for the inertia; expected up to 1e\+06 N m"),
        ({"encoder_lines": 10**18}, "less than or equal"),
        ({"switches": {"home": {"from_rad": 0.0, "to_rad": 1e-9, "every_rad": 1e-8}}}, "greater than or equal"),
    ],
)
def test_axis_that_makes_no_sense_is_refused(wrong: dict[str, Any], says: str) -> None:
    with pytest.raises(ValidationError, match=says):
        ServoSettings(**{**AXIS, **wrong})


@pytest.mark.parametrize(("key", "value"), [("blocked", 2), ("load_torque", "much"), ("load_torque", math.inf)])
def test_point_says_what_would_be_right(key: str, value: Value) -> None:
    with pytest.raises(ValueError, match=r"expected (true or false|a number in N m), got"):
        Bench().push(key, value)


def test_an_axis_that_is_blocked_by_a_fault_stands_until_it_ends() -> None:
    bench = Bench(load_inertia_kg_m2=0.009)
    bench.drive("reference", 5.0)
    bench.wait(0.1)
    before = bench.number("position")
    bench.servo.add_fault({"what": "blocked", "duration_ms": 200})
    assert (bench.point("blocked"), bench.number("speed")) == (True, 0.0)
    bench.wait(0.2)
    assert bench.number("position") == pytest.approx(before)
    assert bench.point("blocked") is False
    bench.wait(0.1)  # 1 N m on 0.01 kg m2
    assert bench.number("speed") == pytest.approx(10.0)
    assert bench.number("position") - before == pytest.approx(0.5)


def test_an_axis_that_is_jammed_twice_stands_until_nothing_jams_it() -> None:
    bench = Bench()
    bench.push("blocked", True)
    number = bench.servo.add_fault({"what": "blocked"})
    bench.drive("reference", 5.0)
    bench.push("blocked", False)
    bench.wait(0.1)
    assert (bench.point("blocked"), bench.number("position")) == (True, 0.0)
    bench.servo.clear_fault(number)
    assert bench.point("blocked") is False
    bench.wait(0.1)
    assert bench.number("speed") > 0


def test_counts_that_an_encoder_misses_without_signal_are_lost() -> None:
    bench = Bench(load_inertia_kg_m2=0.009)
    bench.drive("reference", 5.0)
    bench.wait(0.1)
    shown = bench.count
    assert shown == pytest.approx(0.5 * COUNTS_PER_RAD)
    number = bench.servo.add_fault({"what": "encoder_signal", "start_ms": 0})
    bench.servo.add_fault({"what": "encoder_signal", "duration_ms": 50})
    bench.wait(0.1)
    assert bench.count == pytest.approx(shown)
    assert bench.point("encoder") == floor(shown)
    assert bench.number("position") == pytest.approx(2.0), "the axis moves on"
    bench.servo.clear_fault(number)
    assert bench.count == pytest.approx(shown)
    bench.wait(0.1)
    assert bench.count == pytest.approx(shown + 2.5 * COUNTS_PER_RAD, abs=0.3)
    assert bench.point("encoder") == floor(bench.count)


def test_an_axis_at_standstill_says_nothing_when_its_encoder_is_lost_and_back() -> None:
    bench = Bench()
    bench.wires.take()
    bench.servo.add_fault({"what": "encoder_signal", "duration_ms": 10})
    bench.wait(1)
    assert bench.wires.take() == []
