"""Limit switches at -300 000 and 400 000 increments, in every mode: stopped in time, held, and let out again."""

from itertools import pairwise

import pytest
from cia402_bench import Cia402Bench

pytestmark = pytest.mark.long

PP, PV, PT, HM, IP, CSP, CSV, CST = 1, 3, 4, 6, 7, 8, 9, 10
NEGATIVE, POSITIVE = -300_000, 400_000
SPEED = 2_000_000
STOPPING = SPEED**2 // (2 * 100_000_000) + SPEED * 3 // 250
"""Distance of a stop with 6085h, including the cycles in which the switch is detected."""


def switches(position: int) -> int:
    return (position <= NEGATIVE) | (position >= POSITIVE) << 1


@pytest.fixture
def bench() -> Cia402Bench:
    bench = Cia402Bench()
    bench.motor.switches = switches
    return bench


class Master:
    """It wants to go in a direction with 2 000 000 increments a second, in any mode."""

    def __init__(self, bench: Cia402Bench, mode: int) -> None:
        self.bench, self.mode = bench, mode
        self._place = 0
        bench.put(0x6081, SPEED).put(0x60C2, 4, 1).enabled(mode)

    def go(self, direction: int, cycles: int) -> None:
        bench = self.bench
        for cycle in range(cycles):
            if self.mode == PP and cycle == 0:
                bench.put(0x607A, direction * 900_000).control(0x2F).control(0x3F)
            elif self.mode == CSV or (self.mode == PV and cycle == 0):
                bench.put(0x60FF, direction * SPEED)
            elif self.mode in (CSP, IP):
                self._place += direction * SPEED // 250
                bench.put(*((0x607A, self._place) if self.mode == CSP else (0x60C1, self._place, 1)))
                if self.mode == IP and cycle == 0:
                    bench.control(0x1F)
            bench.cycles(1)


@pytest.mark.parametrize("mode", [PP, PV, IP, CSP, CSV])
@pytest.mark.parametrize(("direction", "switch"), [(-1, NEGATIVE), (1, POSITIVE)])
def test_an_axis_stops_at_the_limit_switch_and_comes_out_again(
    bench: Cia402Bench, mode: int, direction: int, switch: int
) -> None:
    master = Master(bench, mode)
    master.go(direction, 20)
    assert bench.status(0x0800) == 0
    master.go(direction, 130)
    assert (bench.motor.velocity, bench.status(0x086F)) == (0, 0x0827)
    stands = bench.motor.position
    assert 0 <= (stands - switch) * direction <= STOPPING
    master.go(direction, 3)
    assert bench.motor.position == stands
    places = [stands]
    while (places[-1] - switch) * direction >= 0:
        master.go(-direction, 1)
        places.append(bench.motor.position)
        assert len(places) < 200
    assert all((after - before) * direction <= 0 for before, after in pairwise(places))
    assert bench.status(0x086F) == 0x0027


@pytest.mark.parametrize("mode", [PP, PV, IP, CSP, CSV])
def test_an_axis_stays_barred_when_it_overruns_a_short_switch(bench: Cia402Bench, mode: int) -> None:
    bench.motor.switches = lambda position: (POSITIVE <= position <= POSITIVE + 9_000) << 1
    Master(bench, mode).go(1, 150)
    assert bench.motor.position > POSITIVE + 9_000
    assert (bench.motor.velocity, bench.status(0x0800)) == (0, 0x0800)


@pytest.mark.parametrize("mode", [PP, PV, CSP, CSV])
def test_an_axis_that_stands_on_a_limit_switch_goes_out_only(bench: Cia402Bench, mode: int) -> None:
    bench.motor.position = POSITIVE + 10
    master = Master(bench, mode)
    master._place = POSITIVE + 10
    master.go(1, 5)
    assert (bench.motor.position, bench.status(0x0800)) == (POSITIVE + 10, 0x0800)
    master.go(-1, 20)
    assert bench.motor.position < POSITIVE + 10
    assert bench.status(0x0800) == 0


@pytest.mark.parametrize(("mode", "follows"), [(CSP, 0x1000), (CSV, 0x1000)])
def test_an_axis_that_is_held_does_not_follow(bench: Cia402Bench, mode: int, follows: int) -> None:
    master = Master(bench, mode)
    master.go(1, 20)
    assert bench.status(0x1000) == follows
    master.go(1, 130)
    assert bench.status(0x1000) == 0


def test_ip_what_lies_behind_a_limit_switch_is_not_reached(bench: Cia402Bench) -> None:
    Master(bench, IP).go(1, 150)
    assert bench.cycles(10).status(0x0400) == 0


def test_an_axis_that_is_to_stand_on_a_limit_switch_is_not_held(bench: Cia402Bench) -> None:
    bench.motor.position = NEGATIVE - 10
    bench.put(0x60FF, 0).enabled(PV).cycles(3)
    assert bench.status(0x0800) == 0


def test_csp_a_way_back_into_a_limit_switch_is_none(bench: Cia402Bench) -> None:
    bench.motor.position = place = POSITIVE + 50_000
    bench.put(0x60C2, 4, 1).enabled(CSP)
    for _ in range(10):
        place -= 2_000
        bench.put(0x607A, place).cycles(1)
    stands = bench.motor.position
    assert bench.put(0x607A, POSITIVE + 50_000).cycles(5).motor.position == stands


def test_csv_a_speed_below_that_of_the_stop_is_kept_to(bench: Cia402Bench) -> None:
    bench.put(0x60C2, 4, 1).put(0x6085, 1_000_000).enabled(CSV).put(0x60FF, SPEED)
    bench.cycles_until(lambda: bench.motor.position > POSITIVE)
    assert bench.cycles(2).motor.velocity > SPEED - 20_000
    assert 0 <= bench.put(0x60FF, 1_000).cycles(2).motor.velocity <= 1_000


def test_pv_turning_round_does_not_spare_the_quick_stop(bench: Cia402Bench) -> None:
    bench.put(0x60FF, SPEED).enabled(PV)
    bench.cycles_until(lambda: bench.motor.position > POSITIVE)
    bench.put(0x60FF, -SPEED)
    farthest = max(bench.cycles(1).motor.position for _ in range(20))
    assert farthest - POSITIVE <= STOPPING
    bench.cycles_until(lambda: bench.motor.position < POSITIVE)
    assert bench.cycles(1).motor.velocity < 0


def test_pp_a_halt_does_not_bring_a_set_point_back(bench: Cia402Bench) -> None:
    Master(bench, PP).go(1, 150)
    stands = bench.motor.position
    assert bench.control(0x010F).cycles(2).control(0x0F).cycles(20).motor.position == stands


def test_pp_near_is_not_reached_if_a_limit_switch_is_before_it(bench: Cia402Bench) -> None:
    bench.put(0x6081, 100_000).enabled(PP).put(0x607A, POSITIVE + 900).control(0x1F).cycles(1_200)
    assert POSITIVE <= bench.motor.position < POSITIVE + 900
    assert bench.status(0x0C00) == 0x0800


def test_another_mode_is_not_shown_to_be_held(bench: Cia402Bench) -> None:
    Master(bench, PV).go(1, 150)
    assert bench.put(0x6060, HM).status(0x0800) == 0


@pytest.mark.parametrize("mode", [PT, CST])
def test_an_axis_without_torque_is_stopped_too(bench: Cia402Bench, mode: int) -> None:
    bench.put(0x6085, 1_000_000).enabled(mode).cycles(2)
    bench.motor.position, bench.motor.velocity = POSITIVE + 5, 50_000.0
    assert bench.cycles(3).status(0x1C00) == 0x0800
    assert 0 < bench.motor.velocity < 50_000
    bench.cycles(40)
    assert bench.status(0x0800) == 0
    assert bench.motor.velocity <= 500  # of the last cycle of the ramp


def test_pp_a_set_point_behind_a_limit_switch_is_given_up(bench: Cia402Bench) -> None:
    bench.put(0x6081, SPEED).enabled(PP).put(0x607A, 900_000).control(0x1F).control(0x0F)
    bench.put(0x607A, 950_000).control(0x1F).control(0x0F)
    assert bench.status(0x1000) == 0x1000  # one is in the buffer
    bench.cycles(200)
    assert bench.status(0x1C00) == 0x0800  # the buffer is free, the target not reached
    bench.put(0x607A, 0).control(0x1F)
    assert bench.status(0x1000) == 0x1000
    bench.cycles_until(lambda: bench.status(0x0C00) == 0x0400)
    assert bench.motor.position == 0


@pytest.mark.parametrize("mode", [PT, CST])
def test_torque_into_a_limit_switch_is_a_stop(bench: Cia402Bench, mode: int) -> None:
    bench.put(0x6087, 100_000).enabled(mode).put(0x6071, 300).cycles(5)
    assert bench.motor.torque == 300
    bench.motor.position, bench.motor.velocity = POSITIVE + 5, 500_000.0
    bench.cycles(10)
    assert (bench.motor.velocity, bench.status(0x0827)) == (0, 0x0827)
    assert bench.get(0x6074) == 0
    assert POSITIVE + 5 < bench.motor.position < POSITIVE + 5_000
    bench.put(0x6071, -300).cycles(2)
    assert (bench.motor.torque, bench.status(0x0800)) == (-300, 0)


@pytest.mark.parametrize("mode", [CSV, PT, CST])
def test_software_limits_hold_where_no_positions_are_given(bench: Cia402Bench, mode: int) -> None:
    bench.motor.switches = lambda position: 0
    bench.put(0x607D, -200_000, 1).put(0x607D, 200_000, 2).put(0x6087, 100_000).enabled(mode)
    bench.motor.position, bench.motor.velocity = 199_000, 500_000.0
    bench.put(0x60FF, 500_000).put(0x6071, 100).cycles(3)
    bench.motor.position += 2_000
    bench.cycles(10)
    assert (bench.motor.velocity, bench.status(0x0800)) == (0, 0x0800)
    stands = bench.motor.position
    bench.put(0x60FF, -500_000).put(0x6071, -100).cycles(10)
    assert bench.motor.position < stands or bench.motor.torque < 0


def test_a_cyclic_mode_that_begins_in_motion_comes_to_rest_until_it_is_led(bench: Cia402Bench) -> None:
    bench.put(0x60FF, 300_000).enabled(PV).cycles(20).put(0x6060, CSP)
    bench.cycles(1)
    assert bench.motor.velocity == pytest.approx(300_000 - 20_000)  # the mean of the cycle
    assert bench.cycles(10).motor.velocity == 0


def test_pv_who_stops_at_a_software_limit_may_turn_round(bench: Cia402Bench) -> None:
    """2 000 000 a second and 6084h at first: 2 s and 2 000 000 increments to rest."""
    bench.put(0x607D, -2_000_000, 1).put(0x607D, 3_000_000, 2).put(0x6084, 1_000_000).put(0x60FF, SPEED)
    bench.motor.switches = lambda position: 0
    bench.enabled(PV)
    bench.cycles_until(lambda: bench.status(0x0800) != 0)
    assert bench.motor.velocity > 0
    bench.put(0x60FF, -100_000).cycles(600)
    assert (bench.motor.velocity, bench.status(0x0800)) == (-100_000, 0)


@pytest.mark.parametrize("ahead", [0, 1_000, 30_000, 60_000])
def test_pv_a_software_limit_near_by_is_not_overrun(bench: Cia402Bench, ahead: int) -> None:
    bench.put(0x607D, -200_000, 1).put(0x607D, ahead, 2).put(0x6083, 50_000_000).put(0x6084, 50_000_000)
    bench.put(0x60FF, SPEED).enabled(PV)
    places = [bench.cycles(1).motor.position for _ in range(250)]
    assert max(places) == places[-1] == ahead


@pytest.mark.parametrize("mode", [CSP, IP])
def test_cyclic_set_points_bring_an_axis_back_into_the_software_limits_at_their_own_pace(
    bench: Cia402Bench, mode: int
) -> None:
    """It stands 50 000 beyond one; no set-point of the master is a jump."""
    bench.motor.switches = lambda position: 0
    bench.motor.position = 250_000
    bench.put(0x607D, -200_000, 1).put(0x607D, 200_000, 2).put(0x60C2, 4, 1).enabled(mode).control(0x1F)
    for place, stands, limit in ((250_000, 250_000, 0x0800), (251_000, 250_000, 0x0800), (249_000, 249_000, 0x0800)):
        bench.put(*((0x607A, place) if mode == CSP else (0x60C1, place, 1))).cycles(1)
        assert (bench.motor.position, bench.status(0x0800)) == (stands, limit)
    for place in range(248_000, 198_000, -1_000):
        bench.put(*((0x607A, place) if mode == CSP else (0x60C1, place, 1))).cycles(1)
    assert (bench.motor.position, bench.status(0x0800)) == (199_000, 0)
    bench.put(*((0x607A, 201_000) if mode == CSP else (0x60C1, 201_000, 1))).cycles(1)
    assert (bench.motor.position, bench.status(0x0800)) == (200_000, 0x0800)
