"""Commands of Tc2_MC2 that wait for others: the buffer modes and MC_Stop by PLCopen's part 1, times by kinematics."""

import pytest
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import CODESYS

DECLARED = """
    axis : AXIS_REF; power : MC_Power; first, third : MC_MoveAbsolute; second : MC_MoveRelative; turn : MC_MoveVelocity;
    stop : MC_Stop; doFirst, doSecond, doThird, doTurn, doStop : BOOL; mode : MC_BufferMode := MC_Buffered;
    distance : LREAL := 50; speed : LREAL := 50; position, velocity : LREAL; state : INT;
"""
BODY = """
    power(Axis := axis, Enable := TRUE, Enable_Positive := TRUE, Enable_Negative := TRUE);
    turn(Axis := axis, Execute := doTurn, Velocity := 100, Acceleration := 1000, Deceleration := 1000);
    first(Axis := axis, Execute := doFirst, Position := 100, Velocity := 100, Acceleration := 1000,
        Deceleration := 1000);
    second(Axis := axis, Execute := doSecond, Distance := distance, Velocity := speed, Acceleration := 1000,
        Deceleration := 1000, BufferMode := mode);
    third(Axis := axis, Execute := doThird, Position := 0, Velocity := 100, BufferMode := mode);
    stop(Axis := axis, Execute := doStop, Deceleration := 1000);
    axis.ReadStatus();
    position := axis.NcToPlc.ActPos;
    velocity := axis.NcToPlc.ActVelo;
    state := axis.Status.MotionState;
"""
STANDSTILL, STOPPING = 2, 4


@pytest.fixture
def bench() -> IecBench:
    made = IecBench(program(DECLARED, BODY), dialect=CODESYS)
    cycles(made, 3)
    return made


def cycles(bench: IecBench, number: int) -> None:
    for _ in range(number):
        bench.host.ms += 10
        bench.cycle()


def outputs(bench: IecBench, block: str) -> list[str]:
    names = ("Busy", "Active", "Done", "CommandAborted", "Error")
    return [name for name in names if bench[f"{block}.{name}"]]


def speed_at_the_first_target(bench: IecBench) -> float:
    """Return the speed in the cycle in which the first command ends."""
    for _ in range(500):
        cycles(bench, 1)
        if bench["first.Done"]:
            return float(str(bench["velocity"]))
    raise AssertionError("the first command has no end")


def test_a_buffered_command_waits_for_the_end_of_the_one_before(bench: IecBench) -> None:
    bench["doFirst"] = bench["doSecond"] = True
    cycles(bench, 20)
    assert (outputs(bench, "first"), outputs(bench, "second")) == (["Busy", "Active"], ["Busy"])
    assert speed_at_the_first_target(bench) < 11  # it begins from standstill: 1000 units/s2 for at most a cycle
    cycles(bench, 1)
    assert (outputs(bench, "first"), outputs(bench, "second")) == (["Done"], ["Busy", "Active"])
    cycles(bench, 200)
    assert outputs(bench, "second") == ["Done"]
    assert bench["position"] == pytest.approx(150)


@pytest.mark.parametrize(
    ("mode", "speed", "expected"),
    [
        ("MC_BlendingLow", 50, 50),
        ("MC_BlendingLow", 200, 100),
        ("MC_BlendingPrevious", 50, 100),
        ("MC_BlendingNext", 50, 50),
        ("MC_BlendingNext", 200, 200),
        ("MC_BlendingHigh", 50, 100),
        ("MC_BlendingHigh", 200, 200),
    ],
)
def test_a_blended_command_passes_the_target_with_a_speed_of_both(mode: str, speed: float, expected: float) -> None:
    declared = DECLARED.replace("mode : MC_BufferMode := MC_Buffered", f"mode : MC_BufferMode := {mode}")
    bench = IecBench(program(declared, BODY), dialect=CODESYS)
    cycles(bench, 3)
    bench["speed"] = speed
    bench["doFirst"] = bench["doSecond"] = True
    assert speed_at_the_first_target(bench) == pytest.approx(expected, abs=11)
    cycles(bench, 300)
    assert outputs(bench, "second") == ["Done"]
    assert bench["position"] == pytest.approx(150)


def test_a_blended_command_back_begins_from_standstill() -> None:
    declared = DECLARED.replace("mode : MC_BufferMode := MC_Buffered", "mode : MC_BufferMode := MC_BlendingHigh")
    bench = IecBench(program(declared, BODY), dialect=CODESYS)
    cycles(bench, 3)
    bench["distance"] = -20.0
    bench["doFirst"] = bench["doSecond"] = True
    assert abs(speed_at_the_first_target(bench)) < 11
    cycles(bench, 300)
    assert bench["position"] == pytest.approx(80)


def test_one_command_waits_at_most_and_an_aborting_one_ends_it(bench: IecBench) -> None:
    bench["doFirst"] = bench["doSecond"] = True
    cycles(bench, 20)
    bench["doThird"] = True
    cycles(bench, 1)
    assert (outputs(bench, "third"), outputs(bench, "second")) == (["Error"], ["Busy"])
    bench["doTurn"] = True
    cycles(bench, 1)
    cycles(bench, 1)
    assert [outputs(bench, name) for name in ("first", "second", "turn")] == [
        ["CommandAborted"],
        ["CommandAborted"],
        ["Busy", "Active"],
    ]


def test_a_command_behind_an_endless_motion_begins_when_that_has_its_speed(bench: IecBench) -> None:
    bench["doTurn"] = bench["doSecond"] = True
    cycles(bench, 5)
    assert (outputs(bench, "turn"), outputs(bench, "second")) == (["Busy", "Active"], ["Busy"])
    cycles(bench, 15)
    assert (outputs(bench, "turn"), outputs(bench, "second")) == (["CommandAborted"], ["Busy", "Active"])


def test_an_axis_takes_no_command_while_its_stop_is_executed(bench: IecBench) -> None:
    bench["doTurn"] = True
    cycles(bench, 30)
    bench["doStop"] = True
    cycles(bench, 30)
    assert (outputs(bench, "turn"), outputs(bench, "stop")) == (["CommandAborted"], ["Done"])
    assert (bench["state"], bench["velocity"]) == (STOPPING, 0)
    bench["doFirst"] = True
    cycles(bench, 2)
    assert outputs(bench, "first") == ["Error"]
    bench["doFirst"] = bench["doStop"] = False
    cycles(bench, 2)
    assert bench["state"] == STANDSTILL
    bench["doFirst"] = True
    cycles(bench, 2)
    assert outputs(bench, "first") == ["Busy", "Active"]
