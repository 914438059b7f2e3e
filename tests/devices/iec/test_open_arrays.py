"""ARRAY[*] as an argument: what is refused, and what the tools around a program see of it.

The results of programs are in `programs/open-array-*.st`.
"""

import pytest
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect
from fieldrig_devices.opcua.symbols import SymbolsTree

OUTER = """
TYPE Row : ARRAY[1..3] OF INT; END_TYPE
FUNCTION Sum : INT
VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR
Sum := a[1];
END_FUNCTION
FUNCTION Read : INT
VAR_INPUT a : ARRAY[*] OF INT; END_VAR
Read := a[1];
END_FUNCTION
FUNCTION Fill
VAR_OUTPUT a : ARRAY[*] OF INT; END_VAR
a[1] := 1;
END_FUNCTION
FUNCTION_BLOCK Table
VAR_IN_OUT a : ARRAY[*, *] OF INT; END_VAR
VAR_OUTPUT first : INT; END_VAR
first := a[LOWER_BOUND(a, 1), LOWER_BOUND(a, 2)];
END_FUNCTION_BLOCK
"""
VARIABLES = "n : INT; r : REAL; one : Row; two : ARRAY[1..2, 1..2] OF INT; reals : Row2; t : Table; d : DINT := 1;"
ROW2 = """TYPE Row2 : ARRAY[1..3] OF REAL; END_TYPE
VAR_GLOBAL CONSTANT fixed : Row := [1, 2, 3]; pages : ARRAY[1..1] OF Row; END_VAR
"""


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("n := Sum(two);", "two is an ARRAY[1..2] OF ARRAY[1..2] OF INT; expected a variable of type ARRAY[*] OF INT"),
        (
            "n := Sum(reals);",
            "reals is an ARRAY[1..3] OF REAL; expected a variable of type ARRAY[*] OF INT for the VAR_IN_OUT",
        ),
        ("n := Sum(n);", "n is an INT; expected a variable of type ARRAY[*] OF INT for the VAR_IN_OUT a"),
        ("n := Sum(fixed);", "fixed is a constant and a may be changed"),
        ("n := Sum(pages[1]);", "pages[1] is a constant and a may be changed"),
        ("n := Sum();", "the argument a is missing in the call of Sum"),
        ("n := Read(3);", "3 is passed to the VAR_INPUT a; expected a variable"),
        ("Fill();", "the output a is missing in the call of Fill; expected a => array"),
        ("Fill(a => fixed);", "fixed is a constant and a may be changed"),
        ("t(a := one);", "one is an ARRAY[1..3] OF INT; expected a variable of type ARRAY[*] OF ARRAY[*] OF INT"),
        ("t();", "the argument a is missing in the call of Table"),
        ("n := LOWER_BOUND(n, 1);", "n is an INT; expected an array"),
        ("n := UPPER_BOUND(two, 3);", "two has no dimension 3; expected 1 to 2"),
        ("n := UPPER_BOUND(one, d);", "d is not constant; expected a value that is known at compile time"),
        ("n := UPPER_BOUND(one, 1.0);", "1.0 is a REAL; expected an integer"),
        ("n := UPPER_BOUND(one);", "UPPER_BOUND with other arguments than its own; expected UPPER_BOUND(array, 1)"),
        ("n := UPPER_BOUND(A := one, DIM := 1);", "UPPER_BOUND with other arguments than its own"),
        ("UPPER_BOUND(one, 1);", "the result of UPPER_BOUND is not used"),
    ],
)
def test_a_wrong_argument_has_one_message(body: str, expected: str) -> None:
    found = refused(ROW2 + OUTER + program(VARIABLES, body), EDITION_3)
    assert sum("note:" not in message for message in found) == 1, found
    assert any(expected in message for message in found), found


@pytest.mark.parametrize(
    ("declared", "body", "expected"),
    [
        ("VAR_INPUT a : ARRAY[*] OF INT; END_VAR", "a[1] := 2;", "a is a VAR_INPUT, of which there is no copy"),
        (
            "VAR_INPUT a : ARRAY[*] OF INT; END_VAR",
            "f := Sum(a);",
            "a is a part of the VAR_INPUT, of which there is no copy,",
        ),
        (
            "VAR_IN_OUT a, b : ARRAY[*] OF INT; END_VAR",
            "a := b;",
            "b is an ARRAY[*] OF INT and has no value as a whole",
        ),
        (
            "VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR VAR b : Row; END_VAR",
            "b := a;",
            "has no value as a whole; expected an element",
        ),
        (
            "VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR VAR b : Row; END_VAR",
            "a := b;",
            "b is an ARRAY[1..3] OF INT; expected ARRAY[*]",
        ),
        (
            "VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR VAR p : REF_TO INT; END_VAR",
            "p := REF(a);",
            "a is an ARRAY[*] OF INT; expected an element of it",
        ),
        ("VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR", "f := a[1, 2];", "the array a has 1 dimension; expected 1 index"),
        ("VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR", "f := a['x'];", "the index is a STRING(1); expected an integer"),
        (
            "VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR VAR r : REAL; END_VAR",
            "f := UPPER_BOUND(a, r);",
            "the dimension is a REAL",
        ),
        ("VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR", "f := UPPER_BOUND(a, 2);", "a has no dimension 2; expected 1"),
        ("VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR", "f := a.x;", "a is an ARRAY[*] OF INT and has no components"),
        ("VAR_INPUT a : ARRAY[*] OF INT := [1]; END_VAR", "", "the VAR_INPUT a has a start value"),
        ("VAR_INPUT a : ARRAY[*] OF Table; END_VAR", "", "the instance a of Table in a function"),
        ("VAR_IN_OUT a : ARRAY[*, *, *, *] OF INT; END_VAR", "", "an array of 4 dimensions; expected 1 to 3"),
        (
            "VAR a : ARRAY[*] OF INT; END_VAR",
            "",
            "ARRAY[*] is no type of a variable here; expected limits such as ARRAY[1..10]",
        ),
        ("VAR_IN_OUT a : ARRAY[1..2] OF ARRAY[*] OF INT; END_VAR", "", "ARRAY[*] is no type of a variable here"),
        ("VAR_IN_OUT a : POINTER TO ARRAY[*] OF INT; END_VAR", "", "ARRAY[*] is no type of a variable here"),
        ("VAR_IN_OUT a : ARRAY[*, 1..2] OF INT; END_VAR", "", "expected *"),
    ],
)
def test_what_the_body_of_a_function_may_not_do(declared: str, body: str, expected: str) -> None:
    function = f"FUNCTION f : INT {declared} {body} END_FUNCTION "
    found = refused(ROW2 + OUTER + function + program("", ""), EDITION_3)
    assert sum("note:" not in message for message in found) == 1, found
    assert any(expected in message for message in found), found


@pytest.mark.parametrize(
    "text",
    [
        "FUNCTION_BLOCK b VAR_INPUT a : ARRAY[*] OF INT; END_VAR END_FUNCTION_BLOCK ",
        "TYPE T : ARRAY[*] OF INT; END_TYPE ",
        "VAR_GLOBAL a : ARRAY[*] OF INT; END_VAR ",
        "PROGRAM p VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR END_PROGRAM ",
        "FUNCTION f : ARRAY[*] OF INT END_FUNCTION ",
    ],
)
def test_an_array_without_limits_is_only_an_argument(text: str) -> None:
    found = refused(text + program("", ""), EDITION_3)
    assert any("ARRAY[*] is no type of a variable here" in message for message in found), found


@pytest.mark.parametrize("dialect", [EPAS_4], ids=lambda dialect: dialect.name)
def test_the_dialect_of_the_manual_names_the_one_that_has_it(dialect: Dialect) -> None:
    found = refused("FUNCTION f : INT VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR END_FUNCTION " + program("", ""), dialect)
    assert "got *; expected limits such as 1..10" in found[0]
    assert "ARRAY[*] is known in the dialect edition-3." in found[0]


def test_a_project_of_the_manuals_dialect_may_have_functions_of_these_names() -> None:
    text = "FUNCTION UPPER_BOUND : INT VAR_INPUT x : INT; END_VAR UPPER_BOUND := x + 1; END_FUNCTION "
    for dialect in (EPAS_4, EDITION_3):
        bench = IecBench(text + program("n : INT;", "n := UPPER_BOUND(4);"), dialect)
        bench.cycle()
        assert bench["n"] == 5


def test_check_bounds_gets_the_limits_of_the_argument() -> None:
    check = """FUNCTION CheckBounds : DINT
    VAR_INPUT index, lower, upper : DINT; END_VAR
    CheckBounds := LIMIT(lower, index, upper);
    END_FUNCTION
    FUNCTION Get : INT
    VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR
    VAR_INPUT i : INT; END_VAR
    Get := a[i];
    END_FUNCTION
    FUNCTION Third : INT
    VAR_IN_OUT a : ARRAY[*] OF INT; END_VAR
    Third := a[3];
    END_FUNCTION
    """
    body = "n[1] := Get(a, 9); n[2] := Get(a, -9); n[3] := Get(b, 1); n[4] := Third(b);"
    declarations = "a : ARRAY[1..3] OF INT := [4, 5, 6]; b : ARRAY[0..1] OF INT := [7, 8]; n : ARRAY[1..4] OF INT;"
    bench = IecBench(check + program(declarations, body), EDITION_3)
    bench.cycle()
    assert [bench[f"n[{number}]"] for number in range(1, 5)] == [6, 4, 8, 8]


def test_an_input_at_an_address_is_read_and_not_written_back() -> None:
    """A value that arrives during the call stays."""
    late = OUTER.replace("Read := a[1];", "Read := a[1]; late := 99;")
    declarations = "n : INT; w AT %MW4 : ARRAY[1..2] OF INT; END_VAR VAR_EXTERNAL late : INT;"
    shared = "VAR_GLOBAL late AT %MW4 : INT; END_VAR "
    bench = IecBench(shared + late + program(declarations, "w[1] := 7; n := Read(w);"), EDITION_3)
    bench.cycle()
    assert (bench["n"], bench["late"], bench["w[1]"]) == (7, 99, 99)


def test_an_array_behind_a_pointer_must_have_the_form_that_it_says() -> None:
    body = "p := ADR({}); n := Sum(p^);"
    declarations = "n : INT; good : Row := [5, 6, 7]; bad : ARRAY[1..3] OF REAL; p : POINTER TO Row;"
    bench = IecBench(OUTER + program(declarations, body.format("good")), EDITION_3)
    bench.cycle()
    assert bench["n"] == 5
    bench = IecBench(OUTER + program(declarations, body.format("bad")), EDITION_3)
    bench.cycle()
    assert bench.thread.fault is not None


def test_a_function_block_keeps_its_array_and_clients_see_no_hidden_limits() -> None:
    body = "t(a := two); n := t.first;"
    bench = IecBench(ROW2 + OUTER + program(VARIABLES, body), CODESYS)
    bench["two[1,1]"] = 12
    bench.cycle()
    assert bench["n"] == 12
    tree = SymbolsTree(bench.runtime.symbols, bench.runtime)
    assert [node.name for node in tree.children("PLC_PRG.t")] == ["a", "first"]
    assert tree.children("PLC_PRG.t.a") == []


def test_an_accumulator_of_il_is_hidden_from_clients() -> None:
    bench = IecBench(program("a, b : INT;", "LD a\nADD 1\nST a\nST b\n"))
    tree = SymbolsTree(bench.runtime.symbols, bench.runtime)
    assert [node.name for node in tree.children("PLC_PRG")] == ["a", "b"]


def test_the_size_of_an_open_array_is_that_of_the_array_that_is_passed() -> None:
    text = """\
FUNCTION Size : UDINT
VAR_IN_OUT a : ARRAY[*, *] OF INT; END_VAR
Size := SIZEOF(a);
END_FUNCTION
FUNCTION Outer : UDINT
VAR_IN_OUT a : ARRAY[*, *] OF INT; END_VAR
Outer := Size(a) * 10 + SIZEOF(a[LOWER_BOUND(a, 1), 0]);
END_FUNCTION
"""
    bench = IecBench(
        text + program("x : ARRAY[3..4, -1..1] OF INT; n, m : UDINT;", "n := Size(x); m := Outer(x);"), CODESYS
    )
    bench.cycle()
    assert (bench["n"], bench["m"]) == (12, 122)


CLEAR = """\
FUNCTION Clear : BOOL
VAR_IN_OUT list : ARRAY[*] OF INT; END_VAR
VAR size : UDINT; END_VAR
size := MEMSET(destAddr := list, fillByte := 255, n := SIZEOF(list));
Clear := TRUE;
END_FUNCTION
"""


def test_an_open_array_is_its_address_where_one_is_expected() -> None:
    bench = IecBench(CLEAR + program("x : ARRAY[3..5] OF INT; after : INT; b : BOOL;", "b := Clear(x);"), CODESYS)
    bench.cycle()
    assert (bench["x[3]"], bench["x[5]"], bench["after"]) == (-1, -1, 0)


def test_an_open_array_is_no_number_where_none_is_expected() -> None:
    text = CLEAR.replace("fillByte := 255", "fillByte := list")
    messages = refused(text + program("x : ARRAY[3..5] OF INT; b : BOOL;", "b := Clear(x);"), CODESYS)
    assert "list is an ARRAY[*] OF INT and has no value as a whole" in messages[0]
