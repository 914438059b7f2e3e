"""The tank plant on its wires."""

import itertools
import math
from typing import Any

import pytest
from pydantic import ValidationError

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.device import Value
from fieldrig.testing import RecordedLink
from fieldrig_bus.wires import Signal
from fieldrig_devices.plants.tank import Tank, TankSettings

LAB = {"area_m2": 0.25, "height_m": 2.0, "outlet_area_m2": 2e-4, "pump_flow_m3_per_s": 0.001}


class Bench:
    """A tank, its wires, and the hands of a clock."""

    def __init__(self, **settings: Any) -> None:
        self.clock = VirtualClock()
        self.wires = RecordedLink[Signal]()
        self.tank = Tank(self.clock, "tank", TankSettings(**{**LAB, **settings}), self.wires)
        self.tank.start()

    def drive(self, name: str, value: float, unit: str = "%") -> None:
        self.wires.deliver(Signal(name, value, unit))

    def wait(self, seconds: float) -> None:
        self.clock.advance_to(self.clock.now_ns() + round(seconds * S))

    def point(self, key: str) -> Value:
        return self.tank.points()[key].read()

    def published(self, name: str) -> list[bool | float]:
        return [signal.value for signal in self.wires.sent if signal.name == name]


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_tank_publishes_everything_at_the_start(bench: Bench) -> None:
    assert bench.wires.take() == [
        Signal("tank.level", 0.0, "m"),
        Signal("tank.inflow", 0.0, "m3/s"),
        Signal("tank.outflow", 0.0, "m3/s"),
        Signal("tank.high", False),
        Signal("tank.low", True),
    ]
    assert bench.wires.interest == ("pump.speed", "pump.run", "tank.outlet")


def test_tank_in_which_nothing_moves_is_still() -> None:
    bench = Bench(initial_level_m=1.0)
    assert bench.clock.next_ns() is None
    bench.drive("tank.outlet", 50)
    assert bench.clock.next_ns() == 10 * MS
    bench.drive("tank.outlet", 0)
    bench.wait(1)
    assert bench.clock.next_ns() is None


@pytest.mark.long
def test_pump_fills_the_tank_by_its_speed(bench: Bench) -> None:
    bench.drive("pump.speed", 50)
    bench.wait(100)
    assert bench.point("level") == pytest.approx(0.0005 * 100 / 0.25, rel=1e-6)
    assert bench.point("volume") == pytest.approx(0.05, rel=1e-6)
    assert bench.published("tank.inflow") == [0.0, 0.0005]


def test_pump_turns_only_while_its_run_wire_says_so(bench: Bench) -> None:
    bench.drive("pump.speed", 100)
    bench.drive("pump.run", False, "")
    bench.wait(10)
    assert bench.point("level") == 0.0
    bench.drive("pump.run", True, "")
    bench.wait(10)
    assert bench.point("level") == pytest.approx(0.001 * 10 / 0.25, rel=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("step_ms", [3, 10, 700])
def test_draining_follows_the_closed_solution_whatever_the_step(step_ms: int) -> None:
    bench = Bench(initial_level_m=2.0, step_ms=step_ms)
    bench.drive("tank.outlet", 50)
    bench.wait(210)
    k = 0.62 * 1e-4 * math.sqrt(2 * 9.80665)
    root = math.sqrt(2.0) - k * 210 / (2 * 0.25)
    assert bench.point("level") == pytest.approx(root * root, rel=1e-6)


def test_input_counts_from_its_own_instant_and_not_from_the_next_step() -> None:
    bench = Bench(step_ms=1000)
    bench.drive("pump.speed", 100)
    bench.wait(0.25)
    bench.drive("pump.speed", 0)
    bench.wait(2)
    assert bench.point("level") == pytest.approx(0.001 * 0.25 / 0.25, rel=1e-9)


@pytest.mark.long
def test_level_comes_to_rest_where_the_flows_are_equal() -> None:
    bench = Bench(step_ms=1000)
    bench.drive("pump.speed", 50)
    bench.drive("tank.outlet", 100)
    bench.wait(20_000)
    rest_m = (0.0005 / (0.62 * 2e-4)) ** 2 / (2 * 9.80665)
    assert bench.point("level") == pytest.approx(rest_m, rel=1e-6)
    assert bench.point("outflow") == pytest.approx(0.0005, rel=1e-6)


def test_level_is_published_when_it_has_changed_by_its_resolution() -> None:
    bench = Bench(level_resolution_m=0.01)
    bench.drive("pump.speed", 100)  # 4 mm a second
    bench.wait(10)
    levels = bench.published("tank.level")
    assert len(levels) == 4
    assert all(0.01 < after - before < 0.0101 for before, after in itertools.pairwise(levels))


def test_tank_runs_over_at_its_rim() -> None:
    bench = Bench(initial_level_m=1.9)
    bench.drive("pump.speed", 100)
    bench.wait(100)
    assert bench.point("level") == 2.0
    assert bench.point("overflow") == pytest.approx(0.1 - 0.025, rel=1e-6)
    assert bench.point("overflows") == 1
    bench.drive("pump.speed", 0)
    bench.drive("tank.outlet", 100)
    bench.wait(1)
    bench.drive("tank.outlet", 0)
    bench.drive("pump.speed", 100)
    bench.wait(10)
    assert bench.point("overflows") == 2


def test_tank_runs_dry() -> None:
    bench = Bench(initial_level_m=0.01)
    bench.drive("tank.outlet", 100)
    bench.wait(200)
    assert bench.point("level") == 0.0
    assert bench.point("dry_runs") == 1
    assert bench.published("tank.level")[-1] == 0.0
    assert bench.published("tank.outflow")[-1] == 0.0
    assert bench.clock.next_ns() is None


def test_switches_close_at_their_levels_and_open_with_hysteresis() -> None:
    bench = Bench(initial_level_m=1.0, high_m=1.1, low_m=0.9, hysteresis_m=0.02)
    level = bench.tank.points()["level"].write
    assert level is not None
    for metres in (1.09, 1.1, 1.09, 1.081, 1.079, 0.91, 0.9, 0.91, 0.919, 0.921):
        level(metres)
    assert bench.published("tank.high") == [False, True, False]
    assert bench.published("tank.low") == [False, True, False]
    bench.wires.take()
    level(1.1)
    level(1.081)
    assert bench.published("tank.high") == [True]


def test_level_can_be_set_within_the_tank(bench: Bench) -> None:
    level = bench.tank.points()["level"].write
    assert level is not None
    level(1.5)
    assert bench.published("tank.level") == [0.0, 1.5]
    for wrong in (2.1, -0.1, "full", True):
        with pytest.raises(ValueError, match=r"expected a number from 0 to 2 m, got"):
            level(wrong)


@pytest.mark.parametrize(("percent", "inflow"), [(250, 0.001), (-5, 0.0)])
def test_speed_beyond_its_range_counts_as_its_end(bench: Bench, percent: float, inflow: float) -> None:
    bench.drive("pump.speed", percent)
    assert bench.point("inflow") == inflow


def test_wires_have_the_names_of_the_settings() -> None:
    bench = Bench(speed_wire="p2.speed", run_wire="p2.run", outlet_wire="v2", level_wire="b2.level")
    assert bench.wires.interest == ("p2.speed", "p2.run", "v2")
    assert bench.published("b2.level") == [0.0]


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ({"initial_level_m": 2.5}, "above the rim"),
        ({"high_m": 2.5}, "low_m must be below high_m"),
        ({"low_m": 1.9}, "low_m must be below high_m"),
        ({"area_m2": 0}, "greater than 0"),
        ({"step_ms": 0}, "greater than or equal to 1"),
        ({"discharge_coefficient": 1.5}, "less than or equal to 1"),
        ({"colour": "red"}, "Extra inputs"),
    ],
)
def test_wrong_settings_are_refused(settings: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValidationError, match=complaint):
        TankSettings(**{**LAB, **settings})


def test_a_leak_drains_the_tank_by_torricellis_law_while_it_lasts() -> None:
    """The root of the level falls by c * a * sqrt(2 g) / (2 A) per second."""
    bench = Bench(initial_level_m=1.0)
    bench.tank.add_fault({"what": "leak", "area_m2": 2e-4, "start_ms": 1_000, "duration_ms": 20_000})
    bench.wait(1)
    assert bench.point("level") == 1.0
    bench.wait(20)
    root = 1.0 - 20 * 0.62 * 2e-4 * math.sqrt(2 * 9.80665) / (2 * 0.25)
    assert bench.point("level") == pytest.approx(root * root, rel=1e-9)
    bench.wait(10)
    assert bench.point("level") == pytest.approx(root * root, rel=1e-9)
    assert (bench.point("leak"), bench.point("outflow"), bench.clock.next_ns()) == (0.0, 0.0, None)


def test_two_leaks_drain_as_one_of_their_area() -> None:
    twice, once = Bench(initial_level_m=1.0), Bench(initial_level_m=1.0)
    for _ in range(2):
        twice.tank.add_fault({"what": "leak", "area_m2": 1e-4})
    once.tank.add_fault({"what": "leak", "area_m2": 2e-4})
    twice.wait(5)
    once.wait(5)
    assert twice.point("level") == pytest.approx(float(once.point("level")), rel=1e-9)


def test_nothing_leaves_a_blocked_outlet() -> None:
    bench = Bench(initial_level_m=1.0)
    bench.drive("tank.outlet", 100)
    number = bench.tank.add_fault({"what": "blocked_outlet"})
    bench.wait(5)
    assert (bench.point("level"), bench.point("outflow"), bench.point("outlet")) == (1.0, 0.0, 100.0)
    bench.drive("tank.outlet", 50)
    assert bench.published("tank.outflow")[-1] == 0.0
    bench.tank.clear_fault(number)
    assert bench.published("tank.outflow")[-1] == pytest.approx(0.62 * 1e-4 * math.sqrt(2 * 9.80665))


def test_a_stuck_sensor_shows_the_same_level(bench: Bench) -> None:
    bench.drive("pump.speed", 100)
    bench.wait(10)
    number = bench.tank.add_fault({"what": "stuck_sensor"})
    shown = bench.published("tank.level")
    bench.wait(10)
    assert bench.published("tank.level") == shown
    assert bench.point("level") == pytest.approx(20 * 0.001 / 0.25)
    bench.tank.clear_fault(number)
    assert bench.published("tank.level")[-1] == pytest.approx(0.08)
    bench.tank.add_fault({"what": "stuck_sensor", "level_m": 1.5, "duration_ms": 100})
    bench.wait(0.05)
    assert bench.published("tank.level")[-1] == 1.5
    bench.wait(0.1)
    assert bench.published("tank.level")[-1] < 0.1


@pytest.mark.parametrize(("switch", "level_m", "open_m"), [("high", 1.9, 1.0), ("low", 0.1, 1.0)])
def test_a_stuck_switch_stays_as_it_is(switch: str, level_m: float, open_m: float) -> None:
    bench = Bench(initial_level_m=level_m)
    level = bench.tank.points()["level"]
    assert level.write is not None
    number = bench.tank.add_fault({"what": "stuck_switch", "switch": switch})
    level.write(open_m)
    assert bench.point(switch) is True
    assert bench.published(f"tank.{switch}") == [True]
    bench.tank.clear_fault(number)
    assert bench.published(f"tank.{switch}") == [True, False]
    bench.tank.add_fault({"what": "stuck_switch", "switch": switch, "shows": True, "duration_ms": 1})
    assert bench.published(f"tank.{switch}")[-1] is True
    bench.wait(0.002)
    assert bench.published(f"tank.{switch}")[-1] is False
