"""Values as people type them and as devices take them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.device import Value
from fieldrig.points.values import fitting, parse_value, show_number


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("true", True),
        ("off", False),
        ("12", 12),
        ("0x1F", 31),
        ("-3", -3),
        ("2.5", 2.5),
        ("1e-3", 0.001),
        ("010", 10),
        ("green", "green"),
        ("", ""),
    ],
)
def test_text_becomes_what_it_looks_like(text: str, value: Value) -> None:
    assert parse_value(text) == value
    assert isinstance(parse_value(text), type(value))


@pytest.mark.parametrize(
    ("value", "present", "fitted"),
    [(1, False, True), (0, True, False), (2, True, 2), (3, 0.5, 3.0), (4.0, 1, 4), (4.5, 1, 4.5), (7, "x", "7")],
)
def test_a_value_takes_the_type_of_the_point_where_nothing_is_lost(value: Value, present: Value, fitted: Value) -> None:
    assert fitting(value, present) == fitted
    assert isinstance(fitting(value, present), type(fitted))


@given(st.floats(allow_nan=False))
def test_a_number_is_shown_with_all_its_digits(value: float) -> None:
    assert float(show_number(value)) == value


@pytest.mark.parametrize(
    ("value", "text"), [(50.0, "50"), (0.1, "0.1"), (1 / 3, "0.3333333333333333"), (1e16, "1e+16"), (115.2, "115.2")]
)
def test_a_number_is_shown_as_short_as_may_be(value: float, text: str) -> None:
    assert show_number(value) == text
