"""Numeric fields: golden cases, and properties of all fields."""

from decimal import Decimal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.arp.terminal.pattern import Pattern, find

pytestmark = pytest.mark.manual("ARP-114")

# Pattern, raw value, text of the field.
SHOWN = [
    ("#####.###", 1_234_567, " 1234.567"),
    ("#####.###", 99_999_999, "99999.999"),
    ("#####.###", 100_000_000, "*********"),  # the pattern has 5 digits, variables have 6
    ("#####.###", 999_999_999, "*********"),
    ("#####.###", -9_999_999, "-9999.999"),
    ("#####.###", -10_000_000, "*********"),  # the minus takes a place
    ("#####.###", 0, "    0.000"),
    ("#####.###", 5, "    0.005"),
    ("#####.###", -5, "   -0.005"),
    ("#####.#", 9_999_900, " 9999.9"),
    ("#####.#", 9_999_999, " 9999.9"),
    ("#####.#", -99, "    0.0"),  # there is no minus zero
    ("#####.##", 1_239, "    1.23"),
    ("#####", 12_999, "   12"),
    ("#", 9_000, "9"),
    ("#", 10_000, "*"),
    ("#", -1_000, "*"),
    ("##", -1_000, "-1"),
]


@pytest.mark.parametrize(("pattern", "raw", "shown"), SHOWN)
def test_value_in_its_field(pattern: str, raw: int, shown: str) -> None:
    field = find(pattern)
    assert field is not None
    assert field.show(raw) == shown


@pytest.mark.parametrize(("raw", "shown"), [(10_949, "10.9"), (10_950, "11.0"), (-9_950, "****"), (99_950, "****")])
def test_rounded_decimals_are_the_other_reading(raw: int, shown: str) -> None:
    assert Pattern(0, 4, 1).show(raw, "rounded") == shown


# Message, and the field in it.
FOUND = [
    ("LENGTH: = #####.", Pattern(10, 5, 0)),  # the manual's second message, cut at 16
    ("####.# mm", Pattern(0, 6, 1)),
    ("V ##.### OF ###", Pattern(2, 6, 3)),  # the first one only
    ("######", Pattern(0, 5, 0)),  # no longer than #####.###, the rest is text
    ("#####.####", Pattern(0, 9, 3)),
    (".###", Pattern(1, 3, 0)),
    ("DONE.", None),
    ("", None),
]


@pytest.mark.parametrize(("message", "field"), FOUND)
def test_field_in_a_message(message: str, field: Pattern | None) -> None:
    assert find(message) == field


# Pattern, keys, text of the field after them.
TYPED = [
    ("###.#", "1 2 POINT 5", "12.5"),
    ("###.#", "1 2 POINT 5 6", "12.5"),
    ("###.#", "1 2 3 4", "123"),
    ("###.#", "POINT 5", ".5"),
    ("###.#", "1 POINT POINT 5", "1.5"),
    ("###.#", "1 MINUS", "-1"),
    ("###.#", "1 MINUS MINUS", "1"),
    ("###.#", "1 2 3 MINUS", "123"),  # -123.0 has no room
    ("###.#", "1 2 DEL", "1"),
    ("###.#", "DEL", ""),
    ("###", "1 POINT 5", "15"),
    ("###", "MINUS 1 2 3", "-12"),
]


@pytest.mark.parametrize(("pattern", "keys", "typed"), TYPED)
def test_keys_are_taken_as_far_as_there_is_room(pattern: str, keys: str, typed: str) -> None:
    field = find(pattern)
    assert field is not None
    text = ""
    for key in keys.split():
        text = field.typed(text, key)
    assert text == typed


@pytest.mark.parametrize(
    ("typed", "raw"), [("12.5", 12_500), ("-0.125", -125), (".5", 500), ("5.", 5_000), ("", None), ("-", None)]
)
def test_what_was_typed_as_a_value(typed: str, raw: int | None) -> None:
    assert Pattern(0, 9, 3).parse(typed) == raw


PATTERNS = st.builds(
    lambda whole, decimals: Pattern(0, whole + (decimals + 1 if decimals else 0), decimals),
    st.integers(1, 5),
    st.integers(0, 3),
)
RAWS = st.integers(-999_999_999, 999_999_999)
KEYS = st.lists(st.sampled_from([*"0123456789", "POINT", "MINUS", "DEL"]), max_size=20)


@pytest.mark.long
@given(PATTERNS, RAWS)
@settings(max_examples=200, deadline=None)
def test_field_is_as_wide_as_its_pattern_and_shows_the_value_or_stars(field: Pattern, raw: int) -> None:
    shown = field.show(raw)
    assert len(shown) == field.width
    if "*" not in shown:
        step = 10 ** (3 - field.decimals)
        assert int(Decimal(shown) * 1000) == int(Decimal(raw) / step) * step  # towards zero
    else:
        assert shown == "*" * field.width
        needed = len(str(abs(raw) // 1000)) + (raw < 0) + (field.decimals + 1 if field.decimals else 0)
        assert needed > field.width


@pytest.mark.long
@given(PATTERNS, KEYS)
@settings(max_examples=200, deadline=None)
def test_whatever_is_typed_fits_and_shows_as_it_was_typed(field: Pattern, keys: list[str]) -> None:
    text = ""
    for key in keys:
        text = field.typed(text, key)
        assert len(text) <= field.width
    raw = field.parse(text)
    if raw is not None:
        assert "*" not in field.show(raw)
        assert Decimal(field.show(raw).strip()) * 1000 == raw


@pytest.mark.long
@given(st.text(alphabet="#.A ", max_size=16))
@settings(max_examples=200, deadline=None)
def test_a_message_keeps_its_length_whatever_its_field_shows(message: str) -> None:
    field = find(message)
    if field is not None:
        assert len(field.put_into(message, field.show(12_345))) == len(message)
        assert set(message[field.start : field.start + field.width]) <= {"#", "."}
