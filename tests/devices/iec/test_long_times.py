"""The types of edition 3 with nanoseconds, and characters: constants, arithmetic, ends of the ranges, conversions."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from iec_program import IecBench, program, refused

from fieldrig_devices.iec import literal_texts, literals
from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.elementary import LONGER, UNITS_NS, Elementary
from fieldrig_devices.iec.library.conversions import convert

S, DAY = 10**9, 86_400 * 10**9
IN_2000 = 10_957 * DAY
INT64 = st.integers(-(2**63), 2**63 - 1)

# Each row is an expression, the type of its target, and the value, in nanoseconds or as a code.
RESULTS = [
    ("LTIME#1d2h3m4s5ms6us7ns", "LTIME", 93_784_005_006_007),
    ("LT#-1.5us", "LTIME", -1_500),
    ("LTIME#106751d23h47m16s854ms775us807ns", "LTIME", 2**63 - 1),
    ("LTIME#106751d23h47m16s854ms775us807ns + LTIME#1ns", "LTIME", -(2**63)),
    ("one + T#3s", "LTIME", 4 * S),
    ("T#3s - one * 2", "LTIME", S),
    ("one / -3", "LTIME", -333_333_333),
    ("one * 2.5", "LTIME", 2_500_000_000),
    ("SEL(one < T#1s1ms, LTIME#0s, LTIME#1ns)", "LTIME", 1),
    ("MAX(one, LT#2s)", "LTIME", 2 * S),
    ("T#7ms", "LTIME", 7_000_000),
    ("LDATE#2000-01-01", "LDATE", IN_2000),
    ("D#2000-01-01", "LDATE", IN_2000),
    ("LTOD#23:59:59.999999999", "LTOD", DAY - 1),
    ("LTOD#23:59:59.999999999 + LTIME#1ns", "LTOD", 0),
    ("LTOD#00:00:00 - LTIME#1ns", "LTOD", DAY - 1),
    ("LDT#2000-01-01-00:00:01.5", "LDT", IN_2000 + 1_500_000_000),
    ("LDT#2000-01-01-00:00:01.5 - LTIME#2s", "LDT", IN_2000 - 500_000_000),
    ("LDT#2000-01-02-00:00:00 - LDT#2000-01-01-00:00:00", "LTIME", DAY),
    ("LDATE#2000-01-01 - LDATE#2000-01-02", "LTIME", -DAY),
    ("LDT_TO_LDATE(LDT#2000-01-01-12:00)", "LDATE", IN_2000),
    ("LDT_TO_TOD(LDT#2000-01-01-12:00:00.0015)", "TOD", 43_200_001),
    ("LDT_TO_LTOD(LDT#2000-01-01-12:00)", "LTOD", DAY // 2),
    ("LDT_TO_DT(LDT#2000-01-01-00:00:01.9)", "DT", IN_2000 // S + 1),
    ("LTIME_TO_TIME(LTIME#1ms999us)", "TIME", 1),
    ("LTIME_TO_TIME(LTIME#-1ms999us)", "TIME", -1),
    ("LTIME_TO_TIME(LTIME#0s - one - LTIME#1ns)", "TIME", -1_000),
    ("T#-1.9995s", "TIME", -1_999),
    ("LTIME_TO_LINT(LTIME#1us)", "LINT", 1_000),
    ("LTIME_TO_STRING(LTIME#-1m5ns)", "STRING", "LTIME#-1m5ns"),
    ("LDT_TO_STRING(LDT#2000-01-01-00:00:01)", "STRING", "LDT#2000-01-01-00:00:01"),
    ("STRING_TO_LTOD('LTOD#00:00:00.000000001')", "LTOD", 1),
    ("STRING_TO_LTIME('LTIME#x')", "LTIME", 0),
    ("'A'", "CHAR", 65),
    ("CHAR#'$0A'", "CHAR", 10),
    ('"€"', "WCHAR", 0x20AC),
    ('CHAR_TO_WCHAR(CHAR#\'A\')', "WCHAR", 65),
    ('WCHAR_TO_CHAR(WCHAR#"€")', "CHAR", ord("?")),
    ("STRING_TO_CHAR('xyz')", "CHAR", ord("x")),
    ("STRING_TO_CHAR('')", "CHAR", 0),
    ("BYTE_TO_CHAR(16#42)", "CHAR", 66),
    ("CHAR_TO_BYTE(letter)", "BYTE", 90),
    ("CONCAT('<', letter)", "STRING", "<Z"),
    ("letter", "STRING", "Z"),
    ("letter = 'Z' AND letter > 'Y'", "BOOL", True),
]  # fmt: skip


@pytest.mark.parametrize(("expression", "kind", "value"), RESULTS)
def test_results(expression: str, kind: str, value: object) -> None:
    declarations = f"one : LTIME := LTIME#1s; letter : CHAR := 'Z'; result : {kind};"
    bench = IecBench(program(declarations, f"result := {expression};"), EDITION_3)
    bench.cycle()
    assert bench["result"] == value


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("short := long;", "long is an LTIME; expected TIME"),
        ("long := 5;", "the number 5 is no LTIME"),
        ("letter := 'AB';", "'AB' is a STRING(2); expected CHAR"),
        ("letter := letter + letter;", "+ between CHAR and CHAR"),
        ("letter := 65;", "the number 65 is no CHAR"),
        ('letter := "A";', "expected CHAR"),
        ("long := LTIME#106752d;", "too long"),
        ("long := LDT#2263-01-01-00:00 - LDT#2000-01-01-00:00;", "out of range"),
    ],
)
def test_what_does_not_fit_is_refused(statement: str, expected: str) -> None:
    found = refused(program("short : TIME; long : LTIME; letter : CHAR;", statement), EDITION_3)
    assert any(expected in message for message in found), found


def test_the_controller_leaves_their_names_to_others() -> None:
    text = """
    TYPE CHAR : STRUCT code : INT; END_STRUCT; END_TYPE
    FUNCTION LTIME_TO_LDT : INT
    VAR_INPUT x : INT; END_VAR
    LTIME_TO_LDT := x + 1;
    END_FUNCTION
    """
    bench = IecBench(text + program("c : CHAR; n : INT;", "c.code := 5; n := LTIME_TO_LDT(c.code);"), EPAS_4)
    bench.cycle()
    assert bench["n"] == 6
    assert any("LTOD is not declared" in message for message in refused(program("x : LTOD;", ""), EPAS_4))


@given(st.sampled_from([*LONGER.items()]), st.data())
def test_a_short_time_comes_back_from_its_long_one(pair: tuple[Elementary, Elementary], data: st.DataObject) -> None:
    short, long = pair
    value = data.draw(st.integers(short.low, short.high))
    value -= value % 86_400 if short is Elementary.DATE else 0
    assert convert(value, short, long) == value * UNITS_NS[short]
    assert convert(convert(value, short, long), long, short) == value


@given(INT64)
def test_the_constant_of_a_duration_is_its_value(value: int) -> None:
    text = literal_texts.long_time_text(max(value, -(2**63) + 1))
    assert literals.long_time(text.removeprefix("LTIME#"), EDITION_3) == max(value, -(2**63) + 1)


@given(st.sampled_from([(EDITION_3, 2**63 - 1), (CODESYS, 2**64 - 1)]), st.data())
def test_the_constant_of_a_date_with_a_time_is_its_value(range_of: tuple[Dialect, int], data: st.DataObject) -> None:
    dialect, most = range_of
    value = data.draw(st.integers(0, most))
    text = literal_texts.date_text("LDT", value, 1).removeprefix("LDT#")
    assert literals.long_date_and_time(text, dialect) == value
