"""Two logs compared: what one of them has and the other has not, by stream.

Both are read once, as streams, and a second time up to the first difference, for what was around it.  Memory is bounded
whatever the logs have: streams beyond `MOST_STREAMS` are compared together.
"""

from collections.abc import Mapping, Sequence
from heapq import merge
from operator import itemgetter
from typing import Final, NamedTuple

from fieldrig.clock import MS, S
from fieldrig.errors import UsageError
from fieldrig.traces.parts import PartDifference, differences
from fieldrig_devices.replay.align import Aligner, Pair
from fieldrig_devices.replay.context import Read, around
from fieldrig_devices.replay.diff_result import DiffResult, DiffRow, FirstDifference
from fieldrig_devices.replay.leave_out import LeftOut
from fieldrig_devices.replay.log_names import LogNames
from fieldrig_devices.replay.log_side import MOST_STREAMS, LogSide
from fieldrig_devices.replay.offset import offset_ns
from fieldrig_devices.replay.streams import Item, Stream
from fieldrig_devices.replay.words import hex_words, late_words

TOLERANCE_NS: Final = 5 * MS
HORIZON_NS: Final = S
MOST_TOLD: Final = 3
"""Values of one message that are named."""
HEAD_OF_FRAME: Final = 5
"""Bytes before the data of a CAN frame in a trace."""
FURTHER: Final = "further ones"


class _First(NamedTuple):
    time_ns: int
    row: DiffRow
    pair: Pair
    what: str


class Comparison:
    """Compares two logs whose messages are given in the order of time, by the clock of the left one."""

    def __init__(self, tolerance_ns: int, horizon_ns: int, names: tuple[LogNames, LogNames] | None = None) -> None:
        self._tolerance_ns, self._horizon_ns = tolerance_ns, horizon_ns
        self._names = names or (LogNames(), LogNames())
        self._streams: dict[Stream, tuple[Aligner, DiffRow]] = {}
        self._waiting: dict[Stream, None] = {}
        self._sweep_ns: int | None = None
        self.first: _First | None = None

    def take_left(self, stream: Stream, item: Item) -> None:
        if stream not in self._streams:
            stream, item = self._begin(stream, item, 0)
        self._names[0].note(stream, item)
        aligner, row = self._streams[stream]
        row.left += 1
        self._after(stream, aligner.add_left(item), item.time_ns)

    def take_right(self, stream: Stream, item: Item) -> None:
        if stream not in self._streams:
            stream, item = self._begin(stream, item, 1)
        self._names[1].note(stream, item)
        aligner, row = self._streams[stream]
        row.right += 1
        self._after(stream, aligner.add_right(item), item.time_ns)

    def finish(self) -> list[DiffRow]:
        """Return all streams when both logs have ended, those with differences first."""
        for aligner, row in self._streams.values():
            for pair in aligner.settle(0, is_end=True):
                self._note(row, pair)
        rows = [row for _, row in self._streams.values()]
        return sorted(rows, key=lambda row: (row.is_same, row.bus, row.stream))

    def _begin(self, stream: Stream, item: Item, side: int) -> tuple[Stream, Item]:
        """Begin a stream, and return it; beyond `MOST_STREAMS` the one that stands for all further ones of the bus."""
        parts = None
        if len(self._streams) < MOST_STREAMS:
            parts = self._names[side].parts(item)
        else:
            stream, item = Stream(stream.bus, stream.family, FURTHER), item._replace(content=item.entry.data)
        if stream not in self._streams:
            row = DiffRow(stream.bus, stream.text)
            if parts is not None:
                row.node, row.kind = parts.node, parts.kind
            self._streams[stream] = Aligner(self._tolerance_ns, self._horizon_ns), row
        return stream, item

    def _after(self, stream: Stream, pair: Pair | None, now_ns: int) -> None:
        if pair is not None:
            if not -self._tolerance_ns <= pair.late_ns <= self._tolerance_ns:
                self._note(self._streams[stream][1], pair)
        else:
            self._waiting[stream] = None
            if self._streams[stream][0].is_full:
                self._settle(stream, now_ns)
        if self._sweep_ns is None or now_ns > self._sweep_ns:
            self._sweep_ns = now_ns + self._horizon_ns // 2
            for each in list(self._waiting):  # the others have nothing to decide
                self._settle(each, now_ns)

    def _settle(self, stream: Stream, now_ns: int) -> None:
        """Decide what can be decided now."""
        aligner, row = self._streams[stream]
        for pair in aligner.settle(now_ns):
            self._note(row, pair)
        if not aligner.is_waiting:
            del self._waiting[stream]

    def _note(self, row: DiffRow, pair: Pair) -> None:
        what = self._what(row, pair)
        if what and (self.first is None or pair.time_ns < self.first.time_ns):
            self.first = _First(pair.time_ns, row, pair, what)

    def _what(self, row: DiffRow, pair: Pair) -> str:
        """Count a pair, and return its difference in words; empty if there is none."""
        left, right = pair.left, pair.right
        if right is None:
            row.missing += 1
            return "missing in the second log"
        if left is None:
            row.more += 1
            return "only in the second log"
        words = []
        if left.content != right.content:
            row.other += 1
            if not row.words:
                row.words = self._other(left, right)
                words.append(f"other data: {row.words}")
            else:
                words.append("other data")
        if not -self._tolerance_ns <= pair.late_ns <= self._tolerance_ns:
            row.later += pair.late_ns > 0
            row.earlier += pair.late_ns < 0
            row.most_late_ns = max(row.most_late_ns, pair.late_ns, key=abs)
            words.append(f"{late_words(pair.late_ns)} in the second log")
        return ", ".join(words)

    def _other(self, left: Item, right: Item) -> str:
        ours, theirs = self._names[0].parts(left), self._names[1].parts(right)
        if ours is not None and theirs is not None:
            found = list(differences(ours.values, theirs.values))
            if found:
                more = f"; {len(found) - MOST_TOLD} more" if len(found) > MOST_TOLD else ""
                return "; ".join(map(_in_words, found[:MOST_TOLD])) + more
        return f"{_hex(left)}, then {_hex(right)}"


def _in_words(found: PartDifference) -> str:
    expected = "nothing" if found.expected is None else found.expected.text
    actual = "nothing" if found.actual is None else found.actual.text
    return f"{found.label} {expected}, then {actual}{f' ({found.bits})' if found.bits else ''}"


def _hex(item: Item) -> str:
    return hex_words(item.entry.data[HEAD_OF_FRAME:] if item.entry.family == "can" else item.content)


def compare_logs(
    left: Read,
    right: Read,
    *,
    tolerance_ns: int = TOLERANCE_NS,
    horizon_ns: int = HORIZON_NS,
    offset: int | None = None,
    leave_out: LeftOut | None = None,
    names: tuple[LogNames, LogNames] | None = None,
) -> DiffResult:
    """Compare two logs, which are read twice.  See `fieldrig_devices.replay.diff` for the arguments.

    UsageError if neither has a message to compare, as two logs of nothing would pass for equal ones.
    """
    left_out = LeftOut(()) if leave_out is None else leave_out
    ours, theirs = LogSide(left(), left_out), LogSide(right(), left_out)
    their_names = _same_names(ours.buses, theirs.buses)
    theirs.rename(their_names)
    shift_ns = offset_ns(ours.head, theirs.head, tolerance_ns) if offset is None else offset
    comparison = Comparison(tolerance_ns, max(horizon_ns, 2 * tolerance_ns), names)
    tagged = merge(
        ((item.time_ns, 0, stream, item) for stream, item in ours.all()),
        ((item.time_ns - shift_ns, 1, stream, item) for stream, item in theirs.all()),
        key=itemgetter(0),
    )
    for time_ns, side, stream, item in tagged:
        if side == 0:
            comparison.take_left(stream, item)
        else:
            comparison.take_right(stream, item._replace(time_ns=time_ns) if shift_ns else item)
    rows = comparison.finish()
    if not any(row.left or row.right for row in rows):
        raise UsageError(
            "neither log has a message to compare",
            "; ".join(left_out.unmet()) or "they are empty, or --from, --for and --leave-out leave nothing of them",
        )
    result = DiffResult(rows, shift_ns, None, [*_notes(rows, their_names), *left_out.unmet()])
    if comparison.first is not None:
        result.first = _with_context(comparison.first, left, right, shift_ns)
    return result


def _with_context(first: _First, left: Read, right: Read, shift_ns: int) -> FirstDifference:
    ours, theirs = first.pair.left, first.pair.right
    return FirstDifference(
        first.time_ns,
        first.row,
        first.what,
        around(left, first.time_ns, None if ours is None else ours.number, 0),
        around(right, first.time_ns, None if theirs is None else theirs.number, shift_ns),
    )


def _same_names(ours: Mapping[str, str], theirs: Mapping[str, str]) -> dict[str, str]:
    """Return our name of each of their buses that has another one: the only bus of a family is the same bus."""
    names = {}
    for family in set(theirs.values()):
        mine = [bus for bus, of in ours.items() if of == family]
        other = [bus for bus, of in theirs.items() if of == family]
        if len(mine) == len(other) == 1 and mine != other:
            names[other[0]] = mine[0]
    return names


def _notes(rows: Sequence[DiffRow], names: Mapping[str, str]) -> list[str]:
    notes = [f"{bus} of the first log is compared with {other} of the second" for other, bus in names.items()]
    for which, count in (("first", sum(row.left for row in rows)), ("second", sum(row.right for row in rows))):
        if not count:
            notes.append(f"the {which} log has no messages")
    if len(notes) == len(names) and not any(row.left and row.right for row in rows):
        notes.append("the logs have no stream in common; they are probably not of the same machine")
    notes += (
        f"{row.bus}: the log has more than {MOST_STREAMS} streams; the further ones are compared together"
        for row in rows
        if row.stream == FURTHER
    )
    return notes
