"""A breakpoint on any line of a statement that goes over several lines is where the statement begins."""

from typing import Any

import pytest

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.dialect import CODESYS
from fieldrig_devices.iec.solo import Solo
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.debugging.service import DebugService
from fieldrig_devices.languages.source_file import SourceFile


def places(text: str, *lines: int) -> list[int | None]:
    clock = VirtualClock()
    host = StandaloneHost(clock)
    solo = Solo(clock, host, compile_project([SourceFile("a.st", text)], host, CODESYS))
    service = DebugService(VirtualClock(), solo)
    question: dict[str, Any] = {"command": "breakpoints", "file": "a.st", "move": True}
    answer = service.answer(question | {"breakpoints": [{"line": line} for line in lines]})
    found: list[int | None] = answer["places"]
    return found


HEAD = """FUNCTION_BLOCK Keep
VAR_INPUT a, b : INT; END_VAR
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR x, y : INT; k : Keep; t : TON; END_VAR
"""
FIRST = HEAD.count("\n") + 1


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        # the line of the body, from 1, where a breakpoint on each of its lines is
        (["x := 1 +", "  2 +", "  3;", "y := 2;"], [1, 1, 1, 4]),
        (["k(a := 1,", "  b := 2", ");", "y := 2;"], [1, 1, 1, 4]),
        (["k(a := 1, // first", "  // about b", "", "  b := 2);", "y := 2;"], [1, 1, 1, 1, 5]),
        (["t(IN := x > 1", "  AND y > 2,", "  PT := T#5s);", "", "", "y := 2;"], [1, 1, 1, 6, 6, 6]),
        (["IF x > 1", "  AND y > 2", "THEN", "  y := 2;", "END_IF"], [1, 1, 1, 4, None]),
        (["IF x > 1 THEN", "  (* about y *)", "  y := 2;", "ELSE", "  y := 3;", "END_IF"], [1, 3, 3, 5, 5, None]),
        (["CASE x OF", "  1,", "  2: y := 1;", "  3:", "    y := 2;", "END_CASE"], [1, 3, 3, 5, 5, None]),
        (["FOR x := 1 TO", "  10 DO", "  y := 2;", "END_FOR", "y := 3;"], [1, 1, 3, 5, 5]),
        (["WHILE x < 1", "  AND y < 2 DO", "  x := 2;", "END_WHILE", "y := 3;"], [1, 1, 3, 5, 5]),
        (["x := 1; y := 2 +", "  3;", "y := 2;"], [1, 1, 3]),
        (["x := 1;", "y :=", "  3;", "y := 2;"], [1, 2, 2, 4]),
        (["x := 1", "", "// about x", "  ;", "y := 2;"], [1, 5, 5, 1, 5]),
    ],
)
def test_a_breakpoint_inside_a_statement_is_where_it_begins(body: list[str], expected: list[int | None]) -> None:
    text = HEAD + "\n".join(body) + "\nEND_PROGRAM\n"
    found = places(text, *range(FIRST, FIRST + len(body)))
    assert [None if line is None else line - FIRST + 1 for line in found] == expected


def test_a_comment_in_a_list_of_instructions_is_no_part_of_one() -> None:
    text = "PROGRAM PLC_PRG\nVAR x : INT; END_VAR\nLD 1\nST x\n(* about x *)\n\nST x\nEND_PROGRAM\n"
    assert places(text, 1, 3, 4, 5, 6, 7, 8) == [4, 4, 4, 7, 7, 7, None]


COUNTS = """FUNCTION Twice : INT
VAR_INPUT x : INT; END_VAR
Twice := x;
Twice := 2 * x;
END_FUNCTION
PROGRAM PLC_PRG
VAR n, m : INT; END_VAR
n := n + 1;
m := Twice(n);
m := m + 1;
END_PROGRAM
"""


def stepped(kind: str, first: int, *stops: dict[str, Any]) -> tuple[int, int]:
    """Step from a line, past breakpoints that do not stop there; return the cycle and the line of the next stop."""
    clock = VirtualClock()
    host = StandaloneHost(clock)
    solo = Solo(clock, host, compile_project([SourceFile("a.st", COUNTS)], host, CODESYS))
    service = DebugService(clock, solo)
    service.answer({"command": "breakpoints", "file": "a.st", "breakpoints": [{"line": first}, *stops]})
    solo.start()
    solo.run_until(5_000_000)
    service.answer({"command": "step", "kind": kind})
    solo.run_until(25_000_000)
    (frame, *_) = service.answer({"command": "stack"})["frames"]
    return int(solo.evaluate("PLC_PRG.n").value or 0), frame["line"]


@pytest.mark.parametrize(
    "stop", [{"condition": "PLC_PRG.n = 50"}, {"hits": "50"}, {"log": "n is {n}"}], ids=["condition", "count", "log"]
)
@pytest.mark.parametrize(
    ("kind", "first", "passed", "expected"),
    [
        ("over", 8, [9], 9),
        ("over", 9, [3, 4], 10),
        ("over", 9, [3, 4, 10], 10),
        ("into", 9, [3], 3),
        ("out", 3, [4, 10], 9),
    ],
)
def test_a_step_ends_where_it_does_without_breakpoints_that_let_the_program_run(
    stop: dict[str, Any], kind: str, first: int, passed: list[int], expected: int
) -> None:
    """A step to a conditional breakpoint that did not hold ran on, and was lost."""
    assert stepped(kind, first) == (1, expected)
    assert stepped(kind, first, *({"line": line, **stop} for line in passed)) == (1, expected)


def test_a_step_ends_at_a_breakpoint_on_its_way() -> None:
    assert stepped("over", 9, {"line": 3, "log": "{x}"}, {"line": 4, "condition": "x = 1"}) == (1, 4)
