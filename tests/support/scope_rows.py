"""Rows as the recording seam delivers them, made by hand, and what is true of them, found the long way."""

from array import array
from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import inf, isnan, nan

from fieldrig.recording.reader import Rows


def rows(times_ns: Iterable[int], *columns: Iterable[float], lost: int = 0, process: str = "io") -> Rows:
    values = [array("d", column) for column in columns]
    return Rows(process, tuple(range(len(values))), 0, lost, array("q", times_ns), values)


def cut_up(whole: Rows, places: Sequence[int]) -> list[Rows]:
    """The same rows in batches that end at these places."""
    edges = sorted({0, len(whole.times_ns), *(place % (len(whole.times_ns) + 1) for place in places)})
    return [
        rows(whole.times_ns[first:end], *(values[first:end] for values in whole.values), process=whole.process)
        for first, end in pairwise(edges)
    ]


Sample = tuple[int, float]


def naive_buckets(samples: Sequence[Sample], first_ns: int, bucket_ns: int, count: int) -> list[tuple[float, float]]:
    """Minimum and maximum of each bucket by a look at every sample; NaN is a gap, infinite is no news."""
    found = []
    for begin_ns in range(first_ns, first_ns + count * bucket_ns, bucket_ns):
        inside = [value for instant_ns, value in samples if begin_ns <= instant_ns < begin_ns + bucket_ns]
        known = [value for value in inside if not isnan(value)]
        before = [value for instant_ns, value in samples if instant_ns < begin_ns]
        if known:
            found.append((min(known), max(known)))
        elif inside or not before or isnan(before[-1]) or begin_ns > samples[-1][0]:
            found.append((nan, nan))
        else:
            found.append((inf, -inf))
    return found
