"""An enumeration input of a library's block takes any number, and the block answers with its own error."""

from pathlib import Path

import pytest
from hmiscu_device_bench import PTO, DeviceBench

from fieldrig.errors import ConfigError

PROGRAM = """
VAR_GLOBAL
    g_iNumber : INT;
    g_bExecute : BOOL;
    g_eMove, g_eGet, g_eSet : PTOPWM_ERR_TYPE;
    g_dwDiag : DWORD;
END_VAR
PROGRAM PLC_PRG
VAR
    Move : PTOMoveRelative;
    Velocity : PTOMoveVelocity;
    Get : PTOGetParam;
    Set : PTOSetParam;
    Diag : PTOGetDiag;
END_VAR
PTO00();
{move}
Move(PTO_REF_IN := PTO00.PTO_REF, Execute := g_bExecute, Velocity := 1000, Distance := 10, Acceleration := 100,
    Deceleration := 100);
Get(PTO_REF_IN := PTO00.PTO_REF, Execute := g_bExecute, Param := g_iNumber);
Set(PTO_REF_IN := PTO00.PTO_REF, Execute := g_bExecute, Param := g_iNumber, Param_Value := 10);
Diag(PTO_REF_IN := PTO00.PTO_REF, Execute := Move.Error);
g_eMove := Move.ErrID;
g_eGet := Get.ErrID;
g_eSet := Set.ErrID;
g_dwDiag := Diag.PTODiag;
END_PROGRAM
"""
INVALID_DIRECTION = 1 << 26


def answers(bench: DeviceBench) -> tuple[object, ...]:
    bench.set("g_bExecute", True)
    bench.run(30)
    state = bench.get("plc/state")
    return (state, *(bench.get(name) for name in ("g_eMove", "g_eGet", "g_eSet", "g_dwDiag")))


@pytest.mark.long
@pytest.mark.manual("SCU-061", "SCU-064")
@pytest.mark.parametrize("dialect", ["epas-4", "edition-3", "codesys"])
@pytest.mark.parametrize("number", [3, 255, 256, 258, -1, 32767, -32768])
def test_a_wrong_number_by_a_variable_is_an_error_of_the_block(tmp_path: Path, dialect: str, number: int) -> None:
    program = PROGRAM.format(move="Move.Direction := g_iNumber;")
    bench = DeviceBench(tmp_path, program, channel_0=PTO, dialect=dialect)
    bench.set("g_iNumber", number)
    assert answers(bench) == ("run", 3, 2, 2, INVALID_DIRECTION)


@pytest.mark.long
@pytest.mark.manual("SCU-064")
def test_the_number_behind_the_last_parameter_is_an_unknown_parameter(tmp_path: Path) -> None:
    bench = DeviceBench(tmp_path, PROGRAM.format(move=""), channel_0=PTO)
    bench.set("g_iNumber", 2)
    assert answers(bench) == ("run", 0, 2, 2, 0)


@pytest.mark.long
@pytest.mark.parametrize("number", ["3", "-1", "16#7F", "INT#3"])
def test_a_wrong_constant_is_an_error_of_the_block_as_well(tmp_path: Path, number: str) -> None:
    bench = DeviceBench(tmp_path, PROGRAM.format(move=f"Move.Direction := {number};"), channel_0=PTO)
    assert answers(bench) == ("run", 3, 0, 0, INVALID_DIRECTION)


@pytest.mark.long
def test_a_tool_sets_a_wrong_number_too(tmp_path: Path) -> None:
    bench = DeviceBench(tmp_path, PROGRAM.format(move=""), channel_0=PTO)
    bench.set("PLC_PRG.Move.Direction", 77)
    assert answers(bench) == ("run", 3, 0, 0, INVALID_DIRECTION)


@pytest.mark.long
def test_a_variable_of_the_program_still_has_the_numbers_of_its_type(tmp_path: Path) -> None:
    program = PROGRAM.format(
        move="eDirection := g_iNumber; Move.Direction := eDirection; eDirection := Move.Direction;"
    )
    program = program.replace("VAR\n    Move", "VAR\n    eDirection : PTO_DIRECTION;\n    Move")
    bench = DeviceBench(tmp_path, program, channel_0=PTO)
    bench.set("g_iNumber", 1)
    assert answers(bench) == ("run", 0, 0, 0, 0)
    bench.set("g_iNumber", 3)
    bench.run(30)
    assert bench.get("plc/state") == "halt"


@pytest.mark.long
def test_an_input_takes_no_value_of_another_enumeration(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="PTO_PARAMETER_TYPE"):
        DeviceBench(tmp_path, PROGRAM.format(move="Move.Direction := PTO_STOP_FREQUENCY;"), channel_0=PTO)


@pytest.mark.long
def test_the_generator_of_the_standard_library_takes_any_mode(tmp_path: Path) -> None:
    program = """
VAR_GLOBAL g_iMode : INT; g_iOut : INT; END_VAR
PROGRAM PLC_PRG
VAR Wave : GEN; END_VAR
Wave(MODE := g_iMode, BASE := TRUE, PERIOD := T#1s, AMPLITUDE := 100, OUT => g_iOut);
END_PROGRAM
"""
    bench = DeviceBench(tmp_path, program)
    bench.set("g_iMode", 99)
    bench.run(100)
    assert bench.get("plc/state") == "run"
