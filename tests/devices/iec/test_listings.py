"""The listings of the manual with the results that the digest states (section 2.1), and the refused ones.

What needs a controller is elsewhere: PD-L26, L50, L52 and L53 in max4/plc/test_programs_of_the_manual.py, L54 to L56
in max4/libraries.  PD-L58 is for a PC.
"""

from dataclasses import replace

import pytest
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import EPAS_4
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.types import Value
from fieldrig_devices.languages.mistakes import CompileError

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


@pytest.mark.long
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
    assert [(place.routine, place.line) for place in fault.calls] == [("PLC_PRG", 3)]


# ---- Instruction List

# Listing, declarations, lines, results after one cycle; with the missing blanks and the mark put right.
IL_LISTINGS: list[tuple[str, str, str, Results]] = [
    ("PD-L13", "lint, idword : INT; sdword : INT := 1; test : BOOL := TRUE;",
     "LD 17\nST lint\nGE 5\nJMPC next\nLD idword\nEQ sdword\nSTN test\nnext:", {"lint": 17, "test": True}),
    ("PD-L14", "BOOL1 : BOOL := TRUE; BOOL2 : BOOL := TRUE; ERG : BOOL;",
     "LD TRUE\nANDN BOOL1\nJMPC marke\nLDN BOOL2\nST ERG\nmarke: LD BOOL2\nST ERG", {"ERG": True}),
    ("PD-L14", "BOOL1 : BOOL; BOOL2 : BOOL := TRUE; ERG : BOOL;",
     "LD TRUE\nANDN BOOL1\nJMPC marke\nLDN BOOL2\nST ERG\nmarke: LD BOOL2\nST ERG", {"ERG": True}),
    ("PD-L15", "Erg : INT;", "LD 2\nMUL 2\nADD 3\nST Erg", {"Erg": 7}),
    ("PD-L16", "Erg : INT;", "LD 2\nMUL ( 2\nADD 3\n) ST Erg", {"Erg": 10}),
    ("PD-L19", "Counter : INT := 5; Var1 : INT := 3; Erg : INT;",
     ("Loop:\nLD Counter\nEQ 0\nJMPC end\nLD Var1\nMUL 2\nST Var1\nLD Counter\nSUB 1\nST Counter\nJMP Loop\n"
      "end:\nLD Var1\nST Erg"), {"Erg": 96, "Counter": 0}),
    ("PD-L27", "var1, var2, var3, var4, var5 : INT;",
     ("LD 7\nADD 2,4,7\nST var1\nLD 7\nMUL 2,4,7\nST var2\nLD 7\nSUB 8\nST var3\nLD 8\nDIV 2\nST var4\n"
      "LD 9\nMOD 2\nST var5"), {"var1": 20, "var2": 392, "var3": -1, "var4": 4, "var5": 1}),
    ("PD-L28", "arr1 : ARRAY[0..4] OF INT; var1 : INT;", "LD arr1\nSIZEOF\nST var1", {"var1": 10}),
    ("PD-L29", "a, o, x, n : BYTE;",
     ("LD 2#1001_0011\nAND 2#1000_1010\nST a\nLD 2#1001_0011\nOR 2#1000_1010\nST o\n"
      "LD 2#1001_0011\nXOR 2#1000_1010\nST x\nLD 2#1001_0011\nNOT\nST n"),
     {"a": 0b1000_0010, "o": 0b1001_1011, "x": 0b0001_1001, "n": 0b0110_1100}),
    ("PD-L30", "Var1 : BYTE;", "LD 1\nSHL 1\nST Var1", {"Var1": 2}),
    ("PD-L31", "Var1 : BYTE;", "LD 32\nSHR 2\nST Var1", {"Var1": 8}),
    ("PD-L32", "Var1, Var2 : BYTE;", "LD 2#1001_0011\nROL 3\nST Var1\nLD 2#1001_0011\nROR 3\nST Var2",
     {"Var1": 0b1001_1100, "Var2": 0b0111_0010}),
    ("PD-L33", "s, t, a, i, l, m : INT;",
     ("LD TRUE\nSEL 3,4\nST s\nLD FALSE\nSEL 3,4\nST t\nLD 90\nMAX 30\nMAX 40\nMAX 77\nST a\n"
      "LD 90\nMIN 30\nMIN 40\nMIN 77\nST i\nLD 90\nLIMIT 30,80\nST l\nLD 0\nMUX 30,40,50,60,70,80\nST m"),
     {"s": 4, "t": 3, "a": 90, "i": 30, "l": 80, "m": 30}),
    ("PD-L34", "a, b, c, d, e, f : BOOL;",
     ("LD 20\nGT 30\nST a\nLD 20\nLT 30\nST b\nLD 20\nLE 30\nST c\nLD 60\nGE 40\nST d\nLD 40\nEQ 40\nST e\n"
      "LD 40\nNE 40\nST f"), {"a": False, "b": True, "c": True, "d": True, "e": True, "f": False}),
    ("PD-L40", "r : REAL;", "LD 2\nINT_TO_REAL\nMUL 3.5\nST r", {"r": 7.0}),
    ("PD-L40", "b : BOOL; w AT %MW8 : INT := 3;", "LD 2.7\nREAL_TO_INT\nGE %MW8\nST b", {"b": True}),
    ("PD-L44", "b : BOOL; w AT %MW8 : INT := 3;", "LD 2.7\nTRUNC\nGE %MW8\nST b", {"b": False}),
    ("PD-L45", "var1 : INT;", "LD 7\nEXPT 2\nST var1", {"var1": 49}),
]  # fmt: skip


@pytest.mark.parametrize(("declarations", "body", "expected"), [row[1:] for row in IL_LISTINGS],
                         ids=[f"{row[0]}-{number}" for number, row in enumerate(IL_LISTINGS)])  # fmt: skip
def test_listing_in_il(declarations: str, body: str, expected: Results) -> None:
    bench = IecBench(program(declarations, body))
    bench.cycle()
    assert bench.thread.state is WorkState.ENDED, bench.thread.fault
    assert {path: bench[path] for path in expected} == expected


def test_l35_an_address_goes_to_a_function() -> None:
    text = "FUNCTION man_fun1 : DWORD VAR_INPUT address : DWORD; END_VAR man_fun1 := address; END_FUNCTION\n"
    bench = IecBench(
        text
        + program("var1 : INT := 7; var2, var3 : DWORD; pt : POINTER TO INT; var4 : INT;",
                  "LD var1\nADR\nST var2\nman_fun1\nST var3\nLD var3\nST pt\nLD pt^\nST var4")
    )  # fmt: skip
    bench.cycle()
    assert (bench["var3"], bench["var4"]) == (bench["var2"], 7)


def test_l36_il_calls_an_instance() -> None:
    text = """FUNCTION_BLOCK Block VAR_INPUT PAR1 : INT := 5; PAR2 : BOOL; END_VAR VAR_OUTPUT n : INT; END_VAR
    IF PAR2 THEN n := PAR1 + 100; END_IF;
    END_FUNCTION_BLOCK
    """
    bench = IecBench(text + program("INST : Block; r : INT;", "CAL INST(PAR1 := 0, PAR2 := TRUE)\nLD INST.n\nST r"))
    bench.cycle()
    assert bench["r"] == 100


# ---- listings that are refused, and others

# Listing, source text, places of the mistakes and what was wrong.
REFUSED: list[tuple[str, str, list[str]]] = [
    ("PD-L06",
     ("TYPE TrafficLights: (red, yellow, green); END_TYPE\nTYPE Color: (blue, white, red); END_TYPE\n"
      "PROGRAM PLC_PRG END_PROGRAM"),
     [("2: the name red is used already, in main.st, line 1; "
       "names of enumeration values occur once in the project (PD-359)")]),
    ("PD-L10",
     ("FUNCTION TEST: REAL\nVAR_INPUT Switch1, Switch2: BOOL; END_VAR\nVAR Intermediate result: BOOL; END_VAR\n"
      "TEST:= Switch1 AND Switch2;\nEND_FUNCTION\nPROGRAM PLC_PRG END_PROGRAM"),
     ["3: the name Intermediate result has a blank in it; one word", "4: Switch1 AND Switch2 is a BOOL; REAL"]),
    ("PD-L34", program("VAR1 : BOOL;", "VAR1 := 20 > 30 > 40 > 50 > 60 > 70;"),
     ["5: > between BOOL and the number 40; two values of the same type"]),
    ("PD-L47", program("TIME1 : TIME;", "TIME1 := t#5m68s;"),
     ["5: 68s overflows; less than 60s; only the highest unit may overflow"]),
    ("PD-L47", program("TIME1 : TIME;", "TIME1 := 15ms;"), ["5: 15ms has no T# in front of it; T#15ms"]),
    ("PD-L47", program("TIME1 : TIME;", "TIME1 := t#4ms13d;"),
     ["5: d follows ms; the units in the order d, h, m, s, ms, each once"]),
]  # fmt: skip


@pytest.mark.parametrize(("text", "expected"), [row[1:] for row in REFUSED],
                         ids=[f"{row[0]}-{number}" for number, row in enumerate(REFUSED)])  # fmt: skip
def test_listing_is_refused(text: str, expected: list[str]) -> None:
    with pytest.raises(CompileError) as refused:
        IecBench(text)
    shown = [
        f"{mistake.line}: {mistake.what}; {mistake.expected}"
        for mistake in refused.value.mistakes
        if not mistake.is_note
    ]
    assert shown == expected


def test_l08_a_name_for_a_string_of_50_characters() -> None:
    text = "TYPE message:STRING[50];\nEND_TYPE;\n" + program("m : message; n : INT;", "n := SIZEOF(m);")
    bench = IecBench(text)
    bench.cycle()
    assert bench["n"] == 51


def test_l10_put_right_is_the_connection_of_two_switches() -> None:
    text = """FUNCTION TEST : BOOL
    VAR_INPUT Switch1 : BOOL; Switch2 : BOOL; END_VAR
    VAR Intermediate_result : BOOL; END_VAR
    TEST := Switch1 AND Switch2;
    END_FUNCTION
    """
    bench = IecBench(text + program("a, b : BOOL;", "a := TEST(TRUE, TRUE); b := TEST(TRUE, FALSE);"))
    bench.cycle()
    assert (bench["a"], bench["b"]) == (True, False)


def test_l51_a_state_machine_takes_a_step_in_each_cycle() -> None:
    body = "CASE IState OF 1: IState := IState + 1; 2: IState := IState + 1; 3: IState := 2; END_CASE;"
    bench = IecBench(program("IState : INT := 1;", body))
    seen = []
    for _ in range(5):
        bench.cycle()
        seen.append(bench["IState"])
    assert seen == [2, 3, 2, 3, 2]


ENI = r"""<?xml version="1.0" encoding="ISO-8859-1"?>
<pou>
  <accesslevels> rw,rw,r,rw,r,rw,rw,rw </accesslevels>
  <path> \/languages </path>
  <name> ST_EXAMPLE </name>
  <flags> 4 </flags>
  <interface>
    <![CDATA[PROGRAM ST_EXAMPLE
VAR
  YVAL: INT := -250;
  BOTTOM: INT := -250;
  RUN_STRING: STRING(20) := 'Start';
        OFFSET: INT := 2;
    END_VAR
]]>
  </interface>
  <st>
  <body>
    <![CDATA[RUN_STRING:='Start';
    IF (YVAL < 0) THEN
      YVAL := YVAL + OFFSET;
    BOTTOM := YVAL + OFFSET;
    END_IF;
    ]]>
  </body>
  </st>
</pou>
"""


def test_l57_a_component_in_xml_counts_to_zero_in_125_cycles() -> None:
    bench = IecBench(ENI, main="ST_EXAMPLE", name="example.xml")
    bench.cycle(124)
    assert (bench["YVAL"], bench["BOTTOM"]) == (-2, 0)
    bench.cycle(3)
    assert (bench["YVAL"], bench["BOTTOM"]) == (0, 2)
