"""The runs of a ramp in periods are its periods one by one, in both directions."""

from collections.abc import Iterable
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.hmiscu.pto.periods import Run, Staircase

LOWS = st.sampled_from([0, 1, 2]) | st.integers(0, 50_000)
RATES = st.builds(Fraction, st.just(1_000) | st.integers(1_000, 10_000_000), st.sampled_from([1, 3]))


def periods(runs: Iterable[Run]) -> list[int]:
    return [frequency for frequency, count in runs for _ in range(count)]


@pytest.mark.manual("SCU-084")
@given(st.builds(Staircase, LOWS, RATES, st.booleans()), st.integers(0, 40))
def test_runs_are_the_periods_one_by_one(ramp: Staircase, count: int) -> None:
    one_by_one = [ramp.frequency(number) for number in range(count)]
    assert periods(ramp.rising(count)) == one_by_one
    assert periods(ramp.falling(count)) == one_by_one[::-1]


@pytest.mark.manual("SCU-084")
def test_the_last_period_of_a_ramp_is_never_part_of_a_run() -> None:
    """All four periods above 31938 Hz round up to 31939 Hz at 1000 Hz/s; the last one is the stop frequency."""
    assert [*Staircase(31_938, Fraction(1_000)).falling(4)] == [(31_939, 3), (31_938, 1)]
