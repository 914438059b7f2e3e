"""Messages in the order of time, in constant memory.

Buses that are recorded side by side come out of order to each other by a little.  Messages wait until nothing earlier
is expected; one that is earlier by more than that stays where it is in the file.
"""

from collections import deque
from collections.abc import Iterable, Iterator
from heapq import heappop, heappush
from typing import Final

from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.window import DISORDER_NS

MOST_WAITING: Final = 100_000
"""Messages that wait at most."""
_Waiting = tuple[int, int, TraceEntry]
"""Instant, number, message."""


def in_order(entries: Iterable[TraceEntry], most: int = MOST_WAITING) -> Iterator[TraceEntry]:
    """Yield the entries in the order of time; those of one instant stay in their order.

    Nearly all come in order already and wait in a queue, which costs a third of a heap; the others wait in a heap.
    """
    queue, late = deque[_Waiting](), list[_Waiting]()
    newest_ns = None
    for number, entry in enumerate(entries):
        now_ns = entry.time_ns
        if newest_ns is None or now_ns >= newest_ns:
            newest_ns = now_ns
            queue.append((now_ns, number, entry))
        else:
            heappush(late, (now_ns, number, entry))
        before_ns = newest_ns - DISORDER_NS
        if not late:
            while queue[0][0] < before_ns or len(queue) > most:
                yield queue.popleft()[2]
            continue
        while len(queue) + len(late) > most or _first(queue, late)[0] < before_ns:
            yield _take(queue, late)
    while queue or late:
        yield _take(queue, late)


def _first(queue: deque[_Waiting], late: list[_Waiting]) -> _Waiting:
    return min(queue[0], late[0]) if queue and late else queue[0] if queue else late[0]


def _take(queue: deque[_Waiting], late: list[_Waiting]) -> TraceEntry:
    if not late or (queue and queue[0] < late[0]):
        return queue.popleft()[2]
    return heappop(late)[2]
