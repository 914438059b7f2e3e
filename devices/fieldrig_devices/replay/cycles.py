"""The telegrams of a ring on two sides, aligned cycle by cycle.

A ring sends one telegram of each sort in each cycle, and thousands of them are alike.  So contents say nothing of which
two belong together, and a value that differs for a while would be taken for missing telegrams.  Instants say all.
"""

from collections import deque
from collections.abc import Iterator

from fieldrig_devices.replay.align import Matching, Pair
from fieldrig_devices.replay.streams import Item


class Cycles(Matching):
    """Pairs each telegram with the one of the other side that is nearest in time."""

    __slots__ = ()

    def settle(self, now_ns: int, is_end: bool = False) -> Iterator[Pair]:
        left, right = self._left, self._right
        before_ns = now_ns - self._horizon_ns
        while left or right:
            first_ns = min(items[0].time_ns for items in (left, right) if items)
            if not (is_end or self.is_full or first_ns <= before_ns):
                return
            if not right or (left and self._is_nearer(right[0], left)):
                yield Pair(left.popleft(), None)
            elif not left or self._is_nearer(left[0], right):
                yield Pair(None, right.popleft())
            else:
                yield self._paired(left.popleft(), right.popleft())

    def _is_plain(self, left: Item, right: Item) -> bool:
        return left.time_ns == right.time_ns

    def _is_nearer(self, item: Item, others: deque[Item]) -> bool:
        """Return whether a telegram belongs to a later one of the other side than its first."""
        off_ns = abs(others[0].time_ns - item.time_ns)
        if others[0].time_ns > item.time_ns:
            return False
        return off_ns > self._horizon_ns or (len(others) > 1 and abs(others[1].time_ns - item.time_ns) < off_ns)
