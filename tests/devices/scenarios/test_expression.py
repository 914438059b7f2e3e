"""Expressions: precedence, names with signs in them, and texts that are none."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.device import Value
from fieldrig_devices.scenarios.expression import DEEPEST, LONGEST, expression_of

VALUES: dict[str, Value] = {
    "a/b": 3,
    "axis/6041:00": 0x0637,
    "stop-key/pressed": True,
    "tank/level": 1.5,
    "belt/name": "main",
    "x/0": 0,
}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a/b", 3),
        ("stop-key/pressed", True),
        ("axis/6041:00 & 0x6f == 0x27", True),
        ("axis/6041:00 | 1 == 0x637", True),
        ("1 + 2 * 3", 7),
        ("(1 + 2) * 3", 9),
        ("10 - 2 - 3", 5),
        ("7 / 2", 3.5),
        ("- a/b + 1", -2),
        ("-2 + a/b", 1),
        ("not stop-key/pressed or tank/level > 1.4", True),
        ("not (stop-key/pressed or tank/level > 1.4)", False),
        ("true or true and false", True),
        ("not false and false", False),
        ("abs(tank/level - 2) < 0.51", True),
        ("min(a/b, 2, 7) == 2", True),
        ("max(a/b, 2) == 3", True),
        ("belt/name == 'main'", True),
        ('belt/name != "a b"', True),
        ("TRUE AND NOT FALSE", True),
        ("1e3 == 1000", True),
        ("0b101 == 5", True),
    ],
)
def test_values_by_hand(text: str, expected: object) -> None:
    assert expression_of(text).evaluate(VALUES) == expected


def test_places_are_listed_once_in_their_order() -> None:
    assert expression_of("tank/level > a/b and a/b < 7 or x/0 == 1").places == ("tank/level", "a/b", "x/0")


def test_a_division_by_zero_is_not_true() -> None:
    assert expression_of("1 / x/0 > 3").holds(VALUES) is False


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "got the end"),
        ("a/b >", "got the end"),
        ("a/b a/b", "'a/b' does not go on"),
        ("1 < a/b < 4", "'<' does not go on"),
        ("(a/b", "got ''"),
        ("level > 3", "got 'level'"),
        ("a/b => 3", "'=>' does not go on"),
        ("abs(1, 2)", "abs has 2 values"),
        ("min(1)", "min has 1 values"),
        ("belt/name == 'main", "has no end"),
        ("(" * (DEEPEST + 1) + "1" + ")" * (DEEPEST + 1), "nested too deeply"),
        ("not " * (DEEPEST + 1) + "true", "nested too deeply"),
        ("1 + " * LONGEST + "1", "characters"),
    ],
)
def test_what_is_no_expression_says_where(text: str, what: str) -> None:
    with pytest.raises(ValueError, match=r"(?s).") as caught:
        expression_of(text)
    assert what in str(caught.value)
    assert "expected" in str(caught.value)


@given(st.text(alphabet="ab/01<>=&|+-*() \"'.nottruead", max_size=40))
def test_any_text_is_an_expression_or_refused(text: str) -> None:
    try:
        found = expression_of(text)
    except ValueError:
        return
    with suppress(TypeError, OverflowError):
        found.holds(dict.fromkeys(found.places, 1))
