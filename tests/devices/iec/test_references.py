"""REFERENCE TO, REF_TO and UNION of edition 3."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from iec_check import messages, program
from iec_program import IecBench
from iec_program import program as whole_program

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, Dialect

TYPES = """
TYPE Point : STRUCT x, y : INT; END_STRUCT END_TYPE
TYPE Bytes : ARRAY[0..3] OF BYTE; END_TYPE
TYPE Mixed : UNION
    number : DWORD;
    single : REAL;
    bytes : Bytes;
    halves : ARRAY[0..1] OF INT;
END_UNION
END_TYPE
TYPE Outer : STRUCT head : INT; mixed : Mixed; END_STRUCT END_TYPE
FUNCTION_BLOCK Adder
VAR_INPUT total : REFERENCE TO DINT; step : INT; END_VAR
IF __ISVALIDREF(total) THEN
    total := total + step;
END_IF;
END_FUNCTION_BLOCK
FUNCTION Second : INT
VAR_INPUT point : REFERENCE TO Point; END_VAR
point.x := point.x + 1;
Second := point.y;
END_FUNCTION
"""


def bench_of(declarations: str, body: str) -> IecBench:
    text = f"{TYPES}\nPROGRAM PLC_PRG\nVAR\n{declarations}\nEND_VAR\n{body}\nEND_PROGRAM"
    bench = IecBench(text, EDITION_3)
    bench.cycle()
    return bench


# ---- references


def test_the_name_of_a_reference_means_what_it_refers_to() -> None:
    bench = bench_of(
        "r : REFERENCE TO INT; a : INT := 3; b : INT := 4; sum, size : INT; before, after : BOOL;",
        """before := __ISVALIDREF(r);
        r REF= a;
        r := r + 10;
        r REF= b;
        sum := a + r;
        size := SIZEOF(r);
        after := __ISVALIDREF(r);
        r REF= 0;""",
    )
    assert [bench[name] for name in ("a", "sum", "size", "before", "after")] == [13, 17, 2, False, True]
    assert bench["r"] == 0


def test_a_reference_reaches_components_elements_and_what_another_one_refers_to() -> None:
    bench = bench_of(
        "p : REFERENCE TO Point; list : ARRAY[1..3] OF Point; e, f : REFERENCE TO INT; n : INT;",
        """p REF= list[2];
        p.y := 7;
        e REF= p.y;
        f REF= e;
        f := f + 1;
        n := list[2].y;""",
    )
    assert bench["n"] == 8


def test_an_input_takes_a_reference_to_its_argument() -> None:
    bench = bench_of(
        "add : Adder; total : DINT; point : Point := (y := 5); n : INT;",
        "add(step := 1);\nadd(total := total, step := 3);\nadd(step := 4);\nn := Second(point);",
    )
    assert [bench[name] for name in ("total", "n", "point.x")] == [7, 5, 1]


def test_ref_is_the_address_of_a_variable_with_its_type() -> None:
    bench = bench_of("p : REF_TO INT; a : INT := 3; n : INT;", "p := REF(a);\np^ := p^ + 2;\nn := a;")
    assert bench["n"] == 5


def test_a_reference_to_nothing_is_a_fault() -> None:
    bench = bench_of("r : REFERENCE TO INT;", "r := 1;")
    assert "pointer to nothing" in str(bench.thread.fault)


@pytest.mark.parametrize(
    ("declarations", "statement", "message"),
    [
        (
            "r : REFERENCE TO INT; a : DINT;",
            "r REF= a;",
            "3:8 a is a DINT; a variable of type INT for the REFERENCE TO INT",
        ),
        ("a, b : INT;", "a REF= b;", "3:1 a is not a reference; a variable that is declared as REFERENCE TO"),
        ("r : REFERENCE TO BOOL; w : WORD;", "r REF= w.3;", "3:9 w.3 has no address of its own; a variable"),
        ("r : REFERENCE TO INT;", "r REF= 5;", "3:8 5 is a value; a variable"),
    ],
)
def test_what_cannot_be_referred_to_is_refused(declarations: str, statement: str, message: str) -> None:
    assert messages(program(declarations, statement), dialect=EDITION_3) == [message]


# ---- unions


def test_components_of_a_union_are_at_one_address() -> None:
    bench = bench_of(
        "m, copy : Mixed; o : Outer; size : INT; number : DWORD; low : BYTE; high : INT; r : REAL;",
        """size := SIZEOF(m);
        m.single := 1.0;
        number := m.number;
        m.halves[1] := -1;
        high := m.halves[1];
        o.mixed.number := 16#40490FDB;
        r := o.mixed.single;
        low := o.mixed.bytes[0];
        copy := o.mixed;""",
    )
    assert [bench[name] for name in ("size", "number", "high", "low")] == [4, 0x3F800000, -1, 0xDB]
    assert bench["r"] == struct.unpack("<f", bytes.fromhex("db0f4940"))[0]
    assert bench["copy.number"] == 0x40490FDB
    assert bench["copy.bytes[3]"] == 0x40
    assert bench["copy.single"] == bench["r"]
    bench["copy.single"] = 2.0
    assert bench["copy.number"] == 0x40000000


@given(st.integers(0, 2**32 - 1))
def test_a_union_has_the_bytes_of_any_number(number: int) -> None:
    bench = UNION_BENCH
    bench["m.number"] = number
    assert bytes(int(bench[f"m.bytes[{place}]"]) for place in range(4)) == number.to_bytes(4, "little")
    assert bench["m.halves[0]"] == int.from_bytes(number.to_bytes(4, "little")[:2], "little", signed=True)


UNION_BENCH = bench_of("m : Mixed;", "")


def test_a_union_has_only_data() -> None:
    text = "TYPE u : UNION t : TON; END_UNION END_TYPE"
    expected = "1:16 the instance t in a UNION; data without function blocks"
    assert messages(text, dialect=EDITION_3) == [expected]


WIDE = """
TYPE Wide : UNION
    number : LWORD;
    single : REAL;
    text : STRING(3);
    wide : WSTRING(2);
    bytes : ARRAY[1..8] OF BYTE;
    isOn : BOOL;
END_UNION
END_TYPE
TYPE Ready : UNION single : REAL := 1.0; low : INT := 5; wide : Wide; END_UNION END_TYPE
TYPE Holder : STRUCT head : INT := 9; ready : Ready := (single := 2.0); wide : Wide; END_STRUCT END_TYPE
FUNCTION Number : LWORD
Number := 16#0102;
END_FUNCTION
"""


@pytest.mark.parametrize("dialect", [EDITION_3, CODESYS], ids=lambda dialect: dialect.name)
@pytest.mark.parametrize(
    ("declaration", "first_bytes"),
    [
        ("u : Wide", "00 00 00 00 00 00 00 00"),
        ("u : Wide := (number := 16#0123456789ABCDEF)", "EF CD AB 89 67 45 23 01"),
        ("u : Wide := (single := -2.5)", "00 00 20 C0 00 00 00 00"),
        ("u : Wide := (text := 'abc')", "61 62 63 00 00 00 00 00"),
        ('u : Wide := (wide := "xy")', "78 00 79 00 00 00 00 00"),
        ("u : Wide := (bytes := [1, 2, 3, 4, 5, 6, 7, 8])", "01 02 03 04 05 06 07 08"),
        ("u : Wide := (isOn := TRUE)", "01 00 00 00 00 00 00 00"),
        ("u : Wide := (number := 16#FFFFFFFFFFFFFFFF, single := 0.0)", "00 00 00 00 FF FF FF FF"),
    ],
)
def test_a_start_value_of_one_component_is_in_all_of_a_union(
    dialect: Dialect, declaration: str, first_bytes: str
) -> None:
    bench = IecBench(WIDE + whole_program(f"{declaration};", ";"), dialect)
    assert bytes(int(bench[f"u.bytes[{place}]"]) for place in range(1, 9)) == bytes.fromhex(first_bytes)


def test_start_values_in_the_type_of_a_union_come_before_that_of_a_variable() -> None:
    bench = IecBench(
        WIDE
        + whole_program("a : Ready; b : Ready := (wide := (number := 7)); c : Holder; d : ARRAY[0..1] OF Ready;", ";"),
        CODESYS,
    )
    assert [bench[f"{name}.low"] for name in ("a", "b", "c.ready", "d[1]")] == [5, 7, 0, 5]
    assert (bench["a.wide.bytes[4]"], bench["c.head"], bench["c.ready.single"]) == (0x3F, 9, 2.0)


def test_a_union_of_a_function_and_a_computed_component_have_their_start_values() -> None:
    lower = "FUNCTION Lower : BYTE VAR u : Wide := (number := 16#0304); END_VAR Lower := u.bytes[2]; END_FUNCTION\n"
    bench = IecBench(
        WIDE + lower + whole_program("u : Wide := (number := Number()); low : BYTE;", "low := Lower();"), CODESYS
    )
    bench.cycle()
    assert (bench["u.bytes[2]"], bench["low"]) == (1, 3)


def test_the_words_are_names_in_epas() -> None:
    assert messages(program("union, reference, ref_to : INT;", "union := reference + ref_to;")) == []


GIVEN = """\
FUNCTION Twice : INT
VAR_IN_OUT v : INT; END_VAR
Twice := 2 * v;
END_FUNCTION
FUNCTION_BLOCK Gauge
VAR_IN_OUT a : INT; END_VAR
VAR_OUTPUT isGiven : BOOL; END_VAR
isGiven := __ISVALIDREF(a);
METHOD Five : INT
Five := 5;
END_METHOD
METHOD Asks : BOOL
Asks := __ISVALIDREF(a);
END_METHOD
METHOD Guarded : INT
Guarded := -1;
IF __ISVALIDREF(a) THEN Guarded := a; END_IF;
END_METHOD
METHOD Uses : INT
Uses := Twice(a);
END_METHOD
END_FUNCTION_BLOCK
"""


def test_a_method_that_needs_no_in_out_runs_before_the_block_has_one() -> None:
    body = "n := g.Five(); o := g.Asks(); m := g.Guarded(); g(a := x); p := g.Asks(); k := g.Guarded();"
    bench = IecBench(GIVEN + whole_program("g : Gauge; x : INT := 8; n, m, k : INT; o, p : BOOL;", body), CODESYS)
    bench.cycle()
    names = ("n", "o", "m", "p", "k", "g.isGiven")
    assert [bench[name] for name in names] == [5, False, -1, True, 8, True]


def test_a_method_that_uses_an_in_out_which_was_never_given_is_a_fault() -> None:
    bench = IecBench(GIVEN + whole_program("g : Gauge; n : INT;", "n := g.Uses();"), CODESYS)
    bench.cycle()
    assert "a VAR_IN_OUT that has never been given in Gauge.Uses" in str(bench.thread.fault)
