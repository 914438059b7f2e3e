"""Conversions between elementary types: the manual's examples, and properties of every pair."""

import ctypes
import math
import struct
from decimal import ROUND_HALF_EVEN, Decimal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.library.conversions import FUNCTIONS, convert, name_of, pair, python_of
from fieldrig_devices.iec.library.reals import single
from fieldrig_devices.iec.types import EnumType, PointerType, StringType, SubrangeType, Value

E = Elementary
TEXT, WIDE = StringType(), StringType(is_wide=True)
PLAIN = [*E, TEXT]
PAIRS = [(source, target) for source in PLAIN for target in PLAIN if source is not target]
IN_C = {
    E.SINT: ctypes.c_int8, E.INT: ctypes.c_int16, E.DINT: ctypes.c_int32, E.LINT: ctypes.c_int64,
    E.USINT: ctypes.c_uint8, E.UINT: ctypes.c_uint16, E.UDINT: ctypes.c_uint32, E.ULINT: ctypes.c_uint64,
    E.BYTE: ctypes.c_uint8, E.WORD: ctypes.c_uint16, E.DWORD: ctypes.c_uint32, E.LWORD: ctypes.c_uint64,
}  # fmt: skip


def values(kind: E | StringType) -> st.SearchStrategy[Value]:
    if isinstance(kind, StringType):
        letters = st.text(st.characters(max_codepoint=255), max_size=80)
        return st.one_of(
            letters, st.integers().map(str), st.floats().map(str), st.from_regex(r"(T|D|DT|TOD)#[0-9dhms:.-]+")
        )
    if kind is E.BOOL:
        return st.booleans()
    if kind is E.WCHAR:
        return st.characters(max_codepoint=0xFFFF, exclude_categories=["Cs"]).map(ord)
    if kind is E.REAL:
        return st.floats(width=32)
    if kind is E.LREAL:
        return st.floats()
    if kind in (E.LDATE, E.UNSIGNED_LDATE):
        day = 86_400_000_000_000
        return st.integers(kind.low // day, kind.high // day).map(lambda days: days * day)
    if kind is E.DATE:
        return st.integers(0, kind.high // 86_400).map(lambda days: days * 86_400)
    return st.integers(kind.low, kind.high)


def is_value(value: Value, kind: E | StringType) -> bool:
    if isinstance(kind, StringType):
        return isinstance(value, str) and len(value) <= kind.length and max(map(ord, value), default=0) < 256
    if kind is E.BOOL:
        return isinstance(value, bool)
    if kind.is_real:
        return isinstance(value, float) and (kind is E.LREAL or math.isnan(value) or value == single(value))
    return type(value) is int and kind.low <= value <= kind.high and (kind is not E.DATE or value % 86_400 == 0)


# The manual, 2584 to 2745 (PD-L37 to PD-L43), with results as they are printed there.
MANUAL: list[tuple[str, Value, Value]] = [
    ("BOOL_TO_INT", True, 1),
    ("BOOL_TO_STRING", True, "TRUE"),
    ("BOOL_TO_TIME", True, 1),
    ("BOOL_TO_TOD", True, 1),
    ("BOOL_TO_DATE", False, 0),
    ("BOOL_TO_DT", True, 1),
    ("BYTE_TO_BOOL", 0b11010101, True),
    ("INT_TO_BOOL", 0, False),
    ("TIME_TO_BOOL", 5, True),
    ("STRING_TO_BOOL", "TRUE", True),
    ("INT_TO_SINT", 4223, 127),
    ("INT_TO_REAL", 2, 2.0),
    ("REAL_TO_INT", 1.5, 2),
    ("REAL_TO_INT", 1.4, 1),
    ("REAL_TO_INT", 2.7, 3),
    ("TIME_TO_STRING", 12, "T#12ms"),
    ("TIME_TO_DWORD", 5 * 60_000, 300_000),
    ("TOD_TO_SINT", 12, 12),
    ("DATE_TO_BOOL", 0, False),
    ("DATE_TO_INT", 14 * 86_400, 29_952),
    ("DT_TO_BYTE", 14 * 86_400 + 5 * 3_600 + 5 * 60 + 5, 129),
    ("DT_TO_STRING", 887_379_600, "DT#1998-02-13-14:20"),
    ("STRING_TO_WORD", "abc34", 0),
    ("STRING_TO_TIME", "T#127ms", 127),
]


@pytest.mark.parametrize(("name", "value", "result"), MANUAL)
@pytest.mark.manual("PD-367")
def test_examples_of_the_manual(name: str, value: Value, result: Value) -> None:
    types = pair(name)
    assert types is not None
    assert convert(value, *types) == result
    assert type(convert(value, *types)) is type(result)


# What the manual leaves open: the choices in the head of conversions.py and texts.py.
CHOICES: list[tuple[str, Value, Value]] = [
    ("REAL_TO_INT", 2.5, 2),
    ("REAL_TO_INT", -1.5, -2),
    ("REAL_TO_INT", -0.5, 0),
    ("REAL_TO_INT", 70_000.0, 70_000 - 65_536),
    ("REAL_TO_INT", math.inf, 0),
    ("REAL_TO_DINT", math.nan, 0),
    ("REAL_TO_DWORD", -1.0, 0xFFFF_FFFF),
    ("LREAL_TO_REAL", 1e39, math.inf),
    ("DINT_TO_REAL", 16_777_217, 16_777_216.0),
    ("INT_TO_DWORD", -1, 0xFFFF_FFFF),
    ("WORD_TO_INT", 0xFFFF, -1),
    ("DT_TO_TOD", 887_379_600, 51_600_000),
    ("DT_TO_DATE", 887_379_600, 887_328_000),
    ("DATE_TO_DT", 887_328_000, 887_328_000),
    ("DWORD_TO_TOD", 86_400_001, 1),
    ("DWORD_TO_DATE", 86_401, 86_400),
    ("TIME_TO_STRING", 0, "T#0ms"),
    ("TIME_TO_STRING", 90_061_001, "T#1d1h1m1s1ms"),
    ("TIME_TO_STRING", 3_605_000, "T#1h0m5s"),
    ("TIME_TO_STRING", 4_294_967_295, "T#49d17h2m47s295ms"),
    ("TOD_TO_STRING", 51_605_120, "TOD#14:20:05.120"),
    ("DATE_TO_STRING", 887_328_000, "D#1998-02-13"),
    ("DT_TO_STRING", 4_294_967_295, "DT#2106-02-07-06:28:15"),
    ("REAL_TO_STRING", 1.0, "1.0"),
    ("REAL_TO_STRING", single(0.1), "0.1"),
    ("REAL_TO_STRING", single(1e10), "1e+10"),
    ("LREAL_TO_STRING", 0.1, "0.1"),
    ("INT_TO_STRING", -32_768, "-32768"),
    ("STRING_TO_INT", " -12 ", -12),
    ("STRING_TO_INT", "12x", 0),
    ("STRING_TO_INT", "40000", 0),
    ("STRING_TO_INT", "1.5", 0),
    ("STRING_TO_BYTE", "16#ff", 255),
    ("STRING_TO_BYTE", "2#3", 0),
    ("STRING_TO_REAL", "-1.5e3", -1500.0),
    ("STRING_TO_REAL", "1e99", math.inf),
    ("STRING_TO_REAL", "nan", 0.0),
    ("STRING_TO_BOOL", "1", False),
    ("STRING_TO_TIME", "T#1h2m", 3_720_000),
    ("STRING_TO_TIME", "T#5m68s", 0),
    ("STRING_TO_TIME", "T#50d", 0),
    ("STRING_TO_DATE", "D#1998-02-13", 887_328_000),
    ("STRING_TO_DATE", "D#1998-02-30", 0),
    ("STRING_TO_DT", "DT#1998-02-13-14:20", 887_379_600),
    ("STRING_TO_TOD", "TOD#14:20:05.12", 51_605_120),
    ("STRING_TO_TOD", "TOD#24:00:00", 0),
]


@pytest.mark.parametrize(("name", "value", "result"), CHOICES)
def test_cases_that_the_manual_leaves_open(name: str, value: Value, result: Value) -> None:
    types = pair(name)
    assert types is not None
    assert convert(value, *types) == result


def test_other_names_of_the_types_are_known() -> None:
    assert pair("date_and_time_to_time_of_day") == (E.DT, E.TOD)
    assert pair("INT_TO_INT") is None
    assert pair("INT_TO_") is None
    assert name_of(E.DT, TEXT) == "DT_TO_STRING"


@pytest.mark.long
@settings(max_examples=1_000)
@given(st.data())
def test_every_value_has_a_result_in_range(data: st.DataObject) -> None:
    source, target = data.draw(st.sampled_from(PAIRS))
    value = data.draw(values(source))
    assert is_value(convert(value, source, target), target)


EDGES: dict[E | StringType, list[Value]] = {
    TEXT: ["", "T#", "D#0000-00-00", "DT#9999-12-31-23:59:59", "1" * 255, "-", "16#", "\xff"],
    E.BOOL: [False, True],
}
REALS: list[Value] = [0.0, -0.0, math.inf, -math.inf, math.nan, 1e-45, 0.5, -0.5, 2.0**31, 2.0**63, -(2.0**63), 3.4e38]


def _ends(kind: E | StringType) -> list[Value]:
    assert isinstance(kind, E)
    return REALS if kind in (E.REAL, E.LREAL) else [kind.low, kind.high // 86_400 * 86_400]


@pytest.mark.parametrize(("source", "target"), PAIRS, ids=str)
def test_edges_of_every_type_have_a_result_in_range(source: E | StringType, target: E | StringType) -> None:
    edges = EDGES[source] if source in EDGES else _ends(source)
    assert all(is_value(convert(value, source, target), target) for value in edges)


@given(st.data())
def test_integers_are_cut_as_c_cuts_them(data: st.DataObject) -> None:
    source, target = data.draw(st.sampled_from([(a, b) for a in IN_C for b in IN_C]))
    value = data.draw(st.integers(source.low, source.high))
    assert convert(value, source, target) == IN_C[target](value).value


@given(st.sampled_from(list(IN_C)), st.floats(-(2.0**62), 2.0**62) | st.integers(-2000, 2000).map(lambda n: n / 2))
def test_real_numbers_are_rounded_half_to_even_and_cut(target: E, value: float) -> None:
    nearest = int(Decimal(value).to_integral_value(ROUND_HALF_EVEN))
    assert convert(value, E.LREAL, target) == IN_C[target](nearest).value


@given(st.data())
def test_text_of_a_value_is_read_as_the_value(data: st.DataObject) -> None:
    kind = data.draw(st.sampled_from([kind for kind in E if kind not in (E.REAL, E.LREAL)]))
    value = data.draw(values(kind))
    if kind in (E.LDATE, E.LDT):
        value = min(abs(int(value)), kind.high)  # the constants begin with 1970
    text = WIDE if kind is E.WCHAR else TEXT
    assert convert(convert(value, kind, text), text, kind) == value


@pytest.mark.parametrize(
    "kind", [kind for kind in E if kind not in (E.REAL, E.LREAL, E.LDATE, E.LDT, E.UNSIGNED_LDATE)], ids=str
)
def test_text_of_an_end_of_a_type_is_read_as_the_value(kind: E) -> None:
    text = WIDE if kind is E.WCHAR else TEXT
    for value in _ends(kind):
        assert convert(convert(value, kind, text), text, kind) == value


@given(st.floats(width=32, allow_nan=False, allow_infinity=False, allow_subnormal=False))
def test_text_of_a_real_number_has_seven_digits(value: float) -> None:
    text = convert(value, E.REAL, TEXT)
    assert isinstance(text, str)
    assert math.isclose(float(text), value, rel_tol=6e-7)
    assert "." in text or "e" in text


@given(st.data())
def test_a_larger_integer_type_keeps_every_value(data: st.DataObject) -> None:
    small = data.draw(st.sampled_from(list(IN_C)))
    large = data.draw(st.sampled_from([kind for kind in IN_C if kind.low <= small.low and small.high <= kind.high]))
    value = data.draw(st.integers(small.low, small.high))
    assert convert(value, small, large) == value
    assert python_of(small, large) == "{0}"


@given(st.floats())
def test_single_precision_is_that_of_struct(value: float) -> None:
    try:
        (expected,) = struct.unpack("<f", struct.pack("<f", value))
    except OverflowError:
        expected = math.copysign(math.inf, value)
    assert struct.pack("<d", single(value)) == struct.pack("<d", expected) or math.isnan(value) == math.isnan(expected)


@pytest.mark.parametrize(
    ("value", "result"),
    [
        (1 + 2**-24, 1.0),  # a tie goes to the even neighbour
        (1 + 3 * 2**-24, 1 + 2**-22),
        (3.4028235677973366e38, math.inf),  # half a unit above the largest number
        (3.4028235677973362e38, 3.4028234663852886e38),
        (2.0**-150, 0.0),
        (2.0**-149, 2.0**-149),
    ],
)
def test_rounding_to_single_precision_at_the_edges(value: float, result: float) -> None:
    assert single(value) == result


def test_enumerations_subranges_and_pointers_convert_like_their_numbers() -> None:
    color = EnumType("color", {"red": 0, "green": 10})
    assert convert(10, color, E.REAL) == 10.0
    assert convert(300, SubrangeType(E.INT, 0, 1000), E.BYTE) == 44
    assert convert(70_000, PointerType(E.INT), E.WORD) == 4_464


def test_a_character_that_a_string_does_not_have_becomes_a_question_mark() -> None:
    assert [convert(code, E.WCHAR, TEXT) for code in (0x41, 0xE9, 0xFF, 0x100, 0x20AC)] == ["A", "é", "ÿ", "?", "?"]
    assert convert(0x20AC, E.WCHAR, StringType(5, is_wide=True)) == "€"


def test_a_short_string_takes_the_first_characters() -> None:
    assert convert("abcdef", TEXT, StringType(3)) == "abc"
    assert convert(123456, E.DINT, StringType(3)) == "123"


def test_python_of_a_conversion_calls_only_what_is_listed() -> None:
    for source, target in PAIRS:
        code = compile(python_of(source, target).replace("{0}", "value"), "", "eval")
        assert set(code.co_names) <= {"value", *FUNCTIONS}
