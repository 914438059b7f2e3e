"""Variables of tests that have a program as their type, as the validation suite of STruC++ declares them."""

from pathlib import Path

import pytest
from st_tests import outcomes, written

from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.testing.case import Outcome, Verdict

ADDER = """\
PROGRAM Adder
VAR_INPUT a, b : INT; END_VAR
VAR sum : INT; cycles : INT := 3; END_VAR
sum := a + b;
cycles := cycles + 1;
END_PROGRAM
"""


def ran(folder: Path, tests: str, dialect: str = "codesys", **files: str) -> list[Outcome]:
    written(folder, adder=ADDER, adder_test=tests, **files)
    return list(outcomes(folder / "adder_test.st", dialect).values())


@pytest.mark.parametrize("dialect", DIALECTS)
def test_such_a_variable_is_the_program_with_all_its_variables(tmp_path: Path, dialect: str) -> None:
    (outcome,) = ran(
        tmp_path,
        "TEST 'sum' VAR uut : Adder; s : INT; END_VAR uut.a := 4; UUT(b := 3); s := uut.sum; "
        "ASSERT_EQ(s, 7); ASSERT_EQ(uut.cycles, 4); uut(); ASSERT_EQ(Adder.cycles, 5); END_TEST",
        dialect,
    )
    assert (outcome.verdict, outcome.asserts) == (Verdict.PASSED, 3)


def test_each_test_begins_with_fresh_variables_and_those_of_setup_are_seen_everywhere(tmp_path: Path) -> None:
    found = ran(
        tmp_path,
        "SETUP VAR uut : Adder; END_VAR uut(a := 1); END_SETUP TEARDOWN ASSERT_EQ(uut.a, 1); END_TEARDOWN "
        "TEST 'first' ASSERT_EQ(uut.cycles, 4); END_TEST TEST 'second' uut(); ASSERT_EQ(uut.cycles, 5); END_TEST",
    )
    assert [(one.verdict, one.asserts) for one in found] == [(Verdict.PASSED, 2)] * 2


def test_two_variables_of_one_program_have_values_of_their_own(tmp_path: Path) -> None:
    (outcome,) = ran(
        tmp_path,
        "TEST 'both' VAR one, two, three : Adder; END_VAR one(a := 1); one(); two(a := 2); three.b := 5; three(); "
        "ASSERT_EQ(one.sum, 1); ASSERT_EQ(one.cycles, 5); ASSERT_EQ(two.sum, 2); ASSERT_EQ(two.cycles, 4); "
        "ASSERT_EQ(three.sum, 5); END_TEST",
    )
    assert (outcome.verdict, outcome.asserts) == (Verdict.PASSED, 5)


def test_a_failure_names_the_line_and_the_value(tmp_path: Path) -> None:
    (outcome,) = ran(tmp_path, "TEST 'sum'\nVAR uut : Adder; END_VAR\nuut(a := 2);\nASSERT_EQ(uut.sum, 3);\nEND_TEST")
    (failure,) = outcome.failures
    assert (outcome.verdict, failure.actual, failure.expected, failure.line) == (Verdict.FAILED, "2", "3", 4)


@pytest.mark.parametrize("declared", ["uut : Adder := (a := 1);", "uut : ARRAY[1..2] OF Adder;"])
def test_more_than_the_name_of_a_program_is_a_mistake(tmp_path: Path, declared: str) -> None:
    (outcome,) = ran(tmp_path, f"TEST 'sum' VAR {declared} END_VAR ASSERT_TRUE(TRUE); END_TEST")
    (failure, *_) = outcome.failures
    assert (outcome.verdict, failure.actual) == (Verdict.ERROR, "Adder is a PROGRAM, not a type")
