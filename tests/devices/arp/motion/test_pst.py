"""PST on the two axes: entry, synchronism, gear and offsets, ends.  Manual 5.9.4.1, 5.13.2; digest 13.4 to 13.6."""

import pytest
from arp_axes import AxesBench, Motor
from arp_listings import EXAMPLE2

from fieldrig_devices.arp.motion.flags import AxisFlag
from fieldrig_devices.arp.readings import Readings

A = ((0.0, 0.0), (5000.0, 5000.0), (10_000.0, 0.0))
OF_EXAMPLE = (
    (2, 7, 5000.0), (2, 8, 50_000.0),
    (1, 7, 6000.0), (1, 8, 50_000.0), (1, 24, 5000.0), (1, 25, 10.0),
)  # fmt: skip
SIMULATED = ((1, 4, 1.0), (2, 4, 1.0))
SYNC, RUNNING, ARRIVED, FINAL = (
    AxisFlag.SYNCHRONOUS, AxisFlag.RUNNING, AxisFlag.ARRIVED, AxisFlag.FINAL_SPEED,
)  # fmt: skip


def curve_a(master: float) -> float:
    """Digest 13.2, example A, a second implementation."""
    if abs(master - 5000) >= 500:
        return min(master, 10_000 - master)
    return 5000 + (master - 5000) - 2 / 2000 * (master - 4500) ** 2


def bench_of_a(*parameters: tuple[int, int, float], readings: Readings | None = None) -> AxesBench:
    """Both axes simulated and at rest at 0, table A at V10."""
    bench = AxesBench(*SIMULATED, *OF_EXAMPLE, *parameters, readings=readings)
    bench.write_table(10, *A)
    bench.until_flag(1, ARRIVED)
    return bench


def locked(*parameters: tuple[int, int, float], readings: Readings | None = None) -> AxesBench:
    bench = bench_of_a(*parameters, readings=readings)
    bench.axes.follow_table(2, 1, 10)
    bench.until_flag(1, SYNC)
    return bench


def moved(bench: AxesBench, to: float) -> AxesBench:
    """Move the master to a position, and wait until it rests there."""
    bench.axes.move_to(2, round(to * 1000))
    bench.until_flag(2, RUNNING, 0)
    return bench


def entering() -> AxesBench:
    """A slave that has driven to the curve for 200 loops, with the master at rest at 500."""
    bench = moved(bench_of_a(), 500)
    bench.axes.follow_table(2, 1, 10)
    return bench.loop(200)


@pytest.mark.long
@pytest.mark.manual("ARP-101", "ARP-105", "ARP-068")
def test_example_of_the_manual_runs_for_many_cycles() -> None:
    """A15, with a simulated slave: every sample is on the curve."""
    bench = AxesBench(*OF_EXAMPLE)
    bench.load(EXAMPLE2.replace("@par1[4] == 2", "@par1[4] == 1"))
    assert 1000 <= bench.until_flag(1, SYNC) <= 1003  # at once after the WAIT
    for _ in range(6):
        assert bench.until_flag(2, RUNNING) > 1000
        highest, loops = 0.0, 0
        while bench.F[295]:
            bench.loop()
            loops += 1
            assert bench.position(1) == pytest.approx(curve_a(bench.position(2)), abs=1e-9)
            highest = max(highest, bench.position(1))
        assert loops == 2100
        assert highest == pytest.approx(4750.0, abs=0.5)
        assert bench.axes.position(2) in (0, 10_000_000)
        assert bench.F[261] == 1
    assert bench.errors.error == 0


@pytest.mark.long
@pytest.mark.manual("ARP-101")
def test_synchronism_outlasts_a_thousand_parkings_at_the_ends() -> None:
    bench = locked((2, 7, 900_000.0), (2, 8, 900_000_000 / 1000), (1, 7, 999_999.0), (1, 8, 999_999.0))
    for number in range(1000):
        bench.axes.move_to(2, 10_000_000 * ((number + 1) % 2))
        bench.loop(212)
        assert (bench.F[261], bench.F[295]) == (1, 0)
    assert bench.axes.position(1) == 0


@pytest.mark.long
@pytest.mark.manual("ARP-101", "ARP-002")
def test_example_of_the_manual_with_a_motor_on_the_slave() -> None:
    """A15: the controlled slave, with torque, speed and counts."""
    bench = AxesBench(*OF_EXAMPLE, (1, 10, 0.0005), (1, 11, 0.8), (1, 12, 2.0), (1, 13, 0.01), (1, 14, 200.0))
    bench.motors[1] = Motor(50_000.0, friction=5.0)
    bench.load(EXAMPLE2)
    bench.until_flag(1, SYNC)
    for _ in range(2):
        bench.until_flag(2, RUNNING)
        while bench.loop().F[295]:
            assert bench.reading(1) == pytest.approx(curve_a(bench.position(2)), abs=60.0)
    assert bench.F[261] == 1
    assert bench.errors.error == 0
    bench.loop(500)
    assert bench.reading(1) == pytest.approx(0.0, abs=2.0)


@pytest.mark.manual("ARP-068", "ARP-070")
def test_slave_at_rest_on_the_curve_is_synchronous_at_once() -> None:
    bench = bench_of_a()
    bench.axes.follow_table(2, 1, 10)
    assert [bench.flag(1, flag) for flag in (ARRIVED, SYNC, RUNNING, FINAL)] == [0, 1, 1, 0]
    moved(bench, 2500)
    assert bench.position(1) == 2500.0
    assert [bench.flag(1, flag) for flag in (ARRIVED, SYNC, RUNNING, FINAL)] == [0, 1, 1, 0]
    assert bench.F[293] == 0  # the master's flag


@pytest.mark.manual("ARP-105", "ARP-035", "ARP-068")
@pytest.mark.parametrize(("start", "direction"), [(0.0, 1), (1000.0, -1)])
def test_slave_drives_to_the_curve_while_the_master_is_at_rest(start: float, direction: int) -> None:
    """Digest 13.5: 500 units at 10 % of 2000 unit/s, 10000 unit/s2, take 2.52 s."""
    bench = bench_of_a((1, 7, 2000.0), (1, 8, 10_000.0), (1, 24, 1000.0))
    moved(bench, 500)
    bench.axes.preset_position(1, round(start * 1000))
    bench.axes.follow_table(2, 1, 10)
    assert [bench.flag(1, flag) for flag in (ARRIVED, SYNC, RUNNING)] == [0, 0, 1]
    bench.loop(1000)
    assert bench.position(1) == pytest.approx(start + direction * (0.02 * 200 / 2 + 0.98 * 200))
    assert bench.speed(1) == direction * 200.0
    assert 1000 + bench.until_flag(1, SYNC) == 2520
    assert bench.position(1) == 500.0
    moved(bench, 800)
    assert bench.position(1) == 800.0


@pytest.mark.manual("ARP-105")
def test_moving_master_is_followed_at_once() -> None:
    bench = bench_of_a()
    bench.axes.move_to(2, 4_000_000)
    bench.loop(400)
    bench.axes.follow_table(2, 1, 10)
    assert bench.F[261] == 1
    bench.loop()
    assert bench.position(1) == bench.position(2) > 1000  # with a jump
    assert bench.speed(1) == bench.speed(2)


@pytest.mark.manual("ARP-105")
def test_master_with_an_encoder_is_at_rest_if_it_makes_no_count_in_a_sample() -> None:
    bench = AxesBench((1, 4, 1.0), (2, 1, 0.1), *OF_EXAMPLE)
    bench.write_table(10, *A)
    bench.counts[2] = 100
    bench.loop(2)
    bench.axes.follow_table(2, 1, 10)
    assert bench.F[261] == 0
    bench.axes.stop_axis(1)
    bench.until_flag(1, RUNNING, 0)
    bench.counts[2] = 101
    bench.loop()
    bench.axes.follow_table(2, 1, 10)
    assert bench.F[261] == 1
    bench.loop()
    assert bench.position(1) == 1010.0


@pytest.mark.manual("ARP-106")
def test_master_outside_the_table_aborts_without_motion_or_error() -> None:
    bench = bench_of_a()
    moved(bench, 10_001)
    before = list(bench.F)
    bench.axes.follow_table(2, 1, 10)
    bench.loop(100)
    assert bench.F[257:289] == before[257:289]
    assert bench.axes.position(1) == 0
    assert bench.errors.error == 0


@pytest.mark.manual("ARP-068", "ARP-106", "ARP-071", "ARP-104")
def test_master_that_leaves_the_table_leaves_the_slave_at_its_speed() -> None:
    bench = locked()
    moved(bench, 8000)
    bench.axes.move_to(2, 12_000_000)
    bench.until_flag(1, SYNC, 0)
    assert 10_000 < bench.position(2) < 10_010
    assert [bench.flag(1, flag) for flag in (ARRIVED, RUNNING, FINAL)] == [0, 0, 1]
    speed, start = bench.speed(1), bench.position(1)
    assert speed == pytest.approx(-5000.0)
    bench.loop(100)
    assert bench.position(1) == pytest.approx(start + speed / 10)
    bench.axes.stop_axis(1)
    bench.until_flag(1, ARRIVED)
    assert bench.speed(1) == 0


@pytest.mark.manual("ARP-068", "ARP-106", "ARP-100")
def test_stop_brakes_the_slave_and_ends_the_cam() -> None:
    bench = locked()
    bench.axes.move_to(2, 10_000_000)
    bench.loop(500)
    assert bench.speed(1) == pytest.approx(5000.0)
    bench.axes.limit_deceleration(1, 20_000)
    bench.axes.stop_axis(1)
    start = bench.position(1)
    assert [bench.flag(1, flag) for flag in (SYNC, RUNNING, FINAL)] == [0, 1, 0]
    assert bench.until_flag(1, RUNNING, 0) == 500
    assert bench.position(1) == pytest.approx(start + 1250.0)
    assert bench.F[295] == 1  # the master continues
    bench.until_flag(1, ARRIVED)


@pytest.mark.manual("ARP-068", "ARP-106", "ARP-069")
def test_stop_flag_ends_the_cam_at_the_present_speed() -> None:
    """A25, with a PST."""
    bench = locked()
    bench.axes.move_to(2, 10_000_000)
    bench.loop(50)
    speed = bench.speed(1)
    assert speed == pytest.approx(2500.0)
    bench.raise_flag(1, AxisFlag.STOP)
    start = bench.position(1)
    bench.loop(100)
    assert [bench.flag(1, flag) for flag in (ARRIVED, SYNC, RUNNING, FINAL)] == [0, 0, 0, 1]
    assert bench.speed(1) == speed
    assert bench.position(1) == pytest.approx(start + 250.0)
    bench.axes.follow_table(2, 1, 10)
    assert bench.F[262] == 0
    assert bench.F[261] == 1


@pytest.mark.manual("ARP-069")
def test_stop_flag_ends_the_entry_too() -> None:
    bench = entering()
    bench.raise_flag(1, AxisFlag.STOP)
    bench.loop()
    assert [bench.flag(1, flag) for flag in (SYNC, RUNNING, FINAL)] == [0, 0, 1]
    assert bench.speed(1) == 600.0


@pytest.mark.manual("ARP-104")
def test_repetitive_linear_cam_goes_on_over_the_end_of_the_master() -> None:
    bench = locked((2, 5, 10_000.0), (2, 6, 0.0), (1, 14, 10_000.0))
    assert bench.position(1) == 250.0  # the join at the ends
    bench.axes.move_at(2, 100_000)
    bench.loop(200)
    before = bench.position(1)
    for _ in range(6000):  # three turns
        bench.loop()
        assert abs(bench.position(1) - before) <= 5.0 + 1e-9
        before = bench.position(1)
        assert 250 - 1e-9 <= before <= 4750 + 1e-9
    assert bench.F[299] == 1
    assert bench.F[261] == 1


@pytest.mark.manual("ARP-104")
@pytest.mark.parametrize("direction", [1, -1])
def test_repetitive_cyclic_cam_takes_the_slave_round_too(direction: int) -> None:
    """The motor of the slave follows exactly, so a wrong lap would be a tracking error."""
    bench = AxesBench(
        (1, 4, 2.0), (2, 4, 1.0), *OF_EXAMPLE, (2, 5, 10_000.0), (2, 6, 0.0), (1, 5, 4000.0), (1, 6, 0.0),
        (1, 14, 400.0), (1, 11, 0.001),
    )  # fmt: skip
    ends = (0.0, 4000.0) if direction > 0 else (4000.0, 0.0)
    bench.write_table(10, (0.0, ends[0]), (5000.0, 2500.0), (10_000.0, ends[1]))
    travel = 0.0
    bench.counts[1] = 0
    bench.loop()
    bench.axes.follow_table(2, 1, 10)
    bench.until_flag(1, SYNC)
    bench.axes.move_at(2, 100_000)
    for _ in range(9000):
        bench.loop()
        travel += bench.speed(1) / 1000
        bench.counts[1] = round(travel)
        assert 0 <= bench.position(1) <= 4000
    assert bench.errors.error == 0
    assert bench.F[261] == 1
    assert travel * direction > 4 * 4000
    assert bench.F[267 if direction > 0 else 268] == 1
    assert abs(bench.axes.tracking_error(1)) < 200_000


@pytest.mark.manual("ARP-104")
def test_non_repetitive_cam_ends_where_the_master_goes_round() -> None:
    bench = locked((2, 5, 10_000.0), (2, 6, -1.0))
    moved(bench, 9990)
    bench.axes.move_at(2, 100_000)
    bench.until_flag(1, SYNC, 0)
    assert bench.F[299] == 1
    assert bench.F[264] == 1


@pytest.mark.manual("ARP-032")
def test_gear_makes_the_virtual_master_faster_or_slower() -> None:
    bench = locked((1, 21, 0.5))
    moved(bench, 4000)
    assert bench.position(1) == pytest.approx(2000.0)
    bench.set(1, 21, -1.0)
    bench.loop(5)
    assert bench.position(1) == pytest.approx(2000.0)  # no jump: the correspondence is lost instead
    moved(bench, 5000)
    assert bench.position(1) == pytest.approx(1000.0)
    assert bench.axes.position(2) == 5_000_000  # the real counter is unchanged


@pytest.mark.manual("ARP-032")
def test_gear_is_taken_from_the_real_position_on() -> None:
    bench = bench_of_a((1, 21, 2.0))
    moved(bench, 1000)
    bench.axes.follow_table(2, 1, 10)
    bench.until_flag(1, SYNC)
    assert bench.position(1) == 1000.0
    bench.axes.move_to(2, 1_500_000)
    while bench.loop().F[295]:
        assert bench.speed(1) == pytest.approx(2 * bench.speed(2))
    assert bench.position(1) == pytest.approx(2000.0)


@pytest.mark.manual("ARP-032")
def test_gear_counts_on_where_the_real_master_goes_round() -> None:
    bench = locked((2, 5, 10_000.0), (2, 6, 0.0), (1, 21, 0.5))
    moved(bench, 4000)
    bench.axes.move_by(2, 8_000_000)
    bench.until_flag(2, RUNNING, 0)
    assert bench.axes.position(2) == 2_000_000
    assert bench.position(1) == pytest.approx(4000.0)  # 2000 + 4000 of the virtual master


@pytest.mark.manual("ARP-032", "ARP-104")
def test_virtual_master_goes_round_in_the_range_of_the_real_one() -> None:
    bench = locked((2, 5, 10_000.0), (2, 6, 0.0), (1, 21, 3.0), (1, 7, 60_000.0))
    moved(bench, 4000)  # 12000, which is 2000
    assert bench.position(1) == pytest.approx(2000.0)
    assert bench.F[299] == 0
    bench.axes.move_by(2, 8_000_000)  # and the real one: 24000 more
    bench.until_flag(2, RUNNING, 0)
    assert bench.axes.position(2) == 2_000_000
    assert bench.position(1) == pytest.approx(4000.0)
    assert bench.F[261] == 1


@pytest.mark.manual("ARP-033")
def test_master_offset_is_added_to_what_is_read() -> None:
    bench = bench_of_a((1, 22, 700.0))
    bench.axes.follow_table(2, 1, 10)
    bench.until_flag(1, SYNC)
    assert bench.position(1) == 700.0
    bench.set(1, 22, -1.0)
    bench.loop()
    assert bench.F[261] == 0  # outside the table


@pytest.mark.manual("ARP-033")
def test_master_offset_is_reached_by_its_step_in_each_sample() -> None:
    bench = locked((1, 23, 2.5))
    bench.set(1, 22, 10.0)
    assert [bench.loop().position(1) for _ in range(5)] == [2.5, 5.0, 7.5, 10.0, 10.0]
    bench.set(1, 22, 6.0)
    assert [bench.loop().position(1) for _ in range(3)] == [7.5, 6.0, 6.0]


@pytest.mark.manual("ARP-032", "ARP-033")
def test_master_offset_is_in_master_units_whatever_the_gear() -> None:
    """Digest 13.4: x = xv + offset, and the gear applies only to xv."""
    bench = locked((1, 21, -2.0), (1, 22, 3000.0))
    moved(bench, 500)  # 2000 in the table
    assert bench.position(1) == pytest.approx(2000.0)
    bench.set(1, 22, 3100.0)
    assert bench.loop().position(1) == pytest.approx(2100.0)


@pytest.mark.manual("ARP-030", "ARP-031")
def test_slave_offset_moves_the_reference_by_its_step_in_each_sample() -> None:
    bench = locked((1, 20, 2.5))
    bench.set(1, 19, -6.0)
    assert [bench.loop().position(1) for _ in range(4)] == [-2.5, -5.0, -6.0, -6.0]
    moved(bench, 1000)
    assert bench.position(1) == 994.0
    bench.set(1, 19, 0.0)  # absolute, not on top of it
    assert [bench.loop().position(1) for _ in range(4)] == [996.5, 999.0, 1000.0, 1000.0]


@pytest.mark.manual("ARP-030", "ARP-031", "ARP-033")
@pytest.mark.parametrize(("reading", "after"), [("jump", 300.0), ("ignore", 0.0)])
@pytest.mark.parametrize("parameter", [19, 22])
def test_offset_without_a_step_jumps_or_is_ignored(reading: str, after: float, parameter: int) -> None:
    bench = locked(readings=Readings.model_validate({"zero_offset_step": reading}))
    bench.set(1, parameter, 300.0)
    assert bench.loop().position(1) == after
    assert bench.loop(50).position(1) == after


@pytest.mark.manual("ARP-030")
def test_entry_drives_to_the_curve_with_its_offset() -> None:
    bench = locked((1, 19, 40.0))
    assert bench.position(1) == 40.0
    assert bench.loop(5).position(1) == 40.0


def test_offset_that_takes_the_slave_round_is_no_tracking_error() -> None:
    """The slave's counter ends at 4999: 10 + 4990 is the position 1, where the axis already is."""
    bench = AxesBench((1, 4, 2.0), (2, 4, 1.0), *OF_EXAMPLE, (1, 5, 4999.0), (1, 6, 0.0), (1, 19, 4990.0), (1, 14, 9.0))
    bench.write_table(10, *A)
    bench.counts[1] = 1
    moved(bench, 10)
    bench.axes.follow_table(2, 1, 10)
    assert bench.F[261] == 1
    assert bench.loop(5).axes.tracking_error(1) == 0
    moved(bench, 5)
    assert bench.axes.position(1) == 4_995_000
    assert bench.axes.tracking_error(1) == -5_000


@pytest.mark.manual("ARP-101")
def test_preset_of_the_master_before_pst_counts_and_during_it_does_not() -> None:
    bench = bench_of_a((1, 25, 100.0))
    bench.axes.preset_position(2, 1_000_000)
    bench.axes.follow_table(2, 1, 10)
    bench.until_flag(1, SYNC)
    assert bench.loop().position(1) == 1000.0
    bench.axes.preset_position(2, 0)
    assert bench.loop(3).position(1) == 1000.0  # a preset is no motion
    moved(bench, 500)
    assert bench.position(1) == pytest.approx(1500.0)


@pytest.mark.manual("ARP-105")
def test_preset_of_the_slave_on_its_way_to_the_curve_moves_nothing() -> None:
    bench = entering()
    bench.axes.preset_position(1, 40_000)
    assert bench.loop().position(1) == pytest.approx(40.0 + 0.6)


@pytest.mark.manual("ARP-105")
def test_slave_that_only_passes_the_curve_is_not_synchronous_yet() -> None:
    bench = bench_of_a()
    bench.axes.move_at(1, 50_000)
    bench.until_flag(1, FINAL)
    bench.axes.preset_position(1, 0)
    bench.axes.follow_table(2, 1, 10)
    assert bench.F[261] == 0
    bench.loop(10)
    assert bench.position(1) > 10
    bench.until_flag(1, SYNC)
    assert bench.position(1) == 0.0


@pytest.mark.manual("ARP-105")
def test_master_whose_encoder_has_sent_nothing_is_at_rest() -> None:
    bench = AxesBench((1, 4, 1.0), *OF_EXAMPLE)
    bench.write_table(10, *A)
    bench.axes.preset_position(1, 100_000)
    bench.axes.follow_table(2, 1, 10)
    assert (bench.F[261], bench.F[263]) == (0, 1)  # on its way to the curve
    bench.until_flag(1, SYNC)
    assert bench.position(1) == 0.0


@pytest.mark.manual("ARP-106")
def test_ends_of_the_table_are_compared_in_thousandths() -> None:
    bench = AxesBench((1, 4, 1.0), (2, 1, 3.0), *OF_EXAMPLE)
    bench.write_table(10, (-10.0, -10.0), (10_000.333, 0.0))
    bench.counts[2] = 30_001  # 10000.3333...
    bench.loop(2)
    bench.axes.follow_table(2, 1, 10)
    assert bench.F[261] == 1
    bench.counts[2] = 30_002
    assert bench.loop().F[261] == 0


@pytest.mark.manual("ARP-102")
def test_other_reading_of_the_joins_takes_the_slave_through_its_points() -> None:
    for join, peak in (("round", 4750.0), ("through", 5000.0)):
        bench = locked((1, 7, 9000.0), readings=Readings.model_validate({"pst_join": join}))
        moved(bench, 5000)
        assert bench.position(1) == pytest.approx(peak)


@pytest.mark.manual("ARP-102")
def test_acceleration_of_the_joins_is_limited_by_acc_and_dec() -> None:
    for limit in ("limit_acceleration", "limit_deceleration"):
        bench = bench_of_a()
        getattr(bench.axes, limit)(1, 50_000)
        bench.axes.follow_table(2, 1, 10)
        moved(bench, 5000)
        assert bench.position(1) == pytest.approx(4500.0)  # a join of 2000


@pytest.mark.manual("ARP-019")
def test_coarse_master_makes_a_noisy_slave() -> None:
    """Reason for matching resolutions in the manual: a step of the master's is a step of the slave's reference."""
    roughness = {}
    for per_unit in (10.0, 0.1):
        bench = AxesBench((1, 4, 1.0), (2, 1, per_unit), *OF_EXAMPLE)
        bench.write_table(10, *A)
        bench.counts[2] = 0
        bench.loop()
        bench.axes.follow_table(2, 1, 10)
        steps, before = [], 0.0
        for loop in range(1, 400):
            bench.counts[2] = int(loop * 2.5 * per_unit)
            steps.append(bench.loop().position(1) - before)
            before = bench.position(1)
        roughness[per_unit] = max(steps) - min(steps)
    assert roughness[10.0] < 1e-6
    assert roughness[0.1] == pytest.approx(10.0)


@pytest.mark.manual("ARP-103")
@pytest.mark.parametrize(
    "program",
    [
        "PST 1, 2, V10",
        "V10 == 1\nPST 2, 1, V10",
        "V10 == 23\nPST 2, 1, V10",
        "V13 == 0\nPST 2, 1, V10",
        "@PAR1[7] == 4999.999\nPST 2, 1, V10",
        "VEL 1, 80\nPST 2, 1, V10",
        "@PAR1[7] == 99999\n@PAR1[24] == 15811.389\nPST 2, 1, V10",
        "ACC 1, 1\nPST 2, 1, V10",
    ],
)
def test_wrong_pst_is_error_113_and_moves_nothing(program: str) -> None:
    """A19; no program can reach the cause that is missing here, see below."""
    bench = bench_of_a()
    before = list(bench.F)
    bench.load(f"BEG MAIN\n{program}\nV1 == ERROR\nEND")
    bench.loop(50)
    assert bench.V[1] == 113_000
    assert bench.errors.error_axis == 1
    assert [*bench.F] == before
    assert bench.axes.position(1) == 0


@pytest.mark.manual("ARP-101", "ARP-103")
@pytest.mark.parametrize(("first", "error"), [(996, 0), (997, 113), (1000, 113)])
def test_a_table_has_to_end_at_v1000(first: int, error: int) -> None:
    """Digest 13.1: n + 2m <= 1000."""
    bench = bench_of_a()
    table = [2_000, 0, 0, 10_000_000, 0]
    bench.V[first:1001] = table[: 1001 - first]
    bench.axes.follow_table(2, 1, first)
    assert bench.errors.error == error
    assert bench.F[261] == (error == 0)


@pytest.mark.manual("ARP-103", "ARP-034")
def test_master_speed_of_0_is_error_113() -> None:
    """A19: RAM cannot contain it, since a write out of range is refused; flash of an older card might."""
    bench = bench_of_a()
    bench.parameters.ram[1][24] = 0
    bench.parameters.version += 1
    bench.axes.follow_table(2, 1, 10)
    assert bench.errors.error == 113


@pytest.mark.manual("ARP-103", "ARP-034")
@pytest.mark.parametrize(("master_speed", "error"), [(15_811.388, 0), (15_811.389, 113)])
def test_the_slave_s_parameter_24_says_how_fast_the_master_may_be(master_speed: float, error: int) -> None:
    """Digest 13.6; neither the master's own [24] nor its maximum speed, which are far larger here."""
    bench = bench_of_a((1, 7, 99_999.0), (1, 24, master_speed), (2, 7, 99_999.0), (2, 24, 99_999.0))
    bench.axes.follow_table(2, 1, 10)
    assert (bench.errors.error, bench.F[261]) == (error, int(not error))


@pytest.mark.manual("ARP-099")
def test_pst_needs_a_slave_that_may_move() -> None:
    bench = AxesBench((2, 4, 1.0), *OF_EXAMPLE)
    bench.write_table(10, *A)
    bench.axes.follow_table(2, 1, 10)
    bench.loop(10)
    assert (bench.F[261], bench.F[263], bench.errors.error) == (0, 0, 0)


def test_slave_positions_outside_its_counter_end_at_final_speed() -> None:
    """Manual 5.9.4.1, notes 5 and 6."""
    bench = locked((1, 5, 3000.0), (1, 6, 0.0))
    bench.axes.move_to(2, 5_000_000)
    bench.until_flag(1, SYNC, 0)
    assert 2990 < bench.position(2) < 3010
    assert bench.F[264] == 1


@pytest.mark.manual("ARP-028")
def test_slave_that_loses_control_ends_the_cam() -> None:
    bench = AxesBench((1, 4, 2.0), (2, 4, 1.0), *OF_EXAMPLE, (1, 14, 5.0))
    bench.write_table(10, *A)
    bench.counts[1] = 0
    bench.loop()
    bench.axes.follow_table(2, 1, 10)
    bench.axes.move_to(2, 1_000_000)
    bench.until_flag(1, SYNC, 0)
    assert bench.errors.error == 116
    assert bench.F[263] == 0
    assert bench.F[295] == 1
    assert bench.axes.volts(1) == 0.0
