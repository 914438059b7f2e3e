"""Projects whose suites reach units of which a part does not compile, such as code for a library that is not there."""

from pathlib import Path
from typing import Any

import pytest
from tcunit_bench import SuiteBench, suite

from fieldrig_devices.iec.tcunit import program
from fieldrig_devices.iec.testing.case import MISTAKE, Limits, Verdict
from fieldrig_devices.iec.testing.suites import sources_in
from fieldrig_devices.languages.mistakes import CompileError

AXIS = """\
FUNCTION_BLOCK Axis EXTENDS Base
VAR_INPUT on : BOOL; END_VAR
VAR_OUTPUT runs : BOOL; END_VAR
VAR
    motor : Motion.Drive := (speed := 3);
    mode : Mode := Mode.Fast;
    links : ARRAY[1..2] OF POINTER TO Drive;
END_VAR
runs := on;
METHOD Stop : BOOL
motor(on := FALSE);
END_METHOD
METHOD Size : UDINT
Size := SIZEOF(motor);
END_METHOD
METHOD SizeOfAll : UDINT
VAR one : Axis; END_VAR
SizeOfAll := SIZEOF(one);
END_METHOD
METHOD SizeOfPointer : UDINT
SizeOfPointer := SIZEOF(links);
END_METHOD
PROPERTY Speed : INT
GET
Speed := motor.speed;
END_GET
END_PROPERTY
ACTION Halt:
Unheard(motor);
END_ACTION
END_FUNCTION_BLOCK
"""
MISSING = "the type Motion.Drive is not declared"


def with_axis(body: str) -> SuiteBench:
    bench = SuiteBench(
        suite(f"TEST('t'); a(on := TRUE); {body} TEST_FINISHED();", "a : Axis; n : INT; u : UDINT;"), AXIS
    )
    bench.run()
    return bench


def test_a_suite_runs_without_a_library_that_only_other_code_needs() -> None:
    bench = with_axis("AssertTrue(a.runs, 'r'); AssertEquals_UDINT(8, a.SizeOfPointer(), 's');")
    assert (bench.test("t").is_finished, bench.lines, bench.faults) == (True, [], [])
    parts = {one.name: (one.reason.what, one.line, one.is_part) for one in bench.program.left_out}
    assert parts == {
        "Axis.Stop": (MISSING, 11, True),
        "Axis.Size": ("the size of motor is not known, because a type in it is not there", 14, True),
        "Axis.SizeOfAll": ("the size of one is not known, because a type in it is not there", 18, True),
        "Axis.Speed": (MISSING, 25, True),
        "Axis.Halt": ("Unheard is not declared", 29, True),
    }


@pytest.mark.parametrize(
    ("call", "reason", "place"),
    [
        ("a.Stop();", MISSING, "Axis.Stop (part2.st:11)"),
        ("u := a.Size();", "the size of motor is not known", "Axis.Size (part2.st:14)"),
        ("n := a.Speed;", MISSING, "Axis.Speed (part2.st:25)"),
        ("a.Halt();", "Unheard is not declared", "Axis.Halt (part2.st:29)"),
    ],
)
def test_a_run_that_reaches_what_does_not_compile_gets_a_fault_with_the_reason(
    call: str, reason: str, place: str
) -> None:
    fault = with_axis(call).test("t").fault
    assert fault.startswith(f"the run has reached what does not compile: {reason}")
    assert place in fault


def test_a_mistake_in_a_suite_is_one_though_it_could_do_without() -> None:
    bench = SuiteBench(suite("TEST('t'); TEST_FINISHED();", methods="METHOD Later\nx := 1;\nEND_METHOD"))
    bench.run()
    assert [(one.name, one.is_suite, one.reason.what) for one in bench.program.left_out] == [
        ("Suite", True, "x is not declared")
    ]


def test_the_runner_shows_what_was_not_needed_as_skipped_and_what_was_as_a_mistake(tmp_path: Path) -> None:
    (tmp_path / "a.st").write_text(suite("TEST('t'); a.Stop(); TEST_FINISHED();", "a : Axis;"))
    (tmp_path / "b.st").write_text(AXIS)
    (source,) = sources_in(tmp_path)
    outcomes = {(outcome.case.suite, outcome.case.name): outcome for outcome in source.run(source.cases(), Limits())}
    (failure,) = outcomes["PRG_TEST.s", "t"].failures
    assert (outcomes["PRG_TEST.s", "t"].verdict, failure.kind) == (Verdict.ERROR, MISTAKE)
    skipped = outcomes["Axis.Halt", "compiles"]
    assert (skipped.verdict, skipped.reason) == (
        Verdict.SKIPPED,
        "Unheard is not declared, and no suite has needed it",
    )


def test_attempts_end_when_one_says_the_same_as_the_one_before(monkeypatch: pytest.MonkeyPatch) -> None:
    attempts: list[Any] = []

    def changes_nothing(*given: Any) -> bool:
        attempts.append(given)
        return True

    monkeypatch.setattr(program._Builder, "_leave_out", changes_nothing)
    with pytest.raises(CompileError):
        SuiteBench(suite("TEST('t'); Unknown(); TEST_FINISHED();"))
    assert len(attempts) == 1
