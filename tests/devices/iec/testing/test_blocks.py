"""TEST blocks: what passes and fails, with which values, at which instant and line."""

from pathlib import Path

import pytest
from st_tests import MOTOR, as_json, iec_test, one, outcomes, written

from fieldrig import MS, S
from fieldrig_devices.iec.testing.case import Verdict


def said(folder: Path, body: str, others: str = "") -> tuple[str, str, str]:
    """Return expectation, value and message of the assertion that fails."""
    outcome = one(folder, body, others)
    assert outcome.verdict is Verdict.FAILED, outcome
    (failure,) = outcome.failures
    return failure.expected, failure.actual, failure.message


RIGHT = [
    "ASSERT_TRUE(TRUE);",
    "ASSERT(1 < 2);",
    "ASSERT_FALSE(1 > 2, 'never');",
    "ASSERT_EQ(INT#2 + INT#2, 4);",
    "ASSERT_EQ(actual := 4, expected := 4, message := 'named');",
    "ASSERT_EQUAL(expected := 4, actual := 4);",
    "ASSERT_NEQ('a', 'b');",
    "ASSERT_NOT_EQUAL(1, 2);",
    "ASSERT_GT(2, 1); ASSERT_LT(1, 2); ASSERT_GE(2, 2); ASSERT_LE(2, 2);",
    "ASSERT_GREATER(2, 1); ASSERT_LESS(1, 2); ASSERT_GREATER_OR_EQUAL(2, 2); ASSERT_LESS_OR_EQUAL(2, 2);",
    "ASSERT_NEAR(1.0, 1.05, 0.1); ASSERT_NEAR(actual := 1.0, expected := 1.05, delta := 0.1);",
    "ASSERT_NEAR(100, 98, 2);",
    "ASSERT_EQ(T#1s, T#1000ms); ASSERT_GT(D#2026-11-29, D#2026-11-28);",
    "VAR a, b : ARRAY[1..3] OF INT := [1, 2, 3]; END_VAR ASSERT_EQ(a, b);",
    "VAR x : INT; y : DINT; END_VAR x := 5; y := 5; ASSERT_EQ(x, y);",
]


@pytest.mark.parametrize("body", RIGHT)
def test_what_holds_passes(tmp_path: Path, body: str) -> None:
    outcome = one(tmp_path, body)
    assert (outcome.verdict, outcome.failures) == (Verdict.PASSED, ())
    assert outcome.asserts == body.count("ASSERT")


WRONG = [
    ("ASSERT_TRUE(FALSE);", "TRUE", "FALSE", ""),
    ("ASSERT_FALSE(TRUE, 'lamp');", "FALSE", "TRUE", "lamp"),
    ("ASSERT_EQ(INT#3, 4, 'sum');", "4", "3", "sum"),
    ("ASSERT_EQUAL(4, INT#3);", "4", "3", ""),
    ("ASSERT_NEQ(3, 3);", "not 3", "3", ""),
    ("ASSERT_GT(1, 2);", "more than 2", "1", ""),
    ("ASSERT_LE(3, 2);", "at most 2", "3", ""),
    ("ASSERT_NEAR(1.0, 1.5, 0.25);", "1.5 +- 0.25", "1.0", ""),
    ("ASSERT_EQ(T#1s, T#1s1ms);", "T#1s1ms", "T#1s", ""),
    ("ASSERT_EQ(BYTE#16#0F, 16#1F);", "16#1F", "16#0F", ""),
    ("ASSERT_EQ('it$'s', 'its');", "'its'", "'it$'s'", ""),
    ("ASSERT_FAIL('not here');", "", "", "not here"),
    ("VAR s : STRING; END_VAR s := 'computed'; ASSERT_TRUE(FALSE, s);", "TRUE", "FALSE", "computed"),
    (
        "VAR a, b : ARRAY[1..3] OF INT := [1, 2, 3]; END_VAR b[2] := 9; ASSERT_EQ(a, b);",
        "[2] = 9",
        "[2] = 2",
        "",
    ),
    ("VAR a, b : ARRAY[0..1, 1..2] OF INT; END_VAR b[1, 2] := 9; ASSERT_EQ(a, b);", "[1, 2] = 9", "[1, 2] = 0", ""),
]


@pytest.mark.parametrize(("body", "expected", "actual", "message"), WRONG)
def test_what_does_not_hold_fails_with_both_values(
    tmp_path: Path, body: str, expected: str, actual: str, message: str
) -> None:
    assert said(tmp_path, body) == (expected, actual, message)


def test_a_structure_shows_its_first_difference(tmp_path: Path) -> None:
    pair = "TYPE Colour : (red, green); END_TYPE TYPE Pair : STRUCT a : INT; b : Colour; END_STRUCT; END_TYPE"
    body = "VAR p, q : Pair; END_VAR q.b := green; ASSERT_EQ(p, q, 'pairs');"
    assert said(tmp_path, body, pair) == ("b = green", "b = red", "pairs")


def test_real_values_that_look_alike_are_shown_with_all_digits(tmp_path: Path) -> None:
    assert said(tmp_path, "ASSERT_EQ(LREAL#1.0, LREAL#1.0000000000000002);")[:2] == ("1.0000000000000002", "1.0")


def test_the_first_failure_ends_the_test(tmp_path: Path) -> None:
    outcome = one(tmp_path, "ASSERT_TRUE(TRUE);\nASSERT_TRUE(FALSE, 'one');\nASSERT_TRUE(FALSE, 'two');")
    assert [(failure.line, failure.message) for failure in outcome.failures] == [(4, "one")]
    assert outcome.asserts == 2


def test_time_passes_only_as_the_test_says(tmp_path: Path) -> None:
    body = """VAR m : Motor; END_VAR
m(start := TRUE);
ADVANCE_TIME(T#999ms); m(start := FALSE); ASSERT_TRUE(m.run);
ADVANCE_TIME(1000000); m(); ASSERT_FALSE(m.run, 'a second is over');"""
    outcome = one(tmp_path, body)
    assert (outcome.verdict, outcome.duration_ns) == (Verdict.PASSED, 1 * S)


def test_each_test_begins_with_fresh_variables_at_time_0(tmp_path: Path) -> None:
    shared = "VAR_GLOBAL total : INT := 7; END_VAR"
    twice = (
        "TEST '{}' VAR m : Motor; n : INT := 3; END_VAR ASSERT_EQ(total, 7); ASSERT_EQ(n, 3); ASSERT_EQ(m.calls, 0);"
    )
    twice += " m(start := TRUE); ADVANCE_TIME(T#5s); m(); total := 9; n := 8; END_TEST\n"
    written(tmp_path, motor=MOTOR, motor_test=shared + "\n" + "".join(twice.format(name) for name in "abc"))
    done = outcomes(tmp_path / "motor_test.st")
    assert [one.verdict for one in done.values()] == [Verdict.PASSED] * 3
    assert {one.duration_ns for one in done.values()} == {5 * S}


def test_setup_runs_before_and_teardown_after_each_test(tmp_path: Path) -> None:
    text = """
SETUP VAR m : Motor; END_VAR m(start := TRUE); END_SETUP
TEARDOWN ASSERT_EQ(m.calls, 2, 'teardown'); PRINT('down'); END_TEARDOWN
TEST 'one call more' m(); ASSERT_TRUE(m.run); END_TEST
TEST 'no call' ASSERT_TRUE(m.run); END_TEST
TEST 'fails first' ASSERT_FALSE(m.run, 'test'); END_TEST
"""
    written(tmp_path, motor=MOTOR, motor_test=text)
    done = outcomes(tmp_path / "motor_test.st")
    assert [one.verdict for one in done.values()] == [Verdict.PASSED, Verdict.FAILED, Verdict.FAILED]
    assert [failure.message for failure in done["fails first"].failures] == ["test", "teardown"]
    assert done["one call more"].output == ("down",)


def test_a_skipped_test_says_why(tmp_path: Path) -> None:
    written(tmp_path, motor_test="TEST 'later' SKIP 'no sensor yet'\nASSERT_FAIL('x');\nEND_TEST")
    (outcome,) = outcomes(tmp_path / "motor_test.st").values()
    assert (outcome.verdict, outcome.reason) == (Verdict.SKIPPED, "no sensor yet")


def test_a_helper_of_the_test_file_may_assert(tmp_path: Path) -> None:
    helper = """FUNCTION Check : BOOL
VAR_INPUT wanted : INT; END_VAR
ASSERT_EQ(wanted, 5, 'in the helper');
END_FUNCTION"""
    outcome = one(tmp_path, "Check(5); Check(6);", helper, dialect="codesys")
    assert [(failure.line, failure.actual) for failure in outcome.failures] == [(3, "6")]


OBJECTS = """
VAR_GLOBAL g_first : INT := Twice(4); END_VAR
FUNCTION Twice : INT VAR_INPUT x : INT; END_VAR Twice := 2 * x; END_FUNCTION
FUNCTION Half : INT VAR_INPUT x, y : INT; END_VAR
Half := x / y;
END_FUNCTION
INTERFACE ICount METHOD Inc : INT END_METHOD END_INTERFACE
FUNCTION_BLOCK Base IMPLEMENTS ICount
VAR n : INT; END_VAR
METHOD Inc : INT
n := n + 1; Inc := n;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Counter EXTENDS Base
METHOD FB_init : BOOL
VAR_INPUT bInitRetains, bInCopyCode : BOOL; start : INT; END_VAR
n := start;
END_METHOD
END_FUNCTION_BLOCK
"""


def test_instances_are_started_before_each_test(tmp_path: Path) -> None:
    body = "VAR c : Counter(start := 7); i : ICount; END_VAR ASSERT_EQ(g_first, 8); ASSERT_EQ(c.n, 7); i := c;"
    body += " ASSERT_EQ(i.Inc(), 8); g_first := 0;"
    tests = f"TEST 'a' {body} END_TEST TEST 'b' {body} END_TEST"
    written(tmp_path, counter=OBJECTS, counter_test=tests)
    assert [one.failures for one in outcomes(tmp_path / "counter_test.st", "codesys").values()] == [(), ()]


def test_a_fault_of_a_start_value_is_an_error_of_each_test(tmp_path: Path) -> None:
    written(tmp_path, counter=OBJECTS.replace("Twice(4)", "Half(4, 0)"))
    written(tmp_path, counter_test="TEST 'a' ASSERT_EQ(g_first, 8); END_TEST TEST 'b' END_TEST")
    done = outcomes(tmp_path / "counter_test.st", "codesys")
    assert [one.verdict for one in done.values()] == [Verdict.ERROR] * 2
    assert "a division by zero in Half" in done["a"].failures[0].actual


def test_a_fault_in_a_function_says_who_has_called_it(tmp_path: Path) -> None:
    written(tmp_path, counter=OBJECTS, counter_test="TEST 'a'\nASSERT_EQ(Half(1, 0), 1);\nEND_TEST")
    (failure,) = outcomes(tmp_path / "counter_test.st", "codesys")["a"].failures
    assert (failure.file.name, failure.line) == ("counter.st", 5)
    assert failure.diagram == (f"called from {tmp_path}/counter_test.st:2",)


def test_a_value_of_an_enumeration_is_shown_by_its_name(tmp_path: Path) -> None:
    colours = "TYPE Colour : (red, green); END_TYPE"
    assert said(tmp_path, "VAR c : Colour; END_VAR ASSERT_EQ(c, green);", colours)[:2] == ("green", "red")


@pytest.mark.parametrize(
    ("condition", "shown"),
    [
        ("Step(3) > 20 OR Step(1) = 4", "Step(3) = 3 and Step(1) = 1"),
        ("on AND n > 2", "on = FALSE and n = 3"),
        ("1 < n AND n < 3", "n = 3"),
        ("NOT (on OR n > 2) AND w.0", "on = FALSE and n = 3 and w.0 = TRUE"),
        ("(n > 2 XOR NOT on) AND s = 'a'", "n = 3 and on = FALSE and s = 'b'"),
        ("on = (n > 2)", "on = FALSE and n > 2 = TRUE"),
    ],
)
def test_a_condition_that_fails_has_its_operands(tmp_path: Path, condition: str, shown: str) -> None:
    variables = "VAR on : BOOL; n : INT := 3; w : WORD := 1; s : STRING := 'b'; END_VAR"
    assert said(tmp_path, f"{variables} ASSERT_TRUE({condition});")[1] == f"FALSE, where {shown}"
    assert said(tmp_path, f"{variables} ASSERT_FALSE(NOT ({condition}));")[1] == f"TRUE, where {shown}"


def test_operands_are_those_of_the_assertion_that_fails_and_are_computed_once(tmp_path: Path) -> None:
    body = "VAR n : INT := 3; END_VAR ASSERT_TRUE(n > 1 AND Step(1) = 1);"
    body += "ASSERT_EQ(MOCK_CALLS(Step), 1); ASSERT_TRUE(n > 5);"
    assert said(tmp_path, body)[1] == "FALSE, where n = 3"


def test_what_is_behind_and_then_is_not_computed(tmp_path: Path) -> None:
    body = "VAR on : BOOL; zero : INT; END_VAR ASSERT_TRUE(on AND_THEN 1 / zero = 1);"
    assert said(tmp_path, body)[1] == "FALSE, where on = FALSE"


# ---- mocks


def test_a_mocked_function_returns_what_the_test_says(tmp_path: Path) -> None:
    body = """VAR m : Motor; END_VAR
MOCK_FUNCTION Step RETURNS 40;
m(); m();
ASSERT_EQ(m.calls, 80); ASSERT_EQ(MOCK_CALLS(Step), 2);
MOCK_VERIFY_CALLED(Step); MOCK_VERIFY_CALL_COUNT(Step, 3);"""
    assert said(tmp_path, body)[:2] == ("3 calls", "2")


def test_a_mocked_instance_does_nothing_and_the_test_sets_its_outputs(tmp_path: Path) -> None:
    body = """VAR m, other : Motor; END_VAR
MOCK m.longest;
m(start := TRUE); ADVANCE_TIME(T#5s); m(start := FALSE); ASSERT_TRUE(m.run);
m.longest.Q := TRUE; m(); ASSERT_FALSE(m.run);
MOCK_VERIFY_CALL_COUNT(m.longest, 3);
other(start := TRUE); ADVANCE_TIME(T#2s); other(start := FALSE); ASSERT_FALSE(other.run, 'a real one');"""
    assert one(tmp_path, body).verdict is Verdict.PASSED


def test_mocks_of_one_test_are_gone_in_the_next(tmp_path: Path) -> None:
    text = """
TEST 'first' MOCK_FUNCTION Step RETURNS 9; ASSERT_EQ(Step(1), 9); END_TEST
TEST 'second' ASSERT_EQ(Step(1), 1); ASSERT_EQ(MOCK_CALLS(Step), 1); END_TEST
"""
    written(tmp_path, motor=MOTOR, motor_test=text)
    assert {one.verdict for one in outcomes(tmp_path / "motor_test.st").values()} == {Verdict.PASSED}


# ---- faults and limits


def test_a_fault_of_the_program_is_an_error_at_its_line(tmp_path: Path) -> None:
    outcome = one(tmp_path, "VAR zero : INT; END_VAR\nzero := 1 / zero;")
    assert outcome.verdict is Verdict.ERROR
    assert [(one.kind, one.line, one.actual) for one in outcome.failures] == [("fault", 4, "a division by zero")]


@pytest.mark.parametrize(
    "body",
    [
        "WHILE TRUE DO n := n + 1; END_WHILE",
        "REPEAT n := 0; UNTIL n > 1 END_REPEAT",
        "WHILE TRUE DO ADVANCE_TIME(T#1ms); END_WHILE",
        "ASSERT_WITHIN(n > 1, T#20d);",
        "RUN_FOR(T#20d);",
    ],
)
def test_a_test_without_an_end_is_ended(tmp_path: Path, body: str) -> None:
    outcome = one(tmp_path, f"VAR n : DINT; END_VAR\n{body}", timeout_s=0.02)
    assert outcome.verdict is Verdict.ERROR
    (failure,) = outcome.failures
    assert (failure.kind, failure.line, failure.actual) == ("timeout", 4, "the test took more than 0.02 s")


# ---- over time


TASKS = """
PROGRAM Lamp
VAR clock : TON; on : BOOL; cycles : DINT; END_VAR
clock(IN := NOT clock.Q, PT := T#50ms);
on := clock.Q;
cycles := cycles + 1;
END_PROGRAM
CONFIGURATION c
RESOURCE r ON cpu
TASK t(INTERVAL := T#10ms, PRIORITY := 1);
PROGRAM p WITH t : Lamp;
END_RESOURCE
END_CONFIGURATION
"""


@pytest.mark.parametrize(
    ("body", "at_ms"),
    [
        ("ASSERT_WITHIN(Lamp.on, T#60ms);", None),
        ("ASSERT_WITHIN(Lamp.on, T#40ms);", 40),
        ("ASSERT_NEVER(Lamp.on, T#40ms);", None),
        ("ASSERT_NEVER(Lamp.on, T#500ms);", 50),
        ("ASSERT_STAYS(NOT Lamp.on, T#40ms);", None),
        ("ASSERT_STAYS(NOT Lamp.on, T#1s);", 50),
        ("ASSERT_UNTIL(NOT Lamp.on, Lamp.cycles = 3, T#1s);", None),
        ("ASSERT_UNTIL(NOT Lamp.on, Lamp.cycles = 300, T#1s);", 50),
        ("ASSERT_UNTIL(Lamp.cycles >= 0, Lamp.cycles = 300, T#1s);", 1000),
    ],
)
def test_an_expectation_over_time_is_judged_at_each_cycle(tmp_path: Path, body: str, at_ms: int | None) -> None:
    written(tmp_path, lamp=TASKS, lamp_test=f"TEST 'it' {body} END_TEST")
    outcome = outcomes(tmp_path / "lamp_test.st")["it"]
    assert [failure.at_ns // MS for failure in outcome.failures] == ([] if at_ms is None else [at_ms])


def test_tasks_run_only_while_the_test_says_so(tmp_path: Path) -> None:
    body = "ADVANCE_TIME(T#1s); ASSERT_EQ(Lamp.cycles, 0); RUN_FOR(T#95ms); ASSERT_EQ(Lamp.cycles, 10);"
    written(tmp_path, lamp=TASKS, lamp_test=f"TEST 'a' {body} END_TEST TEST 'b' {body} END_TEST")
    assert [one.failures for one in outcomes(tmp_path / "lamp_test.st").values()] == [(), ()]


# ---- the code of the tests


def test_only_what_the_tests_reach_is_compiled(tmp_path: Path) -> None:
    broken = "FUNCTION_BLOCK Broken\nVAR x : Nowhere; END_VAR\nEND_FUNCTION_BLOCK"
    written(tmp_path, broken=broken, other="PROGRAM PLC_PRG END_PROGRAM", second="PROGRAM PLC_PRG END_PROGRAM")
    assert one(tmp_path, "VAR m : Motor; END_VAR m();").verdict is Verdict.PASSED


def test_the_title_of_a_test_reaches_nothing(tmp_path: Path) -> None:
    broken = "FUNCTION_BLOCK Broken\nVAR x : Nowhere; END_VAR\nEND_FUNCTION_BLOCK"
    written(tmp_path, broken=broken, checks="TEST 'broken' ASSERT_EQ(1, 1); END_TEST")
    assert outcomes(tmp_path / "checks.st")["broken"].verdict is Verdict.PASSED


def test_uses_names_the_code(tmp_path: Path) -> None:
    (tmp_path / "src").mkdir()
    written(tmp_path / "src", motor=MOTOR)
    written(tmp_path, checks="USES 'src/motor.st';\nTEST 'it' VAR m : Motor; END_VAR m(); END_TEST")
    assert outcomes(tmp_path / "checks.st")["it"].verdict is Verdict.PASSED


def test_of_two_files_with_one_name_the_test_takes_the_one_that_it_is_named_after(tmp_path: Path) -> None:
    other = "FUNCTION Step : INT VAR_INPUT size : INT; END_VAR Step := 2; END_FUNCTION"
    written(tmp_path, other=other)
    assert one(tmp_path, "ASSERT_EQ(Step(1), 1);").verdict is Verdict.PASSED


def test_tests_may_stand_in_the_file_of_the_code(tmp_path: Path) -> None:
    written(tmp_path, motor=MOTOR + "TEST 'it' ASSERT_EQ(Step(4), 4); END_TEST")
    assert outcomes(tmp_path / "motor.st")["it"].verdict is Verdict.PASSED


def test_a_test_sets_the_inputs_of_a_program(tmp_path: Path) -> None:
    io = """VAR_GLOBAL switch AT %IX0.0 : BOOL; lamp AT %QX1.3 : BOOL; END_VAR
PROGRAM PLC_PRG
VAR enable AT %IX0.1 : BOOL; END_VAR
lamp := switch AND enable;
END_PROGRAM"""
    body = "ASSERT_FALSE(lamp); switch := TRUE; PLC_PRG.enable := TRUE; PLC_PRG(); ASSERT_TRUE(%QX1.3);"
    body += " %IX0.0 := FALSE; PLC_PRG(); ASSERT_FALSE(lamp); %IX0.0 := TRUE; PLC_PRG();"
    written(tmp_path, io=io, io_test=f"TEST 'a' {body} END_TEST TEST 'b' {body} END_TEST")
    assert [one.failures for one in outcomes(tmp_path / "io_test.st").values()] == [(), ()]


def test_code_elsewhere_needs_uses(tmp_path: Path) -> None:
    (tmp_path / "src").mkdir()
    written(tmp_path / "src", motor=MOTOR)
    written(tmp_path, motor_test="TEST 'a'\nVAR m : Motor; END_VAR m(); END_TEST")
    failures = outcomes(tmp_path / "motor_test.st")["a"].failures
    assert any(failure.expected == "USES 'file.st'; for code that is elsewhere" for failure in failures)


def test_code_is_found_in_the_folders_that_are_given(tmp_path: Path) -> None:
    """Many projects have their code in `src` and their tests in `tests`."""
    text = "TEST 'a' VAR m : Motor; END_VAR m(start := TRUE); ASSERT_EQ(m.calls, 1); ASSERT_TRUE(m.run); END_TEST"
    for name in ("src/blocks", "src/functions", "tests", "old"):
        (tmp_path / name).mkdir(parents=True)
    block, function = MOTOR.split("\n\n")
    written(tmp_path / "src/blocks", motor=block)
    written(tmp_path / "src/functions", step=function)
    written(tmp_path / "tests", motor_test=text, other="FUNCTION Other : INT Other := Unknown(1); END_FUNCTION")
    written(tmp_path / "old", strange="FUNCTION Strange : INT Strange := nothing; END_FUNCTION")
    for given in ([tmp_path], [tmp_path / "tests", tmp_path / "src"]):
        done = iec_test(*given)
        assert (done.exit_code, "1 passed" in done.output) == (0, True), done.output
    assert iec_test(tmp_path / "tests").exit_code != 0


def test_of_two_files_elsewhere_the_nearer_one_counts(tmp_path: Path) -> None:
    for name, size in (("one/src", 1), ("two/src", 2)):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name).with_name("tests").mkdir()
        written(tmp_path / name, size=f"FUNCTION Size : INT Size := {size}; END_FUNCTION")
        written((tmp_path / name).with_name("tests"), size_test=f"TEST 'a' ASSERT_EQ(Size(), {size}); END_TEST")
    assert "2 tests: 2 passed" in iec_test(tmp_path).output


def test_a_test_in_a_rig_does_not_need_the_program_of_its_controller(tmp_path: Path) -> None:
    """The program names objects of its controller, which only the rig has; the test has a variable of the same name."""
    controller = """VAR_GLOBAL g_speed : REAL; END_VAR
PROGRAM Main
g_speed := PacDriveM.Timer1;
END_PROGRAM
CONFIGURATION c RESOURCE r ON MAx4 TASK t(INTERVAL := T#10ms, PRIORITY := 1); PROGRAM p WITH t : Main;
END_RESOURCE END_CONFIGURATION"""
    (tmp_path / "empty.yaml").write_text("time: virtual\nbuses: {wires: {kind: wires.virtual}}\ndevices: {}\n")
    body = "VAR g_speed : REAL; END_VAR\nASSERT_STAYS(g_speed = 0.0, T#10ms);"
    written(tmp_path, main=controller, main_test=f"TEST 'a' RIG 'empty.yaml' {body} END_TEST")
    assert outcomes(tmp_path / "main_test.st")["a"].failures == ()


def test_an_expression_may_be_long(tmp_path: Path) -> None:
    """The words of a test are looked for in the code beside it, however deep its tree is."""
    assert one(tmp_path, f"ASSERT_EQ({' + '.join(['1'] * 2_000)}, 2000);").verdict is Verdict.PASSED


CHART = """\
FUNCTION_BLOCK ZFiller
VAR_INPUT full : BOOL; END_VAR
VAR pump : BOOL; END_VAR
INITIAL_STEP Waits:
END_STEP
TRANSITION FROM Waits TO Fills := NOT full; END_TRANSITION
STEP Fills:
    pump(N);
END_STEP
TRANSITION FROM Fills TO Waits := full AND Fills.t > T#100ms; END_TRANSITION
END_FUNCTION_BLOCK
"""


def test_the_steps_of_a_chart_are_seen_in_whatever_order_the_files_are(tmp_path: Path) -> None:
    body = """VAR f : ZFiller; END_VAR
ASSERT_TRUE(f.Waits.X);
f(); f();
ASSERT_TRUE(f.Fills.x AND NOT f.Waits.x AND f.pump);
ADVANCE_TIME(T#50ms); f();
ASSERT_EQ(f.Fills.T, T#50ms);
ASSERT_EQ(f.Fills.x, FALSE, 'to see the step');"""
    outcome = one(tmp_path, body, CHART)
    assert [(failure.message, failure.actual) for failure in outcome.failures] == [("to see the step", "TRUE")]


def test_an_element_of_an_array_is_among_the_values_around_a_failure(tmp_path: Path) -> None:
    body = "VAR a : ARRAY[-1..3] OF INT; b : ARRAY[1..2, 1..2] OF INT; i : INT := 2; END_VAR "
    body += "a[-1] := 5; ADVANCE_TIME(T#10ms); b[2, 1] := 7; ASSERT_TRUE(a[-1] = 6 AND b[2, 1] = 7 AND a[i] = 0);"
    (failure,) = one(tmp_path, body).failures
    shown = [line.split()[:2] for line in failure.diagram]
    assert shown == [["a[-1]", "5"], ["b[2,1]", "7"], ["i", "2"]]


def test_a_call_through_an_interface_that_nothing_is_in_says_so(tmp_path: Path) -> None:
    written(
        tmp_path, counter=OBJECTS, counter_test="TEST 'a'\nVAR i : ICount; END_VAR\nASSERT_EQ(i.Inc(), 1);\nEND_TEST"
    )
    (failure,) = outcomes(tmp_path / "counter_test.st", "codesys")["a"].failures
    assert (failure.line, failure.actual) == (3, "a pointer to nothing")


LEVELS = (
    "TYPE Level : (low, high); END_TYPE\nFUNCTION Twice : INT VAR_INPUT x : INT; END_VAR Twice := x * 2; END_FUNCTION\n"
)


@pytest.mark.parametrize(
    ("body", "actual"),
    [
        ("VAR x : INT := 5; END_VAR ASSERT_TRUE(Twice(x) > 20);", "FALSE, where Twice(x) = 10"),
        ("VAR x, y : INT := 5; END_VAR ASSERT_FALSE(x + 1 > y);", "TRUE, where x + 1 = 6 and y = 5"),
        ("VAR s : STRING := 'abc'; END_VAR ASSERT_FALSE(NOT (s <> 'abc'));", "TRUE, where s = 'abc'"),
        ("VAR l : Level := high; END_VAR ASSERT_TRUE(l = low);", "FALSE, where l = high"),
        ("VAR t : TON; END_VAR ASSERT_TRUE(t.ET >= T#5s, 'time');", "FALSE, where t.ET = T#0ms"),
        ("VAR a : BOOL; END_VAR ASSERT_TRUE(a);", "FALSE"),
        ("ASSERT_TRUE(1 > 2);", "FALSE"),
    ],
)
def test_a_condition_that_compares_shows_both_sides(tmp_path: Path, body: str, actual: str) -> None:
    assert said(tmp_path, body, LEVELS)[1] == actual


def test_the_sides_of_a_comparison_are_computed_once(tmp_path: Path) -> None:
    counter = "VAR_GLOBAL n : INT; END_VAR\nFUNCTION Next : INT n := n + 1; Next := n; END_FUNCTION\n"
    body = "ASSERT_TRUE(Next() = 1); ASSERT_TRUE(Next() = 2); ASSERT_TRUE(Next() = 9);"
    assert said(tmp_path, body, counter)[1] == "FALSE, where Next() = 3"


def test_a_block_with_the_name_of_a_word_of_tests_takes_nothing_from_them(tmp_path: Path) -> None:
    blocks = "FUNCTION_BLOCK Print VAR_INPUT x : INT; END_VAR END_FUNCTION_BLOCK"
    outcome = one(tmp_path, "VAR p : Print; END_VAR p(x := 1); PRINT('still a word'); ASSERT_EQ(p.x, 1);", blocks)
    assert (outcome.verdict, outcome.output) == (Verdict.PASSED, ("still a word",))


def test_a_string_of_codesys_is_as_long_as_a_document(tmp_path: Path) -> None:
    body = "VAR a, b : STRING(100000); END_VAR a := 'document'; b := a; ASSERT_EQ(b, 'document');"
    assert one(tmp_path, body, dialect="codesys").verdict is Verdict.PASSED


@pytest.mark.parametrize("dialect", ["epas-4", "edition-3", "codesys"])
def test_names_of_tests_are_in_either_quotes(tmp_path: Path, dialect: str) -> None:
    text = """USES "motor.st";
TEST "it's so" VAR m : Motor; END_VAR m(start := TRUE); ASSERT_TRUE(m.run); END_TEST
TEST 'say "so"' END_TEST
TEST "later" SKIP "not now" END_TEST
"""
    written(tmp_path, motor=MOTOR, checks=text)
    found = outcomes(tmp_path / "checks.st", dialect)
    assert {name: one.verdict.value for name, one in found.items()} == {
        "it's so": "passed",
        'say "so"': "passed",
        "later": "skipped",
    }


def test_files_for_trust_run(tmp_path: Path) -> None:
    text = """
FUNCTION_BLOCK Counter
VAR_INPUT inc : BOOL; END_VAR
VAR_OUTPUT value : INT; END_VAR
IF inc THEN value := value + 1; END_IF;
END_FUNCTION_BLOCK
TEST_PROGRAM CountsUp
VAR c : Counter; END_VAR
c(inc := TRUE); ASSERT_EQUAL(EXPECTED := 1, ACTUAL := c.value);
END_TEST_PROGRAM
TEST_FUNCTION_BLOCK Fresh
VAR c : Counter; END_VAR
c(inc := FALSE); ASSERT_EQUAL(1, c.value, 'nothing is left of the other test');
END_TEST_FUNCTION_BLOCK
"""
    written(tmp_path, counter=text, named="PROGRAM p VAR test_program, end_test_program : INT; END_VAR END_PROGRAM")
    found = as_json(tmp_path)
    assert [(one["name"], one["verdict"], one["line"]) for one in found] == [
        ("CountsUp", "passed", 7),
        ("Fresh", "failed", 11),
    ]
