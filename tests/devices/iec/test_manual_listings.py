"""The listings of the manual in Structured Text, with the results that the digest states (section 2.1)."""

from dataclasses import replace

import pytest
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import EPAS_4
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.types import Value

Results = dict[str, Value]

# Listing, declarations, body, results after one cycle.
LISTINGS: list[tuple[str, str, str, Results]] = [
    ("PD-L01", "str : STRING(35) := 'This is a String';", "", {"str": "This is a String"}),
    (
        "PD-L02",
        """arr1 : ARRAY [1..5] OF INT := 1,2,3,4,5;
        arr2 : ARRAY [1..2,3..4] OF INT := 1,3(7);
        arr3 : ARRAY [1..2,2..3,3..4] OF INT := 2(0),4(4),2,3;""",
        "",
        {
            **{f"arr1[{number}]": number for number in range(1, 6)},
            "arr2[1,3]": 1, "arr2[1,4]": 7, "arr2[2,3]": 7, "arr2[2,4]": 7,
            "arr3[1,2,3]": 0, "arr3[1,3,3]": 4, "arr3[2,2,4]": 4, "arr3[2,3,3]": 2, "arr3[2,3,4]": 3,
        },
    ),
    (
        "PD-L03",
        "CardGame : ARRAY [1..13, 1..4] OF INT; card : INT;",
        "CardGame[9, 2] := 5; card := CardGame[9, 2];",
        {"card": 5, "CardGame[9,2]": 5, "CardGame[9,1]": 0, "CardGame[10,2]": 0},
    ),
    (
        "PD-L04",
        "pt : POINTER TO INT; var_int1 : INT := 5; var_int2 : INT;",
        "pt := ADR(var_int1); var_int2 := pt^;",
        {"var_int2": 5},
    ),
    ("PD-L17", "value : INT := 3;", "IF value < 7 THEN WHILE value < 8 DO value := value + 1; END_WHILE; END_IF;",
     {"value": 8}),
    ("PD-L17", "value : INT := 7;", "IF value < 7 THEN WHILE value < 8 DO value := value + 1; END_WHILE; END_IF;",
     {"value": 7}),
    ("PD-L18", "A, B : INT := 4; CV : INT := 3; C, X : REAL;", "A := B; CV := CV + 1; C := SIN(X);;",
     {"A": 4, "CV": 4, "C": 0.0}),
    ("PD-L18", "A : INT := 1; B, C, D : INT;",
     "D := B*B; IF D<0 THEN C:=A; ELSIF D=0 THEN C:=2; ELSE C:=D; END_IF;", {"C": 2}),
    ("PD-L18", "INT1 : INT := 2; BOOL1, BOOL2 : BOOL := TRUE;",
     "CASE INT1 OF 1: BOOL1 := TRUE; 2: BOOL2 := FALSE; ELSE BOOL1 := FALSE; BOOL2 := FALSE; END_CASE;",
     {"BOOL1": True, "BOOL2": False}),
    ("PD-L18", "I, J : INT; ARR : ARRAY[1..100] OF INT := 40(0), 70, 59(0);",
     "J:=101; FOR I:=1 TO 100 BY 2 DO IF ARR[I] = 70 THEN J:=I; EXIT; END_IF; END_FOR;", {"J": 41, "I": 41}),
    ("PD-L18", "J : INT; ARR : ARRAY[1..101] OF INT := 40(0), 70, 60(0);",
     "J:=1; WHILE J<= 100 AND ARR[J] <> 70 DO J:=J+2; END_WHILE;", {"J": 41}),
    ("PD-L18", "J : INT; ARR : ARRAY[1..101] OF INT;",
     "J:=1; REPEAT J:=J+2; UNTIL J= 101 OR ARR[J] = 70 END_REPEAT;", {"J": 101}),
    ("PD-L20", "Counter : INT := 5; Var1 : INT := 3; Erg : INT;",
     "WHILE Counter<>0 DO Var1:=Var1*2; Counter:=Counter-1; END_WHILE Erg:=Var1;", {"Erg": 96, "Counter": 0}),
    ("PD-L22", "a : INT := 1; b : BOOL := TRUE;", "IF b THEN RETURN; END_IF; a := 2;", {"a": 1}),
    ("PD-L22", "temp : INT := 16; heating : BOOL;", "IF temp < 17 THEN heating := TRUE; ELSE heating := FALSE; END_IF;",
     {"heating": True}),
    ("PD-L23", "INT1 : INT := 5; BOOL1, BOOL2, BOOL3 : BOOL;",
     ("CASE INT1 OF 1, 5: BOOL1 := TRUE; BOOL3 := FALSE; 2: BOOL2 := FALSE; BOOL3 := TRUE;"
     " ELSE BOOL1 := NOT BOOL1; BOOL2 := BOOL1 OR BOOL2; END_CASE;"),
     {"BOOL1": True, "BOOL2": False, "BOOL3": False}),
    ("PD-L24", "Counter : INT; Var1 : INT := 1; Erg : INT;",
     "FOR Counter:=1 TO 5 BY 1 DO Var1:=Var1*2; END_FOR; Erg:=Var1;", {"Erg": 32, "Counter": 6}),
    ("PD-L25", "Counter : INT := 4; Var1 : INT := 1;",
     "WHILE Counter<>0 DO Var1 := Var1*2; Counter := Counter-1; END_WHILE", {"Var1": 16}),
    ("PD-L25", "Counter : INT := 4; Var1 : INT := 1;",
     "REPEAT Var1 := Var1*2; Counter := Counter-1; UNTIL Counter=0 END_REPEAT", {"Var1": 16}),
    ("PD-L27", "a, b, c, d, e : INT; t : TIME;",
     "a := 7+2+4+7; b := 7*2*4*7; c := 7-2; d := 8/2; e := 9 MOD 2; t := T#45s + T#50s;",
     {"a": 20, "b": 392, "c": 5, "d": 4, "e": 1, "t": 95_000}),
    ("PD-L28", "a : ARRAY[0..4] OF INT; size : INT; pt : POINTER TO INT; second : INT;",
     "size := SIZEOF(a); a[1] := 7; pt := ADR(a); pt := ADR(pt^) + SIZEOF(INT); second := pt^;",
     {"size": 10, "second": 7}),
    ("PD-L29", "a, o, x, n : BYTE; v1 : BYTE := 2#1001_0011; v2 : BYTE := 2#1000_1010;",
     "a := v1 AND v2; o := v1 OR v2; x := v1 XOR v2; n := NOT v1;",
     {"a": 0b1000_0010, "o": 0b1001_1011, "x": 0b0001_1001, "n": 0b0110_1100}),
    ("PD-L30", "r : BYTE; one : BYTE := 1;", "r := SHL(one, 1);", {"r": 2}),
    ("PD-L31", "r : BYTE; v : BYTE := 32;", "r := SHR(v, 2);", {"r": 8}),
    ("PD-L32", "l, r : BYTE; v : BYTE := 2#1001_0011;", "l := ROL(v, 3); r := ROR(v, 3);",
     {"l": 0b1001_1100, "r": 0b0111_0010}),
    ("PD-L33", "s, t, a, i, l, m : INT;",
     ("s := SEL(TRUE, 3, 4); t := SEL(FALSE, 3, 4); a := MAX(90, MAX(30, MAX(40, 77))); i := MIN(90, 30, 40, 77);"
     " l := LIMIT(30, 90, 80); m := MUX(0, 30, 40, 50, 60, 70, 80);"),
     {"s": 4, "t": 3, "a": 90, "i": 30, "l": 80, "m": 30}),
    ("PD-L34", "a, b, c, d, e, f : BOOL; x : INT := 20; y : INT := 30;",
     "a := x > y; b := x < y; c := x <= y; d := x >= 20; e := x = 20; f := x <> 20;",
     {"a": False, "b": True, "c": True, "d": True, "e": True, "f": False}),
    ("PD-L37", "i : INT; s : STRING; t : TIME; o : TOD; d : DATE; dt1 : DT;",
     ("i := BOOL_TO_INT(TRUE); s := BOOL_TO_STRING(TRUE); t := BOOL_TO_TIME(TRUE); o := BOOL_TO_TOD(TRUE);"
     " d := BOOL_TO_DATE(FALSE); dt1 := BOOL_TO_DT(TRUE);"),
     {"i": 1, "s": "TRUE", "t": 1, "o": 1, "d": 0, "dt1": 1}),
    ("PD-L38", "a, b, c, d : BOOL;",
     "a := BYTE_TO_BOOL(2#11010101); b := INT_TO_BOOL(0); c := TIME_TO_BOOL(T#5ms); d := STRING_TO_BOOL('TRUE');",
     {"a": True, "b": False, "c": True, "d": True}),
    ("PD-L39", "si : SINT;", "si := INT_TO_SINT(4223);", {"si": 127}),
    ("PD-L40", "a, b, c : INT; r : REAL; x : REAL := 2.7; n : INT := 2;",
     "r := INT_TO_REAL(n) * 3.5; a := REAL_TO_INT(1.5); b := REAL_TO_INT(1.4); c := REAL_TO_INT(x);",
     {"r": 7.0, "a": 2, "b": 1, "c": 3}),
    ("PD-L41", "s : STRING; d : DWORD; si : SINT;",
     "s := TIME_TO_STRING(T#12ms); d := TIME_TO_DWORD(T#5m); si := TOD_TO_SINT(TOD#00:00:00.012);",
     {"s": "T#12ms", "d": 300_000, "si": 12}),
    ("PD-L42", "b : BOOL; i : INT; y : BYTE; s : STRING;",
     ("b := DATE_TO_BOOL(D#1970-01-01); i := DATE_TO_INT(D#1970-01-15); y := DT_TO_BYTE(DT#1970-01-15-05:05:05);"
     " s := DT_TO_STRING(DT#1998-02-13-14:20);"),
     {"b": False, "i": 29_952, "y": 129, "s": "DT#1998-02-13-14:20"}),
    ("PD-L43", "b : BOOL; w : WORD; t : TIME;",
     "b := STRING_TO_BOOL('TRUE'); w := STRING_TO_WORD('abc34'); t := STRING_TO_TIME('T#127ms');",
     {"b": True, "w": 0, "t": 127}),
    ("PD-L44", "a, b : INT; x : REAL := -1.4;", "a := TRUNC(1.9); b := TRUNC(x);", {"a": 1, "b": -1}),
    ("PD-L45", "i : INT;", "i := EXPT(7, 2);", {"i": 49}),
    ("PD-L46", "a, b, c : TIME;", "a := T#14ms; b := T#100S12ms; c := t#12h34m15s;",
     {"a": 14, "b": 100_012, "c": 45_255_000}),
    ("PD-L48", "s : STRING := 'cost price: $$34.56 $'fine$' $0D';", "",
     {"s": "cost price: $34.56 'fine' \r"}),
]  # fmt: skip


@pytest.mark.parametrize(("declarations", "body", "expected"), [row[1:] for row in LISTINGS],
                         ids=[f"{row[0]}-{number}" for number, row in enumerate(LISTINGS)])  # fmt: skip
def test_listing_has_the_result_that_the_manual_states(declarations: str, body: str, expected: Results) -> None:
    bench = IecBench(program(declarations, body))
    bench.cycle()
    assert bench.thread.state is WorkState.ENDED, bench.thread.fault
    assert {path: bench[path] for path in expected} == expected
    assert {path: type(bench[path]) for path in expected} == {path: type(value) for path, value in expected.items()}


ENUMERATION = """TYPE TrafficLights: (red, yellow, green := 10); END_TYPE
PROGRAM PLC_PRG
VAR lights : TrafficLights := yellow; i, passes : INT; END_VAR
FOR i := red TO green DO
  i := i + 1;
  passes := passes + 1;
END_FOR;
lights := 0;
END_PROGRAM
"""


@pytest.mark.manual("PD-359")
def test_l05_an_enumeration_counts_like_an_integer() -> None:
    bench = IecBench(ENUMERATION)
    bench.cycle()
    assert (bench["passes"], bench["i"], bench["lights"]) == (6, 12, 0)


POLYGON = """TYPE Polygonzug:
STRUCT
  Start:ARRAY [1..2] OF INT;
  Point1:ARRAY [1..2] OF INT;
  Point2:ARRAY [1..2] OF INT;
  Point3:ARRAY [1..2] OF INT;
  Point4:ARRAY [1..2] OF INT;
  End:ARRAY [1..2] OF INT;
END_STRUCT
END_TYPE
PROGRAM PLC_PRG
VAR one, two : Polygonzug; size : INT; END_VAR
one.Start[1] := 1; one.End[2] := 12; size := SIZEOF(one); two := one; one.End[2] := 0;
END_PROGRAM
"""


@pytest.mark.manual("PD-360")
def test_l07_a_structure_is_assigned_as_a_whole() -> None:
    bench = IecBench(POLYGON)
    bench.cycle()
    assert (bench["two.Start[1]"], bench["two.End[2]"], bench["one.End[2]"], bench["size"]) == (1, 12, 0, 24)


INITIAL = """TYPE myStruct : STRUCT state : BOOL; inputValue : REAL; END_STRUCT END_TYPE
PROGRAM PLC_PRG
VAR a : INT := 13; b : STRING := 'this is a string'; c : REAL := 1.1;
s : myStruct := (state := TRUE, inputValue := 2.5);
l : ARRAY[1..10] OF INT := 1, 2, 2(4), 5, 6, 7, 8, 9, 10; END_VAR
END_PROGRAM
"""


@pytest.mark.manual("PD-361")
def test_l09_start_values() -> None:
    bench = IecBench(INITIAL)
    assert (bench["a"], bench["b"], bench["s.state"], bench["s.inputValue"]) == (13, "this is a string", True, 2.5)
    assert bench["c"] == 1.10000002384185791015625  # the nearest number of single precision
    assert [bench[f"l[{number}]"] for number in range(1, 11)] == [1, 2, 4, 4, 5, 6, 7, 8, 9, 10]


COUNTER = """FUNCTION_BLOCK Counter
VAR_INPUT iMode : INT; END_VAR
VAR_OUTPUT iCounter : INT; END_VAR
IF iMode = 0 THEN
  iCounter := 0;
ELSIF iMode = 1 THEN
  iCounter := iCounter + 1;
END_IF;
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR counter_1 : Counter; iActCount : INT; bFirstCycle : BOOL := TRUE; END_VAR
IF bFirstCycle THEN
  counter_1(iMode := 0);
ELSE
  counter_1(iMode := 1);
END_IF
bFirstCycle := FALSE;
iActCount := counter_1.iCounter;
END_PROGRAM
"""


@pytest.mark.manual("PD-355")
def test_l11_and_l12_a_block_counts_cycles() -> None:
    bench = IecBench(COUNTER)
    bench.cycle(8)
    assert bench["iActCount"] == 7


def test_l14_the_manuals_while_loop_leaves_its_array_without_short_circuit() -> None:
    """PD-L18: both sides of AND are evaluated, so ARR[101] is read when nothing is found."""
    text = program("J : INT; ARR : ARRAY[1..100] OF INT;",
                   "J:=1; WHILE J<= 100 AND ARR[J] <> 70 DO J:=J+2; END_WHILE;")  # fmt: skip
    bench = IecBench(text)
    bench.cycle()
    assert bench.thread.fault is not None
    assert (bench.thread.fault.code, bench["J"]) == ("array bounds", 101)


def test_l21_a_timer_takes_a_bare_number_only_where_the_dialect_allows_it() -> None:
    lenient = replace(EPAS_4, allows_numbers_as_times=True)
    text = program("CMD_TMR : TON; A : BOOL;", "CMD_TMR(IN := %IX5, PT := 300); A := CMD_TMR.Q;")
    bench = IecBench(text, lenient)
    bench.host.inputs[0] = 1 << 5
    seen = []
    for bench.host.ms in (0, 299, 300, 301):
        bench.cycle()
        seen.append(bench["A"])
    assert seen == [False, False, True, True]


def test_l49_a_function_is_an_operand() -> None:
    text = "FUNCTION Fct : INT VAR_INPUT x : INT; END_VAR Fct := x * x; END_FUNCTION\n"
    bench = IecBench(text + program("Result : INT;", "Result := Fct(7) + 3;"))
    bench.cycle()
    assert bench["Result"] == 52


@pytest.mark.manual("PD-101")
def test_l53_a_division_by_zero_is_a_fault_with_its_place_and_calls() -> None:
    text = """PROGRAM PLC_PRG
VAR IEndWaitTime : DINT := 8; zero : DINT; END_VAR
Flash();
END_PROGRAM
PROGRAM Flash
VAR x : DINT; END_VAR
x :=
  PLC_PRG.IEndWaitTime / PLC_PRG.zero;
END_PROGRAM
"""
    bench = IecBench(text)
    bench.cycle()
    fault = bench.thread.fault
    assert fault is not None
    assert (fault.code, fault.pou, fault.file) == ("division", "Flash", "main.st")
    assert fault.line in (7, 8)
    assert [(one.pou, one.line) for one in fault.calls] == [("PLC_PRG", 3)]
