"""The one wording in which every device refuses a value of a point."""

from collections.abc import Callable
from math import inf, isfinite, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.device import Value
from fieldrig.points.checks import choice_in, number_in, text_in, truth_in, whole_in

VALUES = st.booleans() | st.integers() | st.floats() | st.text(max_size=5)


@pytest.mark.parametrize(
    ("check", "says"),
    [
        (lambda: number_in(11, 0, 10), "expected a number from 0 to 10, got 11"),
        (lambda: number_in(2.5, 0.0, 2.0, "m"), "expected a number from 0 to 2 m, got 2.5"),
        (
            lambda: number_in(4096, 0, unit="turns", below=4096),
            "expected a number from 0 to less than 4096 turns, got 4096",
        ),
        (lambda: number_in(-1, 0), "expected a number of at least 0, got -1"),
        (lambda: number_in(1, high=0, unit="V"), "expected a number of at most 0 V, got 1"),
        (lambda: number_in("much", unit="N m"), "expected a number in N m, got 'much'"),
        (lambda: number_in(True), "expected a number, got True"),
        (lambda: number_in(nan, 0, 10), "expected a number from 0 to 10, got nan"),
        (lambda: number_in(inf), "expected a number, got inf"),
        (lambda: number_in(11, 0, 10, name="speed"), "speed: expected a number from 0 to 10, got 11"),
        (lambda: whole_in(1.5, 0, 0xFFFF), "expected a whole number from 0 to 65535, got 1.5"),
        (lambda: whole_in(70000, 0, 0xFFFF), "expected a whole number from 0 to 65535, got 70000"),
        (lambda: whole_in(inf), "expected a whole number, got inf"),
        (lambda: truth_in("on", "enable"), "enable: expected true or false, got 'on'"),
        (lambda: truth_in(2), "expected true or false, got 2"),
        (lambda: text_in("longer", 5), "expected a text of up to 5 characters, got 'longer'"),
        (lambda: text_in(5, 5), "expected a text of up to 5 characters, got 5"),
        (lambda: choice_in("go", ("run", "stop", "reset")), "expected run, stop or reset, got 'go'"),
        (lambda: choice_in(3, (1,), "mode"), "mode: expected 1, got 3"),
    ],
)
def test_refusal_says_what_was_expected_and_what_it_got(check: Callable[[], Value], says: str) -> None:
    with pytest.raises(ValueError) as refusal:  # noqa: PT011
        check()
    assert str(refusal.value) == says


@given(VALUES, st.integers(-5, 5), st.integers(-5, 5))
def test_a_number_is_returned_exactly_if_it_is_one_within_the_limits(value: Value, low: int, high: int) -> None:
    fits = not isinstance(value, bool | str) and isfinite(value) and low <= value <= high
    try:
        assert number_in(value, low, high) == value
    except ValueError:
        assert not fits
    else:
        assert fits


@given(VALUES)
def test_what_is_returned_is_the_value_in_the_type_of_the_check(value: Value) -> None:
    for check, kind in ((whole_in, int), (truth_in, bool)):
        try:
            taken = check(value)
        except ValueError:
            continue
        assert (type(taken), taken) == (kind, value)
