"""Shrinking leaves what still fails, and nothing of that can be left out."""

from hypothesis import given
from hypothesis import strategies as st

from fieldrig.shrinking import fewest, least


@given(st.lists(st.integers(0, 9), max_size=40), st.sets(st.integers(0, 39), max_size=5))
def test_all_that_is_left_is_needed(numbers: list[int], places: set[int]) -> None:
    parts = list(enumerate(numbers))
    needed = {part for part in parts if part[0] in places}
    assert fewest(parts, lambda some: needed <= set(some)) == sorted(needed)


@given(st.lists(st.integers(0, 9), min_size=1, max_size=40))
def test_none_can_be_left_out_where_parts_stand_for_one_another(numbers: list[int]) -> None:
    def fails(some: list[int]) -> bool:
        return sum(some) >= sum(numbers) // 2

    left = fewest(numbers, fails)
    assert fails(left)
    assert not any(fails(left[:place] + left[place + 1 :]) for place in range(len(left)))


def test_a_failure_without_any_part_needs_none() -> None:
    assert fewest([1, 2, 3], lambda some: True) == []


@given(st.integers(0, 1000), st.integers(0, 1000))
def test_the_smallest_number_is_found(first: int, second: int) -> None:
    limit, number = sorted((first, second))
    assert least(number, 0, lambda some: some >= limit) == limit
