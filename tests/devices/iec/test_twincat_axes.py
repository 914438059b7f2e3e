"""Axes of Tc2_MC2: times and positions against the kinematics of a trapezium, states against the diagram of PLCopen."""

import pytest
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import CODESYS

CYCLE_NS = 10_000_000

STAGE = "TYPE Stage : STRUCT axis : AXIS_REF; END_STRUCT; END_TYPE\n"
DECLARED = """
    stage : Stage; power : MC_Power; move : MC_MoveAbsolute; other : MC_MoveRelative; endless : MC_MoveVelocity;
    halt : MC_Halt; jog : MC_Jog; home : MC_Home; place : MC_SetPosition; error : MC_Reset;
    isOn, isUp, isDown : BOOL := TRUE; doMove, doOther, doEndless, doHalt, doPlace, doReset, forward, backwards : BOOL;
    goal, speed, acc, dec : LREAL; direction : MC_Direction := MC_Positive_Direction;
    position, velocity : LREAL; state : INT; hasJob : BOOL; ctrl : DWORD;
"""
BODY = """
    stage.axis.ReadStatus();
    power(Axis := stage.axis, Enable := isOn, Enable_Positive := isUp, Enable_Negative := isDown);
    move(Axis := stage.axis, Execute := doMove, Position := goal, Velocity := speed, Acceleration := acc,
        Deceleration := dec);
    other(Axis := stage.axis, Execute := doOther, Distance := goal, Velocity := speed);
    endless(Axis := stage.axis, Execute := doEndless, Velocity := speed, Direction := direction);
    halt(Axis := stage.axis, Execute := doHalt, Deceleration := dec);
    jog(Axis := stage.axis, JogForward := forward, JogBackwards := backwards, Mode := E_JogMode.MC_JOGMODE_CONTINOUS,
        Velocity := speed);
    place(Axis := stage.axis, Execute := doPlace, Position := goal);
    error(Axis := stage.axis, Execute := doReset);
    position := stage.axis.NcToPlc.ActPos;
    velocity := stage.axis.NcToPlc.ActVelo;
    state := stage.axis.Status.MotionState;
    hasJob := stage.axis.NcToPlc.StateDWord.8;
    ctrl := stage.axis.PlcToNc.ControlDWord;
"""
DISABLED, STANDSTILL, STOPPING, DISCRETE, CONTINUOUS, SYNCHRONIZED = 1, 2, 4, 6, 7, 8


@pytest.fixture
def bench() -> IecBench:
    made = IecBench(STAGE + program(DECLARED, BODY), dialect=CODESYS)
    _cycles(made, 2)
    return made


def _order(bench: IecBench, **values: float) -> None:
    for name, value in values.items():
        bench[name] = value


def _cycles(bench: IecBench, number: int) -> None:
    for _ in range(number):
        bench.host.ms += 10
        bench.cycle()


def _until(bench: IecBench, name: str, most: int = 2_000) -> int:
    """Return the number of cycles until a variable is TRUE."""
    for number in range(most):
        if bench[name]:
            return number
        _cycles(bench, 1)
    raise AssertionError(f"{name} was never TRUE")


@pytest.mark.parametrize(
    ("to", "speed", "acc", "dec"), [(100.0, 50.0, 100.0, 100.0), (-30.0, 10.0, 20.0, 40.0), (1.0, 500.0, 100.0, 100.0)]
)
def test_a_move_takes_the_time_of_its_trapezium(
    bench: IecBench, to: float, speed: float, acc: float, dec: float
) -> None:
    _order(bench, goal=to, speed=speed, acc=acc, dec=dec, doMove=True)
    _cycles(bench, 1)
    cycles = _until(bench, "move.Done")
    # A short way has no part with the full speed.
    top = min(speed, (2 * abs(to) * acc * dec / (acc + dec)) ** 0.5)
    seconds = abs(to) / top + top / (2 * acc) + top / (2 * dec)
    assert cycles == pytest.approx(seconds * 100, abs=6)
    assert bench["position"] == pytest.approx(to)
    assert bench["velocity"] == 0


def test_the_states_are_those_of_the_diagram(bench: IecBench) -> None:
    assert bench["state"] == STANDSTILL
    _order(bench, goal=100.0, speed=10.0, acc=100.0, dec=10.0, doMove=True)
    _cycles(bench, 20)
    assert bench["state"] == DISCRETE
    assert bench["hasJob"]
    _order(bench, doEndless=True)
    _cycles(bench, 20)
    assert bench["state"] == CONTINUOUS
    assert bench["move.CommandAborted"]
    assert bench["endless.InVelocity"]
    _order(bench, doHalt=True)
    _cycles(bench, 20)
    assert bench["state"] == STOPPING
    _until(bench, "halt.Done")
    _cycles(bench, 1)
    assert bench["state"] == STANDSTILL
    _order(bench, isOn=False)
    _cycles(bench, 2)
    assert bench["state"] == DISABLED


def test_without_an_enable_there_is_an_error_and_no_motion(bench: IecBench) -> None:
    _order(bench, isOn=False)
    _cycles(bench, 2)
    assert not bench["power.Status"]
    _order(bench, goal=10.0, speed=10.0, doMove=True)
    _cycles(bench, 50)
    assert bench["move.Error"]
    assert bench["move.ErrorID"] == 0x4260
    assert bench["position"] == 0


def test_a_speed_of_zero_is_refused(bench: IecBench) -> None:
    _order(bench, goal=10.0, speed=0.0, doMove=True)
    _cycles(bench, 2)
    assert bench["move.ErrorID"] == 0x4221
    assert not bench["move.Busy"]


def test_an_axis_does_not_move_in_a_direction_without_an_enable(bench: IecBench) -> None:
    _order(bench, isUp=False, goal=5.0, speed=10.0, doMove=True)
    _cycles(bench, 100)
    assert bench["ctrl"] == 0b101
    assert bench["position"] == 0
    _order(bench, isUp=True)
    _until(bench, "move.Done")
    assert bench["position"] == 5.0


def test_outputs_stay_while_a_command_works_and_go_with_its_execute(bench: IecBench) -> None:
    _order(bench, goal=5.0, speed=10.0, doMove=True)
    _cycles(bench, 2)
    _order(bench, doMove=False)
    _cycles(bench, 2)
    assert bench["move.Busy"]
    _cycles(bench, 200)
    assert not bench["move.Busy"]
    assert not bench["move.Done"]
    assert bench["position"] == 5.0


def test_a_jog_moves_while_it_is_asked_and_halts_then(bench: IecBench) -> None:
    _order(bench, speed=10.0, backwards=True)
    _cycles(bench, 100)
    assert bench["velocity"] == -10.0
    _order(bench, backwards=False)
    _until(bench, "jog.Done")
    assert bench["velocity"] == 0
    assert bench["position"] == pytest.approx(-10.0, abs=1.0)


def test_the_place_of_an_axis_gets_another_number(bench: IecBench) -> None:
    _order(bench, goal=7.0, doPlace=True)
    _cycles(bench, 3)
    assert bench["place.Done"]
    assert bench["position"] == 7.0
    _order(bench, goal=3.0, speed=10.0, doOther=True)
    _cycles(bench, 1)
    _until(bench, "other.Done")
    assert bench["position"] == pytest.approx(10.0)


def test_a_program_may_have_an_axis_of_its_own() -> None:
    variables = "VAR_INPUT on : BOOL; END_VAR VAR_OUTPUT out : BOOL; END_VAR"
    own = f"FUNCTION_BLOCK MC_Power {variables} out := on; END_FUNCTION_BLOCK\n"
    bench = IecBench(own + program("p : MC_Power; x : BOOL;", "p(on := TRUE, out => x);"), dialect=CODESYS)
    bench.cycle()
    assert bench["x"]


def test_backlash_is_corrected_after_a_motion_in_its_direction() -> None:
    declared = f"{DECLARED} back : MC_BacklashCompensation; ahead : LREAL;"
    body = f"""{BODY}
    back(Axis := stage.axis, Enable := TRUE, Backlash := 0.5, CompensationInPositiveDirection := TRUE, Ramp := 1.0);
    ahead := position - stage.axis.NcToPlc.ActPosWithoutPosCorrection;
    """
    bench = IecBench(STAGE + program(declared, body), dialect=CODESYS)
    _cycles(bench, 2)
    _order(bench, goal=5.0, speed=10.0, doMove=True)
    _cycles(bench, 30)
    assert bench["ahead"] == pytest.approx(0.3, abs=0.03)
    _cycles(bench, 70)
    assert bench["ahead"] == pytest.approx(0.5)
    _order(bench, goal=-1.0, doOther=True)
    _cycles(bench, 100)
    assert bench["ahead"] == pytest.approx(0.0)


def test_a_slave_follows_its_master_by_the_ratio_until_it_leaves() -> None:
    declared = f"""{DECLARED} slave : AXIS_REF; slavePower : MC_Power; gear : MC_GearIn; out : MC_GearOut;
    doGear, doLeave : BOOL; second : LREAL; slaveState : INT;"""
    body = f"""{BODY}
    slavePower(Axis := slave, Enable := TRUE, Enable_Positive := TRUE, Enable_Negative := TRUE);
    gear(Master := stage.axis, Slave := slave, Execute := doGear, RatioNumerator := 3, RatioDenominator := 2);
    out(Slave := slave, Execute := doLeave);
    slave.ReadStatus();
    second := slave.NcToPlc.ActPos;
    slaveState := slave.Status.MotionState;
    """
    bench = IecBench(STAGE + program(declared, body), dialect=CODESYS)
    _cycles(bench, 2)
    _order(bench, goal=4.0, speed=10.0, doMove=True)
    _until(bench, "move.Done")
    _order(bench, doGear=True, doOther=True)
    _cycles(bench, 100)
    assert bench["gear.InGear"]
    assert bench["slaveState"] == SYNCHRONIZED
    assert bench["position"] == pytest.approx(8.0)
    assert bench["second"] == pytest.approx(6.0)
    _order(bench, doGear=False, doLeave=True)
    _cycles(bench, 2)
    assert bench["slaveState"] == STANDSTILL
    _order(bench, doOther=False)
    _cycles(bench, 2)
    _order(bench, doOther=True)
    _cycles(bench, 100)
    assert bench["position"] == pytest.approx(12.0)
    assert bench["second"] == pytest.approx(6.0)


@pytest.mark.parametrize(
    ("direction", "expected"),
    [("MC_Positive_Direction", 350.0), ("MC_Shortest_Way", -10.0), ("MC_Negative_Direction", -10.0)],
)
def test_a_move_of_a_turn_has_a_direction(direction: str, expected: float) -> None:
    call = f"m(Axis := stage.axis, Execute := doOther, Position := 350.0, Velocity := 500.0, Direction := {direction});"
    body = BODY.replace("other(Axis := stage.axis, Execute := doOther,", "other(Axis := stage.axis, Execute := FALSE,")
    bench = IecBench(STAGE + program(f"{DECLARED} m : MC_MoveModulo;", f"{body}\n{call}"), dialect=CODESYS)
    _cycles(bench, 2)
    _order(bench, doOther=True)
    _cycles(bench, 1)
    _until(bench, "m.Done")
    assert bench["position"] == pytest.approx(expected)


def test_a_program_keeps_the_address_of_a_drive_in_its_axis() -> None:
    call = "r(Axis := stage.axis, Execute := TRUE, DriveAddress => stage.axis.DriveAddress);"
    declared = f"{DECLARED} r : MC_ReadDriveAddress; isDone : BOOL; channel : BYTE := 9;"
    body = f"{BODY} {call} isDone := r.Done; channel := stage.axis.DriveAddress.Channel;"
    bench = IecBench(STAGE + program(declared, body), dialect=CODESYS)
    _cycles(bench, 3)
    assert bench["isDone"]
    assert bench["channel"] == 0


def test_a_reset_ends_the_job_of_an_axis(bench: IecBench) -> None:
    _order(bench, goal=50.0, speed=10.0, doMove=True)
    _cycles(bench, 100)
    _order(bench, doReset=True)
    _cycles(bench, 2)
    assert bench["move.CommandAborted"]
    assert bench["error.Done"]
    assert (bench["velocity"], bench["state"]) == (0, STANDSTILL)


def test_parameters_are_read_as_they_were_written() -> None:
    declared = """
        axis : AXIS_REF; power : MC_Power; write : MC_WriteParameter; writeBool : MC_WriteBoolParameter;
        read, other, speed : MC_ReadParameter; readBool : MC_ReadBoolParameter; move : MC_MoveVelocity;
        a, b, v : LREAL; c, valid, busy : BOOL; doMove, doWrite : BOOL;
    """
    body = """
        power(Axis := axis, Enable := TRUE, Enable_Positive := TRUE, Enable_Negative := TRUE);
        write(Axis := axis, Execute := doWrite, ParameterNumber := MC_AxisParameter.AxisMaxVelocity, Value := 77.5);
        writeBool(Axis := axis, Execute := doWrite, ParameterNumber := MC_AxisParameter.EnableLimitPos, Value := TRUE);
        read(Axis := axis, Enable := TRUE, ParameterNumber := MC_AxisParameter.AxisMaxVelocity,
            ReadMode := E_ReadMode.READMODE_CYCLIC);
        other(Axis := axis, Enable := TRUE, ParameterNumber := MC_AxisParameter.AxisJerk);
        readBool(Axis := axis, Enable := TRUE, ParameterNumber := MC_AxisParameter.EnableLimitPos,
            ReadMode := E_ReadMode.READMODE_CYCLIC);
        move(Axis := axis, Execute := doMove, Velocity := 50.0, Acceleration := 1000.0, Deceleration := 1000.0);
        speed(Axis := axis, Enable := TRUE, ParameterNumber := MC_AxisParameter.ActualVelocity,
            ReadMode := E_ReadMode.READMODE_CYCLIC);
        a := read.Value; b := other.Value; c := readBool.Value; v := speed.Value;
        valid := read.Valid; busy := read.Busy;
    """
    bench = IecBench(program(declared, body), dialect=CODESYS)
    _cycles(bench, 2)
    assert (bench["a"], bench["b"], bench["c"], bench["valid"], bench["busy"]) == (0.0, 0.0, False, True, True)
    bench["doWrite"] = bench["doMove"] = True
    _cycles(bench, 60)
    assert (bench["a"], bench["b"], bench["c"]) == (77.5, 0.0, True)
    assert bench["v"] == pytest.approx(50.0)


def test_a_parameter_is_read_once_for_each_enable() -> None:
    declared = "axis : AXIS_REF; write : MC_WriteParameter; read : MC_ReadParameter; on : BOOL := TRUE; a, n : LREAL;"
    body = """
        write(Axis := axis, Execute := NOT write.Execute, ParameterNumber := MC_AxisParameter.AxisAcc, Value := n);
        n := n + 1.0;
        read(Axis := axis, Enable := on, ParameterNumber := MC_AxisParameter.AxisAcc, ReadMode := READMODE_ONCE);
        a := read.Value;
    """
    bench = IecBench(program(declared, body), dialect=CODESYS)
    _cycles(bench, 1)
    first = bench["a"]
    _cycles(bench, 10)
    assert bench["a"] == first
    bench["on"] = False
    _cycles(bench, 1)
    bench["on"] = True
    _cycles(bench, 1)
    assert bench["a"] > first  # type: ignore[operator]


def test_additive_moves_add_up_on_the_way() -> None:
    declared = """
        axis : AXIS_REF; power : MC_Power; one, two : MC_MoveAdditive; doOne, doTwo : BOOL; position : LREAL;
        aborted, done : BOOL;
    """
    body = """
        power(Axis := axis, Enable := TRUE, Enable_Positive := TRUE, Enable_Negative := TRUE);
        one(Axis := axis, Execute := doOne, Distance := 10.0, Velocity := 20.0, Acceleration := 500.0);
        two(Axis := axis, Execute := doTwo, Distance := 5.0, Velocity := 20.0, Acceleration := 500.0);
        position := axis.NcToPlc.ActPos; aborted := one.CommandAborted OR aborted; done := two.Done;
    """
    bench = IecBench(program(declared, body), dialect=CODESYS)
    _cycles(bench, 2)
    bench["doOne"] = True
    _cycles(bench, 10)
    bench["doTwo"] = True
    _cycles(bench, 200)
    assert bench["position"] == pytest.approx(15.0)
    assert bench["aborted"] is bench["done"] is True
