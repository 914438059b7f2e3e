"""The signals around a failure as lines of text."""

from itertools import pairwise

from fieldrig import MS
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.testing.recorder import HIGH, LOW, Track, diagram


def track(name: str, kind: Elementary, *changes: tuple[int, bool | int]) -> Track:
    made = Track(name, kind)
    for at_ms, value in changes:
        made.note(at_ms * MS, value)
    return made


def test_levels_are_drawn_over_time_with_the_last_one_at_the_end() -> None:
    lamp = track("lamp", Elementary.BOOL, (0, False), (50, True), (100, False))
    count = track("count", Elementary.INT, *((10 * number, number) for number in range(9)))
    assert diagram([lamp, count], 100 * MS) == (
        f"lamp   {LOW * 23}{HIGH * 24}{LOW}",
        "count  ... 5 (50ms)  6 (60ms)  7 (70ms)  8 (80ms)",
        f"       0{'100ms':>47}",
    )


def test_only_the_time_of_the_last_edges_is_drawn() -> None:
    """A lamp has flashed for 100 s, so its last eight edges are within 800 ms."""
    lamp = track("lamp", Elementary.BOOL, *((100 * number, number % 2 == 1) for number in range(1001)))
    drawn, axis = diagram([lamp], 100_000 * MS)
    levels = drawn.split()[1]
    assert axis.split() == ["1m39s212ms500us", "1m40s"]
    assert sum(one != other for one, other in pairwise(levels)) == 8


def test_nothing_is_drawn_without_time_or_signals() -> None:
    assert diagram([], 5) == ()
    assert diagram([track("lamp", Elementary.BOOL, (0, True))], 0) == ("lamp  TRUE (0)",)
