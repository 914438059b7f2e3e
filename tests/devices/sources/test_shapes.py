"""The courses of living values: values at named ages, and each change announced at its nanosecond."""

from collections.abc import Callable
from datetime import datetime
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig import MS, S
from fieldrig.clock import NEVER_NS
from fieldrig_devices.sources.shapes import (
    Constant,
    Counter,
    DateAndTime,
    Ramp,
    RandomWalk,
    Replay,
    Sine,
    Source,
    Square,
)

MAKERS: dict[str, Callable[[], Source]] = {
    "constant": lambda: Constant(5.0),
    "sine": lambda: Sine(-10, 10, 4 * S, 0, 100 * MS),
    "ramp": lambda: Ramp(20, 10, 1 * S, True, 30 * MS),
    "ramp once": lambda: Ramp(0, 7, 250 * MS, False, 100 * MS),
    "square": lambda: Square(0, 1, 10 * MS, 3 * MS),
    "walk": lambda: RandomWalk(0, 10, 5, 1, 20 * MS, "flow"),
    "counter": lambda: Counter(3, Fraction(73, 10), Fraction(1), 10),
    "count down": lambda: Counter(0, Fraction(-7, 10), Fraction(1, 10), None),
    "count down and wrap": lambda: Counter(1, Fraction(-100), Fraction(1), 65536),
    "clock": lambda: DateAndTime(datetime(2024, 2, 28, 23, 59, 58), "day"),  # noqa: DTZ001
    "replay": lambda: Replay([0, 5 * MS, 50 * MS], [1, 2, 1.5], 60 * MS),
    "replay once": lambda: Replay([0, 5 * MS], [1, 2], None),
}


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("sine", {0: 0, 1 * S: 10, 2 * S: 0, 3 * S: -10, 5 * S: 10}),
        ("ramp", {0: 20, 150 * MS: 18.5, 179 * MS: 18.5, 990 * MS: 10.1}),
        ("ramp once", {0: 0, 200 * MS: 5.6, 300 * MS: 7, 9 * S: 7}),
        ("square", {0: 1, 3 * MS - 1: 1, 3 * MS: 0, 10 * MS: 1}),
        ("counter", {0: 3, S // 7: 4, 1 * S: 0, 10 * S: 6}),
        ("count down", {0: 0, 142_857_142: 0, 142_857_143: -0.1, 10 * S: -7}),
        ("count down and wrap", {0: 1, 10 * MS - 1: 1, 10 * MS: 0, 20 * MS - 1: 0, 20 * MS: 65535, 1 * S: 65437}),
        ("replay", {0: 1, 5 * MS: 2, 49 * MS: 2, 50 * MS: 1.5, 60 * MS: 1, 65 * MS: 2}),
        ("replay once", {4 * MS: 1, 9 * S: 2}),
    ],
)
def test_values_at_ages(name: str, values: dict[int, float]) -> None:
    source: Source = MAKERS[name]()
    assert {age_ns: source.at(age_ns) for age_ns in values} == pytest.approx(values)


@pytest.mark.parametrize(
    ("part", "before", "after"),
    [
        ("unix", 1_709_164_799, 1_709_164_800),  # 29 February 2024, 00:00 UTC
        ("year", 2024, 2024),
        ("month", 2, 2),
        ("day", 28, 29),
        ("weekday", 3, 4),  # a Wednesday
        ("hour", 23, 0),
        ("minute", 59, 0),
        ("second", 59, 0),
    ],
)
def test_the_parts_of_a_date(part: str, before: int, after: int) -> None:
    clock = DateAndTime(datetime(2024, 2, 28, 23, 59, 58), part)  # noqa: DTZ001
    assert (clock.at(2 * S - 1), clock.at(2 * S)) == (before, after)


@given(st.sampled_from(sorted(MAKERS)), st.lists(st.integers(1, 400 * MS), min_size=1, max_size=8))
def test_a_value_changes_only_when_it_has_said_so(name: str, waits: list[int]) -> None:
    """A reader at the announced ages only sees the same values as a reader at any age."""
    source: Source = MAKERS[name]()
    announced: Source = MAKERS[name]()
    held, next_ns, age_ns = announced.at(0), announced.next_ns(0), 0
    for wait_ns in waits:
        age_ns += wait_ns
        while next_ns <= age_ns:
            held, now_ns = announced.at(next_ns), next_ns
            next_ns = announced.next_ns(now_ns)
            assert next_ns > now_ns
        assert source.at(age_ns) == held


def test_the_same_seed_walks_the_same_way_within_its_limits() -> None:
    walks = [RandomWalk(0, 10, 9, 3, 10 * MS, seed) for seed in ("1", "1", "2")]
    ways = [[walk.at(age_ns) for age_ns in range(0, 2 * S, 10 * MS)] for walk in walks]
    assert ways[0] == ways[1] != ways[2]
    assert all(0 <= value <= 10 for value in ways[0])
    assert max(abs(after - before) for before, after in zip(ways[0], ways[0][1:], strict=False)) <= 3
    assert len(set(ways[0])) > 100


def test_what_never_changes_again_says_so() -> None:
    assert Constant(1).next_ns(0) == Counter(1, Fraction(0), Fraction(1), None).next_ns(5) == NEVER_NS
    assert MAKERS["ramp once"]().next_ns(300 * MS) == MAKERS["replay once"]().next_ns(5 * MS) == NEVER_NS
