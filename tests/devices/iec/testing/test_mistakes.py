"""Test files with mistakes: all are listed, each with its line, and none ends in a traceback."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from st_tests import LAMP_RIG, MOTOR, as_json, iec_test, one, written
from typer.testing import CliRunner, Result

from fieldrig.system.exits import Exit
from fieldrig_devices.iec.commands import app
from fieldrig_devices.iec.dialect import EDITION_3
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.printer import print_unit
from fieldrig_devices.iec.testing.case import Verdict

MISTAKES = [
    ("TEST 'a' ASSERT_EQ(1); END_TEST", 1, "ASSERT_EQ without expected"),
    ("TEST 'a' ASSERT_EQ(1, 2, 'm', 4); END_TEST", 1, "one argument too many for ASSERT_EQ"),
    ("TEST 'a' ASSERT_EQ(got := 1, expected := 2); END_TEST", 1, "ASSERT_EQ has no argument got"),
    ("TEST 'a' ASSERT_EQUALS(1, 2); END_TEST", 1, "the closest known name is ASSERT_EQUAL"),
    ("TEST 'a' ASSERT_TRUE(5); END_TEST", 1, "5 is"),
    ("TEST 'it''s a' END_TEST", 1, "A quote within a text is $'."),
    ("TEST 'a' ASSERT_TRUE a.b; END_TEST", 1, "Write ASSERT_TRUE(a...);"),
    ("TEST 'a' ASSERT_EQ(TRUE, 'x'); END_TEST", 1, "="),
    ("TEST 'a'\nASSERT_EQ(nowhere, 1);\nEND_TEST", 2, "nowhere is not declared"),
    ("TEST 'a' ADVANCE_TIME('now'); END_TEST", 1, "the time 'now' is"),
    ("TEST 'a' MOCK Nothing; END_TEST", 1, "Nothing is not declared"),
    ("TEST 'a' VAR n : INT; END_VAR MOCK n; END_TEST", 1, "n cannot be mocked"),
    ("TEST 'a' MOCK Motor; END_TEST", 1, "Motor is a type"),
    ("TEST 'a' MOCK_FUNCTION LIMIT RETURNS 5; END_TEST", 1, "LIMIT is a standard function, which cannot be mocked"),
    ("TEST 'a' MOCK_FUNCTION Step RETURNS 'x'; END_TEST", 1, "'x' is"),
    ("TEST 'a' VAR m : Motor; END_VAR ASSERT_EQ(m, m); END_TEST", 1, "m is an instance of Motor"),
    ("TEST 'a' VAR x, y : ARRAY[1..2] OF INT; END_VAR ASSERT_GT(x, y); END_TEST", 1, "x is an ARRAY"),
    ("TEST 'a'\nASSERT_TRUE(TRUE);", 2, "got the end of the text"),
    ("TEST 'a' END_TEST\n\nTEST 'a' END_TEST", 3, "the test 'a' exists already in line 1"),
    ("SETUP END_SETUP\nSETUP END_SETUP TEST 'a' END_TEST", 2, "a second SETUP"),
    ("TEST ' ' END_TEST TEST 'a' END_TEST", 1, "a test without a name"),
    ("USES 'gone.st';\nTEST 'a' END_TEST", 1, "there is no 'gone.st' beside this file"),
    ("TEST 'a' VAR x AT 'tank/level' : REAL; END_VAR END_TEST", 1, "x is at a place of a rig"),
    ("TEST 'a' RIG 'gone.yaml' END_TEST", 1, "there is no gone.yaml"),
    ("TEST 'a' IF TRUE THEN END_TEST", 1, "END_IF"),
    ("TEST 'a' END_SETUP END_TEST", 1, "END_SETUP"),
    ("TEST 'a' VAR n : INT; END_VAR\nSETUP n := 1; END_SETUP\nn := 2; END_TEST", 2, "SETUP beside the TEST blocks"),
    ("TEST 'a'\nTEARDOWN END_TEARDOWN\nEND_TEST TEST 'b' END_TEST", 2, "TEARDOWN within a TEST"),
]


def test_a_setup_within_a_test_is_one_mistake(tmp_path: Path) -> None:
    text = "TEST 'a' VAR n : INT; END_VAR\nSETUP n := 1; END_SETUP\nASSERT_EQ(n, 1); END_TEST\nTEST 'b' END_TEST"
    written(tmp_path, motor=MOTOR, motor_test=text)
    assert iec_test(tmp_path).output.count("motor_test.st:") == 1


@pytest.mark.parametrize(("text", "line", "what"), MISTAKES)
def test_a_mistake_is_named_with_its_line(tmp_path: Path, text: str, line: int, what: str) -> None:
    written(tmp_path, motor=MOTOR, motor_test=text)
    done = iec_test(tmp_path)
    assert done.exit_code == 2, done.output
    assert f"motor_test.st:{line}: " in done.output
    assert what in done.output


def test_all_mistakes_of_a_file_are_listed_once(tmp_path: Path) -> None:
    text = "TEST 'a'\nASSERT_EQ(x, 1);\nASSERT_EQ(1);\nEND_TEST\nTEST 'b'\nASSERT_TRUE(y);\nEND_TEST"
    written(tmp_path, bad_test=text, good_test="TEST 'c' ASSERT_TRUE(TRUE); END_TEST")
    lines = iec_test(tmp_path).stdout.splitlines()
    assert [line.split(":")[1] for line in lines if line.startswith(f"{tmp_path}/bad_test.st:")] == ["2", "3", "6"]
    assert "  ok      c" in lines


def test_a_folder_without_tests_is_said_to_have_none(tmp_path: Path) -> None:
    done = iec_test(written(tmp_path, motor=MOTOR))
    assert (done.exit_code, type(done.exception).__name__) == (1, "UsageError")


NAMES = """PROGRAM PLC_PRG
VAR test, setup, teardown, rig, uses, skip, mock, returns, after, end_test, run_for, assert_true : INT; END_VAR
test := setup + teardown; rig := uses + skip; mock := returns + after; end_test := run_for + assert_true;
END_PROGRAM"""


@pytest.mark.parametrize("dialect", ["epas-4", "edition-3", "codesys"])
def test_the_words_of_tests_are_names_in_programs(tmp_path: Path, dialect: str) -> None:
    body = "TEST 'it' PLC_PRG.test := 5; ASSERT_EQ(PLC_PRG.test, 5); END_TEST"
    written(tmp_path, prg=NAMES, prg_test=body)
    done = iec_test(tmp_path, dialect=dialect)
    assert done.exit_code == 0, done.output


def test_a_function_of_the_program_hides_a_word_of_tests(tmp_path: Path) -> None:
    own = "FUNCTION ASSERT_TRUE : BOOL VAR_INPUT x : INT; END_VAR ASSERT_TRUE := x = 5; END_FUNCTION"
    written(tmp_path, own=own, own_test="TEST 'it' VAR b : BOOL; END_VAR b := ASSERT_TRUE(5); ASSERT(b); END_TEST")
    assert [one["verdict"] for one in as_json(tmp_path)] == ["passed"]


PARTS = [
    "TEST 'a'", "TEST", "END_TEST", "SETUP", "END_SETUP", "TEARDOWN", "END_TEARDOWN", "VAR", "END_VAR", "x : INT;",
    "ASSERT_EQ(x, 1);", "MOCK x;", "MOCK", "MOCK_FUNCTION F RETURNS", "RIG 'r'", "AFTER T#1s", "SKIP 's';", "USES 'u'",
    "IF x THEN", "END_IF", "AT 'p/q'", ";", "PROGRAM p", "END_PROGRAM", "'", "(*",
]  # fmt: skip


def test_no_comment_is_lost_when_a_test_file_is_formatted() -> None:
    text = """(* 1 *) USES 'a.st'; (* 2 *)
(* 3 *)
RIG (* 4 *) 'b.yaml' (* 5 *) AFTER (* 6 *) T#1s (* 7 *); (* 8 *)
(* 9 *)
SETUP (* 10 *) VAR (* 11 *) x : INT; (* 12 *) END_VAR (* 13 *) x := 1; (* 14 *) END_SETUP (* 15 *)
(* 16 *)
TEST (* 17 *) 'a' (* 18 *)
(* 19 *)
RIG 'c.yaml' (* 20 *)
SKIP (* 21 *) 'why'; (* 22 *)
(* 23 *)
ASSERT_TRUE((* 24 *) TRUE); (* 25 *)
(* 26 *)
END_TEST (* 27 *)
TEST 'b' (* 28 *) END_TEST
(* 29 *)
"""
    unit, mistakes = parse(text, "any.st", EDITION_3)
    assert mistakes == []
    printed = print_unit(unit)
    assert [number for number in range(1, 30) if f"(* {number} *)" not in printed] == []
    assert print_unit(parse(printed, "any.st", EDITION_3)[0]) == printed


@settings(max_examples=300, deadline=None)
@given(st.lists(st.sampled_from(PARTS), max_size=12))
def test_any_text_of_tests_is_parsed_without_an_exception(parts: list[str]) -> None:
    unit, mistakes = parse("\n".join(parts), "any.st", EDITION_3)
    if not mistakes:
        printed = print_unit(unit)
        again, wrong = parse(printed, "any.st", EDITION_3)
        assert (again, wrong, print_unit(again)) == (unit, [], printed)


STATEMENTS = [
    "ASSERT_EQ(x, 1);",
    "ASSERT_EQ(a, a);",
    "ASSERT_EQ(m, m);",
    "ASSERT_EQ(m.run, x);",
    "ASSERT_NEAR(x, 1, 2, 3);",
    "ASSERT_NEAR(r, 1.0);",
    "ASSERT_TRUE(m);",
    "ASSERT_TRUE(Motor);",
    "ASSERT_EQ(Step, 1);",
    "ASSERT_EQ(Step(1), Step(2));",
    "ASSERT_EQ(s, s, s);",
    "ASSERT_EQ(s, 5, x);",
    "ASSERT_WITHIN(x = 1, T#5ms);",
    "ASSERT_UNTIL(TRUE, FALSE, t);",
    "ASSERT_NEVER(m.run, 5);",
    "ADVANCE_TIME(t);",
    "ADVANCE_TIME(r);",
    "RUN_FOR(x);",
    "MOCK m;",
    "MOCK x;",
    "MOCK m.longest;",
    "MOCK Step;",
    "MOCK nowhere.at;",
    "MOCK_FUNCTION Step RETURNS x;",
    "MOCK_FUNCTION m RETURNS 1;",
    "MOCK_FUNCTION Step;",
    "MOCK_VERIFY_CALLED(m);",
    "MOCK_VERIFY_CALL_COUNT(Step, r);",
    "x := MOCK_CALLS(m);",
    "x := MOCK_CALLS(5);",
    "x := ASSERT_EQ(1, 1);",
    "PRINT(x);",
    "PRINT(s);",
    "PRINT();",
    "FAULT('a', 'b');",
    "CLEAR_FAULTS(x);",
    "m(start := TRUE);",
    "m.longest.Q := TRUE;",
    "m.run := x;",
    "x := 1 / x;",
    "WHILE TRUE DO x := x + 1; END_WHILE",
    "a[x] := 9;",
    "RETURN;",
    "EXIT;",
    "IF m.run THEN ASSERT_FAIL(); END_IF",
    "%IX0.0 := TRUE;",
    "JMP y;",
    "y:",
]


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(st.lists(st.sampled_from(STATEMENTS), max_size=6), st.sampled_from(["epas-4", "edition-3", "codesys"]))
def test_any_test_has_an_outcome(statements: list[str], dialect: str) -> None:
    body = "VAR x : INT; r : REAL; a : ARRAY[0..1] OF INT; m : Motor; s : STRING; t : TIME := T#1ms; END_VAR\n"
    with TemporaryDirectory() as folder:
        outcome = one(Path(folder), body + "\n".join(statements), dialect=dialect, timeout_s=0.05)
    assert outcome.verdict in Verdict
    assert all(failure.kind for failure in outcome.failures)


LAMP = "PROGRAM PLC_PRG\nVAR lamp AT %QX0.0 : BOOL; END_VAR\nlamp := TRUE;\nEND_PROGRAM\n"


def checked(path: Path, *options: str) -> Result:
    return CliRunner().invoke(app, ["check", str(path), "--dialect", "edition-3", *options])


@pytest.mark.parametrize(
    ("text", "line", "what"),
    [
        ("TEST 'a' VAR b : Nothing; END_VAR ; END_TEST", 1, "the type Nothing is not declared"),
        ("TEST 'a'\nASSERT_EQ(1 = 1, 3);\nEND_TEST", 2, "= between BOOL and the number 3"),
        ("TEST 'a'\nASERT_TRUE(TRUE);\nEND_TEST", 2, "ASERT_TRUE is not declared"),
        ("TEST 'a' RIG 'nothing.yaml' ; END_TEST", 1, "there is no nothing.yaml"),
        ("TEST 'a' RIG 'lamp.yaml'\nVAR b AT 'lmp/x' : BOOL; END_VAR ; END_TEST", 2, "lamp.yaml has no 'lmp'"),
        ("TEST 'a' RIG 'lamp.yaml' AFTER 3 ; END_TEST", 1, "the time behind AFTER in line 1 is no time"),
        ("RIG 'lamp.yaml'\nSETUP\nVAR b AT 'plcs/x' : BOOL; END_VAR END_SETUP TEST 'a' ; END_TEST", 3, "has no 'plcs'"),
    ],
)
def test_the_check_of_a_program_looks_into_its_tests(tmp_path: Path, text: str, line: int, what: str) -> None:
    (tmp_path / "lamp.yaml").write_text(LAMP_RIG)
    written(tmp_path, lamp=LAMP, code_test=text)
    done = checked(tmp_path / "code_test.st", "--json")
    assert done.exit_code == Exit.WRONG
    mistake = next(one for one in json.loads(done.stdout) if what in one["what"])
    assert (Path(mistake["file"]).name, mistake["line"]) == ("code_test.st", line)


def test_right_tests_have_no_mistakes(tmp_path: Path) -> None:
    (tmp_path / "lamp.yaml").write_text(LAMP_RIG)
    test = "TEST 'a' RIG 'lamp.yaml' VAR b AT 'terminal/plc/state' : STRING; END_VAR ASSERT_TRUE(TRUE); END_TEST"
    written(tmp_path, lamp=LAMP, code_test=test)
    done = checked(tmp_path)
    assert done.exit_code == 0, done.output
    assert "Code Size: " in done.stdout
