"""Methods and properties of blocks in tests: those that are PRIVATE are called, and all can be mocked."""

from pathlib import Path
from typing import Any

import pytest
from st_tests import one

from fieldrig import ArgumentError, program
from fieldrig_devices.iec.testing.case import Verdict

DRIVE = """
INTERFACE IMove
METHOD Move : BOOL VAR_INPUT way : INT; END_VAR END_METHOD
END_INTERFACE
FUNCTION_BLOCK Drive IMPLEMENTS IMove
VAR v, factor : INT := 2; END_VAR
METHOD PUBLIC Move : BOOL
VAR_INPUT way : INT; END_VAR
v := v + Scaled(way := way); Move := v > 10;
END_METHOD
METHOD PRIVATE Scaled : INT
VAR_INPUT way : INT; END_VAR
Scaled := factor * way;
END_METHOD
METHOD PROTECTED Halve
v := v / 2;
END_METHOD
PROPERTY Level : INT
GET
Level := v;
END_GET
END_PROPERTY
END_FUNCTION_BLOCK
FUNCTION_BLOCK Fast EXTENDS Drive
METHOD PUBLIC Twice
Move(way := 1); Move(way := 1);
END_METHOD
END_FUNCTION_BLOCK
FUNCTION Through : BOOL
VAR_INPUT it : IMove; END_VAR
Through := it.Move(7);
END_FUNCTION
"""

HOLDS = [
    "d.Halve(); ASSERT_EQ(d.v, 1); ASSERT_EQ(d.Scaled(3), 6);",
    "MOCK d.Move; d.Move(3); e.Move(3); ASSERT_EQ(d.v, 2); ASSERT_EQ(e.v, 8);",
    "MOCK_FUNCTION d.Move RETURNS TRUE; ASSERT_TRUE(d.Move(0)); ASSERT_FALSE(e.Move(0));",
    "MOCK_FUNCTION d.Scaled RETURNS 100; ASSERT_TRUE(d.Move(0), 'the block itself calls it'); ASSERT_EQ(d.v, 102);",
    "MOCK_FUNCTION d.Level RETURNS 33; ASSERT_EQ(d.Level, 33); ASSERT_EQ(e.Level, 2);",
    "d.Move(1); d.Move(1); e.Move(1); ASSERT_EQ(MOCK_CALLS(d.Move), 2); MOCK_VERIFY_CALL_COUNT(e.Move, 1);",
    "MOCK_FUNCTION d.Move RETURNS TRUE; ASSERT_TRUE(Through(d), 'through an interface'); MOCK_VERIFY_CALLED(d.Move);",
    "MOCK f.Move; f.Twice(); ASSERT_EQ(f.v, 2); MOCK_VERIFY_CALL_COUNT(f.Move, 2);",
    "MOCK drives[2].Move; drives[1].Move(1); drives[2].Move(1); ASSERT_EQ(drives[1].v, 4); ASSERT_EQ(drives[2].v, 2);",
]


@pytest.mark.parametrize("body", HOLDS)
def test_methods_of_instances_are_called_counted_and_mocked(tmp_path: Path, body: str) -> None:
    variables = "VAR d, e : Drive; f : Fast; drives : ARRAY[1..2] OF Drive; END_VAR\n"
    outcome = one(tmp_path, variables + body, DRIVE, dialect="codesys")
    assert (outcome.verdict, outcome.failures) == (Verdict.PASSED, ())


@pytest.fixture
def plc(tmp_path: Path) -> Any:
    (tmp_path / "drive.st").write_text(DRIVE)
    return program(tmp_path / "drive.st", dialect="codesys")


def test_python_takes_the_place_of_a_method_in_all_instances(plc: Any) -> None:
    first, second = plc.block("Drive"), plc.block("Drive")
    mock = plc.mock("Drive.Scaled", lambda way: 10 * way)
    assert (first.Move(1), second.Move(2)) == (True, True)
    assert (first.v, second.v) == (12, 22)
    assert mock.arguments == [(1,), (2,)]
    mock.stop()
    assert (first.Move(1), first.v) == (True, 14)


def test_a_method_is_called_on_an_instance(plc: Any) -> None:
    assert plc.block("Fast").Halve() is None
    with pytest.raises(ArgumentError, match=r'Drive\.Move is a method\n  expected block\("Drive"\)\.Move\(\.\.\.\)'):
        plc.function("Drive.Move")
    with pytest.raises(ArgumentError, match=r"no block or function 'Drive\.Mve'"):
        plc.mock("Drive.Mve", returns=True)


def test_a_method_hides_a_function_of_the_project_and_of_a_library(tmp_path: Path) -> None:
    blocks = """
FUNCTION_BLOCK Counter
VAR n : INT; END_VAR
METHOD Step : INT VAR_INPUT size : INT; END_VAR Step := 20 * size; END_METHOD
METHOD Abs : INT VAR_INPUT size : INT; END_VAR Abs := 7; END_METHOD
METHOD Both n := Step(1) + Abs(-1); END_METHOD
Step(1);
END_FUNCTION_BLOCK
"""
    body = "VAR c : Counter; END_VAR c.Both(); ASSERT_EQ(c.n, 27); ASSERT_EQ(Step(1), 1); ASSERT_EQ(ABS(-3), 3);"
    assert one(tmp_path, body, blocks, dialect="codesys").verdict is Verdict.PASSED
