"""Quantiles in bounded memory."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.log_stats.series import Series
from fieldrig_devices.log_stats.spread import MOST_EXACT, Spread


def spread_of(values: list[int]) -> Spread:
    spread = Spread()
    for value in values:
        spread.add(value)
    return spread


def test_quantiles_of_few_values_are_exact() -> None:
    spread = spread_of(list(range(1, 101)))
    assert [spread.quantile(part) for part in (0, 0.01, 0.5, 0.99, 1)] == [1, 1, 50, 99, 100]
    assert (spread.count, spread.lowest, spread.highest, spread.total, spread.is_exact) == (100, 1, 100, 5050, True)


def test_there_is_no_quantile_of_nothing() -> None:
    assert Spread().quantile(0.5) == 0


@given(
    st.lists(st.integers(0, 10**12), min_size=1, max_size=50), st.integers(21, 60), st.sampled_from([0.01, 0.5, 0.99])
)
def test_quantiles_of_many_values_are_within_one_percent(values: list[int], times: int, part: float) -> None:
    every = values * times
    spread, exact = spread_of(every), sorted(every)[max(1, -int(-part * len(every) // 1)) - 1]
    assert abs(spread.quantile(part) - exact) <= 0.011 * exact + 1
    assert spread.is_exact == (len(every) <= MOST_EXACT)


def test_memory_does_not_grow_with_the_number_of_values() -> None:
    spread = spread_of([10**6 + number % 1000 for number in range(50_000)])
    assert spread._values is None
    assert len(spread._classes) < 10


@pytest.mark.parametrize(
    ("instants", "period", "jitter"), [([0], 0, 0), ([0, 10, 20, 30], 10, 0), ([0, 10, 25, 35], 10, 5)]
)
def test_period_is_the_median_and_jitter_what_it_deviates(instants: list[int], period: int, jitter: int) -> None:
    series = Series()
    for instant in instants:
        series.add(instant, 8)
    assert (series.count, series.bytes, series.period_ns, series.jitter_ns) == (
        len(instants),
        8 * len(instants),
        period,
        jitter,
    )


def test_a_jump_back_in_time_is_no_gap() -> None:
    series = Series()
    for instant in (100, 200, 50, 150):
        series.add(instant, 1)
    assert (series.gaps.count, series.gaps.highest) == (2, 100)
