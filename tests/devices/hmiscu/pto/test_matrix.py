"""The command matrix cell by cell, with good and with bad inputs of the second command (manual 1113 to 1127)."""

from collections.abc import Callable
from typing import NamedTuple

import pytest
from hmiscu_bench import PtoBench, shown

from fieldrig.clock import MS, S
from fieldrig_devices.hmiscu.blocks.motion import MotionBlock, PTOMoveVelocity
from fieldrig_devices.hmiscu.enumerations import ErrorId
from fieldrig_devices.hmiscu.pto.matrix import MATRIX, Next, Running
from fieldrig_devices.hmiscu.pto.status import MotionState

REJECTED, FREQUENCY, DECELERATION = 0x2000000, 0x400000, 0x1000000


def relative(bench: PtoBench) -> MotionBlock:
    bench.relative(Distance=1_000_000, Velocity=10_000)
    bench.cycle(500 * MS)
    return bench.move


def constant(bench: PtoBench) -> MotionBlock:
    bench.run(Velocity=10_000)
    bench.cycle(2 * S)
    assert shown(bench.velocity) == {"InVelocity"}
    return bench.velocity


def ramping(bench: PtoBench) -> MotionBlock:
    bench.run(Velocity=10_000)
    bench.cycle(500 * MS)
    assert shown(bench.velocity) == {"Busy"}
    return bench.velocity


def stopping(bench: PtoBench) -> MotionBlock:
    bench.run(Velocity=10_000)
    bench.cycle(2 * S)
    bench.halt(Deceleration=5_000)
    bench.cycle(100 * MS)
    assert shown(bench.stop) == {"Busy"}
    return bench.stop


# Rows and columns of the manual's table.
RUNNING: dict[Running, Callable[[PtoBench], MotionBlock]] = {
    Running.MOVE_RELATIVE: relative,
    Running.VELOCITY_CONSTANT: constant,
    Running.VELOCITY_RAMPING: ramping,
    Running.STOP_DECELERATING: stopping,
}


class Expected(NamedTuple):
    """The status that both blocks show at once, and the state of the axis."""

    first: str
    first_error: ErrorId
    second: str
    second_error: ErrorId
    state: MotionState
    diagnosis: int


NO, INVALID, AXIS = ErrorId.NO_ERROR, ErrorId.PTO_INVALID_PARAMETER, ErrorId.PTO_AXIS_ERROR
ABORTED = Expected("CommandAborted", NO, "Error", INVALID, MotionState.ERROR_STOP, REJECTED)
AXIS_ERROR = Expected("Error", AXIS, "Error", AXIS, MotionState.ERROR_STOP, REJECTED)
NEW_VELOCITY = Expected("CommandAborted", NO, "Busy", NO, MotionState.CONTINUOUS_MOTION, 0)
STOPS_MOVE = Expected("Done", NO, "Busy", NO, MotionState.STOPPING, 0)
STOPS_VELOCITY = Expected("CommandAborted", NO, "Busy", NO, MotionState.STOPPING, 0)

TABLE = {
    (Running.MOVE_RELATIVE, Next.MOVE_RELATIVE): ABORTED,
    (Running.MOVE_RELATIVE, Next.MOVE_VELOCITY): ABORTED,
    (Running.MOVE_RELATIVE, Next.STOP): STOPS_MOVE,
    (Running.VELOCITY_CONSTANT, Next.MOVE_RELATIVE): ABORTED,
    (Running.VELOCITY_CONSTANT, Next.MOVE_VELOCITY): NEW_VELOCITY,
    (Running.VELOCITY_CONSTANT, Next.STOP): STOPS_VELOCITY,
    (Running.VELOCITY_RAMPING, Next.MOVE_RELATIVE): ABORTED,
    (Running.VELOCITY_RAMPING, Next.MOVE_VELOCITY): ABORTED,
    (Running.VELOCITY_RAMPING, Next.STOP): STOPS_VELOCITY,
    (Running.STOP_DECELERATING, Next.MOVE_RELATIVE): AXIS_ERROR,
    (Running.STOP_DECELERATING, Next.MOVE_VELOCITY): AXIS_ERROR,
    (Running.STOP_DECELERATING, Next.STOP): AXIS_ERROR,
}


def second(bench: PtoBench, command: Next, *, is_bad: bool) -> MotionBlock:
    """Give the command with another instance, so that the first one goes on showing its own status."""
    block = next(type(block) for block in (bench.move, bench.velocity, bench.stop) if block.kind is command)(
        {1: bench.channel}
    )
    bench.blocks.append(block)
    inputs = {"PTO_REF_IN": 1, "Velocity": 20_000, "Distance": 5_000, "Acceleration": 1_000, "Deceleration": 1_000}
    if is_bad:
        inputs |= {"Velocity": 50_001, "Deceleration": 50_000 if command is Next.STOP else 1_000}
    bench.execute(block, **{pin: value for pin, value in inputs.items() if pin in block.inputs})
    return block


@pytest.mark.manual("SCU-053", "SCU-049", "SCU-079", "SCU-081")
@pytest.mark.parametrize(
    ("cell", "expected"), TABLE.items(), ids=[f"{row.name}-{column.name}" for row, column in TABLE]
)
def test_a_cell(cell: tuple[Running, Next], expected: Expected) -> None:
    bench = PtoBench()
    first = RUNNING[cell[0]](bench)
    block = second(bench, cell[1], is_bad=False)
    bench.cycle()
    assert shown(first) - {"Active"} == {expected.first}
    assert first.outputs["ErrID"] == expected.first_error
    assert shown(block) - {"Active"} == {expected.second}
    assert block.outputs["ErrID"] == expected.second_error
    assert bench.channel.state is expected.state
    assert bench.diagnosis() == expected.diagnosis
    assert bench.simple.outputs["PTOError"] == (expected.state is MotionState.ERROR_STOP)


@pytest.mark.manual("SCU-054", "SCU-061")
@pytest.mark.parametrize("cell", TABLE)
def test_a_cell_with_bad_inputs_of_the_second_command(cell: tuple[Running, Next]) -> None:
    bench = PtoBench()
    first = RUNNING[cell[0]](bench)
    block = second(bench, cell[1], is_bad=True)
    bench.cycle()
    is_axis_error = cell[0] is Running.STOP_DECELERATING
    assert shown(first) == {"Error" if is_axis_error else "CommandAborted"}
    assert shown(block) == {"Error"}
    assert block.outputs["ErrID"] == ErrorId.PTO_INVALID_PARAMETER
    assert bench.channel.state is MotionState.ERROR_STOP
    bad = DECELERATION if cell[1] is Next.STOP else FREQUENCY
    assert bench.diagnosis() == bad | TABLE[cell].diagnosis


@pytest.mark.parametrize("cell", [cell for cell, expected in TABLE.items() if expected.state is MotionState.ERROR_STOP])
def test_a_refused_sequence_stops_the_axis_at_the_fast_stop_rate(cell: tuple[Running, Next]) -> None:
    bench = PtoBench()
    RUNNING[cell[0]](bench)
    before_ns, frequency = bench.now_ns, bench.frequency
    second(bench, cell[1], is_bad=False)
    seconds = (bench.rest_ns() - before_ns) / S
    assert seconds == pytest.approx(frequency / 500_000, abs=2 / frequency + 1e-4)  # 50000 Hz in 100 ms
    assert bench.channel.state is MotionState.ERROR_STOP


def test_the_code_has_the_cells_of_the_table_and_no_others() -> None:
    assert set(MATRIX) == set(TABLE)


@pytest.mark.long
@pytest.mark.manual("SCU-046", "SCU-086")
def test_the_same_block_may_ask_for_a_new_velocity_without_seeing_an_abort() -> None:
    bench = PtoBench()
    block = constant(bench)
    assert isinstance(block, PTOMoveVelocity)
    bench.run(Velocity=30_000, Acceleration=2_000)
    assert shown(block) == {"Busy"}
    before_ns = bench.now_ns
    bench.until(lambda: shown(block) == {"InVelocity"})
    assert (bench.now_ns - before_ns) / S == pytest.approx(2.0, abs=2e-3)
    assert bench.frequency == 30_000


@pytest.mark.manual("SCU-055")
def test_a_hand_over_sends_pulses_at_the_present_frequency() -> None:
    counts = {}
    for hand_over_ms in (0, 7):
        bench = PtoBench(hand_over_ms=hand_over_ms)
        constant(bench)
        before = bench.sent
        bench.halt(Deceleration=1_000)
        bench.rest_ns()
        counts[hand_over_ms] = bench.channel.output.train.sent - before
    assert counts[7] - counts[0] == 70  # 7 ms at 10 kHz


@pytest.mark.manual("SCU-055")
def test_a_hand_over_takes_a_mast_cycle_unless_it_is_configured() -> None:
    extra = PtoBench(hand_over_ms=None), PtoBench(hand_over_ms=10)
    rests = []
    for bench in extra:
        constant(bench)
        bench.halt(Deceleration=1_000)
        rests.append(bench.rest_ns())
    assert rests[0] == rests[1]


def test_a_stop_may_report_the_abort_of_a_move() -> None:
    bench = PtoBench(stop_reports="aborted")
    relative(bench)
    bench.halt()
    bench.cycle()
    assert shown(bench.move) == {"CommandAborted"}
