"""Enumerations: their integer types, the order of their numbers, names that occur twice, and numbers at run time."""

import pytest
from iec_check import messages
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect

TYPES = """
TYPE
    Big : (low := 40000, high) UINT := high;
    Level : DINT (deep := -100000, flat := 0, tall);
    Color : (red, green, blue := 5) BYTE;
    Light : (off, green := 7, red := 3);
END_TYPE
"""


@pytest.fixture
def bench() -> IecBench:
    body = """
    size := SIZEOF(big) + 10 * SIZEOF(level) + 100 * SIZEOF(color);
    number := big;
    level := deep;
    wide := level;
    color := blue;
    shown := Light.green;
    lamp := shown;
    FOR color := red TO green DO
        passes := passes + 1;
    END_FOR;
    CASE shown OF
        off: kind := 1;
        Light.green: kind := 2;
    END_CASE;
    bits := color;
    """
    declarations = """big : Big; level : Level; color : Color; shown : Light; own : (up := 3, down := 2) SINT;
    size, passes, kind, lamp : INT; number : UINT; wide : DINT; bits : BYTE;"""
    bench = IecBench(TYPES + program(declarations, body), EDITION_3)
    bench.cycle()
    return bench


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("size", 2 + 40 + 100),
        ("big", 40001),
        ("number", 40001),
        ("wide", -100_000),
        ("lamp", 7),
        ("passes", 2),
        ("kind", 2),
        ("bits", 2),
        ("own", 3),
    ],
)
def test_values_have_the_type_of_their_enumeration(bench: IecBench, name: str, value: int) -> None:
    assert bench[name] == value


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("TYPE e : (a := 1, b := 256) BYTE; END_TYPE", "1:24 256 does not fit BYTE; 0 to 255"),
        ("TYPE e : (a := 255, b) BYTE; END_TYPE", "1:21 b is 256; at most 255, as for a BYTE"),
    ],
)
def test_a_number_that_the_type_does_not_hold_is_refused(text: str, message: str) -> None:
    assert messages(text, dialect=EDITION_3) == [message]


@pytest.mark.manual("PD-359")
@pytest.mark.parametrize(
    "text", ["TYPE e : (a := 2, b := 1); END_TYPE", "TYPE e : (a); f : (a); END_TYPE"], ids=["descending", "twice"]
)
def test_epas_wants_ascending_numbers_and_names_that_occur_once(text: str) -> None:
    assert len(messages(text, dialect=EPAS_4)) == 1
    assert messages(text, dialect=EDITION_3) == []


@pytest.mark.manual("PD-359")
@pytest.mark.parametrize(
    ("number", "dialect", "is_right"),
    [
        (-1, EPAS_4, False), (0, EPAS_4, True), (1, EPAS_4, True), (2, EPAS_4, False), (9, EPAS_4, False),
        (10, EPAS_4, True), (11, EPAS_4, False), (5, EDITION_3, True), (5, CODESYS, True), (11, CODESYS, True),
    ],
)  # fmt: skip
def test_the_validity_of_a_number_is_checked_at_run_time(number: int, dialect: Dialect, is_right: bool) -> None:
    """Manual 846; its example has the numbers 0, 1 and 10."""
    text = "TYPE TrafficLights: (red, yellow, green := 10); END_TYPE\n"
    body = "lights := i; passed := TRUE;"
    bench = IecBench(text + program(f"lights : TrafficLights; i : INT := {number}; passed : BOOL;", body), dialect)
    bench.cycle()
    fault = bench.thread.fault
    assert (bench["passed"], fault is None) == (is_right, is_right)
    if fault is not None and dialect is EPAS_4:
        assert (fault.code, fault.text) == ("subrange", f"the value {number} is outside 0..1, 10")


@pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3, CODESYS], ids=lambda dialect: dialect.name)
@pytest.mark.parametrize("first", ["a", "b", "c", "d"])
def test_a_value_may_stand_on_those_in_front_of_it(first: str, dialect: Dialect) -> None:
    """Whichever is asked for first: TwinCAT's projects number ranges in this way."""
    types = "TYPE E : (a := 1, b := a + 4, c, d := b * 2); END_TYPE\nVAR_GLOBAL k : ARRAY[0..{}] OF INT; END_VAR\n"
    body = "sizes := SIZEOF(k) / 2; x[0] := a; x[1] := b; x[2] := c; x[3] := d;"
    source = types.format(first) + program("x : ARRAY[0..3] OF INT; sizes : DINT;", body)
    bench = IecBench(source, dialect)
    bench.cycle()
    values = {"a": 1, "b": 5, "c": 6, "d": 10}
    assert [bench[f"x[{place}]"] for place in range(4)] == list(values.values())
    assert bench["sizes"] == values[first] + 1


SAME_NAMES = """\
TYPE Valve : (Idle, Done); END_TYPE
TYPE Pump : (Start, Done := 7, Idle); END_TYPE
FUNCTION Number : INT VAR_INPUT p : Pump; END_VAR Number := p; END_FUNCTION
"""


@pytest.mark.parametrize("dialect", [EDITION_3, CODESYS], ids=lambda dialect: dialect.name)
@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("p := Done; n := p;", 7),
        ("p := Pump#Done; IF p = Done THEN n := 1; END_IF; IF Idle <> p THEN n := n + 2; END_IF;", 3),
        ("p := Pump#Idle; CASE p OF Start: n := 1; Done: n := 2; Idle: n := 3; END_CASE;", 3),
        ("n := Number(p := Done);", 7),
        ("p := SEL(TRUE, Start, Done); n := p;", 7),
        ("v := Done; n := v;", 1),
        ("v := Valve#Done; IF v = Done THEN n := 5; END_IF;", 5),
    ],
)
def test_a_name_that_two_enumerations_have_means_the_value_of_the_one_that_is_wanted(
    dialect: Dialect, body: str, expected: int
) -> None:
    bench = IecBench(SAME_NAMES + program("p : Pump; v : Valve; n : INT;", body), dialect)
    bench.cycle()
    assert bench["n"] == expected


@pytest.mark.parametrize("dialect", [EDITION_3, CODESYS])
def test_a_name_of_two_enumerations_means_the_wanted_one_wherever_a_type_is_wanted(dialect: Dialect) -> None:
    text = """
    TYPE Lamp : (Red, Green, Idle); END_TYPE
    TYPE Pump : (Idle, Start, Red); END_TYPE
    TYPE Both : STRUCT l : Lamp := Idle; p : Pump := Red; END_STRUCT; END_TYPE
    TYPE Dark : Pump := Red; END_TYPE
    FUNCTION Number : INT VAR_INPUT p : Pump := Red; END_VAR Number := TO_INT(p); END_FUNCTION
    """
    declared = """
    list : ARRAY[1..3] OF Pump := [Red, 2(Idle)]; both : Both; other : Both := (l := Red, p := Idle);
    p : Pump := Red; d : Dark; ok : ARRAY[1..8] OF BOOL;
    """
    body = """
    ok[1] := Number(Red) = 2 AND Number(p := Red) = 2;
    ok[2] := list[1] = Red AND list[3] = Idle;
    ok[3] := both.l = Idle AND both.p = Red AND other.l = Red AND other.p = Idle;
    ok[4] := Red = p AND p = Red;
    p := SEL(TRUE, Red, Idle);
    ok[5] := p = Idle AND NOT (Red = p);
    ok[6] := d = Red;
    CASE both.l OF Red: ok[7] := FALSE; Idle: ok[7] := TRUE; END_CASE
    ok[8] := both.l = Lamp#Idle AND both.p = Pump#Red;
    """
    if dialect is CODESYS:
        body = body.replace("#", ".")
    bench = IecBench(text + program(declared, body), dialect)
    bench.cycle()
    assert [bench[f"ok[{number}]"] for number in range(1, 9)] == [True] * 8


def test_in_codesys_an_enumeration_takes_every_number_of_its_type() -> None:
    """CODESYS and TwinCAT look at the numbers of no enumeration, unless it is strict."""
    body = "level := 4; text := level = 4; number := 77; level := number; after := level;"
    bench = IecBench(f"{TYPES}{program('level : Light; number, after : INT; text : BOOL;', body)}", CODESYS)
    bench.cycle()
    assert bench["text"]
    assert bench["after"] == 77


@pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3])
def test_elsewhere_a_number_must_be_one_of_the_values(dialect: Dialect) -> None:
    types = "TYPE Lamp : (off, green := 7); END_TYPE\n"
    assert any(
        "4 is no value of Lamp" in one
        for one in messages(types + program("lamp : Lamp;", "lamp := 4;"), dialect=dialect)
    )
