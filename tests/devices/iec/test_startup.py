"""The code before the first cycle: FB_init, and start values that are computed (results: programs/constructors.st)."""

import pytest
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.printer import print_unit
from fieldrig_devices.iec.runtime import Start

PUMP = """
FUNCTION_BLOCK Pump
VAR started, number : INT; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains, bInCopyCode : BOOL; number : INT; END_VAR
started := started + 1;
THIS^.number := 12 / number;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Plain VAR_INPUT n : INT; END_VAR END_FUNCTION_BLOCK
FUNCTION Twice : INT VAR_INPUT n : INT; END_VAR Twice := 2 * n; END_FUNCTION
"""


def test_constructors_run_once_after_each_start() -> None:
    bench = IecBench(PUMP + program("p : Pump(3); runs : INT;", "runs := runs + 1;"), CODESYS)
    assert bench["p.started"] == 0
    bench.cycle(3)
    assert (bench["p.started"], bench["p.number"], bench["runs"]) == (1, 4, 3)
    bench.runtime.initialise(Start.WARM)
    bench.cycle()
    assert (bench["p.started"], bench["runs"]) == (1, 1)


def test_variables_of_methods_and_functions_that_last_are_started_once() -> None:
    text = (
        PUMP
        + """
FUNCTION Last : INT VAR_STAT p : Pump(4); END_VAR Last := p.number * 10 + p.started; END_FUNCTION
FUNCTION_BLOCK Holder
METHOD Last : INT VAR_INST p : Pump(6); END_VAR Last := p.number * 10 + p.started; END_METHOD
END_FUNCTION_BLOCK
"""
        + program("h : Holder; a, b : INT;", "a := Last(); b := h.Last();")
    )
    bench = IecBench(text, CODESYS)
    bench.cycle(2)
    assert (bench["a"], bench["b"]) == (31, 21)


def test_an_online_change_starts_nothing_again() -> None:
    text = PUMP + program("p : Pump(3); runs : INT;", "runs := runs + 1;")
    bench = IecBench(text, CODESYS)
    bench.cycle()
    bench.runtime.change(bench.compile(text.replace("runs + 1", "runs + 5"), bench.compiled))
    bench.cycle()
    assert (bench["p.started"], bench["runs"]) == (1, 6)


def test_a_fault_in_a_constructor_stops_the_task_there() -> None:
    bench = IecBench(PUMP + program("p : Pump(0);", ""), CODESYS)
    bench.cycle()
    assert bench.thread.fault is not None
    assert (bench.thread.fault.code, bench.thread.fault.pou, bench.thread.fault.line) == ("division", "Pump.FB_init", 7)


@pytest.mark.parametrize(
    ("declarations", "expected"),
    [
        ("p : Pump;", "the argument number is missing in the call of Pump.FB_init"),
        ("p : Pump(nr := 1);", "Pump.FB_init has no input nr"),
        ("p : Pump(1, 2);", "too many arguments for Pump.FB_init"),
        ("p : Plain(1);", "Plain has no method FB_init for the arguments"),
        ("p : ARRAY[0..1] OF Pump[1, 2];", "got 1; expected ("),
        ("k : INT := Twice(TRUE);", "TRUE is a BOOL; expected INT"),
        ("q : Plain := (n := nix);", "nix is not declared"),
        ("q : Plain := (m := k); k : INT;", "Plain has no component m"),
        ("END_VAR VAR CONSTANT k : INT := Twice(2);", "Twice(...) is not constant"),
    ],
)
def test_wrong_starts_are_refused(declarations: str, expected: str) -> None:
    found = [message for message in refused(PUMP + program(declarations, ""), CODESYS) if "note:" not in message]
    assert any(expected in message for message in found), found
    assert len(found) == 1, found


def test_edition_3_computes_start_values_and_has_no_constructors() -> None:
    assert any("got (" in message or "got )" in message for message in refused(program("p : Pump(3);", ""), EDITION_3))
    bench = IecBench(PUMP + program("a : INT := Twice(3); p : Pump; q : Plain := (n := a);", ""), EDITION_3)
    bench.cycle()
    assert (bench["a"], bench["p.started"], bench["q.n"]) == (6, 0, 6)
    found = refused(PUMP + program("a : INT := Twice(3);", ""), EPAS_4)
    assert any("Twice(...) is not constant" in message for message in found), found


def test_declarations_with_arguments_keep_them_in_print() -> None:
    text = program("p : Pump(3) := (n := 4); q : ARRAY[0..1] OF Pump[(1), (number := 2)]; r : INT(0..5);", "")
    printed = print_unit(parse(text, "a.st", CODESYS)[0])
    assert "p : Pump(3) := (n := 4);" in printed
    assert "q : ARRAY[0..1] OF Pump[(1), (number := 2)];" in printed
    assert "r : INT(0..5);" in printed
    assert print_unit(parse(printed, "a.st", CODESYS)[0]) == printed
