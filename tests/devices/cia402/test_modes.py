"""Set-points, handshakes and status bits of each mode of operation (CiA 402-2), against closed solutions."""

import math
from itertools import pairwise

import pytest
from cia402_bench import Cia402Bench

pytestmark = pytest.mark.long

PP, PV, PT, HM, IP, CSP, CSV, CST = 1, 3, 4, 6, 7, 8, 9, 10
CYCLE_S = 0.004
V, A, D = 1_000_000, 10_000_000, 10_000_000
"""Start values of 6081h, 6083h, 6084h."""


@pytest.fixture
def bench() -> Cia402Bench:
    return Cia402Bench()


def trapezoid_s(way: float, v: float = V, a: float = A, d: float = D) -> float:
    """Duration of a move from rest to rest."""
    peak = min(v, math.sqrt(2 * a * d * way / (a + d)))
    ramps = peak * peak / (2 * a) + peak * peak / (2 * d)
    return peak / a + peak / d + (way - ramps) / peak


def reached(bench: Cia402Bench) -> int:
    """Cycles until bit 10."""
    return bench.cycles_until(lambda: bench.status(0x0400) != 0)


# ---- profile position


@pytest.mark.parametrize("way", [1, 50_000, 100_000, 1_000_000, 20_000_000])
def test_pp_takes_the_time_of_the_trapezoid(bench: Cia402Bench, way: int) -> None:
    bench.put(0x607A, way).put(0x6067, 0).enabled(PP).control(0x1F)
    assert reached(bench) == pytest.approx(trapezoid_s(way) / CYCLE_S, abs=2)
    assert bench.motor.position == way


def test_pp_handshake_of_a_single_set_point(bench: Cia402Bench) -> None:
    bench.put(0x607A, 1_000_000).enabled(PP)
    assert bench.status(0x1400) == 0x0400
    assert bench.control(0x1F).status(0x1400) == 0x1000
    assert bench.cycles(1).status(0x1400) == 0x1000
    assert bench.control(0x0F).status(0x1400) == 0x0000
    reached(bench)
    assert bench.status(0x1400) == 0x0400


def test_pp_one_set_point_is_buffered_and_a_third_is_not_taken(bench: Cia402Bench) -> None:
    bench.enabled(PP).put(0x607A, 1_000_000).control(0x1F).control(0x0F)
    bench.put(0x607A, 2_000_000).control(0x1F).control(0x0F)
    assert bench.status(0x1000) == 0x1000  # the buffer is full
    bench.put(0x607A, 9_000_000).control(0x1F).control(0x0F)
    count = reached(bench)
    assert bench.motor.position == 2_000_000
    assert count == pytest.approx(2 * trapezoid_s(1_000_000) / CYCLE_S, abs=3)
    assert bench.status(0x1000) == 0


def test_pp_change_set_immediately(bench: Cia402Bench) -> None:
    bench.enabled(PP).put(0x607A, 9_000_000).control(0x3F).control(0x2F).cycles(250)
    assert bench.motor.position == pytest.approx(950_000, abs=5_000)
    bench.put(0x607A, -500_000).control(0x3F).control(0x2F)
    reached(bench)
    assert bench.motor.position == -500_000


def test_pp_change_on_set_point_drives_through(bench: Cia402Bench) -> None:
    bench.enabled(PP).put(0x607A, 1_000_000).control(0x1F).control(0x0F)
    bench.put(0x607A, 2_000_000).control(0x021F).control(0x020F)
    speeds: list[float] = []
    while not bench.status(0x0400):
        speeds.append(bench.cycles(1).motor.velocity)
    count = len(speeds)
    assert count == pytest.approx(trapezoid_s(2_000_000) / CYCLE_S, abs=3)
    assert min(speeds[40:450]) == pytest.approx(V, rel=1e-3)
    assert bench.motor.position == 2_000_000


@pytest.mark.parametrize(("option", "target"), [(0, 1_500_000), (1, 950_000), (2, 950_000)])
def test_pp_what_a_relative_set_point_counts_from(bench: Cia402Bench, option: int, target: int) -> None:
    bench.put(0x60F2, option).enabled(PP).put(0x607A, 1_000_000).control(0x1F).control(0x0F).cycles(125)
    bench.put(0x607A, 500_000).control(0x7F)
    reached(bench)
    assert bench.motor.position == pytest.approx(target, abs=5_000)


def test_pp_halt_keeps_the_set_point(bench: Cia402Bench) -> None:
    bench.enabled(PP).put(0x607A, 2_000_000).control(0x1F).control(0x010F).cycles(1)
    bench.control(0x0F).cycles(200).control(0x010F).cycles(60)
    halted = bench.motor.position
    assert (bench.status(0x0400), 0 < halted < 2_000_000) == (0x0400, True)
    bench.control(0x0F).cycles(1)
    assert bench.status(0x0400) == 0
    reached(bench)
    assert bench.motor.position == 2_000_000


def test_pp_set_point_counts_with_the_edge_only(bench: Cia402Bench) -> None:
    bench.enabled(PP).put(0x607A, 1_000).control(0x1F)
    reached(bench)
    bench.put(0x607A, 2_000).control(0x1F).cycles(100)
    assert bench.motor.position == 1_000


def test_pp_a_set_point_before_operation_is_none(bench: Cia402Bench) -> None:
    bench.put(0x6060, PP).put(0x607A, 1_000).control(0x06).control(0x17)
    assert bench.status(0x1000) == 0
    bench.control(0x1F).cycles(100)
    assert bench.motor.position in (0, 1_000)


def test_pp_software_limits_with_home_offset(bench: Cia402Bench) -> None:
    """607Dh is corrected by 607Ch: 100 000 - 25 000."""
    bench.put(0x607D, -100_000, 1).put(0x607D, 100_000, 2).put(0x607C, 25_000)
    bench.put(0x607A, 500_000).enabled(PP).control(0x1F)
    assert bench.status(0x0800) == 0x0800
    reached(bench)
    assert bench.motor.position == 75_000


def test_a_limit_is_not_shown_any_more_when_the_axis_is_enabled_again(bench: Cia402Bench) -> None:
    bench.put(0x607D, -100_000, 1).put(0x607D, 100_000, 2).put(0x607A, 500_000).enabled(PP).control(0x1F)
    reached(bench)
    assert bench.status(0x0800) == 0x0800
    bench.control(0x06).control(0x0F).cycles(2)
    assert bench.status(0x086F) == 0x0027


def test_pp_the_largest_velocity_and_accelerations_hold(bench: Cia402Bench) -> None:
    bench.put(0x6081, 50_000_000).put(0x607F, 500_000).put(0x60C5, 1_000_000).put(0x60C6, 2_000_000)
    bench.put(0x607A, 2_000_000).put(0x6067, 0).enabled(PP).control(0x1F)
    expected = trapezoid_s(2_000_000, 500_000, 1_000_000, 2_000_000)
    assert reached(bench) == pytest.approx(expected / CYCLE_S, abs=2)


def test_pp_position_window_and_time(bench: Cia402Bench) -> None:
    bench.put(0x6067, 100).put(0x6068, 200).put(0x607A, 100_000).enabled(PP).control(0x1F)
    bench.motor.lag = 150
    bench.cycles(200)
    assert bench.status(0x0400) == 0
    bench.motor.lag = 50
    assert reached(bench) == pytest.approx(0.2 / CYCLE_S, abs=3)
    bench.motor.lag = 150
    assert bench.cycles(2).status(0x0400) == 0


def test_pp_a_window_of_0_is_reached_where_a_unit_is_no_whole_number_of_increments(bench: Cia402Bench) -> None:
    """3 units an increment: the motor cannot be nearer to the target than at the next increment."""
    bench.put(0x6092, 3_000_000, 1).put(0x6067, 0).put(0x607A, 1_000).enabled(PP).control(0x1F).cycles(100)
    assert (bench.motor.position, bench.status(0x0400)) == (333, 0x0400)


# ---- profile velocity


def test_pv_ramps_and_bits(bench: Cia402Bench) -> None:
    bench.put(0x60FF, 2_000_000).put(0x606D, 1_000).enabled(PV)
    assert bench.status(0x1400) == 0x1000
    count = reached(bench)
    assert count == pytest.approx(2_000_000 / A / CYCLE_S, abs=2)
    assert (bench.status(0x1400), bench.get(0x606B), bench.get(0x606C)) == (0x0400, 2_000_000, 2_000_000)
    bench.put(0x60FF, -1_000_000).cycles(1)
    assert bench.status(0x0400) == 0
    assert reached(bench) == pytest.approx(3_000_000 / A / CYCLE_S, abs=2)


def test_pv_window_time_and_threshold_time(bench: Cia402Bench) -> None:
    bench.put(0x606D, 1_000).put(0x606E, 100).put(0x6070, 80).put(0x60FF, 2_000_000).enabled(PV)
    assert bench.cycles(18).status(0x1000) == 0x1000
    assert bench.cycles(8).status(0x1000) == 0
    assert reached(bench) == pytest.approx((0.2 + 0.1) / CYCLE_S - 26, abs=2)


def test_pv_stops_at_the_software_limit(bench: Cia402Bench) -> None:
    bench.put(0x607D, 0, 1).put(0x607D, 3_000_000, 2).put(0x60FF, 2_000_000).enabled(PV).cycles(1_000)
    assert (bench.motor.position, bench.status(0x1800)) == (3_000_000, 0x1800)
    bench.put(0x60FF, -2_000_000).cycles(100)
    assert bench.motor.position < 3_000_000


@pytest.mark.parametrize(("begin", "direction"), [(3_500_000, 1), (3_000_000, 1), (-500_000, -1)])
def test_pv_outside_of_the_software_limits_goes_inwards_only(bench: Cia402Bench, begin: int, direction: int) -> None:
    bench.motor.position = begin
    bench.put(0x607D, 0, 1).put(0x607D, 3_000_000, 2).put(0x60FF, direction * 1_000_000).enabled(PV).cycles(100)
    assert (bench.motor.position, bench.status(0x0800)) == (begin, 0x0800)
    bench.put(0x60FF, -direction * 1_000_000).cycles(100)
    assert bench.motor.velocity == -direction * 1_000_000
    assert bench.status(0x0800) == 0


def test_pv_keeps_to_the_largest_velocity(bench: Cia402Bench) -> None:
    bench.put(0x607F, 300_000).put(0x60FF, 2_000_000).enabled(PV).cycles(100)
    assert (bench.get(0x606C), bench.status(0x0800)) == (300_000, 0x0800)


# ---- torque


def test_pt_follows_the_slope(bench: Cia402Bench) -> None:
    bench.put(0x6087, 1_000).put(0x6071, 500).enabled(PT).cycles(50)
    assert bench.motor.torque == pytest.approx(200, abs=5)
    assert bench.status(0x0400) == 0
    bench.cycles(80)
    assert (bench.motor.torque, bench.get(0x6074), bench.status(0x0400)) == (500, 500, 0x0400)
    bench.control(0x010F).cycles(126)
    assert (bench.motor.torque, bench.status(0x0400)) == (0, 0x0400)


def test_pt_a_halt_is_over_when_the_axis_stands(bench: Cia402Bench) -> None:
    """Bit 10 with bit 8 of the control word: the velocity is 0; an axis without torque runs on."""
    bench.put(0x6087, 100_000).put(0x6071, 500).enabled(PT).cycles(5)
    bench.motor.velocity = 500_000.0
    bench.control(0x010F).cycles(5)
    assert (bench.motor.torque, bench.status(0x0400)) == (0, 0)
    bench.motor.velocity = 0.0
    assert bench.cycles(1).status(0x0400) == 0x0400


def test_the_motor_is_told_of_6072_in_every_mode(bench: Cia402Bench) -> None:
    bench.enabled(CSP)
    assert bench.motor.most_torque is None
    bench.put(0x6072, 300)
    assert bench.motor.most_torque == 300


def test_pt_and_cst_keep_to_the_largest_torque(bench: Cia402Bench) -> None:
    bench.put(0x6072, 300).put(0x6071, 500).enabled(CST).cycles(1)
    assert (bench.motor.torque, bench.status(0x1800)) == (300, 0x1800)


def test_cst_is_followed_at_once_with_its_offset(bench: Cia402Bench) -> None:
    bench.put(0x6071, -250).put(0x60B2, 50).enabled(CST).cycles(1)
    assert (bench.motor.torque, bench.status(0x1000)) == (-200, 0x1000)


# ---- cyclic synchronous


def test_csp_with_sync_and_rpdo_is_a_straight_line(bench: Cia402Bench) -> None:
    """SYNC every 8 ms, the ring every 4 ms."""
    bench.put(0x1402, 1, 2).put(0x60C2, 8, 1).enabled(CSP)
    places = []
    for step in range(1, 51):
        bench.send(f"405#0F 00 {(step * 1000).to_bytes(4, 'little').hex(' ')}", "080#")
        places += [bench.cycles(1).motor.position, bench.cycles(1).motor.position]
    assert places == [500 * step for step in range(1, 101)]
    assert bench.status(0x1000) == 0x1000
    bench.cycles(10)
    assert bench.motor.position == 50_000


@pytest.mark.parametrize("mode", [CSV, PT])
def test_a_quick_stop_of_a_velocity_or_a_torque_is_a_ramp_from_its_speed(bench: Cia402Bench, mode: int) -> None:
    bench.put(0x605A, 5).enabled(mode).put(0x60FF, 1_000_000).put(0x6071, 50).cycles(2)
    bench.motor.velocity = 1_000_000.0
    bench.motor.position = 4_000_000
    bench.cycles(2).control(0x02)
    begin = bench.motor.position
    bench.cycles(30)
    assert bench.motor.position - begin == pytest.approx(1_000_000**2 / (2 * D), abs=2 * V * CYCLE_S)
    assert bench.status(0x046F) == 0x0407


@pytest.mark.parametrize("period_ms", [4, 6, 8, 10, 20])
def test_csp_keeps_its_speed_whatever_the_period_of_the_sync_is(bench: Cia402Bench, period_ms: int) -> None:
    """The ring every 4 ms; 1000 increments a ms."""
    bench.put(0x1402, 1, 2).put(0x60C2, period_ms, 1).enabled(CSP)
    speeds = []
    for ms in range(0, 400, 2):
        if ms % period_ms == 0:
            bench.send(f"405#0F 00 {((ms + period_ms) * 1000).to_bytes(4, 'little').hex(' ')}", "080#")
        if ms % 4 == 2:
            speeds.append(bench.cycles(1).motor.velocity)
    assert speeds[6:] == pytest.approx([1_000_000] * (len(speeds) - 6))


def test_csp_stands_until_a_set_point_comes(bench: Cia402Bench) -> None:
    bench.put(0x607A, 5_000_000)
    bench.motor.position = 77
    assert bench.enabled(CSP).cycles(20).motor.position == 77


def test_csp_offset_limits_and_largest_velocity(bench: Cia402Bench) -> None:
    bench.put(0x60B0, 10).put(0x607D, -5_000, 1).put(0x607D, 5_000, 2).enabled(CSP)
    assert bench.put(0x607A, 1_000).cycles(5).motor.position == 1_010
    assert bench.put(0x607A, 100_000).cycles(5).motor.position == 5_000
    assert bench.status(0x0800) == 0x0800
    bench.put(0x607F, 100_000).put(0x607A, 0)
    assert bench.cycles(2).motor.position == 5_000 - 800


def test_cyclic_offsets_count_without_a_new_target(bench: Cia402Bench) -> None:
    bench.put(0x60C2, 4, 1).enabled(CSP).put(0x60B0, 70).cycles(2)
    assert bench.motor.position == 0  # no target yet
    bench.put(0x607A, 1_000).put(0x60B0, 50).cycles(1)
    assert bench.motor.position == 1_050
    assert bench.put(0x60B0, -20).cycles(1).motor.position == 980
    bench.cycles(2).put(0x6060, CSV).cycles(5).put(0x60B1, 500).cycles(2)
    assert bench.motor.velocity == 0
    assert bench.put(0x60FF, 1_000).cycles(1).motor.velocity == 1_500
    assert bench.put(0x60B1, -500).cycles(1).motor.velocity == 500


def test_csp_of_two_targets_between_two_cycles_the_last_one_counts(bench: Cia402Bench) -> None:
    bench.put(0x60C2, 4, 1).enabled(CSP).put(0x607A, 1_000).cycles(1)
    assert bench.put(0x607A, 2_000).put(0x607A, 3_000).cycles(1).motor.position == 3_000


def test_csv_gives_speeds(bench: Cia402Bench) -> None:
    bench.put(0x60C2, 8, 1).enabled(CSV).put(0x60B1, 1_000).put(0x60FF, 400_000).cycles(1)
    assert bench.motor.velocity == pytest.approx(200_500)
    assert bench.cycles(1).motor.velocity == pytest.approx(401_000)
    assert bench.status(0x1000) == 0x1000
    bench.control(0x010F).cycles(20)
    assert (bench.motor.velocity, bench.status(0x0400)) == (0, 0x0400)


def test_a_mode_may_change_while_the_axis_moves(bench: Cia402Bench) -> None:
    bench.enabled(CSV).put(0x60FF, 1_000_000).cycles(50).put(0x6060, PP)
    assert bench.cycles(10).status(0x0400) == 0  # it comes to rest
    bench.cycles(40)
    assert bench.motor.velocity == 0
    assert bench.status(0x0400) == 0x0400
    stands = bench.motor.position
    bench.put(0x607A, 1_000).control(0x5F)
    reached(bench)
    assert bench.motor.position == stands + 1_000


@pytest.mark.parametrize(
    ("before", "after"),
    [(before, after) for before in (PP, PV, HM, CSV) for after in (PP, PV, HM, IP, CSP, CSV) if before != after],
)
def test_no_change_of_mode_in_motion_is_a_jolt(bench: Cia402Bench, before: int, after: int) -> None:
    """Within 6084h: 40 000 increments/s in a cycle."""
    bench.put(0x607A, 50_000_000).put(0x6098, 18).put(0x6099, 1_000_000, 1).enabled(before)
    bench.control(0x1F).put(0x60FF, 1_000_000).cycles(60)
    speeds = [bench.motor.velocity]
    assert speeds[0] == pytest.approx(1_000_000, rel=0.01)
    bench.put(0x60FF, 0).put(0x6060, after)
    speeds += [bench.cycles(1).motor.velocity for _ in range(40)]
    assert max(abs(last - first) for first, last in pairwise(speeds)) <= 40_000.001
    assert speeds[-1] == (1_000_000 if after == CSV else 0)


# ---- interpolated position


def test_ip_plays_its_buffer_one_period_each(bench: Cia402Bench) -> None:
    bench.put(0x60C2, 8, 1).enabled(IP)
    for place in (1_000, 3_000, 2_000):
        bench.put(0x60C1, place, 1)
    assert (bench.get(0x60C4, 4), bench.status(0x1000)) == (3, 0)
    bench.cycles(5)
    assert bench.motor.position == 0
    assert bench.control(0x1F).status(0x1000) == 0x1000
    places = [bench.cycles(1).motor.position for _ in range(7)]
    assert places == [500, 1_000, 2_000, 3_000, 2_500, 2_000, 2_000]
    assert bench.status(0x0400) == 0x0400


@pytest.mark.parametrize(("mode", "word"), [(CSP, 0x0F), (IP, 0x06), (IP, 0x07)])
def test_ip_takes_set_points_when_it_is_enabled_only(bench: Cia402Bench, mode: int, word: int) -> None:
    """A master whose RPDO has control word and set-point sends both from its start on."""
    bench.put(0x60C2, 4, 1).put(0x6060, mode).control(0x06).control(word).cycles(1)
    for place in range(70):
        bench.put(0x60C1, place, 1).cycles(1)
    assert bench.get(0x60C4, 4) == 0
    bench.enabled(IP).control(0x1F).put(0x60C1, 1_000, 1)
    assert bench.cycles(1).motor.position == 1_000


def test_ip_begins_where_the_axis_is(bench: Cia402Bench) -> None:
    bench.motor.position = 5_000
    bench.put(0x60C2, 8, 1).enabled(IP).put(0x60C1, 6_000, 1).control(0x1F)
    assert [bench.cycles(1).motor.position for _ in range(3)] == [5_500, 6_000, 6_000]


@pytest.mark.parametrize("mode", [CSP, IP])
def test_a_halt_that_is_called_off_goes_on_to_rest(bench: Cia402Bench, mode: int) -> None:
    bench.put(0x60C2, 4, 1).enabled(mode).control(0x1F)
    for step in range(1, 40):
        bench.put(*((0x607A, step * 2_000) if mode == CSP else (0x60C1, step * 2_000, 1))).cycles(1)
    speeds = [bench.motor.velocity]
    bench.control(0x011F).cycles(1).control(0x1F)
    speeds += [bench.cycles(1).motor.velocity for _ in range(20)]
    assert max(abs(last - first) for first, last in pairwise(speeds)) <= 2 * 40_000.001
    assert (speeds[0], speeds[-1]) == (500_000, 0)


def test_ip_a_full_buffer_refuses_and_a_cleared_one_is_empty(bench: Cia402Bench) -> None:
    bench.put(0x60C4, 2, 2).enabled(IP).put(0x60C1, 1, 1).put(0x60C1, 2, 1)
    assert bench.try_put(0x60C1, 3, 1) == "05040005"
    assert bench.put(0x60C4, 0, 6).get(0x60C4, 4) == 0
    assert bench.try_put(0x60C1, 3, 1) == "08000022"
    bench.put(0x60C4, 1, 6).put(0x60C1, 3, 1)
    assert bench.get(0x60C4, 4) == 1


def test_csp_an_axis_that_has_caught_up_is_no_longer_limited(bench: Cia402Bench) -> None:
    """No further set-point has to come for that, but beyond a software limit it stays limited."""
    bench.put(0x607F, 1_000_000).put(0x60C2, 4, 1).enabled(CSP).put(0x607A, 100_000).cycles(5)
    assert bench.status(0x0800) == 0x0800
    bench.cycles(200)
    assert (bench.get(0x6064), bench.status(0x0800)) == (100_000, 0)
    bench.put(0x607D, 0, 1).put(0x607D, 200_000, 2).put(0x607A, 300_000).cycles(300)
    assert (bench.get(0x6064), bench.status(0x0800)) == (200_000, 0x0800)


def test_csp_a_jump_of_the_master_is_a_following_error_where_there_is_a_window(bench: Cia402Bench) -> None:
    """The position demand is the master's, so an axis that may only go at 607Fh is behind it."""
    bench.put(0x607F, 100_000).put(0x60C2, 4, 1).enabled(CSP).put(0x607A, 300_000).cycles(2)
    assert bench.motor.position < 2_000
    assert bench.get(0x6062) == 300_000
    assert abs(bench.get(0x60F4) - bench.get(0x6062) + bench.get(0x6064)) <= 800  # of the cycle before
    assert (bench.status(0x0808), bench.get(0x603F)) == (0x0800, 0)  # limited, and no window
    bench.put(0x6066, 10).put(0x6065, 50_000).cycles(2)
    assert bench.status(0x0008) == 0
    bench.cycles(3)
    assert (bench.status(0x2008), bench.get(0x603F)) == (0x2008, 0x8611)


def test_csp_a_limited_axis_that_has_caught_up_has_no_following_error(bench: Cia402Bench) -> None:
    bench.put(0x607F, 100_000).put(0x60C2, 4, 1).put(0x6065, 5_000).enabled(CSP).put(0x607A, 3_000).cycles(20)
    assert (bench.motor.position, bench.get(0x6062), bench.get(0x60F4), bench.status(0x2008)) == (3_000, 3_000, 0, 0)
    bench.put(0x607A, 200_000).put(0x6040, 0x10F).cycles(1)
    assert bench.get(0x60F4) < 10_000  # halted: the demand is that of the ramp
