"""The reader of JSON from outside: the limits, and that nothing makes it raise anything but a MalformedError."""

import json
from math import inf
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.outside.untrusted import DEEPEST, MalformedError, field, items, read_json, shown, typed

SURROGATES: Any = ("Cs",)
TEXTS = st.text(st.characters(exclude_categories=SURROGATES))
GOOD = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(1 << 63), (1 << 64) - 1)
    | st.floats(allow_nan=False, allow_infinity=False)
    | TEXTS,
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(TEXTS, inner, max_size=5),
    max_leaves=20,
)


@pytest.mark.long
@given(GOOD)
def test_what_json_says_is_read(value: Any) -> None:
    assert read_json(json.dumps(value).encode()) == value
    assert read_json(json.dumps(value, ensure_ascii=False).encode()) == value


@given(st.binary(max_size=60) | st.text(alphabet='[]{}",:\\u0d8e19.-+INnatfrl ', max_size=60).map(str.encode))
def test_any_bytes_are_read_or_refused(data: bytes) -> None:
    try:
        value = read_json(data)
    except MalformedError:
        return
    assert json.loads(data) == value


@pytest.mark.long
@pytest.mark.parametrize(
    "text",
    [
        "[" * 2000,
        "[" * 1_000_000,
        '{"a":' * 2000,
        "[" * (DEEPEST + 1) + "]" * (DEEPEST + 1),
        "",
        "[1,2",
        "1 2",
        "NaN",
        "[Infinity]",
        "-Infinity",
        "1e999",
        "18446744073709551616",
        "-9223372036854775809",
        "9" * 5000,
        '{"a": 1, "a": 2}',
        '"\\ud800"',
        '{"\\uDC00": 1}',
        "\ufeff1",
        '"a\nb"',
        "'a'",
    ],
)
def test_what_is_refused(text: str) -> None:
    with pytest.raises(MalformedError):
        read_json(text)
    with pytest.raises(MalformedError):
        read_json(text.encode())


def test_messages_within_a_rig_have_every_float() -> None:
    assert read_json('{"a": [NaN, Infinity, -Infinity]}', takes_nan=True)["a"][1:] == [inf, -inf]
    with pytest.raises(MalformedError):
        read_json("1e999", takes_nan=True)


@pytest.mark.parametrize("data", [b"\xff", b'"\xed\xa0\x80"', "[1]".encode("utf-16"), "[1]".encode("utf-32")])
def test_other_encodings_are_refused(data: bytes) -> None:
    with pytest.raises(MalformedError, match=r"UTF-8|not JSON"):
        read_json(data)


def test_half_of_a_pair_in_a_text_is_refused() -> None:
    with pytest.raises(MalformedError, match="surrogate"):
        read_json('"\ud800"')


def test_brackets_in_texts_are_not_depth() -> None:
    text = "[" * 100 + '\\"' + "{" * 100
    assert read_json(json.dumps([text])) == [text]


def test_the_limits_hold_to_the_last() -> None:
    nested = "[" * DEEPEST + "]" * DEEPEST
    assert json.dumps(read_json(nested)) == nested
    assert read_json("[1]", longest=3) == [1]
    with pytest.raises(MalformedError, match="4 bytes, expected at most 3"):
        read_json("[12]", longest=3)
    assert read_json("[18446744073709551615, -9223372036854775808]") == [(1 << 64) - 1, -(1 << 63)]


@given(GOOD, st.sampled_from([str, int, float, bool, list, dict]))
def test_a_value_has_the_type_that_was_asked_for(value: Any, kind: type[Any]) -> None:
    try:
        found = typed(value, kind)
    except MalformedError:
        assert type(value) is not kind
    else:
        assert type(found) is kind
        assert found == value or kind is float


def test_a_field_is_there_and_of_its_type() -> None:
    assert field({"member": "io"}, "member", str) == "io"
    all_wrong: list[Any] = [None, [], "member", {}, {"member": 1}, {"member": None}, {"member": ["io"]}]
    for wrong in all_wrong:
        with pytest.raises(MalformedError):
            field(wrong, "member", str)
    with pytest.raises(MalformedError, match="unit: expected an integer, found True"):
        field({"unit": True}, "unit", int)


def test_an_array_is_no_longer_than_it_may_be() -> None:
    assert items([1, 2], int, 2) == [1, 2]
    all_wrong: list[Any] = [[1, 2, 3], [1, "2"], {"1": 2}, None, [[1]], [True]]
    for wrong in all_wrong:
        with pytest.raises(MalformedError):
            items(wrong, int, 2)


def test_what_is_shown_is_short_and_on_one_line() -> None:
    assert shown("a\nb\x1b[31m\u2028") == r"'a\nb\x1b[31m\u2028'"
    assert len(shown("x" * 1000)) == 63
