"""The report of pytest about tests of programs in Python: the line of the test, the values, and what came before."""

import pytest

pytest_plugins = ["pytester"]
pytestmark = pytest.mark.long

LAMP = """PROGRAM Lamp
VAR cycles : UDINT; level : INT; on, off : BOOL; END_VAR
cycles := cycles + 1;
IF cycles MOD 10 = 0 THEN level := level + 1; END_IF
on := level > 2;
END_PROGRAM
FUNCTION_BLOCK Shelf
VAR_INPUT place : INT; END_VAR
VAR things : ARRAY[0..4] OF INT; END_VAR
things[place] := 1;
END_FUNCTION_BLOCK
CONFIGURATION Cell
RESOURCE Main ON Controller
TASK Fast(INTERVAL := T#10ms, PRIORITY := 1);
PROGRAM Lamp1 WITH Fast : Lamp;
END_RESOURCE
END_CONFIGURATION
"""

TESTS = """
import pytest
from fieldrig import MS, S

@pytest.fixture
def plc(fieldrig_program):
    return fieldrig_program("lamp.st")

def test_value(plc):
    plc.start()
    plc.advance(350 * MS)
    assert plc["Lamp.level"] == 9

def test_after_reset(plc):
    plc.start()
    plc.advance(1 * S)
    plc.reset()
    plc.start()
    plc.advance(120 * MS)
    assert plc["Lamp.level"] == 9

def test_condition(plc):
    plc.start()
    plc.until(lambda: plc["Lamp.off"], within=50 * MS)

def test_fault(plc):
    shelf = plc.block("Shelf")
    shelf(place=5)

def test_mistake(fieldrig_program):
    fieldrig_program("wrong.st")
"""


def test_a_failed_test_is_told_at_its_own_line_with_values_and_last_changes(pytester: pytest.Pytester) -> None:
    pytester.makefile(".st", lamp=LAMP, wrong=LAMP.replace("level > 2", "levl > 2"))
    pytester.makepyfile(TESTS)
    result = pytester.runpytest_inprocess("-p", "no:xdist", "-p", "no:cacheprovider")
    result.assert_outcomes(failed=5)
    _, value, after_reset, condition, fault, mistake = str(result.stdout).split("__ test_")
    assert "assert 3 == 9" in value
    last = "Lamp.level = 3 since T#290ms; before 0 at T#0ms, 1 at T#90ms, 2 at T#190ms  (lamp.st:2)"
    assert last in value, "the first cycle is at 0"
    assert "Lamp.level = 1 since T#90ms; before 0 at T#0ms  (lamp.st:2)" in after_reset
    assert "the condition did not hold within 50 ms" in condition
    assert "Lamp.off = FALSE all the time  (lamp.st:2)" in condition
    assert ">       shelf(place=5)" in fault
    assert "the index 5 is outside 0..4 in Shelf (lamp.st:10)" in fault
    assert '>       fieldrig_program("wrong.st")' in mistake
    assert "wrong.st:5: levl is not declared" in mistake
    ours = [
        name for name in ("programs.py", "instance.py", "compiler.py", "CompileError") if name in str(result.stdout)
    ]
    assert not ours, "a test has no part in the lines of fieldrig"
