"""Every homing method on a motor with inertia and friction, against the figures of CiA 402-2 (`homing_table`).

The engine alone is tested from every place of the table; here each method has one of them.
"""

from math import tau

import pytest
from homing_table import EDGES, HOME_BEGINS, HOME_ENDS, NEGATIVE, POSITIVE, REVOLUTION, WITHOUT_MOVES, ZEROS
from single_drive_bench import SingleDriveBench

from fieldrig_devices.cia402.homing_methods import STANDARD_METHODS

pytestmark = pytest.mark.long

HM = 6
FAR = 10_000_000
RAD = tau / REVOLUTION
SLOW_STEP = 50_000 * 0.004
"""Distance in a cycle at the slow speed of 6099h."""
CASES = {method: (begin, home) for method, begin, home in (*EDGES[::-1], *ZEROS[::-1], *WITHOUT_MOVES)}
"""The first place of the table for each method."""


def machine(begin: int) -> SingleDriveBench:
    """The machine of the table, whose units are those of the drive by its feed constant."""
    switches = {
        "negative_limit": {"low": -FAR * RAD, "high": NEGATIVE * RAD},
        "positive_limit": {"low": POSITIVE * RAD, "high": FAR * RAD},
        "home": {"low": HOME_BEGINS * RAD, "high": HOME_ENDS * RAD},
    }
    bench = SingleDriveBench(switches=switches, initial_position_rad=begin * RAD, cycle_us=4_000)
    return bench.put(0x6092, REVOLUTION, 1).put(0x6099, 500_000, 1).put(0x6099, 50_000, 2)


def test_the_table_has_every_method_of_the_standard() -> None:
    assert CASES.keys() == STANDARD_METHODS


@pytest.mark.parametrize("method", CASES)
def test_a_method_finds_the_home_of_its_figure(method: int) -> None:
    begin, home = CASES[method]
    bench = machine(begin)
    bench.put(0x6098, method).put(0x607C, 500).put(0x6060, HM).control(0x06).control(0x07).control(0x0F).after(8)
    bench.control(0x1F)
    bench.until(lambda: bench.drive.axis.status_word & 0x3400 == 0x1400)
    bench.after(100)
    place = round(bench.read("position") / RAD)
    found = place - bench.get(0x6064) - 500  # at home the position is -607Ch
    is_exact = method < 15 or method > 30
    assert found == pytest.approx(home, abs=3 if is_exact else 2 * SLOW_STEP)


@pytest.mark.parametrize("slow", [1_000, 137])
def test_a_slow_speed_misses_no_edge(slow: int) -> None:
    """A cycle of 1 ms has less than one increment of this encoder."""
    bench = SingleDriveBench(switches={"home": {"low": 3.0, "high": 100.0}}, encoder_increments=4_096)
    bench.put(0x6092, 4_096, 1).put(0x6099, 4_096, 1).put(0x6099, slow, 2).put(0x609A, 40_960)
    bench.put(0x6098, 19).put(0x6060, HM).control(0x06).control(0x07).control(0x0F).after(8)
    bench.control(0x1F)
    bench.until(lambda: bench.drive.axis.status_word & 0x3400 == 0x1400)
    assert bench.read("position") - bench.get(0x6064) * tau / 4_096 == pytest.approx(3.0, abs=0.01)


def edge_cases() -> list[tuple[float, int, float]]:
    """The two edges of a home switch from 2 to 3 rad as places of the start, with methods that find them."""
    lower = [19, 20, 23, 24, 29, 30]
    upper = [21, 22, 25, 26, 27, 28]
    from_inside = [(2.0, method, home) for methods, home in ((lower, 2.0), (upper, 3.0)) for method in methods]
    from_outside = [(3.0, method, home) for methods, home in ((lower[2:], 2.0), (upper, 3.0)) for method in methods]
    return from_inside + from_outside


@pytest.mark.parametrize(("begin", "method", "home"), edge_cases())
def test_an_axis_that_stands_at_the_very_edge_of_the_switch_finds_home(begin: float, method: int, home: float) -> None:
    """The switch opens before the encoder counts the first increment of the way."""
    switches = {"home": {"low": 2.0, "high": 3.0}, "negative_limit": {"low": -99.0, "high": -8.0}}
    bench = SingleDriveBench(
        switches={**switches, "positive_limit": {"low": 8.0, "high": 99.0}}, initial_position_rad=begin
    )
    bench.put(0x6099, 500_000, 1).put(0x6099, 50_000, 2).put(0x609A, 2_000_000)
    bench.put(0x6098, method).put(0x6060, HM).control(0x06).control(0x07).control(0x0F).after(8)
    bench.control(0x1F)
    bench.until(lambda: bench.drive.axis.status_word & 0x3400 in (0x1400, 0x2400))
    assert bench.read("position") - bench.get(0x6064) * tau / 1_000_000 == pytest.approx(home, abs=0.002)
