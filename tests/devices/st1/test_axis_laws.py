"""Laws of the axis: whatever it is ordered, its shaft moves without jumps and within its limits."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from st1_bench import ProgramBench

from fieldrig_devices.pamring.frames import Move, SetPointMode

CKV, CKA = 20.0, 400.0
LIMITS = {"ckv": CKV, "cka": CKA, "astop": 300.0}
STEP_MS = 0.25
TORQUE_GIVES = 19.5 / 0.002 / 6.283185307179586
"""Turns/s2 of the whole torque, less the friction."""
MOST_STEP = CKV * STEP_MS / 1e3 + 1e-6
"""Turns in a step of time; a shaft has caught up when it is 1e-6 turns from its set position."""

values = st.floats(-3.0, 3.0)
speeds = st.floats(-30.0, 30.0)
rates = st.sampled_from([0.0, 10.0, 300.0, 4000.0])
orders = st.one_of(
    st.tuples(st.sampled_from([Move.ABSOLUTE_MOVE, Move.RELATIVE_MOVE]), values, speeds.map(abs), rates, rates),
    st.tuples(st.just(Move.RUN), speeds, st.just(0.0), rates, rates),
    st.tuples(st.just(Move.STOP), st.just(0.0), st.just(0.0), st.just(0.0), rates),
    st.tuples(st.sampled_from([Move.POWER_ON, Move.POWER_OFF, Move.UPDATE_STATUS]), *[st.just(0.0)] * 4),
    st.tuples(st.just(Move.POSITION), values, *[st.just(0.0)] * 3),
)
points = st.one_of(
    st.tuples(st.just(SetPointMode.POSITION), values),
    st.tuples(st.just(SetPointMode.SPEED), speeds),
    st.tuples(st.just(SetPointMode.TORQUE), st.floats(0.0, 1.0)),
)
ends = st.sampled_from(list(SetPointMode))
commands = st.lists(st.tuples(st.one_of(orders, points, ends), st.integers(1, 60)), min_size=1, max_size=8)


Command = tuple[Move, float, float, float, float] | tuple[SetPointMode, float] | SetPointMode


def give(bench: ProgramBench, command: Command) -> None:
    match command:
        case SetPointMode():
            bench.end(command)
        case (mode, value):
            bench.point(value, mode)
        case (move, *numbers):
            bench.move(move, *numbers)


@pytest.mark.long
@settings(deadline=None, max_examples=50)
@given(commands)
def test_a_shaft_never_jumps_and_never_exceeds_its_limits(given_commands: list[tuple[Command, int]]) -> None:
    bench = ProgramBench(parameters=LIMITS, lag_limit_turns=100.0)
    for command, cycles in given_commands:
        give(bench, command)
        for _ in range(cycles):
            bench.program.cycle()
            for _ in range(round(1 / STEP_MS)):
                before, speed = bench.motor, bench.speed
                bench.wait(STEP_MS)
                assert abs(bench.motor - before) <= MOST_STEP
                assert abs(bench.speed) <= CKV * (1 + 1e-6)
                assert abs(bench.speed - speed) <= TORQUE_GIVES * 1.01e-3


@pytest.mark.long
@settings(deadline=None, max_examples=40)
@given(commands)
def test_an_event_moves_nothing(given_commands: list[tuple[Command, int]]) -> None:
    bench = ProgramBench(parameters=LIMITS, lag_limit_turns=100.0, period=1.5)
    for command, cycles in given_commands:
        before = bench.motor
        if not (isinstance(command, tuple) and isinstance(command[0], SetPointMode)):  # those take a cycle
            give(bench, command)
            assert abs(bench.motor - before) <= 1.1e-6  # a shaft may have caught up
        bench.cycle(cycles)


@pytest.mark.long
@settings(deadline=None, max_examples=40)
@given(commands)
def test_every_order_is_done_in_the_end_and_the_axis_at_rest(given_commands: list[tuple[Command, int]]) -> None:
    bench = ProgramBench(parameters=LIMITS, lag_limit_turns=100.0)
    for command, cycles in given_commands:
        give(bench, command)
        bench.cycle(cycles)
    bench.move(Move.STOP)
    bench.end(SetPointMode.TORQUE).cycle(300).wait(60_000)
    assert (bench.report.number, bench.speed, bench.lag) == (bench.number, 0.0, 0.0)
    assert bench.clock.next_ns() is None
