"""The conveyor on its wires: edges at the instants of the closed form, feeder, discharge, faults, and settings."""

from math import ceil, sqrt
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.device import Value
from fieldrig.testing import RecordedLink
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.plants.conveyor import LONGEST_WAY_M, Conveyor
from fieldrig_devices.plants.conveyor_settings import ConveyorSettings, SensorSettings
from fieldrig_devices.plants.driven import seconds_to

LINE = {
    "length_m": 2.0, "roller_radius_m": 0.05, "drive_wire": "belt.position", "product_m": 0.2,
    "sensors": {"infeed": SensorSettings(at_m=0.5), "outfeed": SensorSettings(at_m=1.8)},
}  # fmt: skip
RADIUS = 0.05


class Bench:
    """A conveyor, its wires, and the hands of a clock."""

    def __init__(self, **settings: Any) -> None:
        self.clock = VirtualClock()
        self.wires = RecordedLink[Signal]()
        self.edges: list[tuple[int, str, bool | int | float]] = []
        self.plant = Conveyor(self.clock, "line", ConveyorSettings(**{**LINE, **settings}), self)
        self.plant.start()
        self.edges.clear()

    def send(self, signal: Signal) -> None:
        self.edges.append((self.clock.now_ns(), signal.name, signal.value))

    def on_receive(self, handler: Any, interest: Any = None) -> None:
        self.wires.on_receive(handler, interest)

    def drive(self, place_m: float, speed: float = 0.0, acceleration: float = 0.0) -> None:
        """Publish the motion of the roller, by the way of the belt."""
        now_ns = self.clock.now_ns()
        motion = Motion("belt.position", place_m / RADIUS, "rad", now_ns, speed / RADIUS, acceleration / RADIUS)
        self.wires.deliver(motion)

    def wait(self, seconds: float) -> None:
        self.clock.advance_to(self.clock.now_ns() + round(seconds * S))

    def point(self, key: str) -> Value:
        return self.plant.points()[key].read()

    def write(self, key: str, value: Value) -> None:
        write = self.plant.points()[key].write
        assert write is not None
        write(value)


def near(seconds: float) -> Any:
    """Return an instant within two nanoseconds."""
    return pytest.approx(seconds * S, abs=2)


def test_edges_fall_when_front_and_rear_reach_the_light_barrier() -> None:
    bench = Bench()
    bench.drive(0.0)
    bench.write("feed", True)  # rear at 0, front at 0.2
    bench.drive(0.0, speed=0.7)
    bench.wait(10)
    assert bench.edges == [
        (near(0.3 / 0.7), "line.infeed", True),
        (near(0.5 / 0.7), "line.infeed", False),
        (near(1.6 / 0.7), "line.outfeed", True),
        (near(1.8 / 0.7), "line.outfeed", False),
        (near(2.0 / 0.7), "line.discharge", 1),
    ]
    assert (bench.point("products"), bench.point("discharged")) == (0, 1)
    assert bench.point("position") == pytest.approx(7.0)


def test_edges_of_an_accelerated_belt_are_those_of_the_parabola() -> None:
    bench = Bench()
    bench.drive(0.0)
    bench.write("feed", True)
    bench.drive(0.0, acceleration=1.5)
    bench.wait(3)
    times = [time for time, _, _ in bench.edges]
    assert times == [near(sqrt(2 * way / 1.5)) for way in (0.3, 0.5, 1.6, 1.8, 2.0)]


def test_a_belt_that_turns_back_frees_the_light_barrier_again() -> None:
    bench = Bench()
    bench.drive(0.0)
    bench.write("feed", True)
    bench.drive(0.0, speed=1.0, acceleration=-1.0)  # turns after 0.5 m, so the front reaches 0.7
    bench.wait(1.9)
    rises = 1 - sqrt(1 - 2 * 0.3)
    assert bench.edges[:1] == [(near(rises), "line.infeed", True)]
    assert bench.edges[-1] == (near(2 - rises), "line.infeed", False)


def test_a_product_at_the_feed_end_falls_off_backwards() -> None:
    bench = Bench()
    bench.drive(5.0)
    bench.write("feed", True)
    bench.drive(5.0, speed=-0.1)
    bench.wait(1.99)
    assert (bench.point("products"), bench.point("lost")) == (1, 0)
    bench.wait(0.02)
    assert (bench.point("products"), bench.point("lost")) == (0, 1)


@given(st.floats(1e-6, 50), st.floats(-10, 10), st.floats(-10, 10))
def test_the_time_of_a_way_solves_the_motion(way: float, speed: float, acceleration: float) -> None:
    seconds = seconds_to(way, speed, acceleration)
    if seconds < 1e6:
        assert speed * seconds + acceleration / 2 * seconds * seconds == pytest.approx(way, rel=1e-6, abs=1e-9)
    else:  # it turns before
        assert acceleration <= 1e-3
        assert speed <= 1e-3 or speed * speed < -2 * acceleration * way * (1 - 1e-12)


@given(st.lists(st.tuples(st.floats(-2, 2), st.floats(-3, 3), st.integers(1, 900)), max_size=12))
def test_light_barriers_always_show_what_is_in_front_of_them(motions: list[tuple[float, float, int]]) -> None:
    """Whatever the belt does, the published values are those of the present positions."""
    bench = Bench(pitch_m=0.35)
    place, shown = 0.0, {"line.infeed": False, "line.outfeed": False}
    bench.drive(place)
    for speed, acceleration, ms in motions:
        bench.drive(place, speed, acceleration)
        bench.wait(ms / 1000)
        seconds = ms / 1000
        place += speed * seconds + acceleration / 2 * seconds * seconds
        shown.update((name, bool(value)) for _, name, value in bench.edges if name in shown)
        assert bench.point("position") == pytest.approx(place, abs=1e-9)
        fronts = [float(front) for front in str(bench.point("fronts")).split(", ") if front]
        for name, at in (("line.infeed", 0.5), ("line.outfeed", 1.8)):
            if all(abs(front - at) > 2e-4 and abs(front - 0.2 - at) > 2e-4 for front in fronts):
                assert shown[name] is any(front - 0.2 < at <= front for front in fronts)


def test_the_feeder_puts_a_product_on_the_belt_after_each_pitch() -> None:
    bench = Bench(pitch_m=0.5)
    bench.drive(3.0, speed=1.0)
    bench.wait(1.75)
    assert (bench.point("fed"), bench.point("fronts")) == (3, "1.4500, 0.9500, 0.4500")
    assert bench.point("speed") == pytest.approx(1.0)


def test_a_wire_feeds_at_its_rising_edge_if_there_is_room() -> None:
    bench = Bench()
    bench.drive(0.0)
    for value in (True, True, False, True):
        bench.wires.deliver(Signal("line.feed", value))
    assert (bench.point("fed"), bench.point("refused")) == (1, 1)
    with pytest.raises(ValueError, match="expected room for a product"):
        bench.write("feed", True)
    bench.drive(0.2)
    bench.write("feed", True)
    assert bench.point("fed") == 2


def test_a_product_that_slips_comes_late() -> None:
    bench = Bench()
    bench.drive(0.0)
    bench.write("feed", True)
    bench.plant.add_fault({"what": "slip", "percent": 60, "product": 1})
    bench.drive(0.0, speed=1.0)
    bench.wait(1)
    assert [time for time, _, _ in bench.edges] == [near(0.3 / 0.4)]
    bench.plant.clear_fault(1)
    bench.wait(10)
    assert bench.edges[1] == (near(1 + 0.1), "line.infeed", False)


def test_a_slip_ends_at_its_time() -> None:
    bench = Bench()
    bench.drive(0.0)
    bench.write("feed", True)
    bench.plant.add_fault({"what": "slip", "duration_ms": 500})
    bench.drive(0.0, speed=1.0)
    bench.wait(1)
    assert bench.point("fronts") == "0.7000"


def test_a_dirty_sensor_always_shows_the_same() -> None:
    bench = Bench()
    number = bench.plant.add_fault({"what": "dirty", "sensor": "infeed"})
    assert bench.edges == [(0, "line.infeed", True)]
    assert bench.point("infeed") is True
    bench.plant.clear_fault(number)
    assert bench.edges[-1] == (0, "line.infeed", False)
    with pytest.raises(ValueError, match="there is no sensor side\nexpected one of: infeed, outfeed"):
        bench.plant.add_fault({"what": "dirty", "sensor": "side"})


def test_a_belt_that_stands_costs_nothing() -> None:
    bench = Bench(pitch_m=0.5)
    bench.drive(0.0, speed=1.0)
    assert bench.clock.next_ns() == S // 2
    bench.drive(0.1)
    assert bench.clock.next_ns() is None


def test_a_belt_that_crawls_or_has_gone_too_far_does_not_keep_the_rig_busy() -> None:
    bench = Bench()
    bench.drive(0.0)
    bench.write("feed", True)
    bench.drive(0.3, speed=1e-12)  # the front is at the light barrier
    bench.wait(0.5)
    next_ns = bench.clock.next_ns()
    assert next_ns is None or next_ns >= bench.clock.now_ns() + MS
    bench.drive(LONGEST_WAY_M * 2, speed=1.0)
    assert bench.clock.next_ns() is None


def test_values_that_are_no_positions_are_ignored() -> None:
    bench = Bench()
    bench.wires.deliver(Signal("belt.position", float("nan"), "rad"))
    assert bench.point("position") == 0.0
    assert ceil(float(bench.point("speed"))) == 0


@pytest.mark.parametrize(
    ("settings", "wrong"),
    [
        ({"sensors": {"x": SensorSettings(at_m=3.0)}}, "sensors.x.at_m: expected at most 2"),
        ({"pitch_m": 0.1}, "pitch_m: expected at least 0.2"),
        ({"product_m": 1e-4}, "at most 1000 products"),
        ({"length_m": 0.0}, "greater than 0"),
    ],
)
def test_settings_that_do_not_fit_are_refused(settings: dict[str, Any], wrong: str) -> None:
    with pytest.raises(ValidationError, match=wrong):
        ConveyorSettings(**{**LINE, **settings})
