"""Durations as people write them, in each unit."""

import pytest

from fieldrig.text.durations import UNITS_NS, duration_ns


@pytest.mark.parametrize(
    ("text", "ns"),
    [
        ("10ns", 10),
        ("10us", 10_000),
        ("10ms", 10_000_000),
        ("1.5s", 1_500_000_000),
        ("2min", 120_000_000_000),
        ("8h", 28_800_000_000_000),  # a search over night
    ],
)
def test_a_number_with_a_unit_is_a_duration(text: str, ns: int) -> None:
    assert duration_ns(text) == ns
    assert any(text.endswith(unit) for unit in UNITS_NS)


@pytest.mark.parametrize("text", ["", "1", "s", "-1s", "1d", "1hour", "nans", "infs", "1e400s"])
def test_anything_else_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="is not a duration"):
        duration_ns(text)


@pytest.mark.parametrize("text", ["1e30s", "1300000h", "9223372036854775807ns"])
def test_what_no_clock_reaches_is_refused(text: str) -> None:
    """A scenario `after: 1e30s` ran without end."""
    with pytest.raises(ValueError, match="is too long; expected at most 1278960h, which is 146 years"):
        duration_ns(text)
