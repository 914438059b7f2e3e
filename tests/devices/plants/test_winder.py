"""The winder on its wires."""

import math
from math import floor
from typing import Any

import pytest
import winders
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from winders import DANCER

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.device import Value
from fieldrig.pytest_plugin import RigMaker
from fieldrig.testing import RecordedLink
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.plants.line_feed import LineFeed
from fieldrig_devices.plants.winder import Winder
from fieldrig_devices.plants.winder_settings import LoadCell, WinderSettings

FILM = {**winders.FILM, "role": "unwinder", "load_cell": {"rated_force_n": 1000.0}}
COUNTS_PER_RAD = 4000 / math.tau


class Bench:
    """A winder, its wires, and the hands of a clock."""

    def __init__(self, **settings: Any) -> None:
        self.clock = VirtualClock()
        self.wires = RecordedLink[Signal]()
        self.winder = Winder(self.clock, "w", WinderSettings(**{**FILM, **settings}), self.wires)
        self.winder.start()

    def drive(self, name: str, value: float, unit: str = "V") -> None:
        self.wires.deliver(Signal(name, value, unit))

    def ramp_line(self, speed: float, seconds: float) -> None:
        """Send a steady motion as a `Motion`, which needs no steps."""
        now_ns = self.clock.now_ns()
        self.wires.deliver(Motion("line.speed", 0.0, "m/s", now_ns, speed / seconds, 0.0))
        self.wait(seconds)
        self.drive("line.speed", speed, "m/s")

    def wait(self, seconds: float) -> None:
        self.clock.advance_to(self.clock.now_ns() + round(seconds * S))

    def number(self, key: str) -> float:
        value = self.winder.points()[key].read()
        assert not isinstance(value, str)
        return value

    def push(self, key: str, value: Value) -> None:
        write = self.winder.points()[key].write
        assert write is not None
        write(value)

    def published(self, wire: str) -> float:
        return next(signal.value for signal in reversed(self.wires.sent) if signal.name == wire)

    @property
    def count(self) -> float:
        """The present value of a counter at the wire."""
        motion = next(signal for signal in reversed(self.wires.sent) if isinstance(signal, Motion))
        return motion.at(self.clock.now_ns())


def test_winder_publishes_everything_at_the_start_and_then_is_still() -> None:
    bench = Bench(dancer={**DANCER, "initial_m": 0.3})
    assert bench.wires.sent == [
        Motion("w.encoder", 0.0, "count", 0, 0.0, 0.0),
        Signal("w.load_cell", 0.0, "V"),
        Signal("w.dancer", 10.0, "V"),
        Signal("w.web", True),
    ]
    assert bench.wires.interest == ("w.reference", "line.speed")
    assert bench.clock.next_ns() is None


@pytest.mark.long
def test_reference_is_a_torque_and_the_load_cell_shows_the_tension_it_makes() -> None:
    bench = Bench()
    bench.drive("w.reference", 4.0)  # 20 N m at 0.2 m: 100 N, 200 N on the cell of 1000 N
    bench.wait(10)
    assert bench.number("torque") == 20.0
    assert bench.number("tension") == pytest.approx(100.0, rel=1e-3)
    assert bench.published("w.load_cell") == pytest.approx(0.2 * 0.020, rel=1e-3)
    bench.wait(30)
    assert bench.clock.next_ns() is None  # it has come to rest


@pytest.mark.parametrize(
    ("keys", "tension", "volt"),
    [
        ({"rated_force_n": 500.0}, 250.0, 0.020),
        ({"rated_force_n": 500.0, "sensitivity_mv_per_v": 1.0}, 250.0, 0.010),
        ({"rated_force_n": 500.0, "excitation_v": 5.0, "force_per_tension": 1.0}, 250.0, 0.005),
        ({"rated_force_n": 500.0, "tare_n": 50.0}, 0.0, 0.002),
        ({"rated_force_n": 500.0}, 9999.0, 0.030),
    ],
)
def test_load_cell_is_a_bridge(keys: dict[str, Any], tension: float, volt: float) -> None:
    bench = Bench(load_cell=keys)
    cell = LoadCell(**keys)
    assert cell.volt(tension) == pytest.approx(volt)
    assert bench.number("load_cell") == cell.volt(0.0)


@pytest.mark.long
def test_line_draws_web_and_the_roll_follows() -> None:
    bench = Bench()
    bench.drive("w.reference", 2.0)
    bench.ramp_line(3.0, 5.0)
    bench.wait(20)
    passed_m = 3.0 * 22.5
    assert bench.number("line_speed") == 3.0
    assert bench.number("speed") * bench.number("radius") == pytest.approx(3.0, rel=1e-3)
    assert bench.number("radius") == pytest.approx(math.sqrt(0.2**2 - passed_m * 0.0001 / math.pi), rel=1e-4)
    assert bench.number("length") == pytest.approx(math.pi * (0.2**2 - 0.05**2) / 0.0001 - passed_m, rel=1e-4)
    assert bench.number("tension") * bench.number("radius") == pytest.approx(10.0, rel=1e-2)
    assert bench.number("encoder") == floor(bench.count)


@pytest.mark.long
def test_rewinder_takes_up_what_the_line_gives() -> None:
    bench = Bench(role="rewinder", initial_radius_m=0.05)
    bench.drive("w.reference", 2.0)
    bench.ramp_line(3.0, 5.0)
    bench.wait(20)
    assert bench.number("radius") == pytest.approx(math.sqrt(0.05**2 + 67.5 * 0.0001 / math.pi), rel=1e-3)
    assert bench.number("tension") * bench.number("radius") == pytest.approx(10.0, rel=1e-2)


@pytest.mark.long
def test_brake_holds_the_roll_and_never_turns_it() -> None:
    bench = Bench(drive="brake")
    bench.drive("w.reference", 5.0)
    bench.wait(1)
    assert (bench.number("position"), bench.number("tension")) == (0.0, 0.0)
    bench.ramp_line(2.0, 5.0)
    bench.wait(20)
    assert bench.number("tension") * bench.number("radius") == pytest.approx(25.0, rel=1e-2)
    bench.drive("w.reference", -5.0)
    assert bench.number("torque") == 0.0


@pytest.mark.long
def test_dancer_publishes_its_place_in_volts() -> None:
    bench = Bench(dancer={**DANCER, "spring_n_per_m": 400.0})
    bench.drive("w.reference", 2.8)
    bench.wait(60)
    tension = 14.0 / 0.2
    place_m = (200.0 - 2 * tension) / 400.0
    assert bench.number("dancer") == pytest.approx(place_m, abs=1e-3)
    assert bench.published("w.dancer") == pytest.approx(20 * place_m / 0.3 - 10, abs=0.05)
    bench.push("dancer_force", 140.0 + 400.0 * 0.25)
    bench.wait(60)
    assert bench.number("dancer") == pytest.approx(0.25, abs=1e-3)


def test_web_torn_by_hand_lets_go_and_is_threaded_again() -> None:
    bench = Bench(initial_tension_n=100.0, dancer=DANCER)
    bench.drive("w.reference", 4.0)
    bench.wait(1)
    bench.push("break_web", True)
    assert (bench.published("w.web"), bench.published("w.load_cell")) == (False, 0.0)
    bench.wait(2)
    assert bench.published("w.dancer") == 10.0
    assert bench.number("speed") < -10  # pulls at nothing, backwards
    bench.push("break_web", False)
    assert (bench.published("w.web"), bench.number("tension"), bench.number("slack")) == (True, 0.0, 0.0)


def test_web_breaks_at_its_tension() -> None:
    bench = Bench(breaking_tension_n=200.0)
    bench.ramp_line(1.0, 0.1)  # jerks at a heavy roll
    assert bench.published("w.web") is False
    assert bench.number("tension") == 0.0


def test_empty_roll_asks_for_another() -> None:
    bench = Bench(initial_radius_m=0.0501)
    bench.drive("w.reference", 0.2)
    bench.ramp_line(1.0, 1.0)
    bench.wait(2)
    assert bench.published("w.web") is False
    with pytest.raises(ValueError, match="empty"):
        bench.push("break_web", False)
    bench.push("radius", 0.15)
    bench.push("break_web", False)
    assert (bench.number("break_web"), bench.number("radius")) == (False, 0.15)


def test_feed_by_an_encoder_is_what_it_counts() -> None:
    feed = LineFeed(0.001)
    assert (feed.passed_m(5 * MS), feed.is_still(5 * MS)) == (0.0, True)
    feed.take(Motion("line", 500.0, "count", 5 * MS, 0.0, 200.0))
    assert (feed.speed(5 * MS), feed.is_still(5 * MS)) == (0.0, False)
    assert feed.passed_m(1005 * MS) == pytest.approx(0.1)
    assert feed.speed(1005 * MS) == pytest.approx(0.2)
    feed.take(Motion("line", 600.0, "count", 1005 * MS, 0.0, 0.0))
    assert (feed.passed_m(2 * S), feed.is_still(2 * S)) == (0.0, True)
    feed.take(Signal("line", 590, "count"))
    assert not feed.is_still(2 * S)
    assert feed.passed_m(2 * S) == pytest.approx(-0.01)


@pytest.mark.long
def test_counts_sent_twice_at_one_instant_are_web_once() -> None:
    """A counter on a hub publishes its value in steps."""
    bench = Bench(line_m_per_count=0.001)
    bench.drive("line.speed", 0, "count")
    bench.drive("w.reference", 2.0)
    bench.wait(0.5)
    before = bench.number("radius")
    for counts in range(0, 500, 2):
        bench.drive("line.speed", counts + 1, "count")
        bench.drive("line.speed", counts + 2, "count")
        bench.wait(0.01)
    bench.wait(1.0)
    length_m = WinderSettings.model_validate(FILM).length_m
    assert length_m(before) - length_m(bench.number("radius")) == pytest.approx(0.5, rel=0.02)


def test_feed_by_a_speed_is_its_integral() -> None:
    feed = LineFeed(None)
    feed.take(Signal("line", 2.0, "m/s"))
    assert feed.passed_m(500 * MS) == pytest.approx(1.0)
    feed.take(Motion("line", 2.0, "m/s", 500 * MS, -4.0, 0.0))
    assert feed.passed_m(S) == pytest.approx(0.5)


moves = st.lists(
    st.tuples(st.sampled_from(["w.reference", "line.speed"]), st.floats(0, 3), st.integers(1, 300 * MS)), max_size=10
)


@pytest.mark.long
@settings(max_examples=40, deadline=None)
@given(moves, st.sampled_from([0.0, 2.0]), st.booleans())
def test_published_encoder_is_the_true_one(
    moves: list[tuple[str, float, int]], coulomb: float, has_dancer: bool
) -> None:
    bench = Bench(coulomb_nm=coulomb, dancer=DANCER if has_dancer else None)
    for wire, value, pause_ns in moves:
        bench.drive(wire, value)
        for _ in range(20):
            bench.clock.advance_to(bench.clock.now_ns() + pause_ns // 20 + 1)
            bench.push("radius", bench.number("radius"))  # a look between two steps
            assert abs(bench.count - bench.number("position") * COUNTS_PER_RAD) <= 0.3


@pytest.mark.long
def test_rig_of_a_servo_that_drives_the_line_of_a_winder(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(
        {
            "time": "virtual",
            "buses": {"wires": {"kind": "wires.virtual"}},
            "devices": {
                "master": {
                    "kind": "plant.servo",
                    "links": {"wires": "wires"},
                    "rated_torque_nm": 10.0,
                    "motor_inertia_kg_m2": 0.05,
                    "viscous_nm_s_per_rad": 0.05,
                },
                "roll": {
                    "kind": "plant.winder",
                    "links": {"wires": "wires"},
                    **FILM,
                    "drive": "brake",
                    "coulomb_nm": 5.0,
                    "line_wire": "master.encoder",
                    "line_m_per_count": 0.1 * math.tau / 4000,  # a roller of 0.1 m
                },
            },
        }
    )
    rig.set("master", "load_torque", -0.5)  # pulled to 10 rad/s
    rig.run_until(20 * S)
    assert rig.get("master", "speed") == pytest.approx(10.0, rel=1e-3)
    assert rig.get("roll", "line_speed") == pytest.approx(1.0, rel=1e-3)
    radius = rig.get("roll", "radius")
    assert isinstance(radius, float)
    assert rig.get("roll", "tension") == pytest.approx(5.0 / radius, rel=2e-2)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e308, -1e308])
@pytest.mark.parametrize("line_m_per_count", [None, 0.001])
@pytest.mark.parametrize("role", ["unwinder", "rewinder"])
def test_no_number_on_a_wire_harms(value: float, line_m_per_count: float | None, role: str) -> None:
    bench = Bench(role=role, dancer=DANCER, line_m_per_count=line_m_per_count)
    for value_sent in (0.0, value, 1.0, value):
        bench.drive("w.reference", value_sent)
        bench.drive("line.speed", value_sent, "m/s")
        bench.wait(0.02)
        bench.wires.deliver(
            Motion("line.speed", 0.0, "m/s", bench.clock.now_ns(), value_sent if abs(value_sent) < math.inf else 0)
        )
        bench.wait(0.02)
    assert all(math.isfinite(bench.number(key)) for key in ("tension", "radius", "position", "speed", "line_speed"))
    assert all(math.isfinite(signal.value) for signal in bench.wires.sent)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"initial_radius_m": 0.01}, "initial_radius_m is too small"),
        ({"initial_tension_n": 1e6}, "too large; expected below"),
        ({"dancer": {**DANCER, "initial_m": 1.0}}, "travel_m"),
        ({"thickness_m": math.nan}, "finite"),
        ({"torque_nm_at_10_v": 1e300}, "torque_nm_at_10_v cannot be 1e\\+300; expected 1e-12 to 1e\\+12"),
        ({"dancer": {**DANCER, "mass_kg": 1e-300}}, "mass_kg cannot be"),
        ({"role": "slitter"}, "unwinder"),
    ],
)
def test_winder_that_makes_no_sense_is_refused(wrong: dict[str, Any], says: str) -> None:
    with pytest.raises(ValidationError, match=says):
        WinderSettings(**{**FILM, **wrong})


@pytest.mark.parametrize(
    ("key", "value"), [("break_web", "maybe"), ("radius", 0.01), ("radius", "big"), ("dancer_force", -1.0)]
)
def test_point_says_what_would_be_right(key: str, value: Value) -> None:
    with pytest.raises(ValueError, match=r"expected (true or false|a number from .* (m|N)), got"):
        Bench(dancer=DANCER).push(key, value)


def test_a_web_is_torn_as_long_as_the_fault_lasts() -> None:
    bench = Bench(initial_tension_n=100.0)
    bench.drive("w.reference", 4.0)
    bench.winder.add_fault({"what": "torn", "start_ms": 10, "duration_ms": 20})
    assert bench.number("tension") == pytest.approx(100.0)
    bench.wait(0.010)
    assert (bench.number("tension"), bench.published("w.web")) == (0.0, False)
    with pytest.raises(ValueError, match="a fault tears the web; clear it first"):
        bench.push("break_web", False)
    bench.wait(0.020)
    assert bench.number("break_web") is False
    assert bench.published("w.web") is True


def test_no_web_is_threaded_from_an_empty_roll() -> None:
    bench = Bench()
    bench.push("radius", 0.05)
    bench.winder.clear_fault(bench.winder.add_fault({"what": "torn"}))
    assert bench.published("w.web") is False


def test_a_web_that_slips_is_drawn_less() -> None:
    """The line draws 60 mm, 25 % of the last 50 mm without web; the roll swings by less than 3 mm on the web."""
    bench, drawn_m = Bench(modulus_pa=1e9, damping_s=0.01), 0.010 + 0.75 * 0.050
    bench.drive("w.reference", 1.0)
    before = bench.number("length")
    bench.drive("line.speed", 0.1, "m/s")
    bench.wait(0.1)
    bench.winder.add_fault({"what": "slip", "percent": 25})
    bench.wait(0.5)
    assert bench.number("line_speed") == 0.1
    assert before - bench.number("length") == pytest.approx(drawn_m, abs=0.003)


def test_a_web_that_slips_altogether_is_not_drawn_until_the_fault_ends() -> None:
    bench = Bench()
    bench.winder.add_fault({"what": "slip", "percent": 100, "duration_ms": 100})
    before = bench.number("length")
    bench.drive("line.speed", 0.1, "m/s")
    bench.wait(0.1)
    assert bench.number("length") == before
    bench.wait(0.1)
    assert bench.number("length") < before


def test_a_roll_is_stopped_to_thread_a_new_web() -> None:
    bench = Bench()
    number = bench.winder.add_fault({"what": "torn"})
    bench.drive("w.reference", 5.0)
    bench.wait(0.5)
    assert abs(bench.number("speed")) > 1
    bench.winder.clear_fault(number)
    assert bench.number("speed") == 0.0
