"""The functions of Check.lib in a project: they are called before accesses that can go wrong (PD-202, PD-368)."""

import pytest
from iec_check import messages
from iec_program import IecBench, program

BOUNDS = """FUNCTION CheckBounds : DINT
VAR_INPUT index, lower, upper : DINT; END_VAR
IF index < lower THEN CheckBounds := lower;
ELSIF index > upper THEN CheckBounds := upper;
ELSE CheckBounds := index; END_IF;
END_FUNCTION
"""
DIVISION = """FUNCTION CheckDiv{size} : {kind}
VAR_INPUT divisor : {kind}; END_VAR
IF divisor = 0 THEN CheckDiv{size} := 1; ELSE CheckDiv{size} := divisor; END_IF;
END_FUNCTION
"""
RANGE = """FUNCTION CheckRange{sign} : {kind}
VAR_INPUT value, lower, upper : {kind}; END_VAR
CheckRange{sign} := LIMIT(lower, value, upper);
END_FUNCTION
"""
POINTER = """VAR_GLOBAL spare : INT := 77; size : DINT; writes : INT; END_VAR
FUNCTION CheckPointer : DWORD
VAR_INPUT address : DWORD; bytes : DINT; is_write : BOOL; END_VAR
size := bytes;
IF is_write THEN writes := writes + 1; END_IF;
IF address = 0 THEN CheckPointer := ADR(spare); ELSE CheckPointer := address; END_IF;
END_FUNCTION
"""


def ran(text: str) -> IecBench:
    bench = IecBench(text)
    bench.cycle()
    assert bench.thread.fault is None, bench.thread.fault
    return bench


@pytest.mark.manual("PD-202", "PD-368")
@pytest.mark.parametrize(("index", "first", "last"), [(-3, 5, 0), (1, 5, 0), (3, 0, 5), (40, 0, 5)])
def test_check_bounds_keeps_an_index_within_its_array(index: int, first: int, last: int) -> None:
    text = program(f"a : ARRAY[1..3] OF INT; i : INT := {index}; b : INT;", "a[i] := 5; b := a[i];")
    bench = ran(BOUNDS + text)
    assert (bench["a[1]"], bench["a[3]"], bench["b"]) == (first, last, 5)
    without = IecBench(text)
    without.cycle()
    assert (without.thread.fault is None) == (1 <= index <= 3)


def test_check_bounds_sees_each_dimension_with_its_own_limits() -> None:
    bench = ran(
        BOUNDS + program("a : ARRAY[1..2, 5..7] OF INT; i, j : INT := 100;", "a[i, j] := 5; a[i - 200, 5] := 6;")
    )
    assert (bench["a[2,7]"], bench["a[1,5]"]) == (5, 6)


@pytest.mark.manual("PD-202")
@pytest.mark.parametrize(
    ("size", "kind", "variable"),
    [
        ("Byte", "BYTE", "BYTE"), ("Byte", "BYTE", "SINT"), ("Word", "WORD", "INT"), ("Word", "WORD", "UINT"),
        ("DWord", "DWORD", "DINT"), ("DWord", "DWORD", "DWORD"), ("Real", "REAL", "REAL"),
    ],
)  # fmt: skip
def test_the_division_function_of_its_size_replaces_a_zero(size: str, kind: str, variable: str) -> None:
    divide = program(f"a, q : {variable} := 42; d, e : {variable}; r : {variable};", "e := a / d; d := 5; q := a / d;")
    bench = ran(DIVISION.format(size=size, kind=kind) + divide)
    assert bench["e"] == 42
    assert bench["q"] == (42 // 5 if variable != "REAL" else pytest.approx(8.4))


def test_a_negative_divisor_and_the_remainder_keep_their_meaning() -> None:
    text = DIVISION.format(size="Word", kind="WORD") + program(
        "a : INT := 42; d : INT := -5; n : INT; q, m, z : INT;", "q := a / d; m := a MOD d; z := a MOD n;"
    )
    bench = ran(text)
    assert (bench["q"], bench["m"], bench["z"]) == (-8, 2, 0)


@pytest.mark.parametrize(
    ("sign", "kind", "declared", "given", "expected"),
    [
        ("Signed", "DINT", "INT(-10..10)", "i : INT := 55", 10),
        ("Signed", "DINT", "INT(-10..10)", "i : INT := -55", -10),
        ("Unsigned", "UDINT", "UINT(5..10)", "i : UINT := 55", 10),
        ("Unsigned", "UDINT", "UINT(5..10)", "i : UINT := 7", 7),
    ],
)
def test_a_value_is_brought_into_its_subrange(sign: str, kind: str, declared: str, given: str, expected: int) -> None:
    bench = ran(RANGE.format(sign=sign, kind=kind) + program(f"r : {declared}; {given};", "r := i;"))
    assert bench["r"] == expected


def test_check_pointer_gets_address_size_and_direction() -> None:
    bench = ran(POINTER + program("p : POINTER TO INT; x : INT;", "x := p^; p^ := 3;"))
    assert (bench["x"], bench["spare"], bench["size"], bench["writes"]) == (77, 3, 2, 1)


def test_the_functions_are_not_called_within_themselves() -> None:
    text = """FUNCTION CheckBounds : DINT
    VAR_INPUT index, lower, upper : DINT; END_VAR
    VAR limits : ARRAY[0..1] OF DINT; i : DINT; END_VAR
    limits[i] := upper; CheckBounds := MIN(index, limits[i]);
    END_FUNCTION
    """
    assert ran(text + program("a : ARRAY[1..3] OF INT; i : INT := 9;", "a[i] := 5;"))["a[3]"] == 5


def test_a_function_with_other_inputs_is_refused() -> None:
    text = "FUNCTION CheckBounds : DINT VAR_INPUT index : DINT; END_VAR CheckBounds := index; END_FUNCTION\n"
    assert messages(text + program("a : ARRAY[1..3] OF INT; i : INT;", "a[i] := 5;"))[0].endswith(
        "CheckBounds has 1 input; 3 of elementary types, because it is called here as in Check.lib"
    )
