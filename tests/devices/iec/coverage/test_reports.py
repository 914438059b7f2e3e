"""Reports of coverage, as the documents of their forms say."""

import re
from pathlib import Path
from xml.etree import ElementTree as Xml

import pytest
from st_tests import iec_test, written

from fieldrig.coverage.summary import ranges

PUMP = """\
FUNCTION_BLOCK Pump
VAR_INPUT level : INT; END_VAR
VAR_OUTPUT run, alarm : BOOL; END_VAR
IF level > 80 THEN
  run := TRUE;
ELSIF level < 20 THEN
  run := FALSE;
END_IF
IF level > 95 THEN alarm := TRUE; END_IF
END_FUNCTION_BLOCK

FUNCTION Never : INT
VAR_INPUT n : INT; END_VAR
Never := n;
END_FUNCTION
"""
TESTS = "TEST 'full <&>' VAR p : Pump; END_VAR p(level := 90); ASSERT_TRUE(p.run); END_TEST\n"
LCOV = """\
TN:
SF:pump.st
FN:4,Pump
FN:14,Never
FNDA:1,Pump
FNDA:0,Never
FNF:2
FNH:1
BRDA:4,0,0,1
BRDA:4,0,1,0
BRDA:4,0,2,0
BRDA:9,0,0,0
BRDA:9,0,1,1
BRF:5
BRH:2
DA:4,1
DA:5,1
DA:7,0
DA:9,1
DA:14,0
LF:5
LH:3
end_of_record
"""
"""Worked out by hand from geninfo(1): DA line,count; BRDA line,block,branch,taken; FN line,name; FNDA count,name."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return written(tmp_path, pump=PUMP, pump_test=TESTS)


def test_a_person_sees_a_table_of_the_pous_with_what_has_not_run(folder: Path) -> None:
    done = iec_test("pump_test.st", "--coverage")
    assert done.exit_code == 0, done.output
    shown = done.stdout[done.stdout.index("coverage") :].splitlines()
    assert [line.split() for line in shown] == [
        ["coverage", "statements", "branches", "%", "not", "run"],
        ["pump.st"],
        ["Pump", "3/5", "2/5", "50.0", "7-9;", "4", "no", "ELSE,", "6", "ELSIF", "1,", "9", "IF"],
        ["Never", "0/1", "-", "0.0", "14"],
        ["total", "3/6", "2/5", "45.4"],
    ]


def test_lcov_has_the_records_of_its_manual(folder: Path) -> None:
    assert iec_test("pump_test.st", "--lcov", "out/coverage.info").exit_code == 0
    assert (folder / "out" / "coverage.info").read_text() == LCOV


def test_lcov_tells_a_choice_that_was_never_reached_from_one_whose_branch_was_not_taken(folder: Path) -> None:
    body = "VAR_INPUT n : INT; END_VAR\nIF n > 1 THEN IF n > 2 THEN F := 3; END_IF END_IF"
    written(
        folder, pump=f"FUNCTION F : INT\n{body}\nEND_FUNCTION\n", pump_test="TEST 'one' ASSERT_EQ(F(1), 0); END_TEST\n"
    )
    assert iec_test("pump_test.st", "--lcov", "coverage.info").exit_code == 0
    lines = (folder / "coverage.info").read_text().splitlines()
    branches = ["BRDA:3,0,0,0", "BRDA:3,0,1,1", "BRDA:3,1,2,-", "BRDA:3,1,3,-"]
    assert [line for line in lines if line.startswith("BRDA")] == branches


def test_cobertura_has_the_elements_of_its_document_type(folder: Path) -> None:
    assert iec_test("pump_test.st", "--cobertura", "coverage.xml").exit_code == 0
    root = Xml.parse(folder / "coverage.xml").getroot()
    rates = ("line-rate", "branch-rate", "lines-covered", "lines-valid", "branches-covered", "branches-valid")
    assert [root.get(name) for name in rates] == ["0.6000", "0.4000", "3", "5", "2", "5"]
    assert [(one.get("name"), one.get("filename")) for one in root.iter("class")] == [
        ("Pump", "pump.st"),
        ("Never", "pump.st"),
    ]
    lines = [(one.get("number"), one.get("hits"), one.get("condition-coverage")) for one in root.iter("line")]
    assert lines == [
        ("4", "1", "33% (1/3)"),
        ("5", "1", None),
        ("7", "0", None),
        ("9", "1", "50% (1/2)"),
        ("14", "0", None),
    ]
    assert [child.tag for child in root] == ["sources", "packages"]


def test_the_page_has_the_escaped_source_and_asks_for_nothing_outside(folder: Path) -> None:
    assert iec_test("pump_test.st", "--coverage-html", "html").exit_code == 0
    text = (folder / "html" / "index.html").read_text()
    assert re.findall(r'<span class="(\w*)"><b> *(\d+) (.)</b>', text)[3:9] == [
        ("partly", "4", "?"),
        ("run", "5", "+"),
        ("partly", "6", "?"),
        ("missed", "7", "!"),
        ("", "8", " "),
        ("partly", "9", "?"),
    ]
    assert "IF level &gt; 80 THEN  <em>not taken: no ELSE</em>" in text
    assert not re.search(r"https?:|<script|<link|@import|url\(|src=", text)


@pytest.mark.parametrize(("least", "code"), [("45", 0), ("45.5", 1), ("100", 1)])
def test_too_little_coverage_is_an_exit_code(folder: Path, least: str, code: int) -> None:
    done = iec_test("pump_test.st", "--fail-under", least)
    assert done.exit_code == code
    assert ("coverage is 45.4 %: expected at least" in done.stderr) is (code == 1)


def test_a_test_that_fails_counts_and_keeps_its_exit_code(folder: Path) -> None:
    written(folder, pump_test=TESTS + "TEST 'bad' VAR p : Pump; END_VAR p(level := 10); ASSERT_TRUE(p.run); END_TEST\n")
    done = iec_test("pump_test.st", "--coverage", "--fail-under", "50")
    assert done.exit_code == 1
    assert re.search(r"total +4/6 +3/5 +63\.6", done.stdout)


def test_the_tests_of_a_file_itself_are_not_counted(folder: Path) -> None:
    written(folder, own_test="FUNCTION Own : INT\nOwn := 1;\nEND_FUNCTION\nTEST 'own' ASSERT_EQ(Own(), 1); END_TEST\n")
    assert re.search(r"total +1/1 +- +100\.0", iec_test("own_test.st", "--coverage").stdout)


def test_tests_without_any_code_are_too_little_coverage(folder: Path) -> None:
    written(folder, own_test="TEST 'own' ASSERT_TRUE(TRUE); END_TEST\n")
    assert iec_test("own_test.st", "--coverage").exit_code == 0
    done = iec_test("own_test.st", "--fail-under", "1")
    assert (done.exit_code, done.stderr) == (1, "coverage: no code of a program was needed\n")


def test_json_has_no_table_beside_it(folder: Path) -> None:
    assert "coverage" not in iec_test("pump_test.st", "--coverage", "--json").stdout


def test_lines_without_code_do_not_divide_a_range() -> None:
    assert ranges([3, 5, 9, 12], [1, 3, 5, 7, 9, 12]) == "3-5, 9-12"
    assert ranges([], [1]) == ""
