"""Files of coverage: they come back as they were, add up in any order, and anything else is refused."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.coverage.data import FORMAT, read, written
from fieldrig.coverage.places import Kind, News, Place
from fieldrig.coverage.summary import Coverage

NUMBERS = st.integers(0, 40)
PLACES = st.builds(
    Place,
    st.sampled_from(["/w/a.st", "/w/b.pam", "/w/ä ö.I01"]),
    st.sampled_from(["Main", "SEQ_a"]),
    st.sampled_from(list(Kind)),
    NUMBERS,
    NUMBERS,
    NUMBERS,
    st.sampled_from(["", "ELSE", "a & b"]),
)
NEWS = st.lists(st.tuples(PLACES, st.booleans()), max_size=12).map(tuple)


def known(coverage: Coverage) -> dict[object, bool]:
    return {place.key: has_run for place, has_run in coverage.news}


@given(NEWS)
def test_a_file_comes_back_as_it_was(news: News) -> None:
    coverage = Coverage(news)
    assert Coverage(read(written(coverage))).news == coverage.news


@given(NEWS, NEWS, NEWS)
def test_runs_add_up_in_any_order_and_once_is_as_good_as_twice(first: News, second: News, third: News) -> None:
    one, other = Coverage((*first, *second, *third)), Coverage((*third, *first, *second, *first))
    assert known(one) == known(other)
    apart = Coverage()
    for news in (first, second, third):
        apart.add(read(written(Coverage(news))))
    assert known(apart) == known(one)


PLACE: list[object] = ["a.st", "Main", "statement", 1, 1, 0, "", True]
WRONG_PLACES: list[object] = [
    None,
    7,
    [7],
    [[]],
    [PLACE[:-2]],
    [[*PLACE, 1]],
    [["a.st", "Main", "unknown", *PLACE[3:]]],
    [[7, *PLACE[1:]]],
    [[*PLACE[:3], "1", *PLACE[4:]]],
    [[*PLACE[:3], True, *PLACE[4:]]],
]
WRONG = [
    b"",
    b"{}",
    b"[]",
    b"[" * 100_000,
    b"\xff",
    b'{"format": "other", "places": []}',
    *(json.dumps({"format": FORMAT, "places": places}).encode() for places in WRONG_PLACES),
]


@pytest.mark.parametrize("data", WRONG)
def test_anything_else_is_refused(data: bytes) -> None:
    with pytest.raises(ValueError, match=r"\w"):
        read(data)


@given(st.binary(max_size=60) | st.text(max_size=60).map(str.encode))
def test_no_other_bytes_are_read(data: bytes) -> None:
    with pytest.raises(ValueError, match=r"\w"):
        read(data)
