"""The latest samples of signals, and their reduction to a minimum and a maximum per pixel, without numpy.

A `Track` has the rows of one process: instants, and one array of values per column.  The arrays are linear, so that a
search is a bisection and a row range is a slice; when they have grown to twice their depth the older half goes, so
memory is constant.

What is not known is never a value.  A row of NaN follows the last row before a loss or a pause of the sampler, so
whatever reads the track finds the gap there, by its instant.  A bucket without a row is "no news" (its minimum is
infinite): a line goes on over it, unless the row before it is such a NaN.
"""

from array import array
from bisect import bisect_left
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from math import inf, nan
from typing import Final, NamedTuple, Protocol, TypeVar

D = TypeVar("D")

DEPTH: Final = 1 << 15
"""Rows that a track always has, once it has taken that many; it has up to twice as many."""
CHUNK: Final = 16
"""Rows whose minimum and maximum are kept, so that a long window costs a sixteenth."""
MOST_GAPS: Final = 256
"""Gaps that a track remembers for their marks; their number and the samples lost are counted on."""
LATE: Final = 1.5
"""A sampler with a period has skipped a tick if the next row is later than this many periods."""


class Batch(Protocol):
    """Rows as the recording seam of the kernel delivers them (`fieldrig.recording.reader.Rows`)."""

    @property
    def lost(self) -> int: ...
    @property
    def times_ns(self) -> "array[int]": ...
    @property
    def values(self) -> "Sequence[array[float]]": ...
    @property
    def whole(self) -> Mapping[tuple[int, int], int]: ...


class Gap(NamedTuple):
    """A time without samples, between two rows."""

    first_ns: int
    end_ns: int
    lost: int
    """Samples that were taken and are lost; 0 if the sampler itself stood still."""


class Buckets(NamedTuple):
    """A minimum and a maximum for each bucket of time, for one column.

    Both are NaN in a gap.  Without news, where the last value still holds, they are inf and -inf.
    """

    low: "array[float]"
    high: "array[float]"


class Track:
    """The latest rows of one process.  Positions count from the oldest row kept, numbers from the first ever."""

    def __init__(self, columns: int, period_ns: int | None = None, depth: int = DEPTH) -> None:
        """`period_ns` is the period of a sampler that has one: rows further apart have a gap between them."""
        self.times_ns = array("q")
        self.values = [array("d") for _ in range(columns)]
        self.whole: dict[tuple[int, int], int] = {}
        """The exact values of whole numbers beyond 2^53, by column and number of the row."""
        self.period_ns, self._depth = period_ns, -(-depth // CHUNK) * CHUNK
        self.base = 0
        """Number of the row at position 0."""
        self.epoch = 0
        """Counts how often time began again, as when a rig in virtual time was started again."""
        self.known_ns = 0
        """Up to here everything is known: a value without a newer row still holds."""
        self.lost = 0
        self.pauses = 0
        """Gaps in which the sampler stood still."""
        self.away_ns = 0
        """The time of all gaps together: samples of a process that stood still were never taken, and have no number."""
        self.gaps: deque[Gap] = deque(maxlen=MOST_GAPS)
        self.noted = 0
        """Number of all gaps so far."""
        self._missing = 0
        """Rows that are lost since the last one."""
        self._lows = [array("d") for _ in range(columns)]
        self._highs = [array("d") for _ in range(columns)]

    @property
    def end(self) -> int:
        """Number of the row that comes next."""
        return self.base + len(self.times_ns)

    def add(self, batch: Batch) -> int:
        """Take rows in, and return the number of the first one.  The oldest rows go when there are too many."""
        times_ns = batch.times_ns
        if not times_ns:
            self.lose(batch.lost)
            return self.end
        if self.times_ns and times_ns[0] < self.times_ns[-1]:
            self._begin_anew()
        self._forget()
        first, breaks = self.end, self._breaks(batch)
        for begin, end in pairwise(sorted({0, *breaks, len(times_ns)})):
            if begin in breaks:
                self._break(times_ns[begin], breaks[begin])
            if batch.whole:
                moved = self.end - begin
                self.whole |= {
                    (column, row + moved): value for (column, row), value in batch.whole.items() if begin <= row < end
                }
            self.times_ns.extend(times_ns[begin:end])
            for kept, values in zip(self.values, batch.values, strict=True):
                kept.extend(values[begin:end])
        self.known_ns = max(self.known_ns, times_ns[-1])
        return first

    def reach(self, now_ns: int) -> None:
        """Note that there is no further row until `now_ns`."""
        if self.period_ns is not None and self.times_ns:
            now_ns = min(now_ns, self.times_ns[-1] + self.period_ns)
        self.known_ns = max(self.known_ns, now_ns)

    def lose(self, lost: int) -> None:
        """Note that rows are lost behind the last one, before the next one has come."""
        if lost and self.times_ns:
            self._missing += lost
            if not self._is_open:
                self._append_gap(self.times_ns[-1] + 1)

    def end_here(self) -> None:
        """Note that the process has gone: nothing is known from here on."""
        if self.times_ns and not self._is_open:
            self._append_gap(self.times_ns[-1] + 1)

    def position(self, instant_ns: int) -> int:
        """Position of the first row at or after the instant."""
        return bisect_left(self.times_ns, instant_ns)

    def value_at(self, column: int, instant_ns: int) -> float:
        """The value that holds at the instant; NaN in a gap, before the first row, and after what is known."""
        place = self.position(instant_ns + 1) - 1
        return self.values[column][place] if place >= 0 and instant_ns <= self.known_ns else nan

    def whole_at(self, column: int, instant_ns: int) -> int | None:
        """The exact value of a whole number beyond 2^53 that is the last one up to the instant; None for any other."""
        return self.whole.get((column, self.base + self.position(instant_ns + 1) - 1))

    def reduced(self, columns: Sequence[int], first_ns: int, bucket_ns: int, count: int) -> list[Buckets]:
        """Minimum and maximum of `count` buckets of `bucket_ns` from `first_ns` on, for each column."""
        known = min(max((self.known_ns - first_ns) // bucket_ns + 1, 0), count)
        edges = self._edges(first_ns, bucket_ns, known)
        unknown = array("d", [nan]) * (count - known)
        found = [self._buckets(column, edges) for column in columns]
        return [Buckets(low + unknown, high + unknown) for low, high in found]

    def cut(self, columns: Sequence[int], first_ns: int, end_ns: int) -> "Track":
        """A copy of some columns over a time, with the row before it, whose value holds at its beginning."""
        first, end = max(self.position(first_ns) - 1, 0), self.position(end_ns)
        part = Track(len(columns), self.period_ns, self._depth)
        part.times_ns = self.times_ns[first:end]
        part.values = [self.values[column][first:end] for column in columns]
        part.base, part.epoch, part.known_ns = self.base + first, self.epoch, min(self.known_ns, end_ns)
        part.whole = {
            (place, number): value
            for (column, number), value in self.whole.items()
            for place in range(len(columns))
            if columns[place] == column and part.base <= number < part.end
        }
        for gap in self.gaps:
            if gap.end_ns > first_ns and gap.first_ns < end_ns:
                part.note(gap)
        return part

    def note(self, gap: Gap) -> None:
        """Count a gap, and keep its mark."""
        self.gaps.append(gap)
        self.noted += 1
        self.lost += gap.lost
        self.pauses += not gap.lost
        self.away_ns += gap.end_ns - gap.first_ns

    def gaps_since(self, noted: int) -> list[Gap]:
        """Return the gaps after the first `noted`, as far as they are remembered."""
        return list(self.gaps)[max(len(self.gaps) - (self.noted - noted), 0) :]

    @property
    def size(self) -> int:
        """Bytes of its rows."""
        return 8 * len(self.times_ns) * (1 + len(self.values))

    def _begin_anew(self) -> None:
        self.base, self.epoch, self.known_ns = self.end, self.epoch + 1, 0
        self.gaps.clear()
        self.whole.clear()
        del self.times_ns[:]
        for values in (*self.values, *self._lows, *self._highs):
            del values[:]

    def _forget(self) -> None:
        while len(self.times_ns) >= 2 * self._depth:
            self.base += self._depth
            self.whole = {place: value for place, value in self.whole.items() if place[1] >= self.base}
            del self.times_ns[: self._depth]
            for values in self.values:
                del values[: self._depth]
            for steps in (*self._lows, *self._highs):  # those that were not made yet begin at the new position 0
                del steps[: self._depth // CHUNK]

    @property
    def _is_open(self) -> bool:
        """True if the newest row is a gap that has begun."""
        return all(values[-1] != values[-1] for values in self.values)

    def _breaks(self, batch: Batch) -> dict[int, int]:
        """Places in the batch before which rows are missing, each with the rows that were lost there.

        The seam says how many are missing up to the last row, and not where: that is where a step is too long.
        """
        lost, self._missing = batch.lost + self._missing, 0
        if not lost and self.period_ns is None:
            return {}
        before_ns = self.times_ns[-1 - self._is_open] if self.times_ns else batch.times_ns[0]
        steps = [after - before for before, after in pairwise([before_ns, *batch.times_ns])]
        usual = self.period_ns or min(steps[1:], default=steps[0])
        late = [place for place, step_ns in enumerate(steps) if step_ns > LATE * usual]
        if not late and lost and self.times_ns:
            late = [0]
        elif not late:
            self.lost += lost
        found: dict[int, int] = {}
        for place in late:
            found[place] = lost if place == late[-1] else min(lost, max(round(steps[place] / max(usual, 1)) - 1, 1))
            lost -= found[place]
        return found

    def _break(self, next_ns: int, lost: int) -> None:
        last_ns = self.times_ns[-1 - self._is_open]
        self.note(Gap(last_ns, next_ns, lost))
        if not self._is_open:
            self._append_gap(min(last_ns + 1, next_ns))

    def _append_gap(self, instant_ns: int) -> None:
        self.times_ns.append(instant_ns)
        for values in self.values:
            values.append(nan)

    def _edges(self, first_ns: int, bucket_ns: int, count: int) -> list[int]:
        """Position of the first row of each bucket, and of the first row after the last one."""
        times_ns, edges, place = self.times_ns, [], 0
        for instant_ns in range(first_ns, first_ns + (count + 1) * bucket_ns, bucket_ns):
            place = bisect_left(times_ns, instant_ns, place)
            edges.append(place)
        return edges

    def _buckets(self, column: int, edges: Sequence[int]) -> Buckets:
        values, lows, highs = self.values[column], list[float](), list[float]()
        is_long = len(edges) > 1 and edges[-1] - edges[0] > 2 * CHUNK * len(edges)
        if is_long:
            self._make_steps(column)
        for first, end in pairwise(edges):
            if first == end:
                low, high = self._silence(values, first)
            elif end - first == 1:
                low = high = values[first]
            elif is_long:
                low, high = self._stepped(column, first, end)
            else:
                part = values[first:end]
                low, high = min(part), max(part)
                if low != low:  # `min` and `max` skip each NaN but a first one
                    low, high = _known_extremes(part)
            lows.append(low)
            highs.append(high)
        return Buckets(array("d", lows), array("d", highs))

    def _silence(self, values: "array[float]", place: int) -> tuple[float, float]:
        is_gap = place == 0 or values[place - 1] != values[place - 1]
        return (nan, nan) if is_gap else (inf, -inf)

    def _stepped(self, column: int, first: int, end: int) -> tuple[float, float]:
        values, begin, over = self.values[column], -(-first // CHUNK), end // CHUNK
        if begin >= over:
            return _known_extremes(values[first:end])
        rest = values[first : begin * CHUNK] + values[over * CHUNK : end]
        known = [value for value in rest if value == value]
        low = min(min(self._lows[column][begin:over]), min(known, default=inf))
        high = max(max(self._highs[column][begin:over]), max(known, default=-inf))
        return (low, high) if low <= high else (nan, nan)

    def _make_steps(self, column: int) -> None:
        """Make the steps of whole chunks that are there; only signals that are drawn over a long time have them."""
        values, lows, highs = self.values[column], self._lows[column], self._highs[column]
        for first in range(len(lows) * CHUNK, len(values) // CHUNK * CHUNK, CHUNK):
            part = values[first : first + CHUNK]
            low, high = min(part), max(part)
            if low != low:
                known = [value for value in part if value == value]
                low, high = min(known, default=inf), max(known, default=-inf)
            lows.append(low)
            highs.append(high)


def by_track(drawn: Iterable[tuple[Track | None, D]]) -> list[tuple[Track, list[D]]]:
    """Return what is drawn of each track, with the tracks in the order in which they come first."""
    found: dict[int, tuple[Track, list[D]]] = {}
    for track, each in drawn:
        if track is not None:
            found.setdefault(id(track), (track, []))[1].append(each)
    return list(found.values())


def _known_extremes(part: Iterable[float]) -> tuple[float, float]:
    known = [value for value in part if value == value]
    return (min(known), max(known)) if known else (nan, nan)
