"""Messages in the order of time, in constant memory.

Buses that are recorded side by side come out of order to each other by a little.  Messages wait until nothing earlier
is expected; one that is earlier by more than that stays where it is in the file.
"""

from collections.abc import Iterable, Iterator
from heapq import heappop, heappush
from typing import Final

from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.window import DISORDER_NS

MOST_WAITING: Final = 100_000
"""Messages that wait at most."""


def in_order(entries: Iterable[TraceEntry], most: int = MOST_WAITING) -> Iterator[TraceEntry]:
    """Yield the entries in the order of time; those of one instant stay in their order."""
    waiting: list[tuple[int, int, TraceEntry]] = []
    newest_ns = None
    for number, entry in enumerate(entries):
        now_ns = entry.time_ns
        newest_ns = now_ns if newest_ns is None else max(newest_ns, now_ns)
        heappush(waiting, (now_ns, number, entry))
        while len(waiting) > most or waiting[0][0] < newest_ns - DISORDER_NS:
            yield heappop(waiting)[2]
    while waiting:
        yield heappop(waiting)[2]
