"""Homing methods as the figures of CiA 402-2 show them: switches at -300 000, 0 to 100 000, and 400 000."""

import pytest
from cia402_bench import Cia402Bench
from homing_table import EDGES, HOME_BEGINS, HOME_ENDS, NEGATIVE, POSITIVE, REVOLUTION, ZEROS, switches

pytestmark = pytest.mark.long

HM = 6
SLOW_STEP = 50_000 * 0.004
"""Distance in a cycle at the slow speed of 6099h."""


@pytest.fixture
def bench() -> Cia402Bench:
    bench = Cia402Bench()
    bench.motor.switches = switches
    bench.motor.revolution = REVOLUTION
    return bench


def home(bench: Cia402Bench, method: int, begin: int, offset: int = 0) -> int:
    """Home by a method, and return the user's zero in increments."""
    bench.motor.position = begin
    bench.put(0x6098, method).put(0x607C, offset).enabled(HM)
    assert bench.status(0x3400) == 0x0400
    assert bench.control(0x1F).status(0x3000) in (0, 0x1000)
    bench.cycles_until(lambda: bench.axis.status_word & 0x3400 == 0x1400)
    assert bench.cycles(1).motor.velocity == 0
    zero: int = bench.get(0x6063) - bench.get(0x6064)
    return zero


@pytest.mark.parametrize(("method", "begin", "edge"), EDGES)
def test_home_is_the_edge_of_the_switch(bench: Cia402Bench, method: int, begin: int, edge: int) -> None:
    assert home(bench, method, begin) == pytest.approx(edge, abs=2 * SLOW_STEP)


@pytest.mark.parametrize(("method", "begin", "zero"), ZEROS)
def test_home_is_the_zero_of_the_encoder(bench: Cia402Bench, method: int, begin: int, zero: int) -> None:
    assert home(bench, method, begin) == zero


@pytest.mark.parametrize(("method", "edge"), [(23, 0), (24, 0), (25, 4_000), (26, 4_000), (27, 4_000), (30, 0)])
@pytest.mark.parametrize("begin", [-100_000, 100_000])
def test_a_switch_that_is_overrun_is_found_on_the_way_back(
    bench: Cia402Bench, method: int, edge: int, begin: int
) -> None:
    """4000 increments wide, and 25 000 are needed to stop in."""
    bench.motor.switches = lambda position: switches(position) & 3 | (0 <= position <= 4_000) << 2
    bench.put(0x609A, 5_000_000)
    assert home(bench, method, begin) == pytest.approx(edge, abs=2_200)


# Which way the axis starts: 7 to 10 up and 11 to 14 down, but off the switch if it is on it (figures of the methods).
@pytest.mark.parametrize(
    ("method", "begin", "sign"),
    [
        *((method, -100_000, 1) for method in (3, 4, 7, 8, 9, 10, 23, 26)),
        *((method, 200_000, -1) for method in (5, 6, 11, 12, 13, 14, 27, 30)),
        *((method, 200_000, 1) for method in (7, 8, 9, 10)),
        *((method, -100_000, -1) for method in (11, 12, 13, 14)),
        *((method, 50_000, -1) for method in (3, 4, 7, 8, 13, 14)),
        *((method, 50_000, 1) for method in (5, 6, 9, 10, 11, 12)),
        (7, 450_000, -1),
        (11, -350_000, 1),
    ],
)
def test_the_direction_of_the_start(bench: Cia402Bench, method: int, begin: int, sign: int) -> None:
    bench.motor.position = begin
    bench.put(0x6098, method).enabled(HM).control(0x1F).cycles(3)
    assert bench.motor.velocity * sign > 0


def test_a_search_without_a_home_switch_fails_at_the_second_limit_switch(bench: Cia402Bench) -> None:
    bench.motor.switches = lambda position: switches(position) & 3
    bench.put(0x6098, 7).enabled(HM).control(0x1F)
    bench.cycles_until(lambda: bench.motor.position > POSITIVE)
    bench.cycles_until(lambda: bench.status(0x2400) == 0x2400)
    assert bench.motor.position == pytest.approx(NEGATIVE, abs=30_000)


def test_the_switch_is_looked_for_fast_and_its_edge_slowly(bench: Cia402Bench) -> None:
    bench.motor.position = -250_000
    bench.put(0x6098, 24).enabled(HM).control(0x1F)
    speeds: list[float] = []
    while not bench.status(0x1000):
        speeds.append(bench.cycles(1).motor.velocity)
    assert max(speeds) == pytest.approx(500_000)
    assert speeds[-3] == pytest.approx(50_000)


def test_an_error_is_followed_by_a_new_start(bench: Cia402Bench) -> None:
    bench.motor.position = 200_000
    bench.put(0x6098, 19).enabled(HM).control(0x1F)
    bench.cycles_until(lambda: bench.status(0x2400) == 0x2400)
    bench.put(0x6098, 25).control(0x0F)
    assert bench.status(0x3400) == 0x2400
    assert bench.control(0x1F).status(0x3400) == 0
    bench.cycles_until(lambda: bench.status(0x3400) == 0x1400)


@pytest.mark.parametrize("method", [35, 37])
def test_home_is_where_the_axis_stands(bench: Cia402Bench, method: int) -> None:
    assert home(bench, method, 12_345) == 12_345
    assert bench.get(0x6064) == 0


def test_zero_lies_by_the_home_offset_beyond_home(bench: Cia402Bench) -> None:
    assert home(bench, 35, 12_345, offset=1_000) == 13_345
    assert bench.get(0x6064) == -1_000


def test_the_time_that_a_search_takes(bench: Cia402Bench) -> None:
    """To the switch at 500 000/s and back over what was overrun at 50 000/s, with 5 000 000/s2."""
    bench.put(0x6098, 17).enabled(HM).control(0x1F)
    count = bench.cycles_until(lambda: bench.status(0x1000) != 0)
    to_switch_s = 0.1 + (300_000 - 25_000) / 500_000
    overrun = 500_000 * 500_000 / 2 / 5_000_000
    back_s = 0.1 + 0.01 + (overrun - 250) / 50_000
    assert count == pytest.approx((to_switch_s + back_s) / 0.004, abs=15)


def test_a_search_that_comes_to_the_wrong_limit_switch_fails(bench: Cia402Bench) -> None:
    bench.motor.position = 200_000  # above the home switch, so method 19 never finds it
    bench.put(0x6098, 19).enabled(HM).control(0x1F)
    bench.cycles_until(lambda: bench.status(0x2000) != 0)
    assert bench.status(0x3400) == 0x2000  # not at rest yet
    bench.cycles(100)
    assert bench.status(0x3400) == 0x2400
    assert bench.get(0x6063) == pytest.approx(POSITIVE, abs=30_000)


def test_a_fallen_bit_4_interrupts(bench: Cia402Bench) -> None:
    bench.put(0x6098, 17).enabled(HM).control(0x1F).cycles(50)
    assert bench.status(0x3400) == 0
    bench.control(0x0F).cycles(50)
    assert (bench.status(0x3400), bench.motor.velocity) == (0x0400, 0)


def test_a_halt_is_gone_on_from(bench: Cia402Bench) -> None:
    bench.put(0x6098, 17).enabled(HM).control(0x1F).cycles(50).control(0x011F).cycles(60)
    assert (bench.status(0x3400), bench.motor.velocity) == (0x0400, 0)
    bench.control(0x1F)
    bench.cycles_until(lambda: bench.status(0x1400) == 0x1400)
    assert bench.motor.position == pytest.approx(NEGATIVE, abs=3_000)


def test_an_edge_that_is_passed_while_halting_is_found_all_the_same(bench: Cia402Bench) -> None:
    bench.motor.position = -100_000
    bench.put(0x6084, 1_000_000).put(0x6098, 23).enabled(HM).control(0x1F)
    bench.cycles_until(lambda: bench.motor.position > -1_000)
    bench.control(0x011F).cycles(200)
    assert (bench.motor.velocity, bench.motor.position > HOME_ENDS) == (0, True)
    bench.control(0x1F)
    bench.cycles_until(lambda: bench.status(0x3400) == 0x1400)
    assert bench.get(0x6063) - bench.get(0x6064) == pytest.approx(HOME_BEGINS, abs=2 * SLOW_STEP)


def test_a_slow_edge_that_is_passed_while_halting_is_looked_for_again(bench: Cia402Bench) -> None:
    bench.motor.position = 50_000
    bench.put(0x6084, 100_000).put(0x6098, 23).enabled(HM).control(0x1F)
    bench.cycles_until(lambda: bench.motor.position < 1_000)
    bench.control(0x011F).cycles(200)
    assert (bench.motor.velocity, bench.motor.position < 0) == (0, True)
    bench.control(0x1F)
    bench.cycles_until(lambda: bench.status(0x3400) == 0x1400)
    assert bench.get(0x6063) - bench.get(0x6064) == pytest.approx(HOME_BEGINS, abs=2 * SLOW_STEP)


def test_a_zero_that_is_passed_the_other_way_is_none(bench: Cia402Bench) -> None:
    """It still goes up when method 33 begins, which looks downwards."""
    bench.motor.switches = lambda position: 0
    bench.put(0x6083, 1_000_000_000).put(0x60FF, 1_000_000).enabled(3).cycles(15)
    assert 50_000 < bench.motor.position < 70_000
    bench.put(0x6098, 33).put(0x6060, HM).control(0x0F).control(0x1F)
    farthest = max(bench.cycles(1).motor.position for _ in range(60))
    bench.cycles_until(lambda: bench.status(0x3400) == 0x1400)
    assert bench.get(0x6063) - bench.get(0x6064) == farthest // 70_000 * 70_000


def test_an_origin_counts_no_more_when_a_search_for_another_began(bench: Cia402Bench) -> None:
    home(bench, 35, 0)
    bench.control(0x0F).put(0x6098, 17).control(0x1F).cycles(20).put(0x6060, 1).cycles(100).put(0x6060, HM)
    assert bench.status(0x3400) == 0x0400


def test_an_axis_that_is_homed_says_so_when_the_mode_comes_back(bench: Cia402Bench) -> None:
    home(bench, 35, 0)
    bench.control(0x0F).put(0x6060, 1).put(0x6060, HM)
    assert bench.status(0x3400) == 0x1400


def test_method_0_is_no_homing_and_leaves_the_origin_where_it_is(bench: Cia402Bench) -> None:
    """A master writes 0 for an axis that needs no homing, such as an axis with an absolute encoder."""
    home(bench, 35, 12_345)
    bench.control(0x06).cycles(1)
    bench.motor.position = 20_000
    bench.put(0x6098, 0).enabled(HM).control(0x1F).cycles(2)
    assert (bench.status(0x3400), bench.get(0x6064)) == (0x1400, 20_000 - 12_345)


@pytest.mark.parametrize("method", [15, 16, 31, 32, 36, 38, -1])
def test_a_method_that_is_not_there_is_refused(bench: Cia402Bench, method: int) -> None:
    assert bench.try_put(0x6098, method) == "06090030"


def test_the_methods_are_listed(bench: Cia402Bench) -> None:
    listed = [bench.get(0x60E3, sub) for sub in range(1, bench.get(0x60E3) + 1)]
    assert listed == [*range(1, 15), *range(17, 31), 33, 34, 35, 37]
