"""The classes of variables in a program that runs (manual 971-996)."""

import pytest
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect

PROGRAM = """
VAR_GLOBAL gTotal : DINT := 100; END_VAR
FUNCTION_BLOCK Counter
VAR_INPUT step : INT := 5; END_VAR
VAR_OUTPUT count : INT; END_VAR
VAR_IN_OUT shared : INT; END_VAR
VAR_EXTERNAL gTotal : DINT; END_VAR
VAR CONSTANT LIMIT : INT := 12; END_VAR
VAR calls : INT; END_VAR
calls := calls + 1;
IF count + step <= LIMIT THEN count := count + step; END_IF
shared := shared + count;
gTotal := gTotal + step;
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR first, second : Counter; own : INT := 1000; other : INT := -1; lamp AT %QB4 : BYTE; seen : BYTE; END_VAR
first(shared := own);
second(step := 2, shared := other);
lamp := 16#A5;
seen := %QB4;
END_PROGRAM
"""


@pytest.mark.manual("PD-351")
def test_each_class_of_variables_keeps_and_shares_what_it_has_to() -> None:
    bench = IecBench(PROGRAM)
    bench.cycle(3)
    assert [bench[name] for name in ("first.count", "second.count")] == [10, 6]  # 12 limits the first one
    assert [bench[name] for name in ("first.calls", "second.calls")] == [3, 3]
    assert (bench["own"], bench["other"]) == (1000 + 5 + 10 + 10, -1 + 2 + 4 + 6)  # VAR_IN_OUT is the caller's variable
    assert bench["gTotal"] == 100 + 3 * (5 + 2)  # VAR_EXTERNAL is the global one
    assert [bench[name] for name in ("first.step", "second.step")] == [5, 2]
    assert (bench["lamp"], bench["seen"]) == (0xA5, 0xA5)


OUTSIDE = """FUNCTION_BLOCK B
VAR CONSTANT c : INT := 4; a : ARRAY[0..2] OF INT := 1, 2, 3; END_VAR
VAR_IN_OUT r : INT; END_VAR
r := c;
END_FUNCTION_BLOCK
"""


@pytest.mark.manual("PD-351")
@pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3, CODESYS])
@pytest.mark.parametrize("statement", ["x := i.r;", "i.r := 4;"])
def test_a_variable_of_the_caller_is_not_known_outside_the_block(dialect: Dialect, statement: str) -> None:
    text = OUTSIDE + program("i : B; x : INT;", f"i(r := x);\n{statement}")
    assert any("r is a VAR_IN_OUT of B and not known outside" in message for message in refused(text, dialect))


@pytest.mark.manual("PD-351")
@pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3, CODESYS])
@pytest.mark.parametrize("statement", ["i.c := 3;", "i.a[1] := 3;", "i.a := z;"])
def test_a_constant_of_a_block_is_written_nowhere(dialect: Dialect, statement: str) -> None:
    text = OUTSIDE
    text += program("i : B; x : INT; z : ARRAY[0..2] OF INT;", f"i(r := x);\n{statement}")
    expected = "is a constant" if dialect is CODESYS else "is a VAR of B and not known outside"
    assert any(expected in message for message in refused(text, dialect))
    inside = OUTSIDE.replace("r := c;", statement.replace("i.", "").replace(":= z", ":= a"))
    assert any("is a constant" in message for message in refused(inside + program("i : B;", "i();"), dialect))


@pytest.mark.manual("PD-351")
@pytest.mark.parametrize("given", ["4", "k", "x + 1"])
def test_a_variable_in_and_out_takes_nothing_that_cannot_be_written(given: str) -> None:
    constant = "VAR_GLOBAL CONSTANT k : INT := 2; END_VAR\n"
    text = constant + OUTSIDE + program("i : B; x : INT;", f"i(r := {given});")
    assert any("is passed to the VAR_IN_OUT r" in message for message in refused(text, EPAS_4))


CONSTANT_INPUT = """FUNCTION Twice : INT
VAR_IN_OUT a : INT; END_VAR
a := 2 * a;
Twice := a;
END_FUNCTION
FUNCTION_BLOCK Scale
VAR_INPUT CONSTANT factor : INT := 3; row : ARRAY[0..1] OF INT; END_VAR
VAR_OUTPUT y : INT; END_VAR
{body}
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR scale : Scale; x, y : INT; END_VAR
scale.factor := 5;
x := scale.factor;
scale(factor := 4);
y := scale.y;
END_PROGRAM
"""


@pytest.mark.parametrize(
    "body",
    [
        "factor := 4;",
        "factor := factor + 1;",
        "row[1] := 4;",
        "y := Twice(factor);",
        "FOR factor := 1 TO 2 DO ; END_FOR",
    ],
)
def test_a_constant_input_is_only_read_in_its_block(body: str) -> None:
    (message,) = [text for text in refused(CONSTANT_INPUT.format(body=body), CODESYS) if "note" not in text]
    assert "constant" in message


def test_a_constant_input_is_given_from_outside() -> None:
    bench = IecBench(CONSTANT_INPUT.format(body="y := 10 * factor;"), CODESYS)
    bench.cycle()
    assert (bench["x"], bench["y"]) == (5, 40)


@pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3, CODESYS])
def test_a_constant_of_a_program_is_read_from_outside(dialect: Dialect) -> None:
    """It is a constant there too, which a label of CASE needs."""
    text = """PROGRAM Other
VAR CONSTANT limit : INT := 7; END_VAR
VAR_OUTPUT y : INT; END_VAR
y := limit;
END_PROGRAM
PROGRAM PLC_PRG
VAR x, y : INT; END_VAR
x := Other.limit;
CASE x OF Other.limit: y := 1; END_CASE
END_PROGRAM
"""
    bench = IecBench(text, dialect)
    bench.cycle()
    assert (bench["x"], bench["y"]) == (7, 1)
