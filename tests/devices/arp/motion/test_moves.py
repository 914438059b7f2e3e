"""PAC, PRC, PVC and STOP, their limits and their flags: manual 4.6, 5.9.1 to 5.9.3."""

import math

import pytest
from arp_axes import AxesBench
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.arp.motion.flags import AxisFlag

SIMULATED = ((1, 4, 1.0), (2, 4, 1.0))
LIMITS = ((1, 7, 1000.0), (1, 8, 5000.0), (2, 7, 1000.0), (2, 8, 5000.0))
BOTH = pytest.mark.parametrize(("axis", "first"), [(1, 257), (2, 289)])


def bench_of_simulated(*parameters: tuple[int, int, float], ms: int = 1) -> AxesBench:
    """Both axes simulated, 1000 unit/s and 5000 unit/s2, at rest and arrived."""
    bench = AxesBench(*SIMULATED, *LIMITS, *parameters, ms=ms)
    bench.until_flag(1, AxisFlag.ARRIVED)
    return bench


@pytest.mark.manual("ARP-022")
@pytest.mark.parametrize("kind", [0, 3])
def test_axis_that_is_only_read_or_regulated_does_not_move(kind: int) -> None:
    bench = AxesBench((1, 4, kind))
    bench.counts[1] = 70
    bench.loop()
    before = list(bench.F)
    bench.axes.move_to(1, 100_000)
    bench.axes.move_by(1, 100_000)
    bench.axes.move_at(1, 50_000)
    bench.axes.stop_axis(1)
    bench.loop(100)
    assert [*bench.F] == before
    assert bench.axes.position(1) == 70_000  # the reference follows the reading
    assert bench.errors.error == bench.errors.warning == 0
    assert bench.axes.volts(1) is None


@pytest.mark.manual("ARP-099", "ARP-022")
@pytest.mark.parametrize(("kind", "moves"), [(0, False), (1, True), (2, True), (3, False)])
def test_moves_run_on_real_and_simulated_axes_only(kind: int, moves: bool) -> None:
    bench = AxesBench((1, 4, kind))
    bench.axes.move_to(1, 1_000)
    assert bench.F[263] == moves
    bench.loop(2)
    assert (bench.axes.position(1) > 0) == moves


@pytest.mark.manual("ARP-022")
def test_simulated_axis_needs_no_encoder_and_drives_no_output() -> None:
    bench = bench_of_simulated()
    bench.counts[1] = 12_345
    bench.axes.move_to(1, 10_000)
    bench.until_flag(1, AxisFlag.ARRIVED)
    assert bench.reading(1) == bench.position(1) == 10.0
    assert bench.axes.volts(1) is None
    assert bench.axes.tracking_error(1) == 0


@pytest.mark.long
@pytest.mark.manual("ARP-024", "ARP-025", "ARP-093", "ARP-095")
def test_every_sample_of_a_move_lies_on_the_closed_solution() -> None:
    """Digest 12: v 1000, a 5000, d 2500, 10000 units take 10.3 s."""
    bench = bench_of_simulated()
    bench.axes.limit_deceleration(1, 50_000)
    bench.axes.move_to(1, 10_000_000)
    begin_ns = bench.now_ns
    while bench.loop().F[263]:
        t = (bench.now_ns - begin_ns) / 1e9
        if t < 0.2:
            closed = 2500 * t * t
        elif t < 9.9:
            closed = 100 + 1000 * (t - 0.2)
        else:
            closed = 10_000 - 1250 * (10.3 - t) ** 2
        assert bench.position(1) == pytest.approx(closed, abs=1e-8)
    assert bench.now_ns - begin_ns == 10_300_000_000
    assert bench.position(1) == 10_000.0
    assert bench.speed(1) == 0


@pytest.mark.manual("ARP-095")
@pytest.mark.parametrize("ms", [1, 4, 10])
def test_short_move_peaks_where_the_triangle_does_at_any_period(ms: int) -> None:
    bench = bench_of_simulated(ms=ms)
    bench.axes.limit_deceleration(1, 50_000)
    bench.axes.move_by(1, 120_000)
    begin_ns, fastest = bench.now_ns, 0.0
    while bench.loop().F[263]:
        t = (bench.now_ns - begin_ns) / 1e9
        peak_s = 632.4555320336759 / 5000
        closed = 2500 * t * t if t < peak_s else 120 - 1250 * (3 * peak_s - t) ** 2
        assert bench.position(1) == pytest.approx(closed, abs=1e-9)
        fastest = max(fastest, bench.speed(1))
    assert bench.now_ns - begin_ns == math.ceil(379_473_319 / (ms * 1_000_000)) * ms * 1_000_000
    assert fastest == pytest.approx(632.456, abs=5000 * ms / 1000)
    assert bench.axes.position(1) == 120_000


@pytest.mark.manual("ARP-067", "ARP-070", "ARP-029")
@BOTH
def test_flags_of_a_move_and_the_dwell_in_the_window(axis: int, first: int) -> None:
    bench = bench_of_simulated((axis, 15, 0.020))
    bench.raise_flag(axis, AxisFlag.STOP)
    bench.axes.move_to(axis, 10_000)
    arrived, stop, running, final = (bench.F[first + n] for n in (3, 5, 6, 7))
    assert (arrived, stop, running, final) == (0, 0, 1, 0)
    bench.until_flag(axis, AxisFlag.RUNNING, 0)
    assert bench.F[first + 3] == 0
    assert bench.until_flag(axis, AxisFlag.ARRIVED) == 20
    assert bench.F[first + 7] == 0


@pytest.mark.manual("ARP-067")
def test_arrived_comes_by_itself_when_an_axis_is_put_under_control_and_not_without() -> None:
    bench = AxesBench((1, 4, 1.0), (1, 15, 0.010))
    assert bench.until_flag(1, AxisFlag.ARRIVED) == 10
    assert bench.loop(100).F[292] == 0  # axis 2 is read only
    bench.set(2, 4, 1.0)
    assert bench.until_flag(2, AxisFlag.ARRIVED) == 51
    bench.axes.release()
    assert bench.loop(10).F[260] == 1  # frozen


@pytest.mark.manual("ARP-096")
def test_relative_move_goes_both_ways_and_across_the_wrap() -> None:
    bench = bench_of_simulated((1, 5, 360.0), (1, 6, 0.0))
    for distance, end in ((350.0, 350.0), (20.5, 10.5), (-30.25, 340.25), (1080.0, 340.25)):
        bench.axes.move_by(1, round(distance * 1000))
        bench.until_flag(1, AxisFlag.RUNNING, 0)
        assert bench.position(1) == pytest.approx(end, abs=1e-9)
        assert bench.axes.position(1) == end * 1000


@pytest.mark.manual("ARP-096")
def test_relative_move_goes_on_from_the_reference_and_not_from_the_reading() -> None:
    """@POS is what a program sees (manual 4.2.1); loop errors do not accumulate over many moves."""
    bench = AxesBench((1, 4, 2.0), *LIMITS)
    bench.counts[1] = 0
    bench.loop()
    for _ in range(3):
        bench.axes.move_by(1, 10_000)
        bench.until_flag(1, AxisFlag.RUNNING, 0)
        bench.counts[1] = round(bench.position(1)) - 3
        bench.loop()
    assert bench.position(1) == 30.0


@pytest.mark.manual("ARP-095")
def test_absolute_move_takes_the_straight_way_and_not_the_short_one() -> None:
    bench = bench_of_simulated((1, 5, 360.0), (1, 6, 0.0))
    bench.axes.move_to(1, 350_000)
    bench.until_flag(1, AxisFlag.RUNNING, 0)
    bench.axes.move_to(1, 10_000)
    bench.until_flag(1, AxisFlag.RUNNING, 0)
    assert (bench.F[267], bench.F[268]) == (0, 0)


@pytest.mark.manual("ARP-097", "ARP-071")
@BOTH
def test_speed_is_reached_and_kept(axis: int, first: int) -> None:
    bench = bench_of_simulated()
    bench.axes.move_at(axis, 50_000)
    assert (bench.F[first + 3], bench.F[first + 6], bench.F[first + 7]) == (0, 1, 0)
    assert bench.until_flag(axis, AxisFlag.FINAL_SPEED) == 100  # 500 unit/s at 5000 unit/s2
    assert bench.F[first + 6] == 0
    start = bench.position(axis)
    assert start == pytest.approx(25.0)
    bench.loop(1000)
    assert bench.position(axis) == pytest.approx(start + 500.0, abs=1e-9)
    assert bench.axes.speed(axis) == 500_000
    assert bench.F[first + 3] == 0


@pytest.mark.manual("ARP-093")
def test_speed_of_pvc_is_capped_by_vel() -> None:
    bench = bench_of_simulated()
    bench.axes.limit_speed(1, 20_000)
    bench.axes.move_at(1, 50_000)
    bench.until_flag(1, AxisFlag.FINAL_SPEED)
    assert bench.speed(1) == 200.0


@pytest.mark.manual("ARP-093")
def test_limits_scale_the_parameters_and_a_reset_restores_them() -> None:
    bench = bench_of_simulated()
    bench.axes.limit_speed(1, 50_000)
    bench.axes.limit_acceleration(1, 10_000)
    bench.axes.limit_deceleration(1, 20_000)
    bench.axes.move_by(1, 2_000_000)
    assert bench.until_flag(1, AxisFlag.RUNNING, 0) == round((500 / 500 + 500 / 1000 + (2000 - 375) / 500) * 1000)
    bench.axes.move_by(1, 2_000_000)  # the limits stay in effect
    assert bench.until_flag(1, AxisFlag.RUNNING, 0) == 4750
    bench.axes.start()
    bench.axes.engage()
    bench.axes.move_by(1, 2_000_000)
    assert bench.until_flag(1, AxisFlag.RUNNING, 0) == 2200


@pytest.mark.manual("ARP-093")
def test_new_limits_count_from_the_next_instruction_on() -> None:
    bench = bench_of_simulated()
    bench.axes.move_by(1, 2_000_000)
    bench.loop(10)
    bench.axes.limit_speed(1, 10_000)
    assert bench.until_flag(1, AxisFlag.RUNNING, 0) == 2190


@pytest.mark.manual("ARP-093")
def test_limit_of_0_percent_all_but_holds_the_axis() -> None:
    bench = bench_of_simulated()
    for limit in (bench.axes.limit_speed, bench.axes.limit_acceleration, bench.axes.limit_deceleration):
        limit(1, 0)
        bench.axes.move_to(1, 10_000)
        bench.loop(20)
        assert abs(bench.axes.position(1)) <= 5
        assert bench.F[263] == 1
        limit(1, 100_000)
        bench.axes.stop_axis(1)
        bench.until_flag(1, AxisFlag.ARRIVED)


@pytest.mark.manual("ARP-069", "ARP-071")
@BOTH
def test_stop_flag_leaves_the_axis_at_its_speed(axis: int, first: int) -> None:
    """A25, with a PAC."""
    bench = bench_of_simulated()
    bench.axes.move_to(axis, 1_000_000)
    bench.loop(100)
    bench.raise_flag(axis, AxisFlag.STOP)
    bench.loop()
    assert (bench.F[first + 3], bench.F[first + 6], bench.F[first + 7]) == (0, 0, 1)
    assert bench.speed(axis) == pytest.approx(500.0)
    before = bench.position(axis)
    bench.loop(3000)  # beyond the old target
    assert bench.position(axis) == pytest.approx(before + 1500.0)
    assert bench.F[first + 5] == 1
    bench.axes.move_by(axis, 0)
    assert (bench.F[first + 5], bench.F[first + 7]) == (0, 0)


@pytest.mark.manual("ARP-069")
@pytest.mark.parametrize("move", ["move_by", "move_at"])
def test_stop_flag_ends_prc_and_pvc_too(move: str) -> None:
    bench = bench_of_simulated()
    getattr(bench.axes, move)(1, 100_000)
    bench.loop(20)
    bench.raise_flag(1, AxisFlag.STOP)
    assert bench.loop(100).speed(1) == pytest.approx(100.0)
    assert (bench.F[263], bench.F[264]) == (0, 1)


@pytest.mark.manual("ARP-100")
def test_stop_brakes_with_dec_and_then_the_axis_has_arrived() -> None:
    bench = bench_of_simulated((1, 15, 0.0))
    bench.axes.limit_deceleration(1, 20_000)
    bench.axes.move_at(1, 100_000)
    bench.until_flag(1, AxisFlag.FINAL_SPEED)
    before = bench.position(1)
    bench.axes.stop_axis(1)
    assert (bench.F[260], bench.F[263], bench.F[264]) == (0, 1, 0)
    bench.raise_flag(1, AxisFlag.STOP)  # acts on moves, not on a stop
    assert bench.until_flag(1, AxisFlag.RUNNING, 0) == 1000  # 1000 unit/s at 1000 unit/s2
    assert bench.position(1) == pytest.approx(before + 500.0)
    assert (bench.F[260], bench.F[264]) == (1, 0)
    assert bench.loop(100).position(1) == pytest.approx(before + 500.0)


@pytest.mark.manual("ARP-100")
def test_stop_in_the_middle_of_a_move() -> None:
    bench = bench_of_simulated()
    bench.axes.move_to(1, 10_000_000)
    bench.loop(500)
    bench.axes.stop_axis(1)
    assert bench.until_flag(1, AxisFlag.RUNNING, 0) == 200
    assert bench.position(1) == pytest.approx(400.0 + 100.0)


def test_stop_of_a_standing_axis_changes_nothing() -> None:
    bench = bench_of_simulated()
    before = list(bench.F)
    bench.axes.stop_axis(1)
    assert [*bench.loop(10).F] == before


@pytest.mark.manual("ARP-095", "ARP-071")
def test_move_begins_at_the_speed_that_was_left_and_may_overshoot() -> None:
    bench = bench_of_simulated()
    bench.axes.move_at(1, 100_000)
    bench.until_flag(1, AxisFlag.FINAL_SPEED)
    start = bench.position(1)
    bench.axes.move_to(1, round(start + 50) * 1000)
    trajectory = [0.0]
    while bench.loop().F[263]:
        trajectory.append(bench.position(1) - start)
    # to rest in 200 ms and 100 units (1000^2 / 2 / 5000), and 50 units back in 200 ms, half of them faster and faster
    assert [trajectory[loop] for loop in (100, 200, 300, 399)] == pytest.approx([75.0, 100.0, 75.0, 50.0025])
    assert (max(trajectory), len(trajectory)) == (trajectory[200], 400)
    assert bench.axes.position(1) == round(start + 50) * 1000
    assert bench.F[264] == 0


@pytest.mark.manual("ARP-055")
def test_writing_the_position_presets_counter_and_reference_without_motion() -> None:
    bench = bench_of_simulated()
    bench.axes.preset_position(1, 123_456)
    assert bench.axes.position(1) == 123_456
    assert bench.loop(10).axes.position(1) == 123_456
    assert bench.reading(1) == 123.456
    assert bench.F[260] == 1
    assert bench.F[263] == 0
    bench.counts[2] = 10
    bench.set(2, 4, 0.0)
    bench.loop()
    bench.axes.preset_position(2, 1_000)
    bench.counts[2] = 25
    assert bench.loop().axes.position(2) == 16_000


@pytest.mark.manual("ARP-055")
def test_preset_during_a_move_shifts_the_rest_of_it() -> None:
    bench = bench_of_simulated()
    bench.axes.move_to(1, 1_000_000)
    bench.loop(400)
    bench.axes.preset_position(1, 0)
    bench.until_flag(1, AxisFlag.RUNNING, 0)
    assert bench.position(1) == pytest.approx(700.0)


@pytest.mark.manual("ARP-055")
def test_preset_outside_the_limits_goes_round() -> None:
    bench = bench_of_simulated((1, 5, 360.0), (1, 6, 0.0))
    bench.axes.preset_position(1, 370_000)
    assert bench.axes.position(1) == 10_000
    assert bench.F[267] == 0


@pytest.mark.manual("ARP-056")
def test_speed_is_in_units_per_second() -> None:
    bench = AxesBench((1, 1, 4.0), ms=2)
    bench.counts[1] = 0
    bench.loop()
    bench.counts[1] = 40
    assert bench.loop().axes.speed(1) == 5_000_000  # 10 units in 2 ms
    bench.counts[1] = 20
    assert bench.loop().axes.speed(1) == -2_500_000
    assert bench.loop().axes.speed(1) == 0
    bench.counts[1] = 1_000_000_000
    assert bench.loop().axes.speed(1) == 999_999_999  # as far as the number goes


@pytest.mark.manual("ARP-066", "ARP-094")
def test_home_has_no_effect_in_firmware_3_00() -> None:
    bench = bench_of_simulated()
    before = list(bench.F)
    bench.axes.home(1)
    bench.axes.home(2)
    assert [*bench.loop(100).F] == before
    assert bench.axes.position(1) == 0


@pytest.mark.manual("ARP-098")
def test_second_move_holds_the_program_on_its_line_until_the_first_has_ended() -> None:
    """A21, in the run-time system."""
    bench = bench_of_simulated()
    bench.load("BEG MAIN\nPAC 1, 100\nV1 == 1\nPAC 1, 50\nV1 == 2\nPVC 2, 10\nL: GOTO L\nEND")
    bench.until(lambda: bench.V[1] == 1_000)
    assert bench.program is not None
    bench.loop(50)
    assert bench.program.place.line == 4
    bench.until(lambda: bench.V[1] == 2_000)
    assert 99.9 < bench.position(1) <= 100.0
    bench.until(lambda: bench.F[296])
    bench.until_flag(1, AxisFlag.ARRIVED)
    assert bench.axes.position(1) == 50_000


@pytest.mark.manual("ARP-022")
def test_program_changes_the_kind_and_moves_in_the_next_line() -> None:
    bench = AxesBench()
    bench.load("BEG MAIN\n@PAR2[4] == 1\nPAC 2, 10\nL: GOTO L\nEND")
    bench.until_flag(2, AxisFlag.ARRIVED)
    assert bench.axes.position(2) == 10_000


@pytest.mark.manual("ARP-022")
def test_position_stays_when_a_simulated_axis_becomes_a_real_one() -> None:
    bench = bench_of_simulated()
    bench.counts[1] = 500
    bench.loop()
    bench.axes.move_to(1, 50_000)
    bench.until_flag(1, AxisFlag.ARRIVED)
    bench.counts[1] = 900
    bench.loop()
    bench.set(1, 4, 0.0)
    assert bench.loop().axes.position(1) == 50_000
    bench.counts[1] = 903
    assert bench.loop().axes.position(1) == 53_000
    bench.set(1, 4, 1.0)
    assert bench.loop().axes.position(1) == 53_000


def test_losing_enable_ends_a_move_and_engaging_begins_where_the_axis_is() -> None:
    bench = bench_of_simulated()
    bench.axes.move_to(1, 1_000_000)
    bench.loop(300)
    bench.axes.release()
    at = bench.loop(10).axes.position(1)
    assert 0 < at < 1_000_000
    assert bench.F[263] == 0
    bench.axes.move_to(1, 0)
    assert bench.loop(10).axes.position(1) == at  # not under control
    bench.axes.start()
    assert not any(bench.F[257:321])
    bench.axes.engage()
    bench.until_flag(1, AxisFlag.ARRIVED)
    assert bench.axes.position(1) == at


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(st.sampled_from(["move_by", "move_to"]), st.integers(-720_000, 720_000)), max_size=6),
    st.integers(1, 10),
)
def test_moves_end_exactly_at_their_targets_within_the_range(moves: list[tuple[str, int]], ms: int) -> None:
    bench = AxesBench(*SIMULATED, (1, 5, 360.0), (1, 6, -360.0), (1, 7, 1000.0), (1, 8, 20_000.0), ms=ms)
    expected = 0
    for name, value in moves:
        raw = max(min(value, 360_000), -360_000) if name == "move_to" else value
        getattr(bench.axes, name)(1, raw)
        expected = raw if name == "move_to" else expected + raw
        while expected > 360_000:
            expected -= 720_000
        while expected < -360_000:
            expected += 720_000
        while bench.loop().F[263]:
            assert -360.0 <= bench.position(1) <= 360.0
            assert abs(bench.speed(1)) <= 1000.0 * (1 + 1e-9)
        assert bench.axes.position(1) == expected
