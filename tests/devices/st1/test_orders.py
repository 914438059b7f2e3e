"""The axis of an ST1: orders, the parts of the set position, power, and what the node reports of it."""

import pytest
from st1_bench import ProgramBench

from fieldrig.clock import S
from fieldrig_devices.pamring.axis_words import Error, Status
from fieldrig_devices.pamring.frames import AxisItem, AxisOrder, AxisReport, Move, SetPoint, SetPointMode
from fieldrig_devices.st1.shaft import TURN

U = 1 / 360
"""A unit of the manual's example: a degree of the motor."""


@pytest.fixture
def bench() -> ProgramBench:
    return ProgramBench()


@pytest.mark.manual("PAML-042", "PAML-064")
@pytest.mark.parametrize(
    ("ms", "units", "speed"),
    [(0, 0, 0), (20_000, 60, 6), (50_000, 240, 6), (80_000, 420, 6), (85_000, 442.5, 3), (90_000, 450, 0)],
)
def test_a_move_is_a_trapezoid_in_the_node(bench: ProgramBench, ms: int, units: float, speed: float) -> None:
    # golden numbers of the manual: 450 u at 6 u/s, 0.3 u/s2 and 0.6 u/s2
    bench.move(Move.ABSOLUTE_MOVE, 450 * U, 6 * U, 0.3 * U, 0.6 * U)
    bench.run_to(ms)
    assert bench.position == pytest.approx(units * U, abs=1e-6)
    assert bench.speed == pytest.approx(speed * U, abs=1e-6)


@pytest.mark.manual("PAML-059")
def test_a_move_is_reported_as_done_when_it_ends(bench: ProgramBench) -> None:
    number = bench.move(Move.RELATIVE_MOVE, 2.0, 10.0, 100.0)
    assert bench.report == AxisReport(Status.IN_MOVE, 0, number - 1, 0)
    bench.run_to(299.999)  # 0.1 s of acceleration and deceleration over 0.5 turns each, 0.1 s at 10 turns/s
    assert bench.report.number == number - 1
    bench.run_to(300.001)
    assert bench.report == AxisReport(Status.STOPPED, 0, number, 2 * TURN)


def test_a_position_has_no_remainder(bench: ProgramBench) -> None:
    for value in (1234567, -7, 3):
        bench.send(AxisOrder(1, Move.RELATIVE_MOVE, value)).wait(5000)
    assert bench.servo.set.name_at(bench.clock.now_ns()) == 1234567 - 7 + 3


@pytest.mark.manual("PAML-053", "PAMS-010")
def test_a_move_replaces_the_one_in_progress(bench: ProgramBench) -> None:
    bench.move(Move.ABSOLUTE_MOVE, 10.0, 10.0, 100.0)
    bench.run_to(500)
    assert bench.position == pytest.approx(4.5)
    number = bench.move(Move.ABSOLUTE_MOVE, 2.0, 10.0, 100.0)
    bench.run_to(600)  # it cannot stop before: half a turn further, then back
    assert (bench.position, bench.speed) == pytest.approx((5.0, 0.0), abs=1e-6)
    bench.run_to(2000)
    assert bench.position == pytest.approx(2.0)
    assert bench.report.number == number


@pytest.mark.manual("PAML-053")
def test_a_move_ends_a_run(bench: ProgramBench) -> None:
    bench.move(Move.RUN, 10.0, acceleration=100.0)
    bench.run_to(1000)
    assert bench.report.status == Status.IN_RUN
    bench.move(Move.ABSOLUTE_MOVE, 20.0, 10.0, 100.0)
    assert bench.report.status == Status.IN_MOVE
    bench.run_to(3000)
    assert bench.position == pytest.approx(20.0)


@pytest.mark.manual("PAMS-014", "PAML-054")
def test_a_relative_move_counts_from_where_the_axis_is(bench: ProgramBench) -> None:
    bench.move(Move.RELATIVE_MOVE, 10.0, 10.0, 100.0)
    bench.run_to(500)
    bench.move(Move.RELATIVE_MOVE, 3.0, 10.0, 100.0)
    bench.run_to(3000)
    assert bench.position == pytest.approx(7.5)


@pytest.mark.manual("PAMS-015")
def test_a_run_is_done_at_its_speed_and_goes_on_without_drift(bench: ProgramBench) -> None:
    number = bench.move(Move.RUN, -7.0, acceleration=70.0)
    bench.run_to(99)
    assert bench.report.number == number - 1
    bench.run_to(100)
    assert (bench.report.number, bench.report.status) == (number, Status.IN_RUN)
    before, start_ns = bench.servo.set.motor_at(bench.clock.now_ns()), bench.clock.now_ns()
    bench.run_to(100_000_000)
    seconds = (bench.clock.now_ns() - start_ns) // S
    assert bench.servo.set.motor_at(start_ns + seconds * S) - before == -7 * TURN * seconds


@pytest.mark.manual("PAML-054", "PAMS-015")
def test_run_0_ends_the_run(bench: ProgramBench) -> None:
    bench.move(Move.RUN, 10.0, acceleration=100.0)
    bench.run_to(1000)
    number = bench.move(Move.RUN, 0.0, acceleration=100.0, deceleration=50.0)
    bench.run_to(1200)
    assert (bench.report.number, bench.report.status, bench.speed) == (number, Status.STOPPED, 0.0)
    assert bench.position == pytest.approx(0.5 + 9.0 + 1.0)


@pytest.mark.manual("PAML-057", "PAMS-017")
@pytest.mark.parametrize(("deceleration", "ms"), [(100.0, 100), (0.0, 20)])
def test_a_stop_takes_its_deceleration_or_astop(bench: ProgramBench, deceleration: float, ms: float) -> None:
    bench.move(Move.RUN, 10.0)
    bench.run_to(1000)
    number = bench.move(Move.STOP, deceleration=deceleration)
    bench.run_to(1000 + ms - 0.1)
    assert bench.speed > 0
    bench.run_to(1000 + ms)
    assert (bench.speed, bench.report.number, bench.report.status) == (0.0, number, Status.STOPPED)


@pytest.mark.manual("PAML-048", "PAML-049")
def test_speed_and_acceleration_are_clipped_to_ckv_and_cka() -> None:
    bench = ProgramBench(parameters={"ckv": 20.0, "cka": 200.0})
    bench.move(Move.RUN, 500.0, acceleration=5000.0)
    bench.run_to(50)
    assert bench.speed == pytest.approx(10.0)
    bench.run_to(1000)
    assert bench.speed == pytest.approx(20.0)
    bench.move(Move.ABSOLUTE_MOVE, 0.0, 500.0, 5000.0, 5000.0)
    bench.run_to(2000)
    assert bench.speed == pytest.approx(-20.0)


@pytest.mark.manual("PAML-055", "PAMS-013")
def test_power_on_makes_the_position_0_without_a_motion(bench: ProgramBench) -> None:
    bench.move(Move.RELATIVE_MOVE, 2.5, 10.0)
    bench.run_to(1000)
    motor = bench.motor
    number = bench.move(Move.POWER_ON)
    assert (bench.position, bench.motor, bench.report.number) == (0.0, motor, number)
    bench.move(Move.POWER_ON, 0.75)  # the PAM's other reading: its INITIAL_POSITION
    assert (bench.position, bench.motor) == (0.75, motor)


@pytest.mark.manual("PAML-056", "PAMS-012")
def test_power_off_stops_the_axis_first(bench: ProgramBench) -> None:
    bench.move(Move.RUN, 10.0)
    bench.run_to(1000)
    number = bench.move(Move.POWER_OFF)
    bench.run_to(1010)
    assert bench.speed == pytest.approx(5.0)
    assert bench.report.number == number - 1
    bench.run_to(1020)
    assert bench.report == AxisReport(Status.POWER_OFF | Status.STOPPED, 0, number, bench.report.set_point)
    assert bench.servo.is_powered is False


@pytest.mark.manual("PAMS-055")
def test_the_bits_of_the_status_are_those_of_the_table(bench: ProgramBench) -> None:
    """Table 12-4 of the manual."""
    seen = [int(ProgramBench(power=False).report.status), int(bench.report.status)]
    for move in (Move.RELATIVE_MOVE, Move.RUN):
        bench.move(move, 10.0, acceleration=100.0)
        seen.append(int(bench.report.status))
    bench.move(Move.STOP, deceleration=100.0)
    bench.run_to(1000)
    bench.send(SetPoint(SetPointMode.POSITION, 0), SetPoint(SetPointMode.POSITION, TURN))
    bench.cycle(500)
    seen.append(int(bench.report.status))
    assert seen == [16 + 32, 32, 2, 4, 1]


@pytest.mark.manual("PAML-060", "PAMS-055")
def test_an_axis_begins_without_power() -> None:
    bench = ProgramBench(power=False)
    assert bench.report.status == Status.POWER_OFF | Status.STOPPED


def test_a_move_without_power_is_refused() -> None:
    bench = ProgramBench(power=False)  # G-15
    number = bench.move(Move.ABSOLUTE_MOVE, 1.0)
    assert (bench.report.number, bench.report.error) == (number, Error.POWER_STAGE_DISABLED)
    bench.run_to(1000)
    assert bench.position == 0.0
    bench.move(Move.UPDATE_STATUS)
    assert bench.report.error == 0


@pytest.mark.manual("PAML-058", "PAMS-011")
def test_a_new_name_moves_nothing_and_a_move_goes_on(bench: ProgramBench) -> None:
    bench.move(Move.ABSOLUTE_MOVE, 10.0, 10.0, 100.0)
    bench.run_to(500)
    bench.move(Move.POSITION, 100.0)
    assert (bench.position, bench.motor, bench.speed) == pytest.approx((100.0, 4.5, 10.0))
    bench.run_to(2000)
    assert (bench.position, bench.motor) == pytest.approx((105.5, 10.0))


@pytest.mark.manual("PAML-043")
def test_the_initial_position_is_a_name() -> None:
    bench = ProgramBench(power=False, initial_turns=3.0)
    assert bench.program.accept(AxisItem(1, 5 * TURN, 0))
    assert (bench.position, bench.motor, bench.report.set_point) == (5.0, 3.0, 5 * TURN)


@pytest.mark.manual("PAML-044")
@pytest.mark.parametrize("target", [0.5, 2.5, 7.5, -0.5])
def test_an_absolute_move_within_a_period_goes_by_the_numbers(target: float) -> None:
    bench = ProgramBench(period=3.0)  # G-14
    bench.move(Move.ABSOLUTE_MOVE, target, 10.0)
    bench.run_to(2000)
    assert bench.motor == pytest.approx(target)
    assert bench.position == pytest.approx(target % 3)


@pytest.mark.manual("PAML-044")
def test_a_position_stays_within_its_period() -> None:
    bench = ProgramBench(period=1.5)
    bench.move(Move.RELATIVE_MOVE, 4.0, 10.0)
    bench.run_to(2000)
    assert bench.report.set_point == TURN
    bench.move(Move.ABSOLUTE_MOVE, 0.0, 10.0)
    bench.run_to(4000)
    assert bench.motor == pytest.approx(3.0)


@pytest.mark.manual("PAML-065", "PAMS-018")
def test_update_status_reports_the_axis_again(bench: ProgramBench) -> None:
    bench.take(AxisReport)
    bench.move(Move.UPDATE_STATUS)
    assert len(bench.take(AxisReport)) == 1


def test_a_node_at_rest_has_nothing_to_do(bench: ProgramBench) -> None:
    bench.move(Move.RELATIVE_MOVE, 1.0)
    bench.run_to(1000)
    bench.take(AxisReport)
    assert bench.clock.next_ns() is None
    bench.cycle(10)
    assert not bench.port.sent


@pytest.mark.manual("PAML-057")
def test_a_set_point_during_a_stop_counts_after_it(bench: ProgramBench) -> None:
    bench.move(Move.RUN, 10.0)
    bench.run_to(100)
    number = bench.move(Move.STOP, deceleration=100.0)
    bench.send(SetPoint(SetPointMode.POSITION, 0), SetPoint(SetPointMode.POSITION, TURN))
    bench.run_to(150)
    assert bench.speed == pytest.approx(5.0)
    bench.cycle(500)
    assert (bench.position, bench.report.status, bench.report.number) == (1.0, Status.SYNCHRONISED, number)


def test_a_set_point_of_a_pipe_that_has_ended_does_not_count_after_a_stop(bench: ProgramBench) -> None:
    bench.move(Move.RUN, 10.0)
    bench.run_to(100)
    bench.move(Move.STOP, deceleration=100.0)
    bench.send(SetPoint(SetPointMode.POSITION, TURN)).end()
    bench.cycle(500)
    assert bench.report.status == Status.STOPPED


def test_power_off_takes_the_deceleration_of_the_axis(bench: ProgramBench) -> None:
    bench.move(Move.RUN, 10.0)
    bench.run_to(1000)
    bench.move(Move.POWER_OFF, deceleration=50.0)
    bench.run_to(1100)
    assert bench.speed == pytest.approx(5.0)


@pytest.mark.manual("PAML-057")
def test_a_stop_ends_also_what_a_set_point_during_an_earlier_stop_would_begin(bench: ProgramBench) -> None:
    bench.move(Move.RUN, 10.0)
    bench.run_to(1000)
    bench.move(Move.STOP, deceleration=10.0)
    bench.point(1.0, SetPointMode.SPEED)
    bench.move(Move.STOP, deceleration=10.0)
    bench.wait(5000)
    assert bench.speed == 0.0
