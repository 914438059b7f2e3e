"""Values as people type them and as devices take them."""

import pytest

from fieldrig.device import Value
from fieldrig.values import fitting, parse_value


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
