"""Tests that notice changes, tests that do not, and what they cannot see."""

import json
from pathlib import Path

import pytest
from st_tests import LAMP_RIG, written
from typer.testing import CliRunner, Result

from fieldrig_devices.iec.commands import app

pytestmark = pytest.mark.long

COUNTER = """\
FUNCTION_BLOCK Counter
VAR_INPUT up, reset : BOOL; limit : INT; END_VAR
VAR_OUTPUT count : INT; full : BOOL; END_VAR
IF reset THEN
  count := 0;
ELSIF up THEN
  count := count + 1;
END_IF
full := count >= limit;
END_FUNCTION_BLOCK
"""
WEAK = """\
TEST 'counts'
VAR c : Counter; END_VAR
c(up := TRUE, limit := 2);
ASSERT_EQ(c.count, 1);
c();
ASSERT_TRUE(c.full);
END_TEST
"""
STRONG = (
    WEAK
    + """
TEST 'is full at its limit, and empty after a reset'
VAR c : Counter; END_VAR
c(up := TRUE, limit := 2);
ASSERT_FALSE(c.full);
c();
c();
ASSERT_TRUE(c.full, 'beyond it too');
c(up := FALSE);
ASSERT_EQ(c.count, 3);
c(reset := TRUE);
ASSERT_EQ(c.count, 0);
END_TEST
"""
)
LAMP = """\
PROGRAM PLC_PRG
VAR switch AT %IX0.0 : BOOL; lamp AT %QX0.0 : BOOL; END_VAR
lamp := switch;
END_PROGRAM
"""


def mutate(path: Path, *options: object) -> Result:
    return CliRunner().invoke(app, ["mutate", str(path), "--dialect", "edition-3", *map(str, options)])


def fates(path: Path, *options: object) -> dict[tuple[int, str, str], str]:
    done = mutate(path, "--json", *options)
    assert done.exit_code == 0, done.output
    return {(one["line"], one["before"], one["after"]): one["fate"] for one in json.loads(done.stdout)["changes"]}


@pytest.mark.parametrize("jobs", [1, pytest.param(2, marks=pytest.mark.system)])
def test_changes_that_no_test_notices_are_listed(tmp_path: Path, jobs: int) -> None:
    written(tmp_path, counter=COUNTER, counter_test=WEAK)
    found = fates(tmp_path / "counter_test.st", "-j", jobs)
    assert found[7, "count + 1", "count - 1"] == "noticed"
    assert found[9, "count >= limit", "count > limit"] == "noticed"
    assert found[9, "count >= limit", "count < limit"] == "noticed"
    assert found[6, "up", "NOT up"] == "noticed"
    assert found[5, "count := 0;", ""] == "not run"
    assert {fate for (line, _, _), fate in found.items() if line == 5} == {"not run"}


def test_strong_tests_notice_all(tmp_path: Path) -> None:
    written(tmp_path, counter=COUNTER, counter_test=STRONG)
    done = mutate(tmp_path, "--fail-under", 100)
    assert done.exit_code == 0, done.output
    assert "(100.0 %)" in done.stdout
    assert "->" not in done.stdout


def test_a_line_says_where_and_what(tmp_path: Path) -> None:
    written(tmp_path, counter=COUNTER, counter_test=WEAK)
    done = mutate(tmp_path, "--fail-under", 90)
    assert done.exit_code == 1
    assert "counter.st:5  reset  without `count := 0;`  (no test runs it)\n" in done.stdout
    assert "expected at least 90 %" in done.stderr


def test_tests_that_fail_without_a_change_end_it(tmp_path: Path) -> None:
    written(tmp_path, counter=COUNTER, counter_test=WEAK.replace("1);", "7);"))
    done = mutate(tmp_path)
    assert done.exit_code == 1
    assert "the tests have to pass before the program is changed" in done.stderr
    assert "expected 7, got 1" in done.stderr


def test_a_change_that_never_ends_is_noticed(tmp_path: Path) -> None:
    loop = (
        "FUNCTION Sum : INT\nVAR_INPUT n : INT; END_VAR\nVAR i : INT; END_VAR\n"
        "WHILE i < n DO\ni := i + 1; Sum := Sum + i;\nEND_WHILE\nEND_FUNCTION\n"
    )
    written(tmp_path, sum=loop, sum_test="TEST 'sum' ASSERT_EQ(Sum(3), 6); END_TEST\n")
    found = fates(tmp_path, "--timeout", 0.2)
    assert found[5, "i := i + 1;", ""] == "noticed"


def test_at_most_so_many_are_tried(tmp_path: Path) -> None:
    written(tmp_path, counter=COUNTER, counter_test=WEAK)
    assert len(fates(tmp_path, "--most", 3)) == 3


def test_a_program_on_its_device_in_a_rig_is_changed(tmp_path: Path) -> None:
    (tmp_path / "lamp.yaml").write_text(LAMP_RIG)
    places = "VAR switch AT 'wires/switch.on' : BOOL; lamp AT 'wires/lamp.on' : BOOL; END_VAR"
    on = f"TEST 'on' RIG 'lamp.yaml' AFTER T#5s;\n{places} switch := TRUE; ASSERT_WITHIN(lamp, T#50ms); END_TEST\n"
    written(tmp_path, lamp=LAMP, lamp_test=on)
    assert fates(tmp_path / "lamp_test.st") == {(3, "lamp := switch;", ""): "noticed"}
