"""The telegrams of a ring on two sides, aligned cycle by cycle.

A ring sends one telegram of each sort in each cycle, and thousands of them are alike.  So contents say nothing of which
two belong together, and a value that differs for a while would be taken for missing telegrams.  Instants say all.
"""

from collections import deque
from collections.abc import Iterator

from fieldrig_devices.replay.align import MOST_WAITING, Pair
from fieldrig_devices.replay.streams import Item


class Cycles:
    """Pairs each telegram with the one of the other side that is nearest in time.  It is used like an `Aligner`."""

    def __init__(self, horizon_ns: int, most: int = MOST_WAITING) -> None:
        """`horizon_ns` is how far two telegrams of one cycle may be apart, and `most` is how many wait on one side."""
        self._horizon_ns, self._most = horizon_ns, most
        self._left: deque[Item] = deque()
        self._right: deque[Item] = deque()

    @property
    def is_waiting(self) -> bool:
        """True if something is not decided yet."""
        return bool(self._left or self._right)

    @property
    def is_full(self) -> bool:
        """True if one side has as many waiting telegrams as it may have."""
        return len(self._left) >= self._most or len(self._right) >= self._most

    def add_left(self, item: Item) -> Pair | None:
        """Take the next telegram of the left side; return the pair if it is decided at once."""
        if self._right and not self._left and self._right[0].time_ns == item.time_ns:
            return Pair(item, self._right.popleft())
        self._left.append(item)
        return None

    def add_right(self, item: Item) -> Pair | None:
        """Take the next telegram of the right side; return the pair if it is decided at once."""
        if self._left and not self._right and self._left[0].time_ns == item.time_ns:
            return Pair(self._left.popleft(), item)
        self._right.append(item)
        return None

    def settle(self, now_ns: int, is_end: bool = False) -> Iterator[Pair]:
        """Yield what is decided when all telegrams up to `now_ns` are there; with `is_end`, no more will come."""
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
                item, other = left.popleft(), right.popleft()
                yield Pair(item, other, other.time_ns - item.time_ns)

    def _is_nearer(self, item: Item, others: deque[Item]) -> bool:
        """Return whether a telegram belongs to a later one of the other side than its first."""
        off_ns = abs(others[0].time_ns - item.time_ns)
        if others[0].time_ns > item.time_ns:
            return False
        return off_ns > self._horizon_ns or (len(others) > 1 and abs(others[1].time_ns - item.time_ns) < off_ns)
