"""SDO transfers of the rig compared with those of a log, one by one."""

from collections import deque
from collections.abc import Iterable, Sequence
from typing import Final

from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.canopen.parts import abort_words, object_key, object_part
from fieldrig_devices.dialogues import SdoDialogues, SdoTransfer
from fieldrig_devices.dialogues.dialogue import Dialogue
from fieldrig_devices.dialogues.sdo_channels import End
from fieldrig_devices.dialogues.sdo_steps import asked
from fieldrig_devices.replay.grounds import Grounds
from fieldrig_devices.replay.replay_result import Difference, What
from fieldrig_devices.replay.runs import Subject
from fieldrig_devices.replay.words import hex_words, late_words, time_words

MOST_WAITING: Final = 1_024
NEAR: Final = 4
"""Transfers among which the one of the same object is looked for."""
HEAD_OF_FRAME: Final = 5
FORMS: Final = {"expedited": "in one message", "segmented": "in segments", "block": "in blocks"}


class SdoAnswers:
    """The transfers of both sides, by channel."""

    def __init__(self, grounds: Grounds) -> None:
        self._grounds = grounds
        self._sides = (SdoDialogues(), SdoDialogues())
        self._waiting: dict[tuple[str, int], tuple[deque[SdoTransfer], deque[SdoTransfer]]] = {}
        self._numbers = [0, 0]
        self._ours: set[tuple[str, int]] = set()
        """The channels in which a device of the rig has an end; others are only between players."""
        self._open_in_rig: dict[tuple[str, int], bytes] = {}
        self._open_in_log: dict[tuple[str, int], None] = {}
        """The channels with a transfer in the log that is not over."""

    def take(self, side: int, entry: TraceEntry) -> bool:
        """Take a frame of a side; return whether it is of an SDO channel."""
        end = self._sides[side].channels(entry.bus).ends.get(int.from_bytes(entry.data[:4], "little"))
        if end is not None:
            self._ours.add((entry.bus, end.request_key))
        self._take(side, entry)
        return end is not None

    def take_own(self, entry: TraceEntry) -> None:
        """Take a frame of the log that has arrived in the rig."""
        self._take(1, entry)
        end, message = self.end_of(entry.bus, int.from_bytes(entry.data[:4], "little")), entry.data[HEAD_OF_FRAME:]
        if end is not None and end.is_client and asked(message) is not None:
            self._open_in_rig[entry.bus, end.request_key] = message[1:4]
            if len(self._open_in_rig) > MOST_WAITING:
                del self._open_in_rig[next(iter(self._open_in_rig))]

    def left_open(self, bus: str, request_key: int) -> bytes | None:
        """Return index and sub-index of the transfer that the rig has not ended; None if it has."""
        return self._open_in_rig.get((bus, request_key))

    def _take(self, side: int, entry: TraceEntry) -> Sequence[Dialogue]:
        ended = self._sides[side].take(self._numbers[side], entry)
        self._numbers[side] += 1
        self._add(side, ended)
        return ended

    def end_of(self, bus: str, word: int) -> End | None:
        """Return the end of a channel that sends this identifier in the log; None if it is of none."""
        return self._sides[0].channels(bus).ends.get(word)

    def take_log(self, entry: TraceEntry) -> bool:
        """Take a frame of the log that is played; return whether it begins a transfer."""
        word = int.from_bytes(entry.data[:4], "little")
        end = self.end_of(entry.bus, word)
        assert end is not None
        key = entry.bus, end.request_key
        was_open = key in self._open_in_log
        is_over = any(isinstance(each, SdoTransfer) for each in self._take(0, entry))
        begins = end.is_client and asked(entry.data[HEAD_OF_FRAME:]) is not None and (is_over or not was_open)
        if begins:
            self._open_in_log[key] = None
            if len(self._open_in_log) > MOST_WAITING:
                del self._open_in_log[next(iter(self._open_in_log))]
        return begins

    def finish(self) -> None:
        """Compare everything that is left."""
        for side in (0, 1):
            self._add(side, self._sides[side].unfinished())
        for log, rig in self._waiting.values():
            self._compare(log, rig, is_end=True)

    def _add(self, side: int, dialogues: Iterable[Dialogue]) -> None:
        for transfer in dialogues:
            if not isinstance(transfer, SdoTransfer):
                continue
            (self._open_in_rig if side else self._open_in_log).pop((transfer.bus, transfer.request_id), None)
            both = self._waiting.setdefault((transfer.bus, transfer.request_id), (deque(), deque()))
            both[side].append(transfer)
            self._compare(*both, is_end=len(both[side]) > MOST_WAITING)

    def _compare(self, log: deque[SdoTransfer], rig: deque[SdoTransfer], *, is_end: bool) -> None:
        while log and rig:
            place = next((at for at, each in enumerate(rig) if at < NEAR and _is_alike(log[0], each)), None)
            if place is None:
                if len(rig) < NEAR and not is_end:
                    return
                self._judge_pair(log.popleft(), None)
                continue
            for _ in range(place):
                self._judge_pair(None, rig.popleft())
            self._judge_pair(log.popleft(), rig.popleft())
        if is_end:
            while log:
                self._judge_pair(log.popleft(), None)
            while rig:
                self._judge_pair(None, rig.popleft())

    def _judge_pair(self, log: SdoTransfer | None, rig: SdoTransfer | None) -> None:
        either = log or rig
        assert either is not None
        if (either.bus, either.request_id) not in self._ours:
            return
        node = self._grounds.node(either.bus, either.node_id)
        dictionary = self._grounds.names[1].dictionary(either.bus, either.node_id)
        key = object_key(either.index, either.subindex)
        variable = None if dictionary is None else dictionary.get(either.index, either.subindex)
        name = f"{key} {variable.name}" if variable is not None else key
        if self._grounds.tolerances.is_left_out(node, key, "" if variable is None else variable.name):
            return
        verb = "write" if either.is_download else "read"
        if log is None:
            if rig is not None and rig.end_ns is not None:
                self._add_difference(
                    What.MORE, rig, node, name, f"{node} had a {verb} of {name}, which the log does not have"
                )
            return
        self._grounds.compared(log.bus, node, name)
        if rig is None:
            self._add_difference(
                What.NO_ANSWER, log, node, name, f"{node} did not answer the {verb} of {name}{self._told(log)}"
            )
            return
        if log.end_ns is None and rig.end_ns is None:
            return
        is_given_up = rig.abort_by_client and log.abort is None
        if rig.end_ns is None or (is_given_up and log.end_ns is not None and rig.form == log.form):
            why = f" ({rig.wrong})" if rig.form != log.form else ""
            words = f"{node} did not answer the {verb} of {name}{self._told(log)}{why}"
            self._add_difference(What.NO_ANSWER, log, node, name, words)
        elif log.end_ns is None:
            if log.wrong != "the log ends before":
                words = f"{node} answered the {verb} of {name} with {self._outcome(rig)}, the log has no answer"
                self._add_difference(What.MORE, log, node, name, words)
        elif is_given_up:
            words = f"{node} answered the {verb} of {name} {FORMS[rig.form]}, the log says {self._outcome(log)}"
            self._add_difference(What.OTHER, log, node, name, words)
        elif (log.abort, rig.abort) != (None, None):
            self._judge_aborts(log, rig, node, name, verb)
        else:
            self._judge_values(log, rig, node, name)

    def _judge_aborts(self, log: SdoTransfer, rig: SdoTransfer, node: str, name: str, verb: str) -> None:
        if log.abort == rig.abort or log.abort_by_client:
            return
        did = "refused" if rig.abort is not None else "accepted"
        words = f"{node} {did} the {verb} of {name} with {self._outcome(rig)}, the log says {self._outcome(log)}"
        self._add_difference(What.REFUSED, log, node, name, words.replace(" with done", ""))

    def _judge_values(self, log: SdoTransfer, rig: SdoTransfer, node: str, name: str) -> None:
        assert log.end_ns is not None
        assert rig.end_ns is not None
        late_ns = (rig.end_ns - rig.begin_ns) - (log.end_ns - log.begin_ns)
        differs = False
        if not log.is_download and log.data is not None:
            dictionary = self._grounds.names[1].dictionary(log.bus, log.node_id)
            expected = object_part(dictionary, log.index, log.subindex, log.data)
            actual = object_part(dictionary, rig.index, rig.subindex, rig.data or b"")
            differs = self._grounds.runs.take(
                Subject(log.bus, node, name, f"{node} answered {{}} with"),
                [expected],
                [actual],
                (self._grounds.since(log.end_ns), self._grounds.since(rig.end_ns)),
            )
        if not differs and abs(late_ns) > self._grounds.tolerances.time_ns:
            words = f"{node} answered {name} {late_words(late_ns)}"
            self._add_difference(What.LATE, log, node, name, words, late_ns)

    def _told(self, log: SdoTransfer) -> str:
        within = f" within {time_words(self._grounds.timeout_ns)}"
        return within if log.end_ns is None else f"{within}, the log says {self._outcome(log)}"

    def _outcome(self, transfer: SdoTransfer) -> str:
        """Return the value or the abort code in words."""
        if transfer.abort is not None:
            return abort_words(transfer.abort)
        if transfer.is_download:
            return "done"
        if transfer.data is None:
            return "data that are not known"
        dictionary = self._grounds.names[1].dictionary(transfer.bus, transfer.node_id)
        part = object_part(dictionary, transfer.index, transfer.subindex, transfer.data)
        return part.text if len(transfer.data) <= 8 else hex_words(transfer.data)

    def _add_difference(
        self, what: What, transfer: SdoTransfer, node: str, name: str, words: str, late_ns: int = 0
    ) -> None:
        time_ns = self._grounds.since(transfer.begin_ns if transfer.end_ns is None else transfer.end_ns)
        self._grounds.result.add(Difference(time_ns, what, transfer.bus, node, name, words, late_ns))


def _is_alike(log: SdoTransfer, rig: SdoTransfer) -> bool:
    return (log.index, log.subindex, log.is_download) == (rig.index, rig.subindex, rig.is_download)
