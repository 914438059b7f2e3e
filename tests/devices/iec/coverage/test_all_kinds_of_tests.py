"""Coverage adds up over files, processes, rigs and suites of TcUnit."""

import re
from pathlib import Path

import pytest
from st_tests import LAMP_RIG, iec_test, written

from fieldrig.coverage.collecting import collecting
from fieldrig.coverage.summary import Coverage
from fieldrig_devices.iec.testing.case import Limits
from fieldrig_devices.iec.testing.suites import sources_in

STEP = """\
FUNCTION Step : INT
VAR_INPUT n : INT; END_VAR
IF n > 0 THEN
  Step := 1;
ELSE
  Step := -1;
END_IF
END_FUNCTION
"""
LAMP = """\
PROGRAM PLC_PRG
VAR switch AT %IX0.0 : BOOL; lamp AT %QX0.0 : BOOL; END_VAR
IF switch THEN
  lamp := TRUE;
ELSE
  lamp := FALSE;
END_IF
END_PROGRAM
"""
SUITE = """\
FUNCTION_BLOCK FB_Step EXTENDS TcUnit.FB_TestSuite
TEST('up');
AssertEquals_INT(Expected := 1, Actual := Step(5), Message := '');
TEST_FINISHED();
END_FUNCTION_BLOCK
"""


def total(folder: Path, *options: object) -> str:
    done = iec_test(folder, "--coverage", *options)
    assert done.exit_code == 0, done.output
    found = re.search(r"^total .*$", done.stdout, re.MULTILINE)
    assert found is not None, done.stdout
    return " ".join(found[0].split())


@pytest.mark.parametrize("jobs", [1, pytest.param(2, marks=pytest.mark.system)])
def test_files_and_processes_add_up(tmp_path: Path, jobs: int) -> None:
    up, down = (f"TEST '{n}' ASSERT_EQ(Step({n}), {n}); END_TEST\n" for n in (1, -1))
    written(tmp_path, step=STEP, up_test=up)
    assert total(tmp_path, "-j", jobs) == "total 2/3 1/2 60.0"
    written(tmp_path, down_test=down)
    assert total(tmp_path, "-j", jobs) == "total 3/3 2/2 100.0"


@pytest.mark.long
def test_a_program_on_its_device_in_a_rig_is_covered_by_the_branches(tmp_path: Path) -> None:
    (tmp_path / "lamp.yaml").write_text(LAMP_RIG)
    places = "VAR switch AT 'wires/switch.on' : BOOL; lamp AT 'wires/lamp.on' : BOOL; END_VAR"
    off = f"TEST 'off' RIG 'lamp.yaml' AFTER T#5s;\n{places} ASSERT_STAYS(NOT lamp, T#50ms); END_TEST\n"
    on = f"TEST 'on' RIG 'lamp.yaml' AFTER T#5s;\n{places} switch := TRUE; ASSERT_WITHIN(lamp, T#50ms); END_TEST\n"
    written(tmp_path, lamp=LAMP, lamp_test=off)
    assert total(tmp_path / "lamp_test.st") == "total 2/3 1/2 60.0"
    written(tmp_path, lamp_test=off + on)
    assert total(tmp_path / "lamp_test.st") == "total 3/3 2/2 100.0"


def test_a_suite_of_tcunit_covers_the_code_and_not_itself(tmp_path: Path) -> None:
    written(tmp_path, step=STEP, suite=SUITE)
    with collecting() as collected:
        (source,) = sources_in(tmp_path)
        for outcome in source.run(source.cases(), Limits()):
            assert outcome.verdict == "passed"
        coverage = Coverage(collected.news())
    assert {place.pou for place, _ in coverage.total.places} == {"Step"}
    assert coverage.total.count() == (3, 5)
