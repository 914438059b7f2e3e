"""A DC motor of a node: moves, braking, zero, stroke limits, and all errors (PAML-120 to PAML-130)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from smart_io_bench import COUNTER, DEC, INC, MOTOR, ZERO, SmartIoBench

from fieldrig.clock import MS, VirtualClock
from fieldrig_devices.pamring.ends import RingFault
from fieldrig_devices.pamring.frames import (
    Answer,
    CounterItem,
    InputItem,
    Motor,
    MotorItem,
    MotorOrder,
    MotorReport,
    OutputItem,
    Read,
    SetOutput,
    Severity,
    Trouble,
)
from fieldrig_devices.smart_io.motor import DcMotor, MotorLimits, MotorState

TIMEOUT, LOWER, UPPER, LOST, UNEXPECTED, DOES_NOT_STOP = 0x1, 0x2, 0x4, 0x2000, 0x4000, 0x8000
"""Bits of Table 12-3."""


@pytest.fixture
def bench() -> SmartIoBench:
    bench = SmartIoBench()
    bench.configure_motor()
    return bench


def outputs(bench: SmartIoBench) -> tuple[bool, bool]:
    return bench.last("motor.inc"), bench.last("motor.dec")


def position(bench: SmartIoBench) -> int | None:
    bench.order(Read(1, MOTOR))
    answer = bench.port.sent[-1]
    assert isinstance(answer, Answer)
    return answer.value


@pytest.mark.manual("PAML-120")
def test_a_motor_consists_of_items_that_are_there() -> None:
    bench = SmartIoBench()
    parts = (
        OutputItem(INC, 201, 1, True), OutputItem(DEC, 202, 1, True), InputItem(ZERO, 102, 1, True, 1, 1),
        CounterItem(COUNTER, 101, True, 1, 1),
    )  # fmt: skip
    for part in parts:
        assert bench.program.accept(part)
    for wrong in (
        (INC, INC, ZERO, COUNTER), (INC, DEC, COUNTER, ZERO), (INC, DEC, ZERO, ZERO), (INC, 9, ZERO, COUNTER),
        (ZERO, DEC, ZERO, COUNTER),
    ):  # fmt: skip
        assert not bench.program.accept(MotorItem(MOTOR, *wrong, 500, 2))
    assert not bench.program.accept(MotorItem(MOTOR, INC, DEC, ZERO, COUNTER, 0, 2))
    assert bench.program.accept(MotorItem(MOTOR, INC, DEC, ZERO, COUNTER, 500, 2))


@pytest.mark.manual("PAML-121")
@pytest.mark.manual("PAML-122")
@pytest.mark.manual("PAML-123")
def test_the_output_is_off_braking_pulses_before_the_target(bench: SmartIoBench) -> None:
    bench.move(Motor.ABSOLUTE_MOVE, 10)
    assert outputs(bench) == (True, False)
    bench.pulse(7)
    assert outputs(bench) == (True, False)
    bench.pulse()
    assert outputs(bench) == (False, False), "BRAKING is 2"
    bench.pulse(2)  # it coasts
    assert position(bench) == 10
    bench.move(Motor.RELATIVE_MOVE, -5)
    bench.run(101)
    assert outputs(bench) == (False, True)
    bench.pulse(5)
    assert position(bench) == 5


@pytest.mark.manual("PAML-129")
def test_the_motor_is_ready_when_no_pulse_has_come_for_a_while(bench: SmartIoBench) -> None:
    bench.move(Motor.ABSOLUTE_MOVE, 4)
    assert bench.motor() == MotorReport(MOTOR, False, 0)
    bench.pulse(4)
    bench.run(89)
    assert not bench.motor().is_ready
    bench.run(2)
    assert bench.motor() == MotorReport(MOTOR, True, 0)


def test_an_order_that_needs_no_motion_is_done_at_once_and_still_reported(bench: SmartIoBench) -> None:
    bench.port.take()
    bench.move(Motor.ABSOLUTE_MOVE, 0)
    assert bench.port.take() == [MotorReport(MOTOR, False, 0), MotorReport(MOTOR, True, 0)]
    bench.move(Motor.STOP)
    assert bench.port.take() == [MotorReport(MOTOR, False, 0), MotorReport(MOTOR, True, 0)]


def test_a_move_that_is_shorter_than_braking_moves_by_a_pulse(bench: SmartIoBench) -> None:
    bench.move(Motor.ABSOLUTE_MOVE, 1)
    assert outputs(bench) == (True, False)
    bench.pulse()
    assert outputs(bench) == (False, False)


def test_an_order_for_the_other_direction_waits_until_the_motor_stands(bench: SmartIoBench) -> None:
    bench.move(Motor.RUN, 1)
    bench.pulse(5)
    bench.move(Motor.ABSOLUTE_MOVE, 0)
    assert outputs(bench) == (False, False)
    bench.pulse(2)
    assert position(bench) == 7
    bench.run(101)
    assert outputs(bench) == (False, True)
    bench.pulse(7)
    assert position(bench) == 0


@pytest.mark.manual("PAML-125")
def test_run_turns_until_stop(bench: SmartIoBench) -> None:
    bench.move(Motor.RUN, -1)
    assert outputs(bench) == (False, True)
    bench.pulse(50)
    bench.move(Motor.STOP)
    assert outputs(bench) == (False, False)
    bench.run(101)
    assert bench.motor().is_ready
    assert position(bench) == -50


@pytest.mark.manual("PAML-126")
@pytest.mark.parametrize(("is_active_high", "level"), [(True, 1), (False, 1), (True, 0)])
def test_zero_position_drives_until_the_input_has_its_level(is_active_high: bool, level: int) -> None:
    bench = SmartIoBench()
    bench.configure(
        OutputItem(INC, 201, 1, True), OutputItem(DEC, 202, 1, True), InputItem(ZERO, 102, 1, is_active_high, 1, 1),
        CounterItem(COUNTER, 101, True, 1, 1), MotorItem(MOTOR, INC, DEC, ZERO, COUNTER, 500, 2),
    )  # fmt: skip
    bench.wire("motor.zero", not level)
    bench.run(5)
    bench.move(Motor.ZERO_POSITION, -1, level)
    bench.pulse(30)
    assert outputs(bench) == (False, True)
    bench.wire("motor.zero", bool(level))
    bench.run(1)
    assert outputs(bench) == (False, False)
    bench.pulse(2)
    assert position(bench) == -2, "the pulses of coasting count"
    bench.run(101)
    assert bench.motor() == MotorReport(MOTOR, True, 0)


def test_zero_position_ends_at_once_if_the_input_has_its_level(bench: SmartIoBench) -> None:
    bench.move(Motor.POSITION, 77)
    bench.wire("motor.zero", True)
    bench.run(1)
    bench.move(Motor.ZERO_POSITION, -1, 1)
    assert outputs(bench) == (False, False)
    assert bench.motor().is_ready
    assert position(bench) == 0


@pytest.mark.manual("PAML-127")
@pytest.mark.parametrize(("direction", "limit", "bit", "code"), [(1, 20, UPPER, 0x0E), (-1, -20, LOWER, 0x0D)])
def test_a_run_ends_at_a_stroke_limit_with_its_error(
    bench: SmartIoBench, direction: int, limit: int, bit: int, code: int
) -> None:
    bench.move(Motor.STROKE_LIMITS, -20, 20)
    bench.move(Motor.RUN, direction)
    bench.pulse(18)
    assert outputs(bench) == (False, False)
    bench.pulse(2)
    bench.run(101)
    assert position(bench) == limit
    assert bench.motor() == MotorReport(MOTOR, True, bit)
    assert bench.troubles() == [Trouble(Severity.WARNING, 0x010, (MOTOR, code))]
    bench.move(Motor.RUN, direction)
    assert outputs(bench) == (False, False), "it is at the limit"
    bench.port.take()
    bench.move(Motor.RUN, -direction)
    assert outputs(bench) != (False, False)
    assert bench.troubles() == [Trouble(Severity.ENDED, 0x010, (MOTOR, code))]


@pytest.mark.manual("PAML-127")
def test_limits_do_not_matter_to_a_move_that_ends_at_one_nor_when_they_are_disabled(bench: SmartIoBench) -> None:
    bench.move(Motor.STROKE_LIMITS, -20, 20)
    bench.move(Motor.ABSOLUTE_MOVE, 20)
    bench.pulse(20)
    bench.run(101)
    assert bench.motor() == MotorReport(MOTOR, True, 0)
    bench.move(Motor.DISABLE_STROKE_LIMITS)
    bench.move(Motor.ABSOLUTE_MOVE, 30)
    bench.pulse(10)
    bench.run(101)
    assert bench.motor() == MotorReport(MOTOR, True, 0)
    assert position(bench) == 30


@pytest.mark.manual("PAML-124")
@pytest.mark.manual("PAMS-053")
def test_no_pulse_within_timeout_is_error_07(bench: SmartIoBench) -> None:
    bench.move(Motor.RUN, 1)
    bench.pulse(3)
    bench.run(489)
    assert outputs(bench) == (True, False)
    bench.run(2)
    assert outputs(bench) == (False, False)
    assert bench.motor().error == TIMEOUT
    assert bench.troubles() == [Trouble(Severity.WARNING, 0x010, (MOTOR, 0x07))]
    bench.run(101)
    assert bench.motor() == MotorReport(MOTOR, True, TIMEOUT)
    bench.port.take()
    bench.move(Motor.RUN, 1)
    assert bench.troubles() == [Trouble(Severity.ENDED, 0x010, (MOTOR, 0x07))]


@pytest.mark.manual("PAML-130")
@pytest.mark.manual("PAMS-053")
def test_pulses_without_an_order_are_an_unexpected_move_and_then_the_position_is_lost(bench: SmartIoBench) -> None:
    bench.pulse(2)
    assert bench.troubles() == [Trouble(Severity.WARNING, 0x010, (MOTOR, 0x10), word=UNEXPECTED)]
    bench.pulse()
    assert position(bench) == 3, "as if INC had been driven"
    assert bench.motor().error == UNEXPECTED | LOST
    assert bench.troubles() == [Trouble(Severity.WARNING, 0x010, (MOTOR, 0x0F), word=UNEXPECTED | LOST)]
    bench.move(Motor.POSITION, 0)
    assert bench.motor().error == UNEXPECTED
    assert bench.troubles() == [Trouble(Severity.ENDED, 0x010, (MOTOR, 0x0F), word=UNEXPECTED)]
    bench.move(Motor.STOP)
    bench.move(Motor.RUN, 1)
    assert bench.troubles() == [Trouble(Severity.ENDED, 0x010, (MOTOR, 0x10))]


@pytest.mark.manual("PAML-125")
@pytest.mark.manual("PAML-130")
def test_a_motor_that_does_not_stop_is_error_11(bench: SmartIoBench) -> None:
    bench.move(Motor.RUN, 1)
    bench.pulse(3)
    bench.move(Motor.STOP)
    bench.pulse(50)  # 500 ms
    assert bench.motor().error == 0
    bench.pulse(2)
    assert bench.motor() == MotorReport(MOTOR, True, DOES_NOT_STOP | LOST)
    assert [trouble.details for trouble in bench.troubles()] == [(MOTOR, 0x0F), (MOTOR, 0x11)]
    assert bench.get("error_word") == DOES_NOT_STOP | LOST


@pytest.mark.manual("PAML-129")
def test_an_order_that_waits_for_a_motor_that_does_not_stop_ends_with_its_error(bench: SmartIoBench) -> None:
    bench.move(Motor.RUN, 1)
    bench.pulse(3)
    bench.move(Motor.RUN, -1)
    bench.pulse(52)  # 520 ms
    assert bench.motor() == MotorReport(MOTOR, True, DOES_NOT_STOP | LOST)
    bench.run(500)
    assert outputs(bench) == (False, False), "what is ready does not begin"


@pytest.mark.manual("PAML-129")
def test_the_state_after_an_order_is_reported_with_its_number(bench: SmartIoBench) -> None:
    bench.port.take()
    bench.order(MotorOrder(MOTOR, Motor.RUN, (1,), 7))
    assert bench.port.take() == [MotorReport(MOTOR, False, 0), MotorReport(MOTOR, False, 0, 7)]
    bench.order(MotorOrder(MOTOR, Motor.RUN, (1,), 8))
    assert bench.port.take() == [MotorReport(MOTOR, False, 0, 8)], "although it goes on as before"
    bench.order(MotorOrder(MOTOR, Motor.POSITION, (5,)))
    assert bench.port.take() == [], "it leaves ready alone"


@pytest.mark.manual("PAML-128")
def test_a_position_inquiry_is_answered_and_one_of_another_item_is_not(bench: SmartIoBench) -> None:
    bench.move(Motor.POSITION, -123)
    bench.order(Read(42, MOTOR), Read(43, INC), Read(44, 99))
    assert bench.port.take()[-3:] == [Answer(42, -123), Answer(43, None), Answer(44, None)]


def test_a_motor_that_is_configured_again_has_its_parts_again(bench: SmartIoBench) -> None:
    assert bench.program.accept(MotorItem(MOTOR, INC, DEC, ZERO, COUNTER, 500, 0))
    bench.move(Motor.ABSOLUTE_MOVE, 3)
    bench.pulse(3)
    assert outputs(bench) == (False, False)
    assert position(bench) == 3


def test_only_the_motor_switches_its_outputs(bench: SmartIoBench) -> None:
    bench.order(SetOutput(INC, 1))
    assert outputs(bench) == (False, False)
    assert bench.troubles() == [Trouble(Severity.WARNING, 0x00C, (0x0A, 0), word=0x02_0000)]


@pytest.mark.parametrize(
    ("order", "values"),
    [
        (Motor.ABSOLUTE_MOVE, ()), (Motor.RUN, (2,)), (Motor.ZERO_POSITION, (0, 1)), (Motor.ZERO_POSITION, (1, 2)),
        (Motor.STROKE_LIMITS, (5, 4)), (Motor.STOP, (1,)),
    ],
)  # fmt: skip
def test_an_order_with_wrong_values_is_not_allowed(bench: SmartIoBench, order: Motor, values: tuple[int, ...]) -> None:
    bench.move(order, *values)
    assert [trouble.details for trouble in bench.troubles()] == [(0x0A, 0)]
    assert outputs(bench) == (False, False)


def test_a_motor_stops_when_the_ring_is_silent(bench: SmartIoBench) -> None:
    bench.move(Motor.RUN, 1)
    bench.program.ring(RingFault.INACTIVE)
    assert outputs(bench) == (False, False)


@given(
    st.lists(
        st.one_of(
            st.tuples(st.sampled_from([Motor.ABSOLUTE_MOVE, Motor.RELATIVE_MOVE]), st.tuples(st.integers(-30, 30))),
            st.tuples(st.just(Motor.RUN), st.tuples(st.sampled_from([1, -1]))),
            st.tuples(st.just(Motor.STOP), st.just(())),
            st.tuples(st.just(Motor.STROKE_LIMITS), st.tuples(st.integers(-20, 0), st.integers(0, 20))),
            st.integers(1, 8),
        ),
        max_size=30,
    )
)
def test_position_and_outputs_are_right_for_any_sequence_of_orders_and_pulses(
    steps: list[tuple[Motor, tuple[int, ...]] | int],
) -> None:
    """The motor coasts by one pulse, and never moves at rest.  A number is as many pulses while it is driven."""
    clock = VirtualClock()
    driven: list[int] = [0]
    motor = DcMotor(clock, MotorLimits(500 * MS, 50 * MS), 1, driven.append, lambda: False, lambda: None)
    true_position, last = 0, 1

    def turn() -> None:
        nonlocal true_position
        true_position += last
        motor.on_pulse()

    for step in steps:
        was = driven[-1]
        if isinstance(step, int):
            for _ in range(step):
                clock.advance_to(clock.now_ns() + 10 * MS)
                if not driven[-1]:
                    break
                turn()
        else:
            assert motor.order(*step)
        if was and not driven[-1]:
            turn()  # coasting
        clock.advance_to(clock.now_ns() + (60 if not driven[-1] else 1) * MS)
        last = driven[-1] or last
        assert motor.position == true_position
        assert (motor.state is MotorState.DRIVEN) == bool(driven[-1])
        assert not motor.errors & {0x07, 0x0F, 0x10, 0x11}
        if not driven[-1]:
            assert motor.is_ready


def test_a_motor_ends_where_it_was_sent_for_good() -> None:
    clock = VirtualClock()
    driven: list[int] = []
    motor = DcMotor(clock, MotorLimits(500 * MS, 50 * MS), 0, driven.append, lambda: False, lambda: None)
    motor.order(Motor.POSITION, (0x7FFF_FFFF,))
    motor.order(Motor.RELATIVE_MOVE, (1,))
    assert driven == [-1], "positions are numbers of 32 bits with a sign"
