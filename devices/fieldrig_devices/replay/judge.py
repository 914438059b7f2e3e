"""The comparison of what a rig sends with what a log expects of it.

Messages that are no answers (PDOs, EMCY, bytes of a line) are aligned stream by stream.  Answers are compared by
dialogue: an SDO transfer or a Modbus exchange of the log with that of the rig, whatever frames it took.  Heartbeats
are compared by state and period, because the instant at which a device was switched on says nothing.
"""

from collections import deque
from operator import attrgetter
from typing import Final

from fieldrig.clock import S
from fieldrig.points.values import counted
from fieldrig.traces.parts import Part
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import REMOTE
from fieldrig_bus.can.frame import EXTENDED_MASK
from fieldrig_bus.can.notices import NOTICE
from fieldrig_bus.modbus.codec import REQUEST, REQUEST_ON_ASCII, RESPONSE
from fieldrig_devices.canopen.names import ERROR_CONTROL, NODES
from fieldrig_devices.replay.align import Aligner, Pair
from fieldrig_devices.replay.grounds import Grounds
from fieldrig_devices.replay.heartbeats import Heartbeats
from fieldrig_devices.replay.log_names import LogNames
from fieldrig_devices.replay.modbus_answers import ModbusAnswers
from fieldrig_devices.replay.replay_result import Difference, ReplayResult, What
from fieldrig_devices.replay.rows import Row, Rows
from fieldrig_devices.replay.runs import Subject
from fieldrig_devices.replay.sdo_answers import SdoAnswers
from fieldrig_devices.replay.streams import Item, Stream, Streams, Telegrams
from fieldrig_devices.replay.tolerances import Tolerances
from fieldrig_devices.replay.words import hex_words

COMPARED: Final = frozenset({"can", "modbus", "serial"})
"""Families whose messages are compared.  Wires and rings are inside of a machine, and no log of one has them."""
HORIZON_NS: Final = 2 * S
MOST_WAITING: Final = 8_192
MOST_WAITS: Final = 64
NOTHING_EXPECTED: Final = "the log has no message of the rig's devices, so nothing is compared"
MOST_STREAMS: Final = 20_000
HEAD_OF_FRAME: Final = 5


class Judge(Grounds):
    """Compares.  All instants are of the rig's clock, and all buses are called as in the rig."""

    def __init__(self, names: tuple[LogNames, LogNames], tolerances: Tolerances, result: ReplayResult) -> None:
        """`names` are those of the log and of the rig: each follows the mappings of its own side."""
        super().__init__(names, tolerances, result)
        self._places = (Streams(), Streams())
        self._telegrams = (Telegrams(), Telegrams())
        self._aligners: dict[Stream, Aligner] = {}
        self._kinds: dict[Stream, tuple[str, str]] = {}
        """Node and kind of each stream."""
        self._only_here: dict[Stream, tuple[int, int]] = {}
        """Streams that the log does not have: the first instant, and how many messages."""
        self._expected: set[Stream] = set()
        self._played: set[Stream] = set()
        self.expected = 0
        """Messages of the log that the rig was expected to send."""
        self._waits: deque[tuple[int, int]] = deque(maxlen=MOST_WAITS)
        self._rows = Rows(self._report)
        self._numbers = [0, 0]
        self.sdo = SdoAnswers(self)
        self.modbus = ModbusAnswers(self)
        self._heartbeats = Heartbeats(self)

    # what comes

    def expect(self, entry: TraceEntry, log_ns: int) -> None:
        """Take a message of the log that the rig is expected to send at its instant.

        `log_ns` is the instant without the time that was spent waiting; heartbeats go by it.
        """
        self.expected += 1
        self.buses.add(entry.bus)
        self._take(0, entry, log_ns)

    def heard(self, entry: TraceEntry) -> None:
        """Take a message that a device of the rig has sent."""
        self._take(1, entry, entry.time_ns)

    def waited(self, from_ns: int, to_ns: int) -> None:
        """Note that the log stood still meanwhile: what a device sends then by itself is not more than the log has."""
        self._waits.append((from_ns, to_ns))

    def played(self, entry: TraceEntry) -> None:
        """Take a message of the log that was sent to the rig: both sides learn from it."""
        self.buses.add(entry.bus)
        if entry.family == "can":
            if len(self._played) < MOST_WAITING:
                self._played.add(self._places[0].place(0, entry)[0])
            for side in (0, 1):
                self._learn(side, entry)

    def settle(self, now_ns: int) -> None:
        """Decide what can be decided when everything up to this instant is there."""
        for side in (0, 1):
            for _, entry in self._telegrams[side].ended_by(now_ns):
                self._align(side, entry)
        for stream, aligner in self._aligners.items():
            if aligner.is_waiting:
                for pair in aligner.settle(now_ns):
                    self._judge(stream, pair)

    def finish(self, end_ns: int) -> None:
        """Decide everything; what the rig sent after `end_ns` is more than the log knows of."""
        for side in (0, 1):
            for _, entry in self._telegrams[side].rest():
                self._align(side, entry)
        for stream, aligner in self._aligners.items():
            for pair in aligner.settle(0, is_end=True):
                if pair.left is not None or pair.time_ns <= end_ns:
                    self._judge(stream, pair)
        self._rows.finish()
        if not self.expected:
            self.result.forget(NOTHING_EXPECTED)
            return
        self._heartbeats.finish(end_ns)
        self.sdo.finish()
        self.modbus.finish()
        self.runs.finish()
        self._tell_only_here()
        self.result.differences.sort(key=attrgetter("time_ns"))

    # streams

    def _take(self, side: int, entry: TraceEntry, own_ns: int) -> None:
        if entry.family not in COMPARED:
            return
        self._numbers[side] += 1
        if entry.family == "serial":
            for _, telegram in self._telegrams[side].take(self._numbers[side], entry):
                self._align(side, telegram)
            return
        if entry.family == "can":
            if self.sdo.take(side, entry):
                self._learn(side, entry)
                return
            word = int.from_bytes(entry.data[:4], "little")
            if word & ~EXTENDED_MASK == NOTICE:
                return  # errors and injected faults are no messages of a device
            if word - ERROR_CONTROL in NODES and not word & REMOTE and len(entry.data) == HEAD_OF_FRAME + 1:
                self._heartbeats.take(side, word - ERROR_CONTROL, entry, own_ns)
                return
        elif entry.data[0] == RESPONSE or not REQUEST <= entry.data[0] <= REQUEST_ON_ASCII:
            return  # answers are taken by their exchange
        self._align(side, entry)

    def _align(self, side: int, entry: TraceEntry) -> None:
        stream, item = self._places[side].place(self._numbers[side], entry)
        if entry.family == "serial":
            stream = stream._replace(key=str(stream.key).partition(" ")[2])  # senders have other names in other logs
        aligner = self._aligners.get(stream)
        if aligner is None:
            if len(self._aligners) >= MOST_STREAMS:
                self.result.note(f"only {MOST_STREAMS} identifiers and units of the log are compared, as it has more")
                return
            aligner = self._aligners[stream] = Aligner(self.tolerances.time_ns, HORIZON_NS, MOST_WAITING)
            parts = self.names[1].parts(item)
            self._kinds[stream] = ("", "") if parts is None else (parts.node, parts.kind)
        if side == 0:
            self._expected.add(stream)
        pair = aligner.add_left(item) if side == 0 else aligner.add_right(item)
        if pair is not None:
            self._judge(stream, pair)
        elif aligner.is_full:
            for pair in aligner.settle(item.time_ns):
                self._judge(stream, pair)

    def _learn(self, side: int, entry: TraceEntry) -> None:
        stream, item = self._places[side].place(0, entry)
        self.names[side].note(stream, item)

    def _judge(self, stream: Stream, pair: Pair) -> None:
        node, kind = self._kinds[stream]
        if self.tolerances.is_left_out(node, stream.text, kind):
            return
        left, right = pair.left, pair.right
        if left is None:
            self._more(stream, pair)
            return
        self.compared(stream.bus, node, kind or stream.text)
        if right is None:
            self._rows.take(stream, What.MISSING, left.time_ns, self._content(0, left))
            return
        expected, actual = self._parts(0, left), self._parts(1, right)
        subject = Subject(
            stream.bus, node, kind or stream.text, f"{node or stream.bus} sent {kind or stream.text} with {{}}"
        )
        times_ns = self.since(left.time_ns), self.since(right.time_ns)
        differs = self.runs.take(subject, expected, actual, times_ns)
        if not differs and abs(pair.late_ns) > self.tolerances.time_ns:
            self._rows.take(stream, What.LATE, left.time_ns, self._content(1, right), pair.late_ns)
        else:
            self._rows.end(stream)

    def _report(self, stream: Stream, row: Row) -> None:
        node, kind = self._kinds[stream]
        subject = kind or stream.text
        words = row.words(node or stream.bus, subject)
        self._add(row.what, row.time_ns, stream, node, subject, words, row.late_ns)

    def _parts(self, side: int, item: Item) -> tuple[Part, ...]:
        parts = self.names[side].parts(item)
        if parts is not None:
            return tuple(parts.values)
        content = _plain(item)
        return (Part("data", "", content.hex(), hex_words(content)),)

    def _content(self, side: int, item: Item) -> str:
        return ", ".join(f"{part.label} {part.text}" for part in self._parts(side, item)[:3])

    def _more(self, stream: Stream, pair: Pair) -> None:
        item = pair.right
        assert item is not None
        if any(from_ns <= item.time_ns <= to_ns for from_ns, to_ns in self._waits):
            return
        if stream not in self._expected:
            first_ns, count = self._only_here.get(stream, (item.time_ns, 0))
            self._only_here[stream] = first_ns, count + 1
            return
        self._rows.take(stream, What.MORE, item.time_ns, self._content(1, item))

    def _tell_only_here(self) -> None:
        for stream, (first_ns, count) in self._only_here.items():
            if stream.bus not in self.buses:
                continue
            node, kind = self._kinds[stream]
            subject = f"{kind} ({stream.text})" if kind else stream.text
            if stream in self._played:
                self.result.note(f"{subject} of {stream.bus} was played, and a device of the rig sends it as well")
                continue
            words = f"{node or stream.bus} sent {counted(count, 'message')} of {subject}, and the log has none of them"
            self._add(What.MORE, first_ns, stream, node, kind or stream.text, words)

    def _add(
        self, what: What, time_ns: int, stream: Stream, node: str, subject: str, words: str, late_ns: int = 0
    ) -> None:
        self.result.add(Difference(self.since(time_ns), what, stream.bus, node, subject, words, late_ns))


def _plain(item: Item) -> bytes:
    return item.entry.data[HEAD_OF_FRAME:] if item.entry.family == "can" else item.entry.data[1:]
