"""The dialect of CODESYS and TwinCAT: a library in the manner of their public ones compiles and computes."""

import pytest
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect

LIBRARY = """
TYPE
    Words : STRUCT
        days : ARRAY[1..2, 1..3] OF STRING(10) := 'Monday', 'Tuesday', 'Wednesday', 'Montag', 'Dienstag', 'Mittwoch';
        marks : ARRAY[1..2, 0..7] OF STRING(3) := 16('-');
    END_STRUCT;
    Vector : STRUCT x : REAL; y : REAL; END_STRUCT;
END_TYPE

VAR_GLOBAL CONSTANT
    LONGEST : INT := 250;
END_VAR
VAR_GLOBAL
    LANGUAGE : Words;
END_VAR

FUNCTION NOW_MS : DWORD
VAR CONSTANT
    shift : WORD := 2;
    offset : DWORD := 16#10;
END_VAR
NOW_MS := SHL(TIME_TO_DWORD(TIME()), shift) + SHL(DWORD#1, shift) - 1 + offset;
END_FUNCTION

FUNCTION ONES : INT  (* counts the bits, and changes its input *)
VAR_INPUT in : DWORD; END_VAR
WHILE in > 0 DO
    IF in.0 THEN ONES := ONES + 1; END_IF;
    in := SHR(in, 1);
END_WHILE;
END_FUNCTION

FUNCTION LAST_PLACE : INT
VAR_INPUT text, part : STRING(LONGEST); END_VAR
VAR size : INT; END_VAR
size := LEN(part);
FOR LAST_PLACE := LEN(text) - size + 1 TO 1 BY -1 DO
    IF MID(text, size, LAST_PLACE) = part THEN RETURN; END_IF;
END_FOR;
LAST_PLACE := 0;
END_FUNCTION

FUNCTION CAPITALS : STRING(LONGEST)  (* works on the bytes of its input *)
VAR_INPUT text : STRING(LONGEST); END_VAR
VAR p : POINTER TO BYTE; i : INT; END_VAR
p := ADR(text);
FOR i := 1 TO LEN(text) DO
    IF p^ > 96 AND p^ < 123 THEN p^ := p^ AND 16#DF; END_IF;
    p := p + 1;
END_FOR;
CAPITALS := text;
END_FUNCTION

FUNCTION SUM : Vector
VAR_INPUT a, b : Vector; END_VAR
SUM.x := a.x + b.x;
SUM.y := a.y + b.y;
END_FUNCTION

FUNCTION SORTED : BOOL
VAR_INPUT pt : POINTER TO ARRAY[0..32000] OF REAL; size : UINT; END_VAR
VAR i, j, stop : INT; kept : REAL; END_VAR
stop := UINT_TO_INT(size / SIZEOF(pt^[0])) - 1;
FOR i := 0 TO stop - 1 DO
    FOR j := 0 TO stop - 1 - i DO
        IF pt^[j] > pt^[j + 1] THEN kept := pt^[j]; pt^[j] := pt^[j + 1]; pt^[j + 1] := kept; END_IF;
    END_FOR;
END_FOR;
SORTED := TRUE;
END_FUNCTION

FUNCTION_BLOCK RAMP
VAR_INPUT up : BOOL; E : BOOL := TRUE; TR : TIME; END_VAR
VAR_IN_OUT value : BYTE; END_VAR
VAR last : TIME; start : BYTE; is_ready : BOOL; END_VAR
IF E AND is_ready THEN
    value := DWORD_TO_BYTE(MIN(TIME_TO_DWORD(TIME() - last) * 255 / TIME_TO_DWORD(TR) + start, 255));
    IF NOT up AND value > 0 THEN value := value - 1; END_IF;
ELSE
    last := TIME(); start := value; is_ready := TRUE;
END_IF;
END_FUNCTION_BLOCK

FUNCTION_BLOCK ACTUATOR  (* inputs with the names of blocks and of words that are keywords elsewhere *)
VAR_INPUT
    ON, SINGLE : BOOL; TON, TOFF : TIME; STEP : INT; DAY : BYTE := 2#1111111;
    T_START : TIME_OF_DAY := TIME_OF_DAY#3:0;
END_VAR
VAR_OUTPUT Y : BOOL; STATUS : BYTE; out : REAL; END_VAR
VAR timer : TP; ramp : RAMP; level : BYTE; C : REAL := 1; x : REAL := -15; END_VAR
VAR RETAIN changed : DATE; END_VAR
timer(IN := ON AND NOT timer.Q, PT := TON);
ramp(up := ON, TR := TOFF, value := level);
STATUS := SEL(SINGLE, BYTE#101, BYTE#102);
out := MAX(0.0, LIMIT(-1.5, C * x, 1E6)) + EXPT(2, 3) + ABS(x);
Y := timer.Q OR STATUS.0;
END_FUNCTION_BLOCK

PROGRAM PLC_PRG
VAR
    one : ACTUATOR; bits, place : INT; text, large, day, mark : STRING;
    list : ARRAY[0..3] OF REAL := 4.0, 1.0, 3.0, 2.0; a, b, both : Vector; is_sorted : BOOL; ticks : DWORD;
END_VAR
one(ON := TRUE, TON := t#1s, TOFF := TIME#10000m0s0ms, STEP := 5);
bits := ONES(16#F0F);
text := 'Monday to Monday';
place := LAST_PLACE(text, 'Mon');
large := CAPITALS(text);
is_sorted := SORTED(ADR(list), SIZEOF(list));
a.x := 1; b.y := 2.5;
both := SUM(a, b);
day := LANGUAGE.days[2, 3];
mark := LANGUAGE.marks[2, 7];
ticks := NOW_MS();
END_PROGRAM
"""


@pytest.fixture(scope="module")
def bench() -> IecBench:
    bench = IecBench(LIBRARY, CODESYS)
    bench.host.ms = 100
    bench.cycle()
    return bench


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("bits", 8),
        ("place", 11),
        ("large", "MONDAY TO MONDAY"),
        ("text", "Monday to Monday"),
        ("list[0]", 1.0),
        ("list[3]", 4.0),
        ("both.x", 1.0),
        ("both.y", 2.5),
        ("day", "Mittwoch"),
        ("mark", "-"),
        ("ticks", 400 + 4 - 1 + 16),
        ("one.Y", True),
        ("one.STATUS", 101),
        ("one.out", 23.0),
        ("one.T_START", 10_800_000),
    ],
)
def test_results(bench: IecBench, name: str, value: object) -> None:
    assert bench[name] == value


def test_the_standard_keeps_bit_strings_and_numbers_apart() -> None:
    assert any("+ between DWORD and DWORD" in message for message in refused(LIBRARY, EDITION_3))


def test_of_an_argument_that_is_given_twice_the_last_value_counts() -> None:
    block = (
        "FUNCTION_BLOCK Sum VAR_INPUT a, b : INT; END_VAR VAR_OUTPUT c : INT; END_VAR c := a + b; END_FUNCTION_BLOCK\n"
    )
    text = block + program("s : Sum; x : INT;", "s(a := 1, b := 2, a := 30, c => x);")
    bench = IecBench(text, CODESYS)
    bench.cycle()
    assert bench["x"] == 32
    assert any("the argument a is given twice" in message for message in refused(text, EDITION_3))


@pytest.mark.parametrize(("dialect", "has_edge"), [(CODESYS, False), (EDITION_3, True), (EPAS_4, True)])
def test_the_first_call_of_a_falling_edge(dialect: Dialect, has_edge: bool) -> None:
    """The help of CODESYS about SF_F_TRIG: it finds an edge in its first call, other than F_TRIG of the library."""
    body = "f(CLK := clk); found := f.Q;"
    bench = IecBench(program("f : F_TRIG; clk, found : BOOL;", body), dialect)
    bench.cycle()
    assert bench["found"] is has_edge
    bench["clk"] = True
    bench.cycle()
    assert bench["found"] is False
    bench["clk"] = False
    bench.cycle()
    assert bench["found"] is True
