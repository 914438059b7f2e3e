"""Passages about programs that can be read in two ways (docs/devices/pam/pam-readings.md)."""

import sys
from pathlib import Path
from typing import Any

import pytest
from pam_bench import PamBench, sequence, started

from fieldrig_devices.pam.runtime.processor import Limits
from fieldrig_devices.pam.runtime.readings import Readings
from fieldrig_devices.pam.settings import PamSettings, ProgramReadings

LARGEST = sys.float_info.max
OTHER = "SEQUENCE SEQ_x; n <- n + 1; END_SEQUENCE\n"
SECOND = "TASK TSK_x; SPECS CYCLES = 1; END_SPECS SEQUENCE SEQ_x; n <- n + 1; WAIT_TIME 100; END_SEQUENCE END_TASK\n"


def reading(**values: Any) -> Readings:
    return Readings(**values)


def pulse(bench: PamBench, name: str, times: int = 1) -> None:
    """Short events, which are gone before the next basic cycle."""
    for _ in range(times):
        bench[name] = True
        bench[name] = False


def test_a_rig_file_says_how_fast_the_processor_is() -> None:
    assert PamSettings(application=Path(__file__)).limits() == Limits()
    programs = ProgramReadings(statements_per_ms=7, is_overrun_fatal=True)
    assert PamSettings(application=Path(__file__), programs=programs).limits() == Limits(7, is_overrun_fatal=True)


# ---- events and conditions


@pytest.mark.parametrize(("events", "runs"), [("remembered", 1), ("counted", 3), ("sampled", 0)])
def test_three_events_between_two_cycles_of_the_actions(events: str, runs: int) -> None:
    actions = "ACTIONS ACT_a; SPECS CYCLES = 10; END_SPECS ON_EVENT f ACTION n <- n + 1; END_ACTION END_ACTIONS"
    bench = PamBench(actions, readings=reading(events=events))
    bench.run(12)
    pulse(bench, "f", 3)
    bench.run(20)
    assert bench["n"] == runs
    bench["f"] = True  # long enough to be sampled
    bench.run(20)
    assert bench["n"] == runs + 1


@pytest.mark.parametrize(("events", "runs"), [("remembered", 1), ("counted", 1), ("sampled", 0)])
def test_of_several_events_a_task_handles_one(events: str, runs: int) -> None:
    bench = PamBench(sequence("n <- n + 1; WAIT_TIME 5;", cycles=10), readings=reading(events=events))
    bench.run(12)
    pulse(bench, "SBI_a", 3)
    bench.run(30)
    assert bench["n"] == runs


@pytest.mark.parametrize(("at_start", "runs"), [("changes", [0, 1]), ("all", [1, 1]), ("none", [0, 0])])
@pytest.mark.parametrize("events", ["remembered", "sampled"])
def test_events_before_the_power_on_parts_have_finished(at_start: str, events: str, runs: list[int]) -> None:
    actions = (
        "ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS ON_EVENT SBI_b ACTION n <- n + 1; END_ACTION\n"
        "ON_EVENT f ACTION at <- at + 1; END_ACTION END_ACTIONS\n"
    )
    bench = PamBench(
        actions + sequence("w <- w + 1;", power_on="WAIT_TIME 5; f <- set;"),
        readings=reading(events_at_start=at_start, events=events),
    )
    bench["SBI_b"] = bench["SBI_a"] = True
    bench.restart()  # with inputs that are true already
    bench.run(20)
    assert ([bench["n"], bench["at"]], bench["w"]) == (runs, runs[0])
    bench["f"] = False
    bench.run()
    bench["f"] = True
    bench.run()
    assert bench["at"] == runs[1] + 1


@pytest.mark.parametrize(("causes_events", "seen"), [(True, 1), (False, 0)])
def test_a_common_variable_in_an_event(causes_events: bool, seen: int) -> None:
    actions = (
        "ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS ON_EVENT cf ACTION n <- n + 1; END_ACTION\n"
        "ON_EVENT f * cf ACTION at <- at + 1; END_ACTION ON_STATE cf ACTION w <- w + 1; END_ACTION END_ACTIONS"
    )
    bench = PamBench(actions, readings=reading(common_variables_cause_events=causes_events))
    bench.run()
    bench["cf"] = True
    bench.run(5)
    assert (bench["n"], bench["w"]) == (seen, 5)  # a state is looked at in each cycle anyhow
    bench["f"] = True
    bench.run()
    assert bench["at"] == 1


@pytest.mark.parametrize(("causes_events", "seen"), [(True, 1), (False, 0)])
def test_a_common_variable_in_an_exception_and_in_a_condition(causes_events: bool, seen: int) -> None:
    statements = "EXCEPTION cf SEQUENCE SEQ_x; WAIT_TIME 5; CONDITION cf; at <- 1;"
    bench = started(statements, more=OTHER, readings=reading(common_variables_cause_events=causes_events))
    bench["cf"] = True
    bench.run(10)
    assert (bench["n"], bench["at"]) == (seen, 1 - seen)


@pytest.mark.parametrize("wait", ["CONDITION SBI_b;", "CASE CONDITION SBI_b XEQ_SEQUENCE SEQ_x; END_CASE"])
def test_a_short_event_of_a_condition_is_missed(wait: str) -> None:
    bench = started(f"{wait} n <- n + 1;", cycles=10, more=OTHER)
    bench.run(2)
    pulse(bench, "SBI_b")
    seen = bench.trace("n", 20)
    bench["SBI_b"] = True
    assert (seen, list(bench.trace("n", 10).values())) == ({}, [1])


# ---- order


def test_actions_that_are_declared_after_a_task_run_after_it() -> None:
    actions = "ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS ON_EVENT SBI_a ACTION n <- n * 10 + 2; END_ACTION END_ACTIONS"
    bench = PamBench(sequence("n <- n * 10 + 1;") + actions)
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    assert bench["n"] == 12


def test_an_equation_is_evaluated_before_the_programs() -> None:
    programs = (
        "BOOLEAN BOL_f; LINKED_OUTPUT = SBO_a; EQUATION = f; END_BOOLEAN BOOLEAN BOL_b; EQUATION = SBI_b; END_BOOLEAN\n"
        "ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS ON_EVENT BOL_b ACTION n <- n + 1; END_ACTION END_ACTIONS\n"
    )
    bench = PamBench(programs + sequence("f <- set;"))
    bench.run()
    bench["SBI_a"] = bench["SBI_b"] = True
    seen = dict[str, int]()
    for cycle in (2, 3):
        bench.run()
        seen |= {name: cycle for name in ("SBO_a", "n") if bench[name] and name not in seen}
    assert seen == {"SBO_a": 3, "n": 2}


# ---- exceptions


@pytest.mark.parametrize("wakes", [True, False])
@pytest.mark.parametrize(
    ("wait", "end"),
    [("WAIT_TIME 20;", 22), ("CONDITION f TIMEOUT 20;", 22), ("XEQ_TASK TSK_y SEQUENCE SEQ_y WAIT;", 23)],
)
def test_an_exception_of_a_suspended_sequence(wait: str, end: int, wakes: bool) -> None:
    second = "TASK TSK_y; SPECS CYCLES = 1; END_SPECS SEQUENCE SEQ_y; WAIT_TIME 20; END_SEQUENCE END_TASK\n"
    statements = f"EXCEPTION SBI_b SEQUENCE SEQ_x; {wait} at <- 1;"
    bench = PamBench(second + sequence(statements, more=OTHER), readings=reading(exceptions_wake=wakes))
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    pulse(bench, "SBI_b")
    assert bench.trace("n", 40) == {3 if wakes else end: 1}
    assert bench["at"] == 0


@pytest.mark.parametrize(("wake", "cycle"), [(True, 3), (False, 22)])
def test_a_late_exception_comes_before_the_sequence_of_a_case(wake: bool, cycle: int) -> None:
    statements = (
        "EXCEPTION SBI_b ENTRY e; CASE CONDITION SBI_c XEQ_SEQUENCE SEQ_x; TIMEOUT 20 XEQ_SEQUENCE SEQ_x; END_CASE\n"
        "EXCEPTION_ENTRY e; at <- 1;"
    )
    bench = started(statements, more=OTHER, readings=reading(exceptions_wake=wake))
    pulse(bench, "SBI_b")
    assert bench.trace("at", 40).keys() == {cycle}
    assert (bench["n"], bench.runtime.tasks[0].is_alive) == (0, False)


@pytest.mark.parametrize(("wake", "cycle"), [(True, 3), (False, 22)])
def test_a_sequence_goes_on_beside_the_task_of_its_exception(wake: bool, cycle: int) -> None:
    statements = "EXCEPTION SBI_b XEQ_TASK TSK_x SEQUENCE SEQ_x; CONDITION f TIMEOUT 20; at <- 1;"
    bench = PamBench(sequence(statements) + SECOND, readings=reading(exceptions_wake=wake))
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    pulse(bench, "SBI_b")
    assert bench.trace("n", 30) == {cycle: 1}
    assert bench["at"] == 1


@pytest.mark.parametrize("wakes", [True, False])
@pytest.mark.parametrize("event", ["f", "cf"])
def test_an_exception_that_the_sequence_itself_causes_comes_before_its_wait(event: str, wakes: bool) -> None:
    statements = f"EXCEPTION {event} SEQUENCE SEQ_x; {event} <- 1; WAIT_TIME 20; at <- 1;"
    readings = reading(exceptions_wake=wakes, common_variables_cause_events=True)
    bench = started(statements, more=OTHER, readings=readings)
    assert (bench["n"], bench["at"]) == (1, 0)


def test_an_exception_occurs_again() -> None:
    statements = "EXCEPTION SBI_b ENTRY e; EXCEPTION_ENTRY e; n <- n + 1; CONDITION SBI_c;"
    bench = started(statements)
    for _ in range(3):
        pulse(bench, "SBI_b")
        bench.run()
    assert bench["n"] == 4


def test_the_time_out_of_an_exception_that_has_occurred_is_still_to_come() -> None:
    statements = "EXCEPTION SBI_b TIMEOUT 10 ENTRY e; EXCEPTION_ENTRY e; n <- n + 1; CONDITION SBI_c;"
    bench = started(statements)
    pulse(bench, "SBI_b")
    bench.run(30)
    assert bench["n"] == 3


def test_an_exception_that_has_occurred_leaves_the_rest_of_its_time_out() -> None:
    statements = (
        "EXCEPTION SBI_b TIMEOUT 20 ENTRY e; CONDITION SBI_c;\n"
        "EXCEPTION_ENTRY e; EXCEPTION SBI_c TIMEOUT SEQUENCE SEQ_x; WAIT_TIME 100;"
    )
    bench = started(statements, more=OTHER)
    pulse(bench, "SBI_b")
    assert bench.trace("n", 40) == {22: 1}  # 20 ms after the first EXCEPTION


# ---- tasks


def test_duplicates_are_those_of_a_sequence() -> None:
    task = (
        "TASK TSK_a; SPECS NUMBER = 3; DUPL = 1; CYCLES = 1; END_SPECS\n"
        "EVENTS ON_EVENT we[i] = 1 XEQ_SEQUENCE SEQ_a[i]; ON_EVENT we[i] = 2 XEQ_SEQUENCE SEQ_b[i]; END_EVENTS\n"
        "SEQUENCE SEQ_a[i]; CONDITION DUPL_START; beyond[i] <- 1; CONDITION SBI_a; END_SEQUENCE\n"
        "SEQUENCE SEQ_b[i]; CONDITION DUPL_START; beyond[i] <- 1; CONDITION SBI_b; END_SEQUENCE END_TASK"
    )
    variable = "INTERNAL WORD_VAR beyond; NUMBER = 3; END\n"
    bench = PamBench(variable + task)
    bench.run()
    bench["we"] = [1, 2, 1]
    bench.run(3)
    assert bench["beyond"] == [1, 1, 0]
    bench["SBI_a"] = bench["SBI_b"] = True
    bench.run(5)
    assert bench["beyond"] == [1, 1, 1]


@pytest.mark.parametrize(
    ("statement", "error"),
    [
        ("XEQ_TASK TSK_x SEQUENCE SEQ_x;", "03..E033"),
        ("CONDITION SBI_c TIMEOUT -1;", "03..E032"),
        ("EXCEPTION SBI_c TIMEOUT -1 ABORT_SEQUENCE;", "03..E031"),
    ],
)
def test_a_task_whose_sequence_has_ended_by_an_error_starts_again(statement: str, error: str) -> None:
    first = "TASK TSK_y; SPECS CYCLES = 1; END_SPECS EVENTS ON_EVENT g XEQ_SEQUENCE SEQ_y; END_EVENTS\n"
    first += "SEQUENCE SEQ_y; XEQ_TASK TSK_x SEQUENCE SEQ_x; END_SEQUENCE END_TASK\n"
    bench = PamBench(SECOND + first + sequence(f"w <- w + 1; {statement}"))
    bench.run()
    bench["g"] = True
    bench.run(2)
    for _ in range(2):
        bench["SBI_a"] = True
        bench.run(2)
        bench["SBI_a"] = False
        bench.run(2)
    assert (bench["w"], bench.errors) == (2, [error] * 2)
    assert not bench.runtime.is_stopped


def test_such_a_task_is_started_by_another_one() -> None:
    failing = sequence("CONDITION SBI_c TIMEOUT -1;", more="SEQUENCE SEQ_b; n <- n + 1; END_SEQUENCE\n")
    other = (
        "TASK TSK_b; SPECS CYCLES = 1; END_SPECS EVENTS ON_EVENT f XEQ_SEQUENCE SEQ_c; END_EVENTS\n"
        "SEQUENCE SEQ_c; XEQ_TASK TSK_a SEQUENCE SEQ_b WAIT; at <- 1; END_SEQUENCE END_TASK"
    )
    bench = PamBench(failing + other)
    bench.run()
    bench["SBI_a"] = True
    bench.run(2)
    bench["f"] = True
    bench.run(3)
    assert (bench["n"], bench["at"], bench.errors) == (1, 1, ["03..E032"])


# ---- numbers


@pytest.mark.manual("PAMS-003", "PAMS-004", "PAMS-005", "PAMS-006")
@pytest.mark.parametrize(
    ("expression", "limit"),
    [
        ("-1.0 ? sqrt", 0.0),
        ("2.0 ? acos", 0.0),
        ("-2.0 ? asin", 0.0),
        ("0.0 ? ln", -LARGEST),
        ("-1.0 ? log10", -LARGEST),
        ("1000.0 ? exp", LARGEST),
        ("-1000.0 ? cosh", LARGEST),
        ("-1000.0 ? sinh", -LARGEST),
        ("0.0 ^ -1.0", 0.0),
        ("-2.0 ^ 0.5", 0.0),
        ("10.0 ^ 400.0", LARGEST),
        ("-10.0 ^ 401.0", -LARGEST),
        ("-10.0 ^ 400.0", LARGEST),
    ],
)
@pytest.mark.parametrize("is_fatal", [True, False])
def test_an_error_of_a_function(expression: str, limit: float, is_fatal: bool) -> None:
    readings = reading(math_error_is_fatal=is_fatal)
    bench = started(f"y <- 7; x <- {expression}; y <- 8;", readings=readings)
    assert (bench["x"], bench["y"]) == ((0.0, 7.0) if is_fatal else (limit, 8.0))
    assert bench.errors == (["02..FFF3"] if is_fatal else [])


@pytest.mark.parametrize(
    ("statement", "error"), [("x <- x / x;", "02..FFF3"), ("w <- n / n;", "02..FFF2"), ("x <- 1.0 / x;", "02..FFF3")]
)
def test_a_division_by_zero_stops_the_application_in_both_readings(statement: str, error: str) -> None:
    bench = started(statement, readings=reading(math_error_is_fatal=False))
    assert bench.errors == [error]  # manual lines 11684 to 11695


@pytest.mark.parametrize("is_fatal", [True, False])
def test_zero_to_the_power_of_zero_is_one(is_fatal: bool) -> None:
    readings = reading(math_error_is_fatal=is_fatal)
    bench = started("x <- y ^ y;", readings=readings)
    assert (bench["x"], bench.errors) == (1.0, [])
    assert started("x <- 0.0 ^ 2.0 + 3.0 ^ 0.0;", readings=readings)["x"] == 1.0  # manual line 6658: 0 and 1.0


# ---- workspaces


@pytest.mark.parametrize(("checks", "errors"), [(True, ["03..E02C"]), (False, [])])
def test_a_workspace_that_is_too_small(checks: bool, errors: list[str]) -> None:
    statements = "SPECS WORKSPACE = 1; END_SPECS n <- 1;"
    bench = started(statements, readings=reading(checks_workspaces=checks))
    assert (bench.errors, bench.runtime.is_stopped, bench["n"]) == (errors, checks, 0 if checks else 1)
