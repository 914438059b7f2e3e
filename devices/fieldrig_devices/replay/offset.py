"""How much later the second of two logs began: the difference of times under which most of their messages agree.

Only the first messages of each log are looked at.  Contents that are rare say more than a heartbeat that is always the
same, so the candidates come from them.
"""

from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from typing import Final

from fieldrig.traces.trace import is_time_of_day
from fieldrig_devices.replay.streams import Item, Stream

HEAD: Final = 2_000
"""Messages of each log that are looked at."""
RARE: Final = 3
"""A content that occurs more often is not taken for a candidate."""
MOST_TRIED: Final = 48

Placed = Sequence[tuple[Stream, Item]]
_Content = tuple[Stream, bytes]


def offset_ns(left: Placed, right: Placed, tolerance_ns: int) -> int:
    """Return what is to be subtracted from the times of the right log."""
    if not left or not right:
        return 0
    begins_ns = (left[0][1].time_ns, right[0][1].time_ns)
    preferred = [begins_ns[1] - begins_ns[0]]
    if is_time_of_day(begins_ns[0]) == is_time_of_day(begins_ns[1]):
        preferred.insert(0, 0)
    ours, theirs = _times(left), _times(right)
    scores = {candidate: _score(ours, theirs, candidate, tolerance_ns) for candidate in preferred}
    likely = [*_candidates(ours, theirs, tolerance_ns), *_of_first(left, right)]
    for candidate in dict.fromkeys(likely[:MOST_TRIED]):
        scores.setdefault(candidate, _score(ours, theirs, candidate, tolerance_ns))
    best = max(scores.values())
    for candidate in preferred:
        if scores[candidate] == best:
            return candidate
    return min((candidate for candidate, score in scores.items() if score == best), key=abs)


def _times(placed: Placed) -> dict[_Content, list[int]]:
    times: dict[_Content, list[int]] = defaultdict(list)
    for stream, item in placed:
        times[stream, item.content].append(item.time_ns)
    return times


def _candidates(ours: dict[_Content, list[int]], theirs: dict[_Content, list[int]], tolerance_ns: int) -> Iterable[int]:
    """Return the differences of times of rare contents, the most frequent one first."""
    votes: Counter[int] = Counter()
    exact: dict[int, list[int]] = defaultdict(list)
    width_ns = max(tolerance_ns, 1)
    for content, times in ours.items():
        others = theirs.get(content, ())
        if len(times) <= RARE and len(others) <= RARE:
            for difference_ns in (other - time for time in times for other in others):
                votes[difference_ns // width_ns] += 1
                exact[difference_ns // width_ns].append(difference_ns)
    for place, _ in votes.most_common(MOST_TRIED // 2):
        found = sorted(exact[place])
        yield found[len(found) // 2]


def _of_first(left: Placed, right: Placed) -> Iterable[int]:
    """Return the differences of times of the first message of each stream with those of the same content."""
    first: dict[Stream, Item] = {}
    for stream, item in left:
        first.setdefault(stream, item)
    told: Counter[Stream] = Counter()
    for stream, item in right:
        begin = first.get(stream)
        if begin is not None and begin.content == item.content and told[stream] < RARE:
            told[stream] += 1
            yield item.time_ns - begin.time_ns


def _score(
    ours: dict[_Content, list[int]], theirs: dict[_Content, list[int]], candidate_ns: int, tolerance_ns: int
) -> int:
    """Return how many messages of the left log are in the right one at the same time."""
    found = 0
    for content, times in ours.items():
        others = theirs.get(content)
        if others is None:
            continue
        for time_ns in times:
            place = bisect_left(others, time_ns + candidate_ns - tolerance_ns)
            found += place < len(others) and others[place] <= time_ns + candidate_ns + tolerance_ns
    return found
