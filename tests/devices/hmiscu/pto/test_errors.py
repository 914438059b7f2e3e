"""Errors of an axis: what causes them, what they do, and how they are reset (digest 6 and 8)."""

from typing import Any

import pytest
from hmiscu_bench import PtoBench, shown

from fieldrig.clock import MS, S
from fieldrig_devices.hmiscu.blocks.motion import PTOStop
from fieldrig_devices.hmiscu.enumerations import ErrorId
from fieldrig_devices.hmiscu.pto.status import MotionState

FREQUENCY, ACCELERATION, DECELERATION, REJECTED, DIRECTION = (1 << bit for bit in (22, 23, 24, 25, 26))
HZ = {"ramp_unit": "Hz/ms"}

# Block, settings, inputs, bits of the diagnosis (digest 8.1).
WRONG_INPUTS: list[tuple[str, dict[str, Any], dict[str, int], int]] = [
    ("relative", {}, {"Velocity": 0}, FREQUENCY),
    ("relative", {}, {"Velocity": 50_001}, FREQUENCY),
    ("relative", {"maximum_frequency_hz": 9_999}, {"Velocity": 10_000}, FREQUENCY),
    ("relative", {"start_frequency_hz": 500}, {"Velocity": 499}, FREQUENCY),
    ("relative", {"stop_frequency_hz": 500}, {"Velocity": 499}, FREQUENCY),
    ("run", {}, {"Velocity": 0}, FREQUENCY),
    ("run", {}, {"Velocity": 50_001}, FREQUENCY),
    ("run", {"start_frequency_hz": 500}, {"Velocity": 499}, FREQUENCY),
    ("relative", {}, {"Acceleration": 19}, ACCELERATION),
    ("relative", {}, {"Acceleration": 50_000}, ACCELERATION),
    ("relative", HZ, {"Acceleration": 0}, ACCELERATION),
    ("relative", HZ, {"Acceleration": 2_501}, ACCELERATION),
    ("run", {}, {"Acceleration": 19}, ACCELERATION),
    ("relative", {}, {"Deceleration": 19}, DECELERATION),
    ("relative", {}, {"Deceleration": 50_000}, DECELERATION),
    ("run", HZ, {"Deceleration": 2_501}, DECELERATION),
    ("halt", {}, {"Deceleration": 19}, DECELERATION),
    ("halt", HZ, {"Deceleration": 0}, DECELERATION),
    ("relative", {}, {"Distance": 0}, 0),
    ("relative", {}, {"Distance": 2**32}, 0),
    ("relative", {}, {"Direction": 3}, DIRECTION),
    ("run", {}, {"Direction": 255}, DIRECTION),
    ("relative", {}, {"Velocity": 0, "Acceleration": 0, "Direction": 9}, FREQUENCY | ACCELERATION | DIRECTION),
]


@pytest.mark.manual("SCU-022", "SCU-026", "SCU-034", "SCU-035", "SCU-037", "SCU-047", "SCU-048", "SCU-059", "SCU-061")
@pytest.mark.parametrize(("command", "settings", "inputs", "bits"), WRONG_INPUTS)
def test_a_wrong_input_ends_in_error_stop_without_pulses(
    command: str, settings: dict[str, Any], inputs: dict[str, int], bits: int
) -> None:
    bench = PtoBench(**settings)
    getattr(bench, command)(**inputs)
    block = {"relative": bench.move, "run": bench.velocity, "halt": bench.stop}[command]
    bench.cycle()
    assert shown(block) == {"Error"}
    assert block.outputs["ErrID"] == ErrorId.PTO_INVALID_PARAMETER
    assert bench.simple.outputs["PTOError"]
    assert bench.diagnosis() == bits
    assert bench.segments == []


# The ends of each range are legal.
LEGAL: list[tuple[str, dict[str, Any], dict[str, int]]] = [
    ("relative", {}, {"Velocity": 1, "Distance": 1}),
    ("relative", {}, {"Velocity": 50_000, "Distance": 2**32 - 1, "Acceleration": 20, "Deceleration": 49_999}),
    ("relative", HZ, {"Acceleration": 1, "Deceleration": 2_500}),
    ("relative", {"start_frequency_hz": 500, "stop_frequency_hz": 400}, {"Velocity": 500}),
    ("run", {"start_frequency_hz": 500}, {"Velocity": 500}),
    ("run", {"stop_frequency_hz": 500}, {"Velocity": 400}),
    ("halt", {}, {"Deceleration": 20}),
]


@pytest.mark.manual("SCU-034", "SCU-035", "SCU-037", "SCU-048")
@pytest.mark.parametrize(("command", "settings", "inputs"), LEGAL)
def test_the_ends_of_the_ranges_are_accepted(command: str, settings: dict[str, Any], inputs: dict[str, int]) -> None:
    bench = PtoBench(**settings)
    getattr(bench, command)(**inputs)
    bench.cycle()
    assert not bench.simple.outputs["PTOError"]


@pytest.mark.manual("SCU-048")
def test_a_velocity_below_the_start_frequency_is_possible_in_motion() -> None:
    bench = PtoBench(start_frequency_hz=5_000)
    bench.run(Velocity=6_000)
    bench.cycle(2 * S)
    bench.run(Velocity=100)
    bench.cycle(2 * S)
    assert shown(bench.velocity) == {"InVelocity"}
    assert bench.frequency == 100


def test_a_reversed_direction_in_motion_stops_the_axis() -> None:
    bench = PtoBench()
    bench.run(Direction=0)
    bench.cycle(2 * S)
    bench.run(Direction=1)
    assert bench.velocity.outputs["ErrID"] == ErrorId.PTO_INVALID_PARAMETER
    assert bench.diagnosis() == DIRECTION
    bench.rest_ns()
    assert bench.channel.output.train.value == bench.sent


@pytest.mark.manual("SCU-023", "SCU-025", "SCU-062")
@pytest.mark.parametrize("filter_ms", [3, 12])
def test_a_drive_that_is_not_ready_stops_the_axis_after_the_filter(filter_ms: int) -> None:
    bench = PtoBench(aux="drive_ready", aux_filter_ms=filter_ms)
    bench.channel.put_drive_ready(0, True)
    bench.cycle(20 * MS)
    bench.reset()
    bench.relative(Distance=1_000_000)
    bench.cycle(2 * S)
    bench.channel.put_drive_ready(bench.now_ns, False)
    bench.cycle(filter_ms * MS - 1)
    assert shown(bench.move) == {"Busy", "Active"}
    bench.cycle(1)
    assert shown(bench.move) == {"Error"}
    assert bench.move.outputs["ErrID"] == ErrorId.PTO_AXIS_ERROR
    assert bench.diagnosis() == 0x20000
    before_ns = bench.now_ns
    assert (bench.rest_ns() - before_ns) / S == pytest.approx(0.04, abs=1e-4)  # 20 kHz at 500 Hz/ms
    assert bench.state is MotionState.ERROR_STOP


@pytest.mark.manual("SCU-024")
def test_a_bounce_that_is_shorter_than_the_filter_is_ignored() -> None:
    bench = PtoBench(aux="drive_ready")
    bench.channel.put_drive_ready(0, True)
    bench.cycle(20 * MS)
    bench.reset()
    bench.run()
    for level in (False, True, False, True):
        bench.channel.put_drive_ready(bench.now_ns, level)
        bench.cycle(3 * MS - 1)
    bench.cycle(S)
    assert shown(bench.velocity) == {"Busy"} or shown(bench.velocity) == {"InVelocity"}
    assert not bench.simple.outputs["PTOError"]


@pytest.mark.manual("SCU-030")
def test_drive_ready_may_be_ignored_and_does_nothing_if_it_is_not_used() -> None:
    for settings, is_ignored in (({"aux": "drive_ready"}, True), ({"aux": "not_used"}, False)):
        bench = PtoBench(**settings)
        bench.simple.inputs["DIS_AuxInput"] = is_ignored
        bench.cycle()
        bench.relative()
        bench.channel.put_drive_ready(0, True)
        bench.cycle(50 * MS)
        bench.channel.put_drive_ready(bench.now_ns, False)
        bench.cycle(50 * MS)
        assert shown(bench.move) == {"Busy", "Active"}


@pytest.mark.manual("SCU-025")
def test_without_a_ready_drive_the_error_can_not_be_reset() -> None:
    bench = PtoBench(aux="drive_ready")
    bench.cycle()
    bench.reset()
    bench.cycle()
    assert bench.simple.outputs["PTOError"]
    assert bench.diagnosis() == 0x20000
    bench.channel.put_drive_ready(bench.now_ns, True)
    bench.cycle(3 * MS)
    bench.reset()
    bench.cycle()
    assert not bench.simple.outputs["PTOError"]
    assert bench.diagnosis() == 0


@pytest.mark.manual("SCU-029", "SCU-040")
def test_an_error_blocks_commands_until_it_is_reset_at_rest_without_execute() -> None:
    bench = PtoBench()
    bench.relative(Distance=1_000_000)
    bench.cycle(S)
    bench.run()  # a refused sequence
    bench.reset()
    bench.cycle()
    assert bench.simple.outputs["PTOError"]  # the axis moves
    bench.rest_ns()
    bench.reset()
    bench.cycle()
    assert bench.simple.outputs["PTOError"]  # Execute of PTOMoveRelative is TRUE
    bench.run()
    assert bench.velocity.outputs["ErrID"] == ErrorId.PTO_AXIS_ERROR  # ignored
    assert bench.diagnosis() == REJECTED
    bench.release(bench.move)
    bench.simple.inputs["ResetError"] = True
    bench.cycle()
    assert not bench.simple.outputs["PTOError"]
    assert bench.state is MotionState.STANDSTILL
    assert bench.diagnosis() == 0
    bench.simple.inputs["ResetError"] = False
    bench.relative()
    assert shown(bench.move) == {"Busy", "Active"}


@pytest.mark.manual("SCU-051")
def test_no_move_begins_while_the_stop_is_held() -> None:
    bench = PtoBench()
    bench.halt()
    bench.cycle()
    assert shown(bench.stop) == {"Done"}
    assert bench.simple.outputs["Stopping"]
    bench.relative()
    assert bench.move.outputs["ErrID"] == ErrorId.PTO_AXIS_ERROR
    assert bench.diagnosis() == REJECTED
    assert not bench.simple.outputs["PTOError"]
    bench.release(bench.stop)
    bench.cycle()
    assert shown(bench.stop) == set()
    bench.relative()
    assert shown(bench.move) == {"Busy", "Active"}


def test_a_stop_whose_execute_fell_early_frees_the_axis_at_rest() -> None:
    bench = PtoBench()
    bench.run()
    bench.cycle(S)
    bench.halt()
    bench.release(bench.stop)
    assert shown(bench.stop) == {"Busy"}
    bench.rest_ns()
    bench.cycle()
    assert shown(bench.stop) == {"Done"}
    assert bench.state is MotionState.STANDSTILL


@pytest.mark.manual("SCU-062")
def test_an_internal_error_is_an_axis_error() -> None:
    bench = PtoBench()
    bench.run()
    bench.cycle(S)
    bench.channel.fail(bench.now_ns)
    bench.cycle()
    assert bench.velocity.outputs["ErrID"] == ErrorId.PTO_AXIS_ERROR
    assert bench.diagnosis() == 0x10


@pytest.mark.manual("SCU-065")
def test_a_lost_connection_to_the_outputs_is_a_communication_error() -> None:
    bench = PtoBench()
    bench.run()
    bench.cycle(S)
    bench.channel.set_linked(bench.now_ns, False)
    bench.cycle()
    assert bench.velocity.outputs["ErrID"] == ErrorId.PTO_COM_ERROR
    bench.rest_ns()
    bench.relative()
    assert bench.move.outputs["ErrID"] == ErrorId.PTO_COM_ERROR
    bench.release(bench.move)
    bench.reset()
    bench.cycle()
    assert bench.simple.outputs["PTOError"]
    bench.channel.set_linked(bench.now_ns, True)
    bench.reset()
    bench.relative()
    assert shown(bench.move) == {"Busy", "Active"}


@pytest.mark.manual("SCU-063")
def test_a_wrong_reference_is_an_error_of_the_block_only() -> None:
    bench = PtoBench()
    for reference in (0, 2):
        stop = PTOStop({1: bench.channel})
        bench.execute(stop, PTO_REF_IN=reference, Deceleration=1_000)
        assert shown(stop) == {"Error"}
        assert stop.outputs["ErrID"] == ErrorId.PTO_UNKNOW_REF
    bench.cycle()
    assert not bench.simple.outputs["PTOError"]
    assert bench.diagnosis() == 0x80


@pytest.mark.manual("SCU-056", "SCU-099")
def test_a_restart_brings_back_the_configuration_and_clears_the_error() -> None:
    bench = PtoBench(start_frequency_hz=300)
    bench.execute(bench.set, Param=0, Param_Value=700)
    bench.run()
    bench.cycle(S)
    bench.channel.shutdown(bench.now_ns)
    assert bench.channel.is_stopping
    bench.channel.restart(bench.now_ns)
    bench.rest_ns()
    bench.cycle()
    assert bench.state is MotionState.STANDSTILL
    bench.execute(bench.get, Param=0)
    assert bench.get.outputs["ParamValue"] == 300


def test_a_restart_forgets_the_blocks_of_the_program_before() -> None:
    bench = PtoBench()
    bench.relative(Distance=0)
    assert bench.state is MotionState.ERROR_STOP
    bench.channel.restart(bench.now_ns)
    bench.channel.fail(bench.now_ns)
    bench.channel.reset(bench.now_ns)
    assert bench.channel.diagnosis == 0  # nothing has Execute any more
