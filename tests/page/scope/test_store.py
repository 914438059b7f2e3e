"""The store of the scope: no sample is missed by a reduction, and no gap is ever drawn as a value."""

from array import array
from collections.abc import Sequence
from math import inf, isnan, nan
from unittest.mock import ANY

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scope_rows import Sample, cut_up, naive_buckets, rows

from fieldrig_page.scope import store
from fieldrig_page.scope.store import Buckets, Gap, Track

steps = st.lists(st.tuples(st.integers(1, 400), st.floats(-1e9, 1e9)), min_size=1, max_size=300)
steps_with_gaps = st.lists(
    st.tuples(st.integers(1, 400), st.floats(-1e9, 1e9) | st.just(nan)), min_size=1, max_size=300
)


def pairs(buckets: Buckets) -> list[tuple[float, float]]:
    return list(zip(buckets.low, buckets.high, strict=True))


def alike(found: Sequence[tuple[float, float]], expected: Sequence[tuple[float, float]]) -> bool:
    return [tuple(map(repr, pair)) for pair in found] == [tuple(map(repr, pair)) for pair in expected]


def samples_of(drawn: Sequence[tuple[int, float]]) -> list[Sample]:
    instant_ns, found = 0, []
    for step_ns, value in drawn:
        instant_ns += step_ns
        found.append((instant_ns, value))
    return found


@pytest.mark.long
@given(steps, st.lists(st.integers(0, 400)), st.integers(-50, 5000), st.integers(1, 3000), st.integers(1, 60))
def test_the_reduction_is_that_of_a_look_at_every_sample(
    drawn: list[tuple[int, float]], places: list[int], first_ns: int, bucket_ns: int, count: int
) -> None:
    samples = samples_of(drawn)
    track = Track(1)
    for batch in cut_up(rows([at for at, _ in samples], [value for _, value in samples]), places):
        track.add(batch)
    (found,) = track.reduced([0], first_ns, bucket_ns, count)
    assert alike(pairs(found), naive_buckets(samples, first_ns, bucket_ns, count))


def test_whole_numbers_beyond_every_float_stay_exact_over_gaps_cuts_and_forgetting() -> None:
    track, big, period_ns = Track(2, 10, depth=16), 2**53 + 1, 10
    for number in range(0, 96, 4):
        at = [period_ns * (place + place // 8) for place in range(number, number + 4)]  # every eighth tick is skipped
        exact = {(1, row): big + number + row for row in range(4) if number + row != 50}
        track.add(rows(at, [0.0] * 4, [float(big + number + row) for row in range(4)])._replace(whole=exact))

    def found(of: Track, column: int) -> dict[int, int]:
        return {of.times_ns[number - of.base]: value for (place, number), value in of.whole.items() if place == column}

    kept = {period_ns * (place + place // 8): big + place for place in range(96) if place != 50}
    assert found(track, 1) == {at: value for at, value in kept.items() if at >= track.times_ns[0]}
    part = track.cut([1], track.times_ns[5], track.times_ns[-3])
    assert found(part, 0) == {at: kept[at] for at in part.times_ns if at in kept}
    assert found(track, 0) == {}


@pytest.mark.long
@given(steps_with_gaps, st.lists(st.integers(0, 400)), st.integers(1, 60_000), st.integers(1, 12))
def test_a_row_without_a_value_is_a_gap_also_where_steps_are_used(
    drawn: list[tuple[int, float]], places: list[int], bucket_ns: int, count: int
) -> None:
    samples = samples_of(drawn)
    track = Track(1)
    for batch in cut_up(rows([at for at, _ in samples], [value for _, value in samples]), places):
        track.add(batch)
    (found,) = track.reduced([0], 0, bucket_ns, count)
    assert alike(pairs(found), naive_buckets(samples, 0, bucket_ns, count))


def test_lost_samples_are_a_gap_by_their_instants() -> None:
    track = Track(1)
    track.add(rows([0, 10, 20], [1.0, 1.0, 1.0]))
    track.add(rows([60, 70], [1.0, 1.0], lost=3))
    (found,) = track.reduced([0], 0, 10, 8)
    assert list(found.low) == [1.0, 1.0, 1.0, ANY, ANY, ANY, 1.0, 1.0]
    assert all(isnan(low) for low in found.low[3:6])
    assert track.lost == 3
    assert list(track.gaps) == [Gap(20, 60, 3)]


def test_the_time_of_gaps_is_counted_also_where_samples_are_that_were_never_taken() -> None:
    track = Track(1, period_ns=10)
    track.add(rows([0, 10, 20], [1.0] * 3))
    track.add(
        rows([220, 230], [1.0] * 2, lost=1)
    )  # the process stood still: one sample was lost, the others never were
    track.add(rows([330, 340], [1.0] * 2))
    assert (track.lost, track.pauses, track.away_ns) == (1, 1, 200 + 100)


def test_a_sampler_that_stood_still_leaves_a_gap_within_a_batch_and_between_two() -> None:
    track = Track(1, period_ns=10)
    track.add(rows([0, 10, 40, 50], [1.0, 2.0, 3.0, 4.0]))
    track.add(rows([80], [5.0]))
    (found,) = track.reduced([0], 0, 10, 9)
    assert [place for place, low in enumerate(found.low) if isnan(low)] == [2, 3, 6, 7]
    assert (track.lost, track.pauses) == (0, 2)


def test_a_value_holds_between_two_changes_and_not_beyond_what_is_known() -> None:
    track = Track(1)
    track.add(rows([5], [1.0]))
    track.reach(40)
    (found,) = track.reduced([0], 0, 10, 6)
    assert pairs(found)[:5] == [(1.0, 1.0), (inf, -inf), (inf, -inf), (inf, -inf), (inf, -inf)]
    assert isnan(found.low[5])
    assert track.value_at(0, 39) == 1.0
    assert isnan(track.value_at(0, 41))


def test_nothing_is_known_after_a_process_has_gone() -> None:
    track = Track(1)
    track.add(rows([0, 10], [1.0, 2.0]))
    track.end_here()
    track.reach(1000)
    assert isnan(track.value_at(0, 500))


@pytest.mark.long
@given(st.integers(1, 700), st.integers(1, 90))
def test_memory_is_constant_and_numbers_go_on(batches: int, length: int) -> None:
    track = Track(2, depth=64)
    for number in range(batches):
        times_ns = range(number * length, (number + 1) * length)
        assert track.add(rows(times_ns, [float(at) for at in times_ns], [0.0] * length)) == number * length
        assert len(track.times_ns) <= 2 * 64 + length
    assert track.end == batches * length
    newest = min(track.end, 64)
    assert list(track.values[0][-newest:]) == [float(at) for at in range(track.end - newest, track.end)]
    (found,) = track.reduced([0], track.end - newest, newest, 1)
    assert pairs(found) == [(track.end - newest, track.end - 1)]


def test_steps_stay_right_when_old_rows_go() -> None:
    track = Track(1, depth=64)
    for number in range(200):
        track.add(
            rows(range(number * 7, number * 7 + 7), [float(at * 37 % 101) for at in range(number * 7, number * 7 + 7)])
        )
        first = track.times_ns[0]
        (found,) = track.reduced([0], first, len(track.times_ns), 1)
        assert pairs(found) == [(min(track.values[0]), max(track.values[0]))]


def test_time_that_begins_anew_begins_a_new_epoch() -> None:
    track = Track(1)
    track.add(rows([100, 200], [1.0, 2.0]))
    assert track.add(rows([0, 10], [3.0, 4.0])) == 2
    assert (track.epoch, list(track.times_ns), track.base) == (1, [0, 10], 2)


def test_a_cut_has_the_row_before_it_and_its_gaps() -> None:
    track = Track(2)
    track.add(rows([0, 10, 20], [1.0, 2.0, 3.0], [9.0, 8.0, 7.0]))
    track.add(rows([60], [4.0], [6.0], lost=3))
    part = track.cut([1], 15, 61)
    assert list(part.times_ns) == [10, 20, 21, 60]
    assert list(part.values[0])[:2] == [8.0, 7.0]
    assert (part.lost, list(part.gaps)) == (3, [Gap(20, 60, 3)])
    assert track.cut([0], 0, 15).lost == 0


def test_the_store_needs_no_numpy() -> None:
    assert isinstance(Track(1).values[0], array)
    assert not hasattr(store, "numpy")
