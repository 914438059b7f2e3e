"""Numeric ranges of OPC 10000-4, 7.27, and what they are a part of."""

import pytest
from asyncua import ua
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.opcua.values import bounds, part_of, wrong_read


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("6", (6, 6)),
        ("5:7", (5, 7)),
        ("0:0", None),  # "the first bound shall be less than the second"
        ("7:5", None),
        ("", None),
        (":3", None),
        ("3:", None),
        ("+1", None),
        ("١", None),
        ("1:2:3", None),
    ],
)
def test_bounds_of_a_dimension(text: str, found: tuple[int, int] | None) -> None:
    assert bounds(text) == found


@given(
    st.text(alphabet="0123456789:,- ab\0", max_size=30),
    st.lists(st.integers(-5, 5), min_size=1) | st.text() | st.binary(),
)
def test_any_range_is_refused_or_is_a_part(text: str, whole: list[int] | str | bytes) -> None:
    read = ua.ReadValueId(AttributeId=ua.AttributeIds.Value, IndexRange=text)
    if wrong_read(read):
        return
    value = part_of(read, ua.DataValue(ua.Variant(whole)))
    if not text:
        assert value.Value.Value == whole
    elif value.StatusCode.is_good():
        first, last = bounds(text) or (0, 0)
        assert value.Value.Value == whole[first : last + 1] != whole[:0]
    else:
        assert value.StatusCode.name == "BadIndexRangeNoData"
