"""References whose variable is gone: the program stops with a fault or goes on, and the device never fails."""

import pytest
from iec_program import IecBench, program

from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.thread import Start

COUNTER = """FUNCTION_BLOCK Counter
VAR_IN_OUT target : INT; END_VAR
VAR own : INT; END_VAR
target := target + 1;
ACTION Again: target := target + 1; END_ACTION
END_FUNCTION_BLOCK
"""
GLOBALS = "VAR_GLOBAL counter1 : Counter; total : INT; END_VAR "


def test_a_forced_reference_waits_until_it_is_given_again() -> None:
    text = COUNTER + program("total : INT; counter1 : Counter;", "counter1(target := total);")
    bench = IecBench(text)
    bench.cycle()
    bench.runtime.force(bench.runtime.find("PLC_PRG.counter1.target"), 5)
    bench.cycle()
    assert bench["total"] == 5
    bench.runtime.initialise(Start.WARM)
    bench.cycle()
    assert bench["total"] == 5
    bench.runtime.change(bench.compile(text.replace("own : INT", "more, own : INT"), previous=bench.compiled))
    bench.cycle()
    assert (bench["total"], list(bench.runtime.forced)) == (5, ["PLC_PRG.counter1.target"])


def test_an_online_change_takes_the_target_of_a_reference_with_it() -> None:
    before = COUNTER + GLOBALS + program("n : INT;", "n := n + 1; IF n = 1 THEN counter1(target := total); END_IF;")
    bench = IecBench(before)
    bench.cycle()
    assert bench["counter1.target"] == 1
    after = (
        COUNTER + GLOBALS.replace("total : INT", "name : STRING := 'abc'") + program("n : INT;", "counter1.Again();")
    )
    bench.runtime.change(bench.compile(after, previous=bench.compiled))
    with pytest.raises(ValueError, match="refers to nothing yet"):
        bench["counter1.target"]
    bench.cycle()
    assert bench["name"] == "abc"
    assert (bench.thread.state, bench.thread.fault is not None) == (WorkState.FAULTED, True)


def test_an_online_change_leaves_references_whose_variable_stays() -> None:
    text = COUNTER + GLOBALS + program("n : INT;", "n := n + 1; IF n = 1 THEN counter1(target := total); END_IF;")
    bench = IecBench(text)
    bench.cycle()
    changed = text.replace("VAR n : INT;", "VAR n : INT; m : DINT;").replace("END_IF;", "END_IF; counter1.Again();")
    bench.runtime.change(bench.compile(changed, previous=bench.compiled))
    bench.cycle()
    assert (bench.thread.fault, bench["total"]) == (None, 2)


@pytest.mark.parametrize(
    "use",
    ["p^ := p^ + 1;", "p^ := 5; B := LEN(x);", "p^ := 5; x := CONCAT(x, 'd');", "counter1.Again();"],
)
def test_a_reference_to_a_variable_of_an_ended_call_is_a_fault_of_the_program(use: str) -> None:
    functions = (
        "FUNCTION A : INT VAR x : INT; END_VAR p := ADR(x); counter1(target := x); A := x; END_FUNCTION "
        f"FUNCTION B : INT VAR x : STRING(5) := 'abc'; END_VAR {use} END_FUNCTION "
    )
    variables = "VAR_GLOBAL p : POINTER TO INT; END_VAR "
    bench = IecBench(COUNTER + functions + GLOBALS + variables + program("n : INT;", "n := A(); n := B();"))
    bench.cycle()
    fault = bench.thread.fault
    assert fault is not None
    assert (fault.code, fault.text) == ("pointer", "a pointer or VAR_IN_OUT to a variable of a call that has ended")
