"""The texts of TcUnit's report, row by row of the facts in the docstring of `tcunit/forms.py` and TcUnit 1.3.2."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tcunit_bench import SuiteBench, suite

from fieldrig_devices.iec.tcunit import forms


def failing(declarations: str, call: str) -> str:
    return suite(f"TEST('t');\n{call}\nTEST_FINISHED();", declarations)


SCALARS = [
    ("BOOL", "TRUE", "FALSE", "TRUE", "FALSE"),
    ("BYTE", "16#AB", "16#1", "0xAB", "0x01"),
    ("WORD", "16#AB", "16#1", "0x00AB", "0x0001"),
    ("DWORD", "16#12345678", "16#90ABCDEF", "0x12345678", "0x90ABCDEF"),
    ("LWORD", "16#0123656789ABCBEC", "0", "0x0123656789ABCBEC", "0x0000000000000000"),
    ("SINT", "-128", "127", "-128", "127"),
    ("INT", "12345", "-12345", "12345", "-12345"),
    ("DINT", "-55555", "70000", "-55555", "70000"),
    ("LINT", "-451416345", "589532453", "-451416345", "589532453"),
    ("USINT", "3", "7", "3", "7"),
    ("UINT", "64322", "32312", "64322", "32312"),
    ("UDINT", "34123244", "52343244", "34123244", "52343244"),
    ("ULINT", "45683838383", "18446744073709551615", "45683838383", "18446744073709551615"),
    ("TIME", "T#12h34m15s10ms", "T#11h34m13s244ms", "T#12h34m15s10ms", "T#11h34m13s244ms"),
    (
        "LTIME",
        "LTIME#213503d23h34m33s709ms551us615ns",
        "LTIME#1000d15h23m12s34ms2us44ns",
        "LTIME#213503d23h34m33s709ms551us615ns",
        "LTIME#1000d15h23m12s34ms2us44ns",
    ),
    ("DATE", "D#1996-05-06", "D#2019-01-20", "D#1996-05-06", "D#2019-01-20"),
    (
        "DATE_AND_TIME",
        "DT#1996-05-06-15:36:30",
        "DT#1972-03-29-00:00:00",
        "DT#1996-05-06-15:36:30",
        "DT#1972-03-29-00:00:00",
    ),
    ("TIME_OF_DAY", "TOD#15:36:30.123", "TOD#06:21:11.492", "TOD#15:36:30.123", "TOD#06:21:11.492"),
    ("STRING", "'This is a text'", "'Another text'", "This is a text", "Another text"),
]


@pytest.mark.parametrize(("kind", "one", "other", "expected", "actual"), SCALARS)
def test_a_failed_assert_shows_both_values(kind: str, one: str, other: str, expected: str, actual: str) -> None:
    call = f"AssertEquals_{kind}(Expected := a, Actual := b, Message := 'Values differ');"
    bench = SuiteBench.ran(failing(f"a : {kind} := {one}; b : {kind} := {other};", call))
    assert bench.lines == [f"FAILED TEST 'PRG_TEST.s@t', EXP: {expected}, ACT: {actual}, MSG: Values differ"]


@pytest.mark.long
@pytest.mark.parametrize(("kind", "one", "other", "expected", "actual"), SCALARS)
def test_any_acts_as_the_assert_of_the_type(kind: str, one: str, other: str, expected: str, actual: str) -> None:
    declarations = f"a : {kind} := {one}; b : {kind} := {other};"
    equal = SuiteBench.ran(failing(declarations, "AssertEquals(a, a, 'equal');"))
    assert equal.lines == []
    if kind == "STRING":
        return  # their lengths differ, which has a text of its own
    bench = SuiteBench.ran(failing(declarations, "AssertEquals(a, b, 'Values differ');"))
    assert bench.lines == [f"FAILED TEST 'PRG_TEST.s@t', EXP: {expected}, ACT: {actual}, MSG: Values differ"]


@pytest.mark.parametrize(
    ("kind", "values", "delta", "texts"),
    [
        ("REAL", ("1234.5", "1234.4"), "0.05", ("1234.5", "1234.4")),
        ("LREAL", ("1234567.89", "0.0"), "1.0", ("1234567.89", "0.0")),
        ("REAL", ("1234.5", "1234.4"), "0.2", None),
        ("LREAL", ("-1.0", "1.0"), "2.0", None),  # exactly the tolerance passes
    ],
)
def test_a_tolerance_is_absolute(kind: str, values: tuple[str, str], delta: str, texts: tuple[str, str] | None) -> None:
    declarations = f"a : {kind} := {values[0]}; b : {kind} := {values[1]};"
    bench = SuiteBench.ran(failing(declarations, f"AssertEquals_{kind}(a, b, {delta}, 'far');"))
    wanted = [f"FAILED TEST 'PRG_TEST.s@t', EXP: {texts[0]}, ACT: {texts[1]}, MSG: far"] if texts else []
    assert bench.lines == wanted


def test_nan_passes() -> None:
    call = "b := SQRT(a);\nAssertEquals_LREAL(1.0, b, 0.1, 'not a number');"
    assert SuiteBench.ran(failing("a : LREAL := -1.0; b : LREAL;", call)).lines == []


def test_wide_strings_cannot_be_printed() -> None:
    call = "AssertEquals_WSTRING(a, b, 'differ');"
    bench = SuiteBench.ran(failing('a : WSTRING := "Hello"; b : WSTRING := "World";', call))
    shown = "EXP: Not possible to print EXP unicode WSTRING value, ACT: Not possible to print ACT unicode WSTRING value"
    assert bench.lines == [f"FAILED TEST 'PRG_TEST.s@t', {shown}, MSG: differ"]


@pytest.mark.parametrize(
    ("declarations", "assertion", "expected", "actual", "note"),
    [
        (
            "a : ARRAY[1..6] OF BOOL; b : ARRAY[1..4] OF BOOL;",
            "AssertArrayEquals_BOOL(Expecteds := a, Actuals := b, Message := 'Arrays differ');",
            "SIZE = 6",
            "SIZE = 4",
            ", size of arrays not matching.",
        ),
        (
            "a : ARRAY[-8..-7] OF INT := [12, -23]; b : ARRAY[1..2] OF INT := [12, 24];",
            "AssertArrayEquals_INT(a, b, 'Arrays differ');",
            "ARRAY[-7] = -23",
            "ARRAY[2] = 24",
            "",
        ),
        (
            "a : ARRAY[-4..-2, -1..0] OF LREAL; b : ARRAY[1..2, 0..1] OF LREAL;",
            "AssertArray2dEquals_LREAL(a, b, 0.1, 'Arrays differ');",
            "SIZE = [-4..-2,-1..0] (3x2)",
            "SIZE = [1..2,0..1] (2x2)",
            ", size of arrays not matching.",
        ),
        (
            "a : ARRAY[-5..-4, -1..0] OF REAL; b : ARRAY[0..1, 3..4] OF REAL := [0, 0, 0, 1.0];",
            "AssertArray2dEquals_REAL(a, b, 0.1, 'Arrays differ');",
            "ARRAY[-4,0] = 0.0",
            "ARRAY[1,4] = 1.0",
            "",
        ),
        (
            "a : ARRAY[0..1, 1..1, 2..2] OF LREAL; b : ARRAY[0..1, 1..1, 2..2] OF LREAL := [0, 1.0];",
            "AssertArray3dEquals_LREAL(a, b, 0.1, 'Arrays differ');",
            "ARRAY[1,1,2] = 0.0",
            "ARRAY[1,1,2] = 1.0",
            "",
        ),
    ],
)
def test_arrays_are_compared_by_position(
    declarations: str, assertion: str, expected: str, actual: str, note: str
) -> None:
    bench = SuiteBench.ran(failing(declarations, assertion))
    assert bench.lines == [f"FAILED TEST 'PRG_TEST.s@t', EXP: {expected}, ACT: {actual}, MSG: Arrays differ{note}"]


@pytest.mark.parametrize(
    ("declarations", "expected", "actual"),
    [
        ("a : INT := 5; b : DINT := 5;", "(Type class = INT)", "(Type class = DINT)"),
        ("a : ARRAY[1..2] OF BYTE; b : ARRAY[1..4] OF BYTE;", "(Data size = 2)", "(Data size = 4)"),
        ("a : STRING := 'abc'; b : STRING := 'ab';", "(Data size (LEN) = 3)", "(Data size (LEN) = 2)"),
        ('a : WSTRING := "abc"; b : WSTRING := "ab";', "(Data size (WLEN) = 3)", "(Data size (WLEN) = 2)"),
        ("a : ARRAY[1..2] OF BYTE := [1, 171]; b : ARRAY[1..2] OF BYTE := [1, 2];", "0x01AB", "0x0102"),
    ],
)
def test_any_tells_classes_sizes_and_bytes_apart(declarations: str, expected: str, actual: str) -> None:
    bench = SuiteBench.ran(failing(declarations, "AssertEquals(a, b, 'differ');"))
    assert bench.lines == [f"FAILED TEST 'PRG_TEST.s@t', EXP: {expected}, ACT: {actual}, MSG: differ"]
    assert bench.test("t").failures[0].kind == "ANY"


def test_any_writes_at_most_39_bytes() -> None:
    assert forms.of_bytes(bytes(range(64))) == f"0x{bytes(range(39)).hex().upper()}"


def test_any_compares_instances_members_and_results() -> None:
    text = suite(
        "TEST('t');\nbox.Fill(3);\nAssertEquals(3, box.Filled(), 'result');\nAssertEquals(box.n, list[1], 'member');\n"
        "AssertEquals(box.Size, list[2] * 2, 'property');\nTEST_FINISHED();",
        "box : Box; list : ARRAY[1..2] OF INT := [3, 4];",
    )
    box = """
    FUNCTION_BLOCK Box
    VAR_OUTPUT n : INT; END_VAR
    METHOD Fill VAR_INPUT level : INT; END_VAR n := level; END_METHOD
    METHOD Filled : INT Filled := n; END_METHOD
    PROPERTY Size : INT GET Size := n + 5; END_GET END_PROPERTY
    END_FUNCTION_BLOCK
    """
    bench = SuiteBench.ran(text, box)
    assert bench.lines == []
    assert bench.test("t").asserts == 3


def test_without_a_message_the_last_part_is_left_out() -> None:
    bench = SuiteBench.ran(failing("", "AssertTrue(FALSE, '');"))
    assert bench.lines == ["FAILED TEST 'PRG_TEST.s@t', EXP: TRUE, ACT: FALSE"]


# ---- the length of a line: at most 253 characters, with the two of the placeholder


@pytest.mark.parametrize(
    ("front", "message", "expected"),
    [
        (234, 19, 234 + 19),
        (100, 154, 253),
        (234, 20, 253),
        (235, 20, 253),
        (254, 0, 253),
    ],
)
def test_a_long_line_says_what_is_cut(front: int, message: int, expected: int) -> None:
    text, kept = forms.adjusted("f" * front, "m" * message)
    assert len(text) + len(kept) == expected
    if front > 234:
        assert text == "f" * 233 + "...TestName too long"
        assert kept == ""
    elif front + message > 253:
        assert text == "f" * front
        assert kept == "m" * (234 - front) + "...TestMsg too long"


@given(st.text(max_size=300), st.text(max_size=255))
def test_no_line_is_longer_than_its_limit(front: str, message: str) -> None:
    text, kept = forms.adjusted(front, message)
    assert len(text) + len(kept) <= forms.LONGEST_LINE
