"""Instances of function blocks as values: copied, passed as inputs, and given as results (CODESYS V3 and TwinCAT 3)."""

import pytest
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect

COUNTER = """
FUNCTION_BLOCK Counter
VAR n : INT := 1; END_VAR
METHOD Set VAR_INPUT to_ : INT; END_VAR n := to_; END_METHOD
METHOD Get : INT Get := n; END_METHOD
METHOD Next : Counter Next.Set(n + 1); END_METHOD
END_FUNCTION_BLOCK
FUNCTION Doubled : INT VAR_INPUT a : Counter; END_VAR a.Set(2 * a.Get()); Doubled := a.Get(); END_FUNCTION
FUNCTION Made : Counter VAR_INPUT n : INT; END_VAR Made.Set(n); END_FUNCTION
"""


def test_a_copy_has_a_life_of_its_own() -> None:
    text = COUNTER + program("a, b : Counter; x, y : INT;", "a.Set(5); b := a; a.Set(7); x := a.Get(); y := b.Get();")
    bench = IecBench(text, CODESYS)
    bench.cycle()
    assert (bench["x"], bench["y"]) == (7, 5)


def test_an_input_is_a_copy() -> None:
    bench = IecBench(COUNTER + program("a : Counter; x, y : INT;", "a.Set(5); x := Doubled(a); y := a.Get();"), CODESYS)
    bench.cycle()
    assert (bench["x"], bench["y"]) == (10, 5)


def test_a_result_is_an_instance_with_methods() -> None:
    text = COUNTER + program(
        "a, b : Counter; x, y, z : INT;",
        "x := Made(3).Next().Get(); a := Made(8); b := a.Next(); y := a.Get(); z := b.Get() + Made(1).Get();",
    )
    bench = IecBench(text, CODESYS)
    bench.cycle()
    assert (bench["x"], bench["y"], bench["z"]) == (4, 8, 10)


@pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3])
def test_other_dialects_refuse_a_copy(dialect: Dialect) -> None:
    text = "FUNCTION_BLOCK Lamp VAR n : INT; END_VAR END_FUNCTION_BLOCK\n" + program("a, b : Lamp;", "a := b;")
    assert any("cannot be copied" in message for message in refused(text, dialect))
