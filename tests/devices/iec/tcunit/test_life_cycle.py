"""The life cycle of suites and tests: what runs when, what counts, and what is reported once."""

import pytest
from tcunit_bench import SuiteBench, suite

from fieldrig.clock import MS, S
from fieldrig_devices.iec.tcunit.program import NothingToRunError


def verdicts(bench: SuiteBench) -> dict[str, str]:
    """Return the status of each test by its name."""
    lines = bench.summary()
    names = [line.removeprefix("| Test name=") for line in lines if line.startswith("| Test name=")]
    states = [line[len("| Test status=") :][:4] for line in lines if line.startswith("| Test status=")]
    return dict(zip(names, states, strict=True))


def test_a_test_without_asserts_passes_and_one_with_a_failed_assert_goes_on() -> None:
    bench = SuiteBench.ran(
        suite(
            "TEST('empty'); TEST_FINISHED();\n"
            "TEST('t'); AssertTrue(FALSE, 'a'); AssertFalse(TRUE, 'b'); TEST_FINISHED();"
        )
    )
    assert verdicts(bench) == {"empty": "PASS", "t": "FAIL"}
    assert [failure.message for failure in bench.test("t").failures] == ["a", "b"]


def test_a_failure_has_the_file_and_the_line_of_its_assert() -> None:
    text = suite(
        "TEST('t');\nCheck(1);\nTEST_FINISHED();",
        methods="METHOD Check VAR_INPUT a : INT; END_VAR\n\nAssertEquals_INT(2, a, 'one');\nEND_METHOD",
    )
    failure = SuiteBench.ran(text).test("t").failures[0]
    assert (failure.file, text.splitlines()[failure.source_line - 1]) == ("part1.st", "AssertEquals_INT(2, a, 'one');")


def test_an_assert_that_fails_in_each_cycle_is_printed_once() -> None:
    body = "n := n + 1;\nTEST('t'); AssertTrue(FALSE, 'again');\nIF n = 50 THEN TEST_FINISHED(); END_IF"
    bench = SuiteBench.ran(suite(body, "n : INT;"))
    assert bench.clock.now_ns() == 500 * MS
    assert len(bench.lines) == 1
    assert bench.test("t").asserts == 1


def test_equal_asserts_in_one_cycle_are_printed_each_and_further_ones_of_a_later_cycle_too() -> None:
    body = """
    n := n + 1;
    TEST('t');
    FOR k := 1 TO 3 DO AssertTrue(FALSE, 'same'); END_FOR
    IF n >= 3 THEN FOR k := 1 TO 2 DO AssertTrue(FALSE, 'same'); END_FOR END_IF
    IF n = 5 THEN TEST_FINISHED(); END_IF
    """
    assert len(SuiteBench.ran(suite(body, "n, k : INT;")).lines) == 5


def test_arrays_are_the_same_assert_by_their_sizes() -> None:
    body = """
    n := n + 1;
    a[1] := n;
    TEST('t'); AssertArrayEquals_INT(a, b, 'same'); AssertEquals_INT(n, 0, 'other');
    IF n = 4 THEN TEST_FINISHED(); END_IF
    """
    lines = SuiteBench.ran(suite(body, "n : INT; a, b : ARRAY[1..2] OF INT;")).lines
    assert sum("ARRAY[1]" in line for line in lines) == 1
    assert sum("other" in line for line in lines) == 4


def test_asserts_outside_of_a_test_are_ignored() -> None:
    body = "AssertTrue(FALSE, 'before'); TEST('t'); TEST_FINISHED(); AssertTrue(FALSE, 'behind');"
    bench = SuiteBench.ran(suite(body))
    assert bench.lines == []
    assert bench.test("t").asserts == 0


def test_asserts_of_a_finished_test_do_nothing_while_others_go_on() -> None:
    body = """
    n := n + 1;
    TEST('short'); AssertEquals_INT(1, n, 'short'); TEST_FINISHED();
    TEST('long'); IF n = 3 THEN TEST_FINISHED(); END_IF
    """
    assert SuiteBench.ran(suite(body, "n : INT;")).lines == []


def test_a_disabled_test_is_skipped_and_counts_as_successful() -> None:
    body = """
    TEST('DISABLED_t'); AssertTrue(FALSE, 'never');
    TEST_FINISHED();
    TEST('u'); AssertFalse(IS_TEST_FINISHED('DISABLED_t'), 'skipped'); TEST_FINISHED();
    AssertTrue(IS_TEST_FINISHED('u'), 'ignored');
    """
    bench = SuiteBench.ran(suite(body))
    assert bench.lines == []
    assert verdicts(bench) == {"t": "SKIP", "u": "PASS"}
    assert bench.summary()[-4:-2] == ["| Successful tests: 2", "| Failed tests: 0"]


def test_a_name_twice_in_a_cycle_is_reported_once() -> None:
    body = """
    n := n + 1;
    TEST(' t '); AssertTrue(TRUE, 'one'); TEST_FINISHED();
    TEST('t'); AssertTrue(FALSE, 'two'); TEST_FINISHED();
    TEST('T'); IF n = 3 THEN TEST_FINISHED(); END_IF
    """
    bench = SuiteBench.ran(suite(body, "n : INT;"))
    assert bench.lines == ["Test with name 't' already exists in test suite 'PRG_TEST.s'"]
    assert verdicts(bench) == {"t": "PASS", "T": "PASS"}


def test_ordered_tests_take_turns_and_the_next_begins_in_the_cycle_after_the_end() -> None:
    body = """
    n := n + 1;
    IF TEST_ORDERED('first') THEN ones := ones + 1; IF ones = 2 THEN TEST_FINISHED(); END_IF END_IF
    IF TEST_ORDERED('second') THEN began := n; AssertEquals_INT(3, n, 'turn'); TEST_FINISHED(); END_IF
    """
    bench = SuiteBench.ran(suite(body, "n, ones, began : INT;"))
    assert bench.lines == []
    assert bench.runtime.read(bench.runtime.find("PRG_TEST.s.began")) == 3


def test_a_test_can_be_ended_by_its_name() -> None:
    body = (
        "n := n + 1; TEST('a'); TEST('b'); IF n = 2 THEN TEST_FINISHED_NAMED('a'); TEST_FINISHED_NAMED(' b '); END_IF"
    )
    bench = SuiteBench.ran(suite(body, "n : INT;"))
    assert verdicts(bench) == {"a": "PASS", "b": "PASS"}


def test_an_unknown_name_aborts_the_run_without_a_summary() -> None:
    bench = SuiteBench.ran(suite("TEST('a'); TEST_FINISHED_NAMED('b');"))
    assert bench.lines == ["Failed to find test 'b'"]
    assert bench.summary() == []


PAIR = """
FUNCTION_BLOCK One EXTENDS FB_TestSuite
VAR n : INT; END_VAR
n := n + 1; TEST('one'); IF n = 2 THEN TEST_FINISHED(); END_IF
END_FUNCTION_BLOCK
FUNCTION_BLOCK Two EXTENDS FB_TestSuite
TEST('two'); TEST_FINISHED();
END_FUNCTION_BLOCK
PROGRAM PRG_TEST VAR a : One; b : ARRAY[1..2] OF Two; END_VAR {run}; END_PROGRAM
"""


def test_suites_register_in_the_order_of_their_declaration_wherever_they_are() -> None:
    text = PAIR.replace("{run}", "TcUnit.RUN()") + "VAR_GLOBAL g : Two; END_VAR"
    bench = SuiteBench.ran(text)
    assert [suite.path for suite in bench.suites] == ["g", "PRG_TEST.a", "PRG_TEST.b[1]", "PRG_TEST.b[2]"]
    assert bench.clock.now_ns() == 20 * MS


def test_in_a_sequence_the_next_suite_starts_three_cycles_after_its_predecessor() -> None:
    bench = SuiteBench.ran(PAIR.replace("{run}", "TcUnit.RUN_IN_SEQUENCE()"))
    assert [suite.started_ns for suite in bench.suites] == [0, 40 * MS, 70 * MS]


def test_a_pause_between_suites_is_a_parameter() -> None:
    text = PAIR.replace("{run}", "TcUnit.RUN_IN_SEQUENCE()")
    bench = SuiteBench.ran(text, parameters={"timebetweentestsuitesexecution": "T#1S"})
    assert [suite.started_ns for suite in bench.suites] == [0, 1 * S + 10 * MS, 2 * S + 10 * MS]


def test_too_many_asserts_are_said_once_and_not_counted() -> None:
    body = "TEST('t'); FOR n := 1 TO 5 DO AssertEquals_INT(n, n, 'm'); END_FOR TEST_FINISHED();"
    bench = SuiteBench.ran(suite(body, "n : INT;"), parameters={"maxnumberofassertsforeachtestsuite": "3"})
    limit = "Max number of assertions exceeded. Check parameter MaxNumberOfAssertsForEachTestSuite."
    assert bench.lines == [f"PRG_TEST.s. {limit}"]
    assert bench.test("t").asserts == 3


def test_a_test_beyond_the_maximum_fails() -> None:
    body = "TEST('a'); TEST_FINISHED(); TEST('b'); TEST_FINISHED();"
    bench = SuiteBench.ran(suite(body), parameters={"maxnumberoftestsforeachtestsuite": "1"})
    assert verdicts(bench) == {"a": "PASS", "b": "FAIL"}


def test_the_summary_has_suites_tests_and_totals() -> None:
    body = "TEST('t'); AssertEquals_BYTE(171, 205, ''); AssertEquals_BYTE(171, 205, 'm'); TEST_FINISHED();"
    assert SuiteBench.ran(suite(body)).summary() == [
        "| Test suite ID=0 'PRG_TEST.s'",
        "| ID=0 number of tests=1, number of failed tests=1, duration=0.0",
        "| Test name=t",
        "| Test class name=PRG_TEST.s",
        "| Test status=FAIL, number of asserts=2, duration=0.0",
        "| Test assert message=m",
        "| Test assert type=BYTE",
        "| ==========TESTS FINISHED RUNNING==========",
        "| Test suites: 1",
        "| Tests: 1",
        "| Successful tests: 0",
        "| Failed tests: 1",
        "| Duration: 0.0",
        "| ======================================",
    ]


def test_without_extended_results_only_the_totals_are_there() -> None:
    bench = SuiteBench.ran(suite("TEST('t'); TEST_FINISHED();"), parameters={"logextendedresults": "FALSE"})
    assert bench.summary()[0] == "| ==========TESTS FINISHED RUNNING=========="


def test_a_fault_ends_its_suite_and_the_others_go_on() -> None:
    text = PAIR.replace("{run}", "TcUnit.RUN()").replace("n := n + 1;", "TEST('one'); n := 1 / n;")
    bench = SuiteBench.ran(text)
    assert bench.test("one").fault.startswith("a division by zero in One")
    assert [bench.test(name).has_failed for name in ("one", "two")] == [True, False]


def test_a_cycle_without_an_end_is_ended() -> None:
    text = suite("TEST('t'); WHILE TRUE DO n := n + 1; END_WHILE", "n : UDINT;")
    bench = SuiteBench(text)
    bench.cycle(limit_s=0.0)
    assert "the cycle does not end" in bench.test("t").fault


def test_a_cycle_without_an_end_beside_the_suites_is_ended() -> None:
    text = suite("TEST('t'); TEST_FINISHED();").replace("TcUnit.RUN();", "TcUnit.RUN(); WHILE TRUE DO ; END_WHILE")
    bench = SuiteBench(text)
    bench.run(limit_s=0.0)
    assert verdicts(bench) == {"t": "PASS"}
    assert "the cycle does not end in PRG_TEST" in bench.faults[0]


def test_a_suite_that_takes_too_long_ends_and_the_others_go_on() -> None:
    # It waits for what never comes, as for a machine that is not there.
    text = PAIR.replace("{run}", "TcUnit.RUN()").replace("n := n + 1;", "TEST('one');")
    bench = SuiteBench(text)
    bench.run(limit_s=0.0)
    assert bench.test("one").fault == "its tests take a processor for more than 0 s each"
    assert bench.session.is_over
    assert bench.clock.now_ns() < 1 * S


def test_a_suite_that_never_finishes_is_left_after_its_time() -> None:
    bench = SuiteBench.ran(suite("TEST('t');"), longest_ns=100 * MS)
    assert not bench.session.is_over
    assert bench.clock.now_ns() == 100 * MS


def test_a_program_is_made_for_suites_that_nothing_runs() -> None:
    text = suite("TEST('t'); TEST_FINISHED();").partition("PROGRAM")[0]
    assert verdicts(SuiteBench.ran(text)) == {"t": "PASS"}


def test_a_line_of_the_program_is_in_the_report() -> None:
    body = "TEST('t'); TCUNIT_ADSLOGSTR(ADSLOG_MSGTYPE_HINT, 'a %s', 'word'); TEST_FINISHED();"
    assert SuiteBench.ran(suite(body)).lines == ["a word"]


@pytest.mark.parametrize(
    ("kind", "value"), [("INT", "5"), ("STRING", "'x'"), ("LREAL", "2.5"), ("DATE", "D#2020-01-02")]
)
def test_protected_variables_can_be_written(kind: str, value: str) -> None:
    body = f"TEST('t'); WRITE_PROTECTED_{kind}(ADR(v), {value}); AssertEquals(w, v, 'same'); TEST_FINISHED();"
    assert SuiteBench.ran(suite(body, f"v : {kind}; w : {kind} := {value};")).lines == []


def test_a_text_without_suites_has_nothing_to_run() -> None:
    with pytest.raises(NothingToRunError):
        SuiteBench("PROGRAM PLC_PRG END_PROGRAM")


def test_a_test_goes_on_in_the_next_cycle_without_being_named_again() -> None:
    """TcUnit keeps the name of the current test until TEST names another one."""
    body = """step := step + 1;
IF step = 1 THEN TEST('slow'); END_IF;
IF step = 3 THEN AssertTrue(FALSE, 'late'); TEST_FINISHED(); END_IF;"""
    bench = SuiteBench.ran(suite(body, "step : INT;"))
    assert bench.test("slow").is_finished
    assert [failed.message for failed in bench.test("slow").failures] == ["late"]


def test_after_the_end_of_a_test_asserts_belong_to_no_test_until_the_next_one_is_named() -> None:
    body = """step := step + 1;
IF step = 1 THEN TEST('first'); TEST_FINISHED(); TEST('second'); END_IF;
IF step = 2 THEN TEST_FINISHED(); AssertTrue(FALSE, 'none'); END_IF;"""
    bench = SuiteBench.ran(suite(body, "step : INT;"))
    assert not bench.test("first").failures
    assert not bench.test("second").failures
    assert bench.test("second").is_finished


def test_a_suite_is_told_where_a_variable_is_in_memory() -> None:
    areas = """
FUNCTION AreaOfLocal : DINT
VAR local : INT; END_VAR
AreaOfLocal := F_CheckMemoryArea(ADR(local), 2);
END_FUNCTION
"""
    body = """
p := __NEW(INT, 3);
AssertTrue(F_CheckMemoryArea(p, 6) = E_TcMemoryArea.Dynamic, 'of __NEW');
AssertTrue(F_CheckMemoryArea(ADR(p[1]), 2) = E_TcMemoryArea.Dynamic, 'within it');
AssertTrue(F_CheckMemoryArea(p, 7) = E_TcMemoryArea.Unknown, 'beyond it');
AssertTrue(F_CheckMemoryArea(ADR(i), 2) = E_TcMemoryArea.Static, 'of the program');
AssertTrue(AreaOfLocal() = 0, 'on the stack');
AssertTrue(F_CheckMemoryArea(0, 1) = E_TcMemoryArea.Unknown, 'nowhere');
q := p;
__DELETE(p);
AssertTrue(F_CheckMemoryArea(q, 6) = E_TcMemoryArea.Unknown, 'given back');
"""
    declarations = "p, q : POINTER TO INT; i : INT;"
    bench = SuiteBench(suite(f"TEST('t');{body}TEST_FINISHED();", declarations), areas)
    bench.run()
    assert (bench.test("t").is_finished, bench.lines, bench.faults) == (True, [], [])


def test_arrays_that_are_constants_are_compared() -> None:
    body = "TEST('t'); AssertArrayEquals_INT(wanted, found, 'differ'); TEST_FINISHED();"
    bench = SuiteBench.ran(
        suite(body, "found : ARRAY[1..2] OF INT := [3, 4]; END_VAR VAR CONSTANT wanted : ARRAY[1..2] OF INT := [3, 5];")
    )
    assert [line.partition(", EXP: ")[2] for line in bench.lines] == ["ARRAY[2] = 5, ACT: ARRAY[2] = 4, MSG: differ"]
