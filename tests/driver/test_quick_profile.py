"""The stage `quick` has few examples of every property, and the stage `unit` has as many as the test states."""

import hypothesis
from hypothesis import given, settings
from hypothesis import strategies as st

SEEN: list[int] = []


@settings(max_examples=30)
@given(st.integers())
def test_a_property(number: int) -> None:
    SEEN.append(number)


def test_a_number_of_examples_is_stated_for_the_whole_profile() -> None:
    SEEN.clear()
    test_a_property()
    is_quick = hypothesis.settings.get_current_profile_name() == "quick"
    assert len(SEEN) == (10 if is_quick else 30)
