"""Spans of a trace in words."""

import pytest

from fieldrig.clock import MS, US, S
from fieldrig.traces.instants import span


@pytest.mark.parametrize(
    ("span_ns", "words"),
    [
        (0, "0 ns"),
        (999, "999 ns"),
        (850 * US, "850 us"),
        (999_600, "1 ms"),
        (12_345 * US, "12.3 ms"),
        (999_999_999, "1 s"),
        (7_080 * MS, "7.08 s"),
        (1_197_970 * S, "1197970 s"),
        (-4_090 * MS, "-4.09 s"),
    ],
)
def test_a_span_has_no_power_of_ten(span_ns: int, words: str) -> None:
    assert span(span_ns) == words
