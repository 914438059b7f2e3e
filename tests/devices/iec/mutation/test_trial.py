"""Tests that notice changes, tests that do not, and what they cannot see."""

import json
from pathlib import Path

import pytest
from st_tests import LAMP_RIG, written
from typer.testing import CliRunner, Result

from fieldrig.errors import UsageError
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


DEADLY = """\
import os

import fieldrig


def test_counts():
    counter = fieldrig.program("counter.st", dialect="edition-3").block("Counter")
    if counter(up=True, limit=2).count != 1:
        os._exit(9)
"""


def test_a_change_that_its_process_dies_of_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(tmp_path, counter=COUNTER)
    (tmp_path / "test_counter.py").write_text(DEADLY)
    monkeypatch.chdir(tmp_path)
    found = fates(tmp_path / "test_counter.py", "-j", 2, "--most", 6)
    assert len(found) == 6
    assert "noticed" in found.values()


def test_at_most_so_many_are_tried(tmp_path: Path) -> None:
    written(tmp_path, counter=COUNTER, counter_test=WEAK)
    assert len(fates(tmp_path, "--most", 3)) == 3


def test_a_program_on_its_device_in_a_rig_is_changed(tmp_path: Path) -> None:
    (tmp_path / "lamp.yaml").write_text(LAMP_RIG)
    places = "VAR switch AT 'wires/switch.on' : BOOL; lamp AT 'wires/lamp.on' : BOOL; END_VAR"
    on = f"TEST 'on' RIG 'lamp.yaml' AFTER T#5s;\n{places} switch := TRUE; ASSERT_WITHIN(lamp, T#50ms); END_TEST\n"
    written(tmp_path, lamp=LAMP, lamp_test=on)
    assert fates(tmp_path / "lamp_test.st") == {(3, "lamp := switch;", ""): "noticed"}


IN_PYTHON = """\
import fieldrig

PLC = fieldrig.program("counter.st", dialect="edition-3")


def test_counts_with_the_program_of_the_module():
    PLC.reset()
    assert PLC.block("Counter")(up=True, limit=2).count == 1


def test_is_full(fieldrig_program):
    counter = fieldrig_program("counter.st", dialect="edition-3").block("Counter")
    counter(up=True, limit=2)
    assert counter().full
"""


def test_tests_in_python_notice_changes_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(tmp_path, counter=COUNTER, counter_test=WEAK)
    (tmp_path / "test_counter.py").write_text(IN_PYTHON)
    monkeypatch.chdir(tmp_path)
    in_blocks = fates(tmp_path / "counter_test.st", "--most", 4)
    assert fates(tmp_path / "test_counter.py", "--most", 4) == in_blocks
    assert set(in_blocks.values()) == {"noticed", "not run"}


def test_accepted_changes_are_left_out_with_their_reasons(tmp_path: Path) -> None:
    written(tmp_path, counter=COUNTER, counter_test=WEAK)
    known = tmp_path / "known.txt"
    known.write_text("# the reset\n\ncounter.st:5  reset  without `count := 0;`  # it counts from 0\n")
    found = fates(tmp_path / "counter_test.st", "--accepted", known)
    assert found[5, "count := 0;", ""] == "accepted"
    assert "1 accepted" in mutate(tmp_path / "counter_test.st", "--accepted", known).stdout


def test_only_the_changes_of_a_report_are_tried_again(tmp_path: Path) -> None:
    written(tmp_path, counter=COUNTER, counter_test=WEAK)
    report = [line for line in mutate(tmp_path / "counter_test.st").stdout.splitlines() if line.startswith("  ")]
    (tmp_path / "again.txt").write_text("\n".join(report))
    written(tmp_path, counter_test=STRONG)
    again = fates(tmp_path / "counter_test.st", "--only", tmp_path / "again.txt")
    assert len(again) == len(report)
    assert set(again.values()) == {"noticed"}


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("counter.st:5  reset  without `count := 0;`", "has no reason"),
        ("counter.st:4  reset  without `count := 0;`  # why", "the same text is in line 5"),
        ("counter.st:5  reset  without `other := 0;`  # why", "expected a line of the report"),
    ],
)
def test_a_line_that_is_no_change_is_refused(tmp_path: Path, line: str, told: str) -> None:
    written(tmp_path, counter=COUNTER, counter_test=WEAK)
    (tmp_path / "known.txt").write_text(f"{line}\n")
    done = mutate(tmp_path / "counter_test.st", "--accepted", tmp_path / "known.txt")
    assert isinstance(done.exception, UsageError)
    assert "known.txt:1: " in str(done.exception)
    assert told in str(done.exception)


def test_a_change_that_does_not_compile_is_no_program_in_python_either(tmp_path: Path) -> None:
    table = "FUNCTION F : INT\nVAR t : ARRAY[0..2] OF INT := [1, 2, 3]; END_VAR\nF := t[2];\nEND_FUNCTION\n"
    written(tmp_path, table=table)
    loads = f"fieldrig_program({str(tmp_path / 'table.st')!r})"
    test = f"def test(fieldrig_program):\n    assert {loads}.function('F')() == 3\n"
    (tmp_path / "test_table.py").write_text(test)
    assert fates(tmp_path / "test_table.py")[3, "2", "3"] == "no program"


def test_tests_of_no_iec_program_are_refused(tmp_path: Path) -> None:
    """The tests of a PAM or of a card change nothing, and 0 of 0 changes would be 100 %."""
    (tmp_path / "card.I01").write_text("BEG MAIN\nAGAIN: WAIT 0.01\nGOTO AGAIN\nEND\n")
    (tmp_path / "rig.yaml").write_text(
        "time: virtual\nbuses: {wires: {kind: wires.virtual}}\n"
        "devices: {card: {kind: arp, number: 1, program: card.I01, links: {wires: wires}}}\n"
    )
    (tmp_path / "card_test.st").write_text(
        "TEST 'runs'\nRIG 'rig.yaml' AFTER T#10ms;\nADVANCE_TIME(T#10ms);\nEND_TEST\n"
    )
    done = mutate(tmp_path / "card_test.st", "--fail-under", "90")
    assert isinstance(done.exception, UsageError)
    assert "no program that can be changed" in str(done.exception)
