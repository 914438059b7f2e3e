"""The part of a pipe in the set position: modes, the sum with the own part, jumps, and the end of a pipe."""

import pytest
from st1_bench import ProgramBench

from fieldrig.clock import MS
from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.pamring.axis_words import Error, Status
from fieldrig_devices.pamring.frames import EndOfPipe, Move, SetPoint, SetPointMode
from fieldrig_devices.st1.pipe_part import PipePart
from fieldrig_devices.st1.shaft import TURN

POSITION, SPEED, TORQUE = SetPointMode.POSITION, SetPointMode.SPEED, SetPointMode.TORQUE


@pytest.fixture
def bench() -> ProgramBench:
    return ProgramBench()


def ramp(bench: ProgramBench, last: int, first: int = 0) -> None:
    """Accelerate with 100 turns/s2 as a pipe does, from rest."""
    for cycle in range(first, last):
        bench.point(50e-6 * cycle * cycle)


@pytest.mark.manual("PAML-042")
def test_an_axis_is_at_each_set_point_one_interval_later(bench: ProgramBench) -> None:
    ramp(bench, 100)
    for cycle in range(100, 110):
        assert bench.position == pytest.approx(50e-6 * (cycle - 1) ** 2, abs=1e-8)
        bench.point(50e-6 * cycle * cycle)
    assert bench.report.status == Status.SYNCHRONISED


def test_set_points_of_every_fourth_cycle_make_a_steady_motion(bench: ProgramBench) -> None:
    for number in range(10):
        bench.point(0.004 * number).cycle(3)
    speeds = []
    for _ in range(4):
        speeds.append(bench.speed)
        bench.wait(0.99)
    assert speeds == pytest.approx([1.0] * 4, abs=1e-6)


def test_a_set_point_holds_until_the_next(bench: ProgramBench) -> None:
    bench.point(0.0).point(0.0005).cycle(500)
    assert (bench.position, bench.speed) == pytest.approx((0.0005, 0.0), abs=1e-9)
    bench.point(0.001).cycle()
    assert bench.position == pytest.approx(0.001, abs=1e-9)


def test_an_axis_goes_on_steadily_where_frames_are_damaged(bench: ProgramBench) -> None:
    for cycle in range(100):
        bench.point(0.001 * cycle)
    bench.wait(2)
    assert (bench.position, bench.speed) == pytest.approx((0.101, 1.0), abs=1e-6)
    for cycle in range(102, 110):
        bench.point(0.001 * cycle)
    assert (bench.position, bench.speed, bench.lag) == pytest.approx((0.109, 1.0, 0.0), abs=1e-6)


def test_an_axis_holds_the_last_set_point_where_no_cycle_comes(bench: ProgramBench) -> None:
    for cycle in range(100):
        bench.point(0.001 * cycle)
    bench.wait(3.9)
    assert bench.position == pytest.approx(0.1029, abs=1e-6)
    bench.wait(50)
    assert (bench.position, bench.speed, bench.lag) == pytest.approx((0.099, 0.0, 0.0), abs=1e-6)


@pytest.mark.long
def test_set_points_that_come_late_and_all_at_once_do_not_make_an_axis_overshoot(bench: ProgramBench) -> None:
    """The pattern is that of processes on a busy host; the limit of the lag is one turn."""
    furthest, cycle = 0.0, 0
    for _ in range(40):
        for _ in range(10):
            bench.point(0.008 * cycle)
            cycle += 1
        bench.wait(30)
        for _ in range(30):
            bench.send(SetPoint(POSITION, round(0.008 * cycle * TURN)))
            bench.program.cycle()
            bench.wait(0.05)
            cycle += 1
            furthest = max(furthest, abs(bench.position - 0.008 * cycle))
    assert bench.servo.is_powered
    assert furthest < 0.4
    for _ in range(100):
        bench.point(0.008 * cycle)
        cycle += 1
    assert (bench.position, bench.speed) == pytest.approx((0.008 * (cycle - 1), 8.0), abs=1e-6)


def test_an_axis_whose_timer_is_late_is_at_its_last_set_point() -> None:
    pipe = PipePart(Limits(1e12, 1e15, 1e15))
    pipe.begin(0, POSITION)
    for number in range(1, 6):
        pipe.set_position(number * MS, number * 1000)
    assert [pipe.at(5 * MS + after_ns) for after_ns in (MS, 4 * MS, 5 * MS, 900 * MS)] == [5000, 8000, 5000, 5000]
    pipe.set_position(905 * MS, 6000)
    assert pipe.at(905 * MS) == 5000
    assert pipe.at(999 * MS) == 6000


@pytest.mark.manual("PAML-053", "PAML-054")
def test_a_move_is_superimposed_on_a_pipe(bench: ProgramBench) -> None:
    bench.point(0.0)
    bench.move(Move.ABSOLUTE_MOVE, 0.5, 10.0, 100.0)
    for cycle in range(1000):
        bench.point(0.001 * cycle)
    assert bench.position == pytest.approx(0.999 + 0.5, abs=1e-6)
    assert bench.report.set_point == TURN // 2
    bench.move(Move.RELATIVE_MOVE, -0.2, 10.0, 100.0)
    for cycle in range(1000, 2000):
        bench.point(0.001 * cycle)
    assert bench.position == pytest.approx(1.999 + 0.3, abs=1e-6)


@pytest.mark.manual("PAML-054", "PAMS-015")
def test_run_0_ends_only_the_superimposed_motion(bench: ProgramBench) -> None:
    bench.point(0.0)
    bench.move(Move.RUN, 2.0, acceleration=100.0)
    for cycle in range(500):
        bench.point(0.001 * cycle)
    assert bench.speed == pytest.approx(1.0 + 2.0, abs=1e-6)
    bench.move(Move.RUN, 0.0, acceleration=100.0)
    for cycle in range(500, 600):
        bench.point(0.001 * cycle)
    assert bench.speed == pytest.approx(1.0, abs=1e-6)


@pytest.mark.manual("PAML-405")
def test_no_jump_if_the_first_set_point_is_the_position(bench: ProgramBench) -> None:
    bench.move(Move.ABSOLUTE_MOVE, 0.75, 10.0)
    bench.run_to(1000)
    bench.point(0.75).cycle(5)
    assert (bench.position, bench.speed, bench.report.set_point) == (0.75, 0.0, 0)
    assert bench.report.status == Status.SYNCHRONISED


@pytest.mark.manual("PAML-405")
def test_an_axis_jumps_at_maximum_torque(bench: ProgramBench) -> None:
    bench.point(0.5)
    assert bench.report.error == Error.CHANGE_IN_CD | Error.CURRENT_LIMITED
    # 19.5 N m at 0.002 kg m2 are 1551.8 turns/s2: half a turn takes 2 * sqrt(0.5 / 1551.8) = 35.9 ms
    bench.cycle(35)
    assert bench.position == pytest.approx(0.5, abs=0.03)
    bench.cycle(10)
    assert (bench.position, bench.lag) == (0.5, 0.0)
    assert bench.report.error == Error.CHANGE_IN_CD
    bench.move(Move.UPDATE_STATUS)
    assert bench.report.error == 0


@pytest.mark.manual("PAML-171", "PAML-406")
def test_the_position_holds_after_a_pipe(bench: ProgramBench) -> None:
    bench.point(0.0).point(0.0005)
    bench.end().cycle(10)
    assert bench.position == pytest.approx(0.0005, abs=1e-9)
    assert bench.report.status == Status.STOPPED
    assert bench.report.set_point == round(0.0005 * TURN)
    bench.move(Move.ABSOLUTE_MOVE, 1.0, 10.0)
    bench.run_to(1000)
    assert bench.position == pytest.approx(1.0)


def test_a_pipe_may_end_in_the_cycle_of_its_last_set_point(bench: ProgramBench) -> None:
    bench.point(0.0)
    bench.send(SetPoint(POSITION, TURN // 2000), EndOfPipe(POSITION)).cycle(10)
    assert bench.report.set_point == TURN // 2000
    assert bench.report.status == Status.STOPPED


@pytest.mark.manual("PAML-171", "PAML-406")
def test_the_speed_goes_to_0_after_a_pipe(bench: ProgramBench) -> None:
    bench.point(10.0, SPEED)
    bench.cycle(99)
    assert bench.speed == pytest.approx(10.0)
    bench.end(SPEED).cycle(5)
    assert bench.speed == pytest.approx(5.0)  # with CKA, 1000 turns/s2
    bench.cycle(6)
    assert (bench.speed, bench.report.status) == (0.0, Status.STOPPED)
    assert bench.report.set_point == pytest.approx((0.05 + 0.09 * 10 + 0.05) * TURN, rel=1e-6)


def test_a_pipe_of_speeds_adds_up_exactly(bench: ProgramBench) -> None:
    thirds = TURN // 3  # RU/s, which a millisecond does not divide
    for cycle in range(3000):
        bench.send(SetPoint(SPEED, thirds + cycle % 2)).cycle()
    assert bench.servo.set.pipe.at(bench.clock.now_ns()) == thirds * 3 + 1  # half of 3 s with 1 RU/s more


@pytest.mark.manual("PAML-044")
def test_set_points_pass_the_end_of_a_period(bench: ProgramBench) -> None:
    bench = ProgramBench(period=1.0)
    for cycle in range(2500):
        bench.point(0.001 * cycle % 1.0)
    assert bench.motor == pytest.approx(2.498, abs=0.002)
    assert bench.position == pytest.approx(0.499, abs=0.002)
    assert bench.report.error == 0


def test_a_pipe_begins_the_shorter_way_round(bench: ProgramBench) -> None:
    bench = ProgramBench(period=1.0)
    bench.point(0.999).cycle(50)
    assert bench.motor == pytest.approx(-0.001)


@pytest.mark.manual("PAML-171")
def test_a_limit_of_torque_ends_with_its_pipe(bench: ProgramBench) -> None:
    bench.point(0.1, TORQUE)
    # 2 N m less 0.5 N m of friction at 0.002 kg m2 are 119.4 turns/s2
    bench.point(0.2).cycle(20)
    assert bench.speed == pytest.approx(119.4 * 0.021, rel=0.01)
    assert bench.report.error & Error.CURRENT_LIMITED
    bench.end(TORQUE).cycle(60)
    assert (bench.lag, bench.report.error & Error.CURRENT_LIMITED) == (0, 0)


@pytest.mark.manual("PAML-057")
def test_a_stop_ends_the_pipe_and_what_is_superimposed(bench: ProgramBench) -> None:
    bench.point(0.0)
    bench.move(Move.RUN, 2.0)
    for cycle in range(500):
        bench.point(0.003 * cycle)
    assert bench.speed == pytest.approx(5.0, abs=1e-6)
    number = bench.move(Move.STOP, deceleration=50.0)
    bench.end()
    bench.wait(100.001)
    assert (bench.speed, bench.report.number, bench.report.status) == (0.0, number, Status.STOPPED)
    assert bench.report.set_point == round(bench.position * TURN)


def test_without_power_a_pipe_moves_nothing() -> None:
    bench = ProgramBench(power=False)
    bench.point(0.0).point(1.0).cycle(10)
    assert bench.motor == 0.0
