"""__TRY, __CATCH and __FINALLY (the public descriptions of CODESYS V3 and TwinCAT 3).

What a program sees of them is in `programs/exceptions.st`.
"""

import pickle
from pathlib import Path

import pytest
from covered import coverage, missed
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.printer import print_unit
from fieldrig_devices.iec.runtime import Runtime

TEXT = (Path(__file__).parent / "programs" / "exceptions.st").read_text(encoding="ascii")


def test_single_steps_come_to_the_same_values_as_the_fast_code() -> None:
    fast, stepped = IecBench(TEXT, CODESYS), IecBench(TEXT, CODESYS)
    fast.cycle()
    stepped.thread.look_on((lambda: None, lambda: None))
    stepped.cycle()
    assert stepped.values() == fast.values()


@pytest.mark.parametrize("budget_ns", [1, 700, 20_000])
def test_a_slice_may_end_anywhere(budget_ns: int) -> None:
    whole, sliced = IecBench(TEXT, CODESYS), IecBench(TEXT, CODESYS)
    whole.cycle()
    sliced.cycle(budget_ns=budget_ns)
    assert sliced.values() == whole.values()


def test_code_that_another_process_has_made_still_catches() -> None:
    bench = IecBench(TEXT, CODESYS)
    bench.compiled = pickle.loads(pickle.dumps(bench.compiled))
    bench.runtime = Runtime(bench.compiled, bench.host)
    bench.thread = bench.runtime.thread(bench.compiled.program.pous["plc_prg"])
    bench.cycle()
    assert bench.thread.fault is None
    assert bench["caught"] == 111


def test_a_fault_without_a_handler_stops_the_task_behind_finally() -> None:
    bench = IecBench(program("a, b : INT;", "__TRY a := 1 / a;\n__FINALLY b := 2;\n__ENDTRY"), CODESYS)
    bench.cycle()
    assert bench["b"] == 2
    assert bench.thread.fault is not None
    assert bench.thread.fault.code == "division"


def test_a_caught_fault_leaves_what_follows_it_uncovered() -> None:
    text = (
        "PROGRAM PLC_PRG VAR a, b : INT; END_VAR\n__TRY\na := 1 / a;\nb := 1;\n__CATCH\nb := 2;\n__ENDTRY\nEND_PROGRAM"
    )
    with coverage() as seen:
        bench = IecBench(text, CODESYS)
        bench.cycle()
        assert missed(seen()) == [(4, "")]


def test_a_breakpoint_in_a_handler_stops_there() -> None:
    bench = IecBench(program("a : INT;", "__TRY\na := 1 / a;\n__CATCH\na := 2;\n__ENDTRY\na := 3;"), CODESYS)
    assert bench.runtime.break_at({"main.st": {8}}) == {"main.st": {8}}
    bench.cycle()
    at = bench.thread.at
    assert at is not None
    assert (at.line, bench["a"]) == (8, 0)
    bench.thread.go_on()
    bench.thread.run(1_000_000)
    assert bench["a"] == 3


def test_the_printed_program_is_the_same() -> None:
    unit, _ = parse(TEXT, "main.st", CODESYS)
    printed = print_unit(unit)
    assert print_unit(parse(printed, "main.st", CODESYS)[0]) == printed
    first, second = IecBench(TEXT, CODESYS), IecBench(printed, CODESYS)
    first.cycle()
    second.cycle()
    assert second.values() == first.values()


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("__TRY a := 1; __ENDTRY", "got __ENDTRY; expected __CATCH or __FINALLY for the __TRY"),
        ("__TRY a := 1; __CATCH(b) ; __ENDTRY", "b is a BOOL; expected a variable of type __SYSTEM.ExceptionCode"),
        ("__TRY a := 1; __CATCH ; a := 2;", "__ENDTRY for the __TRY in line"),
        ("a := 1; __ENDTRY", "no __TRY is open here"),
        ("JMP x; __TRY x: a := 1; __CATCH ; __ENDTRY", "JMP x leads into or out of a __TRY"),
        ("__TRY JMP x; __CATCH x: ; __ENDTRY", "JMP x leads into or out of a __TRY"),
    ],
)
def test_mistakes_are_named(body: str, said: str) -> None:
    assert said in "\n".join(refused(program("a : INT; b : BOOL;", body), CODESYS))


def test_another_dialect_says_once_that_it_has_none() -> None:
    _, said = refused(program("a : INT;", "__TRY a := 1; __CATCH ; __FINALLY ; __ENDTRY"), EDITION_3)
    assert said.splitlines()[1] == "  hint: The dialect codesys has it."
