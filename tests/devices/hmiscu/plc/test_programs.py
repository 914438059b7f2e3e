"""Programs on the controller: MAST, the library, the watchdog, RUN, STOP and HALT."""

from pathlib import Path

import pytest
from hmiscu_device_bench import PTO, DeviceBench

from fieldrig.clock import MS
from fieldrig.errors import ConfigError

MOVE = """
VAR_GLOBAL
    g_bStart : BOOL;
    g_dwLength : DWORD := 40000;
    g_uCycles : UINT;
END_VAR
PROGRAM PLC_PRG
VAR
    Move : PTOMoveRelative;
    bLamp AT %QX0.0 : BOOL;
    bReady AT %IX0.2 : BOOL;
END_VAR
PTO00();
g_uCycles := g_uCycles + 1;
Move(PTO_REF_IN := PTO00.PTO_REF, Execute := g_bStart, Velocity := 20000, Distance := g_dwLength,
    Acceleration := 1000, Deceleration := 500, Direction := PTO_POSITIVE);
bLamp := Move.Busy;
END_PROGRAM
"""


@pytest.mark.long
@pytest.mark.manual("SCU-010", "SCU-028", "SCU-094", "SCU-097")
def test_a_program_moves_the_axis_by_the_global_instance_of_the_channel(tmp_path: Path) -> None:
    bench = DeviceBench(tmp_path, MOVE, channel_0=PTO, mast={"cycle_ms": 5})
    bench.run(100)
    assert bench.get("g_uCycles") == 21
    bench.set("g_bStart", True)
    bench.run(2_744)
    assert (bench.level("lamp"), bench.get("PTO00.Moving")) == (True, True)
    bench.run(20)
    assert (bench.level("lamp"), bench.get("PTO00.Moving"), bench.get("PTO00.Distance")) == (False, False, 40_000)


@pytest.mark.long
@pytest.mark.manual("SCU-010")
def test_the_global_instance_can_be_renamed(tmp_path: Path) -> None:
    program = MOVE.replace("PTO00", "Feeder")
    bench = DeviceBench(tmp_path, program, channel_0=PTO | {"variable": "Feeder"})
    bench.set("g_bStart", True)
    bench.run(3_000)
    assert bench.get("PTO00.Distance") == bench.get("Feeder.Distance") == 40_000


@pytest.mark.manual("SCU-094")
def test_instruction_list_calls_a_block_with_cal(tmp_path: Path) -> None:
    listing = """
VAR_GLOBAL
    g_bStart : BOOL;
    g_dwFrequency : DWORD;
END_VAR
PROGRAM PLC_PRG
VAR
    Velocity : PTOMoveVelocity;
END_VAR
    CAL PTO00(Frequency => g_dwFrequency)
    CAL Velocity(PTO_REF_IN := PTO00.PTO_REF, Execute := g_bStart, Velocity := 10000, Acceleration := 100,
        Deceleration := 100)
END_PROGRAM
"""
    bench = DeviceBench(tmp_path, listing, channel_0=PTO)
    bench.set("g_bStart", True)
    bench.run(500)
    assert bench.get("g_dwFrequency") == 10_000


@pytest.mark.manual("SCU-063", "SCU-098")
def test_an_instance_that_is_not_the_one_of_the_channel_has_no_axis(tmp_path: Path) -> None:
    program = """
VAR_GLOBAL
    g_eError : PTOPWM_ERR_TYPE;
END_VAR
PROGRAM PLC_PRG
VAR
    Other : PTOSimple;
    Stop : PTOStop;
END_VAR
Other();
Stop(PTO_REF_IN := Other.PTO_REF, Execute := TRUE, Deceleration := 100, ErrID => g_eError);
END_PROGRAM
"""
    bench = DeviceBench(tmp_path, program, channel_0=PTO)
    bench.run(50)
    assert bench.get("g_eError") == 1


@pytest.mark.long
@pytest.mark.manual("SCU-092")
@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("NO_ERROR", 0), ("PTO_UNKNOW_REF", 1), ("PTO_UNKNOW_PARAMETER", 2), ("PTO_INVALID_PARAMETER", 3),
        ("PTO_COM_ERROR", 4), ("PTO_AXIS_ERROR", 5), ("PTO_NO_ERROR", 0), ("PTO_UNKNOWN_REF", 1),
        ("PTO_UNKNOWN_PARAMETER", 2), ("PTO_POSITIVE", 0), ("PTO_NEGATIVE", 1), ("PTO_CURRENT", 2),
        ("PTO_START_FREQUENCY", 0), ("PTO_STOP_FREQUENCY", 1),
    ],
)  # fmt: skip
def test_the_types_of_the_library_have_the_values_of_the_manual(tmp_path: Path, name: str, value: int) -> None:
    bench = DeviceBench(
        tmp_path, f"VAR_GLOBAL g_iValue : INT; END_VAR PROGRAM PLC_PRG g_iValue := {name}; END_PROGRAM", channel_0=PTO
    )
    bench.run(20)
    assert bench.get("g_iValue") == value


@pytest.mark.manual("SCU-095")
def test_inputs_are_those_of_the_begin_of_the_cycle(tmp_path: Path) -> None:
    program = """
VAR_GLOBAL
    g_bSeen : BOOL;
END_VAR
PROGRAM PLC_PRG
VAR
    bReady AT %IX0.2 : BOOL;
    bLamp AT %QX0.0 : BOOL;
END_VAR
g_bSeen := bReady;
bLamp := NOT bLamp;
END_PROGRAM
"""
    bench = DeviceBench(tmp_path, program)
    bench.run(1)
    bench.wire("drive.ready", True)
    bench.run(8)
    assert (bench.get("g_bSeen"), bench.level("lamp")) == (False, True)
    bench.run(2)
    assert (bench.get("g_bSeen"), bench.level("lamp")) == (True, False)


def test_the_program_has_the_keys_lamps_and_lines_of_the_panel(tmp_path: Path) -> None:
    program = """
PROGRAM PLC_PRG
VAR
    bKey AT %IX8.1 : BOOL;
    bLamp AT %QX8.2 : BOOL;
END_VAR
bLamp := bKey;
IF bKey THEN PanelText(2, 'jam in lane 3'); END_IF;
END_PROGRAM
"""
    bench = DeviceBench(tmp_path, program)
    bench.set("panel.key2", True)
    bench.run(20)
    assert (bench.get("panel.lamp3"), bench.get("panel.line2")) == (True, "jam in lane 3")


SLOW = """
VAR_GLOBAL g_bSlow : BOOL; g_uCycles : UINT; END_VAR
PROGRAM PLC_PRG
VAR i, iMost : DINT; bLamp AT %QX0.0 : BOOL; END_VAR
bLamp := TRUE;
g_uCycles := g_uCycles + 1;
iMost := SEL(g_bSlow, 10, 10000000);
FOR i := 1 TO iMost DO
    ;
END_FOR;
END_PROGRAM
"""


@pytest.mark.long
def test_the_watchdog_halts_a_program_that_never_ends_its_cycle(tmp_path: Path) -> None:
    bench = DeviceBench(tmp_path, SLOW, mast={"cycle_ms": 10, "watchdog_ms": 50})
    bench.run(25)
    assert (bench.get("plc/state"), bench.level("lamp")) == ("run", True)
    bench.set("g_bSlow", True)
    bench.run(200)
    assert (bench.get("plc/state"), bench.level("lamp")) == ("halt", False)
    assert "watchdog" in str(bench.get("plc/problem"))
    with pytest.raises(ValueError, match="HALT"):
        bench.set("plc/command", "run")
    bench.set("plc/command", "reset cold")
    bench.set("plc/command", "run")
    bench.run(100)
    assert (bench.get("plc/state"), bench.get("g_uCycles")) == ("run", 11)


@pytest.mark.long
def test_a_stall_of_the_host_does_not_expire_the_watchdog(tmp_path: Path) -> None:
    """In real time a blocked process finds its timers late; here the clock is moved past them in one leap."""
    bench = DeviceBench(tmp_path, SLOW, mast={"cycle_ms": 10, "watchdog_ms": 50})
    bench.run(25)
    for _ in range(5):
        bench.clock.instant_ns += 400 * MS
        bench.run(20)
    assert bench.get("plc/state") == "run"


def test_a_fault_of_the_program_halts_the_controller_and_stops_the_move(tmp_path: Path) -> None:
    program = MOVE.replace(
        "bLamp := Move.Busy;",
        "bLamp := Move.Busy; IF g_uCycles > 50 THEN g_uCycles := g_uCycles / (g_uCycles - g_uCycles); END_IF;",
    )
    bench = DeviceBench(tmp_path, program, channel_0=PTO)
    bench.set("g_bStart", True)
    bench.run(1_000)
    assert (bench.get("plc/state"), bench.level("lamp"), bench.get("PTO00.State")) == ("halt", False, 4)
    assert "division" in str(bench.get("plc/problem"))


def test_a_stopped_program_goes_on_where_it_was(tmp_path: Path) -> None:
    bench = DeviceBench(tmp_path, MOVE, channel_0=PTO)
    bench.run(100)
    bench.set("plc/command", "stop")
    before = bench.get("g_uCycles")
    bench.run(100)
    assert bench.get("g_uCycles") == before
    bench.set("plc/command", "run")
    bench.run(100)
    assert int(bench.get("g_uCycles")) > int(before)
    bench.set("plc/command", "reset warm")
    assert bench.get("g_uCycles") == 0


def test_a_task_configuration_replaces_mast(tmp_path: Path) -> None:
    program = (
        MOVE
        + """
CONFIGURATION Feeder
    RESOURCE Controller ON HMISCU
        TASK Slow(INTERVAL := T#50ms, PRIORITY := 5);
        PROGRAM Main WITH Slow : PLC_PRG;
    END_RESOURCE
END_CONFIGURATION
"""
    )
    bench = DeviceBench(tmp_path, program, channel_0=PTO)
    bench.run(500)
    assert (bench.get("g_uCycles"), bench.get("plc/task/Slow/cycles")) == (11, 10)


def test_a_program_with_a_mistake_is_refused_with_its_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"program\.st:3:1: .*nothing"):
        DeviceBench(tmp_path, "PROGRAM PLC_PRG\nVAR END_VAR\nnothing := 1;\nEND_PROGRAM\n")


@pytest.mark.manual("SCU-010", "SCU-063")
@pytest.mark.parametrize("dialect", ["epas-4", "edition-3", "codesys"])
def test_the_name_of_the_embedded_function_may_stand_in_front_of_an_instance(tmp_path: Path, dialect: str) -> None:
    program = """
VAR_GLOBAL g_eError : PTOPWM_ERR_TYPE; END_VAR
PROGRAM PLC_PRG
VAR Stop : PTOStop; END_VAR
PTO_PWM.PTO00();
Stop(PTO_REF_IN := PTO_PWM.PTO00.PTO_REF, Execute := TRUE, Deceleration := 100, ErrID => g_eError);
END_PROGRAM
"""
    bench = DeviceBench(tmp_path, program, channel_0=PTO, dialect=dialect)
    bench.run(50)
    assert (bench.get("g_eError"), bench.get("PTO00.State")) == (0, 3)


@pytest.mark.manual("SCU-063")
@pytest.mark.parametrize(
    "block", ["PTOStop", "PTOMoveRelative", "PTOMoveVelocity", "PTOGetParam", "PTOSetParam", "PTOGetDiag"]
)
def test_an_open_reference_is_found_when_the_program_is_compiled(tmp_path: Path, block: str) -> None:
    program = "PROGRAM PLC_PRG\nVAR Block : %s; END_VAR\nPTO00();\n%s\nEND_PROGRAM"
    with pytest.raises(ConfigError, match=r"program\.st:2:5: .*Block\.PTO_REF_IN is open"):
        DeviceBench(tmp_path, program % (block, "IF TRUE THEN Block(Execute := TRUE); END_IF;"), channel_0=PTO)
    for call in ("Block(PTO_REF_IN := PTO00.PTO_REF);", "Block.PTO_REF_IN := PTO00.PTO_REF; Block();", ""):
        DeviceBench(tmp_path, program % (block, call), channel_0=PTO)


def test_the_error_of_the_drift_has_both_names_of_its_type(tmp_path: Path) -> None:
    """The manual calls it RTCDRIFT_ERROR, the programming software RTCSETDRIFT_ERROR.  A wrong day is its error."""
    program = """
VAR_GLOBAL g_iDay : INT := 6; g_iError : INT; END_VAR
PROGRAM PLC_PRG
VAR eFirst : RTCDRIFT_ERROR; eSecond : RTCSETDRIFT_ERROR; END_VAR
eFirst := SetRTCDrift(5, g_iDay, 12, 0);
eSecond := eFirst;
g_iError := eSecond;
END_PROGRAM
"""
    bench = DeviceBench(tmp_path, program)
    bench.run(20)
    assert (bench.get("g_iError"), bench.get("rtc.drift")) == (0, 5)
    bench.set("g_iDay", 7)
    bench.run(20)
    assert (bench.get("g_iError"), bench.get("plc/state")) == (2, "run")


@pytest.mark.long
def test_a_block_of_the_controller_is_used_and_not_extended(tmp_path: Path) -> None:
    text = "FUNCTION_BLOCK Mine EXTENDS PTOMoveRelative\nEND_FUNCTION_BLOCK\nPROGRAM PLC_PRG\nEND_PROGRAM\n"
    with pytest.raises(ConfigError, match=r"program.st:1:1: .*built into the controller.*\n.*instance of it in VAR"):
        DeviceBench(tmp_path, text, dialect="codesys")
