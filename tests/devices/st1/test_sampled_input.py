"""The input that computes its samples is the same as one that takes them."""

from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.st1.sampled_input import SampledInput

PERIOD = 10
changes = st.lists(st.integers(1, 400), max_size=30, unique=True).map(sorted)


def sampled(times: list[int], samples: int, until: int) -> list[tuple[int, bool]]:
    """Take every sample, and return when which level was accepted."""
    found, level, seen = [], False, 0
    for now in range(0, until, PERIOD):
        raw = sum(when <= now for when in times) % 2 == 1
        seen = seen + 1 if raw is not level else 0
        if seen == samples:
            level, seen = raw, 0
            found.append((now, level))
    return found


@given(changes, st.integers(1, 5))
def test_computed_samples_are_the_same_as_taken_ones(times: list[int], samples: int) -> None:
    one, found, raw = SampledInput(0, False, PERIOD, samples), [], False
    for now in range(600):
        if now in times:
            raw = not raw
            one.put(now, raw)
        if one.advance(now):
            found.append((now, one.level))
    assert found == sampled(times, samples, 600)


@given(changes)
def test_it_knows_when_the_change_began(times: list[int]) -> None:
    one, raw = SampledInput(0, False, PERIOD, 2), False
    for now in range(600):
        if now in times:
            raw = not raw
            one.put(now, raw)
        if one.advance(now):
            assert one.changed_ns in times
            assert now - one.changed_ns < 2 * PERIOD + (PERIOD if now - 2 * PERIOD in times else 0) + 1
