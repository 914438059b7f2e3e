"""The checker's decisions, seen in running programs: literals, mixed signs, loops over enumerations, times."""

import pytest
from iec_program import IecBench


def run(declarations: str, body: str, before: str = "") -> IecBench:
    bench = IecBench(f"{before}\nPROGRAM PLC_PRG\nVAR {declarations} END_VAR\n{body}\nEND_PROGRAM")
    bench.cycle()
    return bench


@pytest.mark.manual("PD-359")
def test_a_loop_over_an_enumeration_with_a_changed_variable() -> None:
    traffic = "TYPE TrafficLights : (red, yellow, green := 10); END_TYPE"
    bench = run("i, passes : INT;", "FOR i := red TO green DO i := i + 1; passes := passes + 1; END_FOR", traffic)
    assert (bench["passes"], bench["i"]) == (6, 12)  # PD-L05


def test_a_comparison_of_signed_and_unsigned_values_is_right() -> None:
    bench = run("i : INT := -5; u : UINT := 40000; a, b : BOOL;", "a := i < u; b := u = -25536;")
    assert (bench["a"], bench["b"]) == (True, False)


def test_a_literal_widens_an_operation_that_it_does_not_fit() -> None:
    bench = run("i : INT := 30000; small, large : DINT;", "small := i + 30000; large := i + 40000;")
    assert (bench["small"], bench["large"]) == (60000, 70000)  # a 32-bit target adds in 32 bits


def test_a_loop_of_an_unsigned_variable_counts_down() -> None:
    bench = run("b : BYTE; n : INT;", "FOR b := 10 TO 5 BY -1 DO n := n + 1; END_FOR")
    assert bench["n"] == 6


def test_times_and_dates() -> None:
    bench = run(
        "t : TIME; d : DT; e : TIME;",
        "t := T#1s * 2.5; d := DT#1970-01-01-00:00:10 + t; e := d - DT#1970-01-01-00:00:02;",
    )
    assert (bench["t"], bench["d"], bench["e"]) == (2_500, 12, 10_000)


def test_hexadecimal_literals_are_bit_patterns() -> None:
    bench = run("i : INT; b : BOOL;", "i := 16#FFFF; b := i = 16#FFFF;")
    assert (bench["i"], bench["b"]) == (-1, True)


def test_a_block_of_the_project_and_the_library_that_uses_the_same_name() -> None:
    block = (
        "FUNCTION_BLOCK TP VAR_INPUT mine : BOOL; END_VAR VAR_OUTPUT q : INT; END_VAR q := q + 1; END_FUNCTION_BLOCK"
    )
    bench = run("t : TP; k : INT; b : BLINK;", "t(mine := TRUE); k := t.q; b(ENABLE := TRUE);", block)
    assert bench["k"] == 1


@pytest.mark.manual("PD-352")
def test_a_located_word_is_passed_by_its_address() -> None:
    block = "FUNCTION_BLOCK B VAR_IN_OUT r : INT; END_VAR r := r + 1; END_FUNCTION_BLOCK"
    assert run("x AT %MW5 : INT; y : INT; i : B;", "x := 4; i(r := x); y := %MW5;", block)["y"] == 5
