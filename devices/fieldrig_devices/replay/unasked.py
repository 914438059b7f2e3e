"""The comparison of what a rig sends unasked with what a log expects: PDOs, EMCY, requests, bytes of serial lines.

The messages are aligned stream by stream.  A timer that sends a PDO began when its node was started, which a log of a
machine that was on does not show, and that of a real node is a little faster or slower than that of an emulated one.
So a stream that is cyclic in the log is compared by its values, its period and its gaps, like a heartbeat, and not by
instants.  What follows SYNC has the instants of the log.
"""

from collections import deque
from collections.abc import Iterable
from typing import Final

from fieldrig.clock import S
from fieldrig.points.values import counted
from fieldrig.traces.parts import Part
from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.canopen.names import SYNC
from fieldrig_devices.replay.align import Aligner, Matching, Pair
from fieldrig_devices.replay.cycles import Cycles
from fieldrig_devices.replay.families import CYCLIC, INNER, RINGS
from fieldrig_devices.replay.gaps import UNEVEN, Gaps
from fieldrig_devices.replay.grounds import Grounds
from fieldrig_devices.replay.replay_result import Difference, What
from fieldrig_devices.replay.rows import Row, Rows
from fieldrig_devices.replay.runs import Subject
from fieldrig_devices.replay.streams import Item, Stream, Streams, Telegrams
from fieldrig_devices.replay.words import hex_words, time_words

HORIZON_NS: Final = 2 * S
MOST_WAITING: Final = 8_192
MOST_WAITS: Final = 64
MOST_STREAMS: Final = 20_000
MOST_ROWS: Final = 20_000
"""Rows that wait for the end, where it is known whether their stream is cyclic."""
OTHER_PERIOD: Final = 0.1
"""Part of a period by which that of the rig may differ, beside the tolerance."""
HEAD_OF_FRAME: Final = 5


class _Compared:
    """One stream on both sides."""

    def __init__(self, aligner: Matching, node: str, kind: str) -> None:
        self.aligner, self.node, self.kind = aligner, node, kind
        self.gaps = (Gaps(), Gaps())
        self.after_sync_ns: tuple[int, int] | None = None
        """The shortest and the longest time from a SYNC to a message of the log; None without SYNC."""
        self.first: Item | None = None
        """The first message of the log."""
        self.only_here: tuple[int, int] | None = None
        """The instant of the first message, and how many, as long as the log has none."""


class Unasked:
    """The streams of both sides."""

    def __init__(self, grounds: Grounds) -> None:
        self._grounds = grounds
        self._places = (Streams(), Streams())
        self._telegrams = (Telegrams(), Telegrams())
        self._streams: dict[Stream, _Compared] = {}
        self._played: set[Stream] = set()
        self._sync_ns: dict[str, tuple[int, int]] = {}
        """The instant of the last SYNC of each bus, and the time since the one before."""
        self._waits: deque[tuple[int, int]] = deque(maxlen=MOST_WAITS)
        self._before: dict[Stream, bytes] = {}
        """The last content that the rig has sent before the log begins."""
        self._rows = Rows(self._keep)
        self._kept: list[tuple[Stream, Row]] = []
        self._numbers = [0, 0]

    def waited(self, from_ns: int, to_ns: int) -> None:
        """Note that the log stood still meanwhile: what a device sends then by itself is not more than the log has."""
        self._waits.append((from_ns, to_ns))

    def played(self, entry: TraceEntry) -> None:
        """Take a frame of the log that was sent to the rig."""
        stream, _ = self._places[0].place(0, entry)
        if len(self._played) < MOST_WAITING:
            self._played.add(stream)
        if stream.key == SYNC:
            before_ns, _ = self._sync_ns.get(stream.bus, (entry.time_ns, 0))
            self._sync_ns[stream.bus] = entry.time_ns, entry.time_ns - before_ns

    def sent_before(self, entry: TraceEntry) -> None:
        """Take a message that the rig has sent before the log begins."""
        stream, item = self._places[1].place(0, entry)
        self._grounds.names[1].note(stream, item)
        if stream in self._before or len(self._before) < MOST_STREAMS:
            self._before[stream] = item.content

    def take(self, side: int, entry: TraceEntry, own_ns: int) -> None:
        """Take a message of the log (0) or of the rig (1); `own_ns` is its instant by the clock of its own side."""
        self._numbers[side] += 1
        if entry.family == "serial":
            for _, telegram in self._telegrams[side].take(self._numbers[side], entry):
                self._align(side, telegram)
        else:
            self._align(side, entry, own_ns)

    def settle(self, now_ns: int) -> None:
        """Decide what can be decided when everything up to this instant is there."""
        for side in (0, 1):
            for _, entry in self._telegrams[side].ended_by(now_ns):
                self._align(side, entry)
        for stream, compared in self._streams.items():
            if compared.aligner.is_waiting:
                self._judge_all(stream, compared, compared.aligner.settle(now_ns))

    def finish(self, end_ns: int) -> None:
        """Decide everything; what the rig sent after `end_ns` is more than the log knows of."""
        for side in (0, 1):
            for _, entry in self._telegrams[side].rest():
                self._align(side, entry)
        for stream, compared in self._streams.items():
            pairs = compared.aligner.settle(0, is_end=True)
            self._judge_all(
                stream, compared, (pair for pair in pairs if pair.left is not None or pair.time_ns <= end_ns)
            )
        self._rows.finish()
        for stream, row in sorted(self._kept, key=lambda kept: kept[1].time_ns):
            self._report(stream, row)
        self._kept.clear()

    def tell_rest(self) -> None:
        """Report the periods of cyclic streams, and the streams that the log does not have."""
        for stream, compared in self._streams.items():
            if self._is_cyclic(stream, compared):
                self._tell_period(stream, compared)
            elif compared.only_here is not None and compared.first is None:
                self._tell_only_here(stream, compared, *compared.only_here)

    # ---- parts

    def _align(self, side: int, entry: TraceEntry, own_ns: int | None = None) -> None:
        stream, item = self._places[side].place(self._numbers[side], entry)
        if entry.family in RINGS:
            self._grounds.names[side].note(stream, item)
        if entry.family == "serial":
            stream = stream._replace(key=str(stream.key).partition(" ")[2])  # senders have other names in other logs
        compared = self._streams.get(stream)
        if compared is None:
            if len(self._streams) >= MOST_STREAMS:
                words = f"only {MOST_STREAMS} identifiers and units of the log are compared, as it has more"
                self._grounds.result.note(words)
                return
            compared = self._streams[stream] = self._begun(stream, item)
        if own_ns is not None:
            compared.gaps[side].take(item.time_ns, own_ns)
        if side == 0:
            compared.first = compared.first or item
            self._note_sync(stream, compared, item.time_ns)
        aligner = compared.aligner
        pair = aligner.add_left(item) if side == 0 else aligner.add_right(item)
        if pair is not None:
            self._judge(stream, compared, pair)
        elif aligner.is_full:
            self._judge_all(stream, compared, aligner.settle(item.time_ns))

    def _begun(self, stream: Stream, item: Item) -> _Compared:
        parts = self._grounds.names[1].parts(item)
        node, kind = ("", "") if parts is None else (parts.node, parts.kind)
        if stream.family == "wires":
            node, kind = item.entry.sender, stream.text
        if stream.family in RINGS:
            return _Compared(Cycles(HORIZON_NS, MOST_WAITING), node, kind)
        return _Compared(Aligner(self._grounds.tolerances.time_ns, HORIZON_NS, MOST_WAITING), node, kind)

    def _judge_all(self, stream: Stream, compared: _Compared, pairs: Iterable[Pair]) -> None:
        for pair in pairs:
            self._judge(stream, compared, pair)

    def _judge(self, stream: Stream, compared: _Compared, pair: Pair) -> None:
        grounds, node, kind = self._grounds, compared.node, compared.kind
        if self._is_left_out(stream, compared):
            return
        left, right = pair.left, pair.right
        if left is None:
            self._more(stream, compared, pair)
            return
        grounds.compared(stream.bus, node, kind or stream.text)
        if right is None:
            if self._before.get(stream) == left.content and compared.first is left:
                return  # the rig has had this value for longer than the log lasts
            self._rows.take(stream, What.MISSING, left.time_ns, self._content(stream, 0, left))
            return
        differs = self._differs(stream, compared, left, right)
        if not differs and abs(pair.late_ns) > grounds.tolerances.time_ns:
            self._rows.take(stream, What.LATE, left.time_ns, self._content(stream, 1, right), pair.late_ns)
        else:
            self._rows.end(stream)

    def _differs(self, stream: Stream, compared: _Compared, left: Item, right: Item) -> bool:
        """Compare the values of two messages, and return whether they differ."""
        runs, node, name = self._grounds.runs, compared.node, compared.kind or stream.text
        begin = f"{node or stream.bus} {'set {} to' if stream.family == 'wires' else f'sent {name} with {{}}'}"
        subject = Subject(stream.bus, node, name, begin)
        if left.content == right.content and stream.family in INNER and not runs.is_open(subject):
            return False  # a ring has a thousand telegrams a second, and most are alike
        times_ns = self._grounds.since(left.time_ns), self._grounds.since(right.time_ns)
        return runs.take(subject, self._parts(0, left), self._parts(1, right), times_ns)

    def _is_left_out(self, stream: Stream, compared: _Compared) -> bool:
        tolerances = self._grounds.tolerances
        return tolerances.is_left_out(compared.node, stream.text, compared.kind) or tolerances.is_left_out(
            "", stream.bus
        )

    def _more(self, stream: Stream, compared: _Compared, pair: Pair) -> None:
        item = pair.right
        assert item is not None
        is_before = item.time_ns < self._grounds.first_ns
        if is_before or any(from_ns <= item.time_ns <= to_ns for from_ns, to_ns in self._waits):
            return
        if compared.first is not None:
            self._rows.take(stream, What.MORE, item.time_ns, self._content(stream, 1, item))
            return
        first_ns, count = compared.only_here or (item.time_ns, 0)
        compared.only_here = first_ns, count + 1

    def _parts(self, side: int, item: Item) -> tuple[Part, ...]:
        parts = self._grounds.names[side].parts(item)
        if side == 0 and item.entry.family in RINGS:  # the log may have begun when the ring was configured
            parts = max(
                parts, self._grounds.names[1].parts(item), key=lambda each: 0 if each is None else len(each.values)
            )
        if parts is not None:
            return tuple(parts.values)
        content = _plain(item)
        return (Part("data", "", content.hex(), hex_words(content)),)

    def _content(self, stream: Stream, side: int, item: Item) -> str:
        parts = self._parts(side, item)[:3]
        return ", ".join(part.text if part.key == stream.key else f"{part.label} {part.text}" for part in parts)

    # ---- reports

    def _keep(self, stream: Stream, row: Row) -> None:
        if len(self._kept) < MOST_ROWS:
            self._kept.append((stream, row))
        else:
            self._report(stream, row)

    def _report(self, stream: Stream, row: Row) -> None:
        compared = self._streams[stream]
        if self._is_cyclic(stream, compared) and _is_of_phase(row, *compared.gaps):
            return
        words = row.words(compared.node or stream.bus, compared.kind or stream.text)
        self._add(row.what, row.time_ns, stream, compared, words, row.late_ns)

    def _note_sync(self, stream: Stream, compared: _Compared, time_ns: int) -> None:
        if stream.bus in self._sync_ns:
            after_ns = time_ns - self._sync_ns[stream.bus][0]
            least_ns, most_ns = compared.after_sync_ns or (after_ns, after_ns)
            compared.after_sync_ns = min(least_ns, after_ns), max(most_ns, after_ns)

    def _is_cyclic(self, stream: Stream, compared: _Compared) -> bool:
        """Return whether a timer of the device sends the messages of a stream, and not SYNC."""
        if stream.family not in CYCLIC or not compared.gaps[0].is_cyclic:
            return False
        if compared.after_sync_ns is None:
            return True
        least_ns, most_ns = compared.after_sync_ns
        return most_ns - least_ns > UNEVEN * self._sync_ns[stream.bus][1]

    def _tell_period(self, stream: Stream, compared: _Compared) -> None:
        if self._is_left_out(stream, compared):
            return
        log, rig = compared.gaps
        who, subject = compared.node or stream.bus, compared.kind or stream.text
        allowed_ns = max(self._grounds.tolerances.time_ns, round(OTHER_PERIOD * log.usual_ns))
        if rig.count and abs(rig.usual_ns - log.usual_ns) > allowed_ns:
            words = f"{who} sent {subject} every {time_words(rig.usual_ns)}, the log says {time_words(log.usual_ns)}"
            self._add(What.PERIOD, rig.longest_at_ns, stream, compared, words)

    def _tell_only_here(self, stream: Stream, compared: _Compared, first_ns: int, count: int) -> None:
        if stream.bus not in self._grounds.buses:
            return
        subject = f"{compared.kind} ({stream.text})" if compared.kind else stream.text
        if stream in self._played:
            words = f"{subject} of {stream.bus} was played, and a device of the rig sends it as well"
            self._grounds.result.note(words)
            return
        who = compared.node or stream.bus
        words = f"{who} sent {counted(count, 'message')} of {subject}, and the log has none of them"
        self._add(What.MORE, first_ns, stream, compared, words)

    def _add(self, what: What, time_ns: int, stream: Stream, compared: _Compared, words: str, late_ns: int = 0) -> None:
        subject, since_ns = compared.kind or stream.text, self._grounds.since(time_ns)
        self._grounds.result.add(Difference(since_ns, what, stream.bus, compared.node, subject, words, late_ns))


def _is_of_phase(row: Row, log: Gaps, rig: Gaps) -> bool:
    """Return whether a row of a cyclic stream only says that the timer began at another instant, or is a bit faster."""
    match row.what:
        case What.LATE:
            return True
        case What.MISSING:
            return row.count == 1 and rig.count > 0 and rig.long <= log.long
        case What.MORE:
            return row.count == 1 and rig.short <= log.short and log.long <= rig.long
    return False


def _plain(item: Item) -> bytes:
    return item.entry.data[HEAD_OF_FRAME:] if item.entry.family == "can" else item.entry.data[1:]
