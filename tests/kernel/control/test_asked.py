"""Refusals speak as people do."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.control.question_words import asked

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@pytest.mark.parametrize(
    ("verb", "message", "words"),
    [
        ("restart", {"name": "io"}, "restart io"),
        ("pause", None, "pause"),
        ("get", {"keys": ["level", "inflow"]}, "get level inflow"),
        ("join", {"process": "io", "pid": 7}, "join process io, pid 7"),
        ("set", {"values": {"level": 1.5}}, "set level=1.5"),
        ("step", 5, "step 5"),
    ],
)
def test_a_question_in_words(verb: str, message: object, words: str) -> None:
    assert asked(verb, message) == words


@pytest.mark.long
@given(JSON)
def test_it_stays_short_whatever_was_asked(message: object) -> None:
    assert asked("get", message).startswith("get")
    assert len(asked("get", message)) < 100
