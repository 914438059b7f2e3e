"""Two sequences of messages of one stream, aligned as they arrive: which are the same, and which are in one only.

Contents decide first, and times where the contents do not: in a row of heartbeats that are all the same, the one that
is missing is where the gap is.  Most messages are found at once, as the next one on both sides has the same content at
the same time.  Elsewhere a few messages on both sides are aligned with the least cost (Needleman and Wunsch, 1970), and
the first step of that alignment is taken.  So memory is bounded, and one missing message among a million costs only
itself.
"""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterator
from itertools import pairwise
from typing import Final, NamedTuple

from fieldrig.clock import MS
from fieldrig_devices.replay.streams import Item

LOOK_AHEAD: Final = 8
"""Messages of each side among which the alignment with the least cost is looked for."""
MOST_WAITING: Final = 256
"""Messages of one side that wait for the other; the oldest ones are then taken as they are."""
SKIP: Final = 0.75
"""Cost of a message that the other side does not have.  Two of them cost more than one that has other data."""
OTHER: Final = 1.0
"""Cost of a message with other data."""
LATE: Final = 1.4
"""Most that a message with the same data costs because it is early or late; its unit is the time between messages."""


class Pair(NamedTuple):
    """One message on both sides; None on a side where it is missing."""

    left: Item | None
    right: Item | None
    late_ns: int = 0
    """How much later the right one is; 0 if one is missing."""

    @property
    def is_same(self) -> bool:
        """True if both sides have the same content."""
        return self.left is not None and self.right is not None and self.left.content == self.right.content

    @property
    def time_ns(self) -> int:
        item = self.left or self.right
        return 0 if item is None else item.time_ns


class Matching(ABC):
    """One stream on two sides, whose times are of one clock: what waits on each side for the other."""

    __slots__ = ("_horizon_ns", "_left", "_most", "_right")

    def __init__(self, horizon_ns: int, most: int = MOST_WAITING) -> None:
        """`horizon_ns` is how far two messages of a pair may be apart, and `most` is how many wait on one side."""
        self._horizon_ns, self._most = horizon_ns, most
        self._left: deque[Item] = deque()
        self._right: deque[Item] = deque()

    @property
    def is_waiting(self) -> bool:
        """True if something is not decided yet."""
        return bool(self._left or self._right)

    @property
    def is_full(self) -> bool:
        """True if one side has as many waiting messages as it may have, so that some have to be decided now."""
        return len(self._left) >= self._most or len(self._right) >= self._most

    def add_left(self, item: Item) -> Pair | None:
        """Take the next message of the left side; return the pair if it is decided at once."""
        right = self._right
        if right and not self._left and self._is_plain(item, right[0]):
            return self._paired(item, right.popleft())
        self._left.append(item)
        return None

    def add_right(self, item: Item) -> Pair | None:
        """Take the next message of the right side; return the pair if it is decided at once."""
        left = self._left
        if left and not self._right and self._is_plain(left[0], item):
            return self._paired(left.popleft(), item)
        self._right.append(item)
        return None

    @abstractmethod
    def settle(self, now_ns: int, is_end: bool = False) -> Iterator[Pair]:
        """Yield what is decided when all messages up to `now_ns` are there; with `is_end`, no more will come."""

    @abstractmethod
    def _is_plain(self, left: Item, right: Item) -> bool:
        """Return whether the first messages of both sides are a pair, whatever comes behind them."""

    def _paired(self, left: Item, right: Item) -> Pair:
        return Pair(left, right, right.time_ns - left.time_ns)


class Aligner(Matching):
    """Aligns one stream by its contents."""

    __slots__ = ("_drift_ns", "_loose", "_odd_ns", "_tolerance_ns")

    def __init__(self, tolerance_ns: int, horizon_ns: int, most: int = MOST_WAITING) -> None:
        """`horizon_ns` is how far the same message may be early or late, and `most` is how many wait on one side."""
        super().__init__(horizon_ns, most)
        self._tolerance_ns = tolerance_ns
        self._loose: list[Pair] = []
        """Messages of one side only, as long as the same one may come on the other side out of its order."""
        self._drift_ns = 0
        """How much later the right side usually is at present."""
        self._odd_ns: int | None = None
        """How much later than that the last message was, if it was off by more than the tolerance."""

    @property
    def is_waiting(self) -> bool:
        return super().is_waiting or bool(self._loose)

    def settle(self, now_ns: int, is_end: bool = False) -> Iterator[Pair]:
        left, right = self._left, self._right
        before_ns = now_ns - self._horizon_ns
        while left or right:
            if left and right and self._is_plain(left[0], right[0]):
                yield self._paired(left.popleft(), right.popleft())
                continue
            first_ns = min(items[0].time_ns for items in (left, right) if items)
            if not (is_end or self.is_full or first_ns <= before_ns):
                break
            yield from self._step()
        yield from self._let_go(before_ns, is_end)

    def _is_plain(self, left: Item, right: Item) -> bool:
        return (
            left.content == right.content
            and -self._tolerance_ns <= right.time_ns - left.time_ns - self._drift_ns <= self._tolerance_ns
        )

    def _paired(self, left: Item, right: Item) -> Pair:
        late_ns = right.time_ns - left.time_ns
        off_ns = late_ns - self._drift_ns
        if off_ns:
            self._follow(off_ns)
        return Pair(left, right, late_ns)

    def _follow(self, off_ns: int) -> None:
        """Follow what lasts: one message that is late says nothing of the next ones, and two of them do."""
        if -self._tolerance_ns <= off_ns <= self._tolerance_ns:
            self._drift_ns += off_ns // 4
            self._odd_ns = None
        elif self._odd_ns is None or (self._odd_ns > 0) != (off_ns > 0):
            self._odd_ns = off_ns
        else:
            self._drift_ns += min(self._odd_ns, off_ns, key=abs)
            self._odd_ns = None

    def _step(self) -> Iterator[Pair]:
        """Decide the first message of one side or of both."""
        left, right = self._left, self._right
        step = _first_step(list(left)[:LOOK_AHEAD], list(right)[:LOOK_AHEAD], self._drift_ns, self._horizon_ns)
        if step is _Step.BOTH:
            yield self._paired(left.popleft(), right.popleft())
        elif step is _Step.LEFT:
            yield from self._lone(Pair(left.popleft(), None))
        else:
            yield from self._lone(Pair(None, right.popleft()))

    def _lone(self, pair: Pair) -> Iterator[Pair]:
        """Take a message of one side: the same one of the other side may have come in another order."""
        for place, other in enumerate(self._loose):
            left, right = pair.left or other.left, pair.right or other.right
            if left is None or right is None or left.content != right.content:
                continue
            if abs(right.time_ns - left.time_ns) <= self._horizon_ns:
                del self._loose[place]
                yield Pair(left, right, right.time_ns - left.time_ns)
                return
        self._loose.append(pair)
        if len(self._loose) > self._most:
            yield self._loose.pop(0)

    def _let_go(self, before_ns: int, is_end: bool) -> Iterator[Pair]:
        kept = []
        for pair in self._loose:
            if is_end or pair.time_ns <= before_ns - self._horizon_ns:
                yield pair
            else:
                kept.append(pair)
        self._loose = kept


class _Step:
    """The sides from which the first step of an alignment takes a message."""

    BOTH, LEFT, RIGHT = range(3)


def _first_step(left: list[Item], right: list[Item], drift_ns: int, horizon_ns: int) -> int:
    """Return the first step of the alignment that costs the least."""
    if not right:
        return _Step.LEFT
    if not left:
        return _Step.RIGHT
    period_ns = _period_ns(left, right, horizon_ns)
    rows, columns = len(left), len(right)
    is_cut = rows >= LOOK_AHEAD or columns >= LOOK_AHEAD
    rest = 0.0 if is_cut else SKIP
    after = [rest * (columns - column) for column in range(columns + 1)]
    step = _Step.BOTH
    for row in range(rows - 1, -1, -1):
        costs = [0.0] * columns + [rest * (rows - row)]
        for column in range(columns - 1, -1, -1):
            both = after[column + 1] + _cost(left[row], right[column], drift_ns, period_ns, horizon_ns)
            skip_left, skip_right = after[column] + SKIP, costs[column + 1] + SKIP
            costs[column] = min(both, skip_left, skip_right)
            if row == column == 0:
                step = _choice(both, skip_left, skip_right, left[0].time_ns + drift_ns <= right[0].time_ns)
        after = costs
    return step


def _choice(both: float, skip_left: float, skip_right: float, is_left_first: bool) -> int:
    least = min(both, skip_left, skip_right)
    if both == least:
        return _Step.BOTH
    if skip_left == skip_right:
        return _Step.LEFT if is_left_first else _Step.RIGHT
    return _Step.LEFT if skip_left == least else _Step.RIGHT


def _cost(left: Item, right: Item, drift_ns: int, period_ns: int, horizon_ns: int) -> float:
    late_ns = abs(right.time_ns - left.time_ns - drift_ns)
    if abs(right.time_ns - left.time_ns) > horizon_ns:
        return 4 * SKIP
    if left.content == right.content:
        return min(late_ns / period_ns, LATE)
    return OTHER + late_ns / period_ns


def _period_ns(left: list[Item], right: list[Item], horizon_ns: int) -> int:
    """Return the usual time between two messages of a side."""
    gaps = sorted(after.time_ns - before.time_ns for items in (left, right) for before, after in pairwise(items))
    return max(gaps[len(gaps) // 2], MS) if gaps else horizon_ns
