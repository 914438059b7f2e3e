"""One recording in the process of its signals: tracks, batches, and the batches that are kept to be asked for again.

A reader acknowledges the batches that it has.  One that stops reading is left behind: nothing is published for it while
`MOST_BEHIND` batches wait for it, the latest `MOST_KEPT_BYTES` are kept, and it sees by the numbers of the rows what it
has lost.  A lossless recording, as in virtual time, keeps everything instead, and its rig waits (`is_behind`), unless
the reader says nothing for `PATIENCE_S`.
"""

import json
import time
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import Final

from fieldrig.device import Value
from fieldrig.recording import batch
from fieldrig.recording.sampler import Changes, Texts, Track
from fieldrig.recording.signals import (
    CHANGE,
    CYCLE,
    OWN_PERIOD_NS,
    REST_NS,
    Column,
    Described,
    End,
    RecordedPart,
    Rhythm,
    Sort,
    Source,
    split_signal,
)

MOST_BEHIND: Final = 64
"""Batches that may wait for their acknowledgement."""
MOST_KEPT: Final = 4 * MOST_BEHIND
MOST_KEPT_BYTES: Final = 8 << 20
PATIENCE_S: Final = 5.0
"""How long a rig in virtual time waits for a reader that says nothing."""
MARK_NS: Final = 500_000_000
"""Time between two batches without rows, which say that nothing has happened."""
LONGEST_BUNDLE: Final = 4 << 20


class RecordSet:
    """The recording of some signals of one process, from when it is made until `end`."""

    def __init__(
        self,
        source: Source,
        signals: Sequence[str],
        rhythm: Rhythm,
        publish: Callable[[bytes], None],
        *,
        is_lossless: bool,
    ) -> None:
        """ControlError for a signal that does not exist."""
        self._source, self._publish, self._is_lossless = source, publish, is_lossless
        self.columns: list[Column] = []
        """The signals, with the texts that they had at the beginning."""
        self.tracks: list[list[int]] = []
        """The columns of each track."""
        self._takers: list[Track | Changes] = []
        self._texts: dict[int, Texts] = {}
        self._whole: set[int] = set()
        """The columns of whole numbers."""
        self._ends: list[End] = []
        self._kept: deque[tuple[int, bytes]] = deque()
        self._kept_bytes = 0
        self._next = self._acknowledged = 0
        self._until_ns = source.now_ns()
        self._heard_s = time.monotonic()
        self._is_ended = False
        try:
            self._begin(signals, rhythm)
        except BaseException:
            self.end()
            raise

    def _begin(self, signals: Sequence[str], rhythm: Rhythm) -> None:
        parts: dict[str, list[tuple[int, str]]] = {}
        for number, name in enumerate(signals):
            part, key = split_signal(name)
            parts.setdefault(part, []).append((number, key))
        described: dict[int, Described] = {}
        found_parts = {name: self._source.part(name) for name in parts}
        self._ends += [part.close for part in found_parts.values()]
        for name, keys in parts.items():
            found = found_parts[name].describe([key for _, key in keys])
            described |= {number: of_it for (number, _), of_it in zip(keys, found, strict=True)}
        for number, name in enumerate(signals):
            of_it = described[number]
            if of_it.sort is Sort.TEXT:
                self._texts[number] = Texts(of_it.states)
            elif of_it.is_whole:
                self._whole.add(number)
            is_open = of_it.sort is Sort.TEXT and not of_it.states
            self.columns.append(Column(name, of_it.sort, of_it.unit, list(of_it.states), is_open=is_open))
        for name, keys in parts.items():
            self._begin_part(found_parts[name], [number for number, _ in keys], [key for _, key in keys], rhythm)

    def _begin_part(self, part: RecordedPart, numbers: list[int], keys: list[str], rhythm: Rhythm) -> None:
        if rhythm == CHANGE or (rhythm == CYCLE and part.is_bus):
            self._begin_changes(part, numbers, keys)
            return
        texts = [self._texts.get(number) for number in numbers]
        whole = [place for place, number in enumerate(numbers) if number in self._whole]
        track = Track(len(self.tracks), part.reader(keys), texts, self.flush, whole)
        self._add(track, numbers)
        end = part.on_cycle(track.sample) if rhythm == CYCLE else None
        if end is not None:
            self._ends += [end, self._source.every(REST_NS, track.sample_at_rest)]
        else:
            self._ends.append(self._source.every(int(rhythm) if rhythm != CYCLE else OWN_PERIOD_NS, track.sample))

    def _begin_changes(self, part: RecordedPart, numbers: list[int], keys: list[str]) -> None:
        changes = Changes(len(self.tracks), self.flush)
        self._add(changes, numbers)
        for number in numbers:
            self.columns[number] = self.columns[number]._replace(is_held=True)
        note = partial(self._note, changes, numbers)
        now_ns = self._source.now_ns()
        for place, value in enumerate(part.reader(keys)()):
            note(now_ns, place, value)
        self._ends.append(part.on_change(keys, note))

    def _add(self, taker: Track | Changes, numbers: list[int]) -> None:
        self.tracks.append(numbers)
        self._takers.append(taker)

    def _note(self, changes: Changes, numbers: Sequence[int], now_ns: int, place: int, value: Value) -> None:
        texts = self._texts.get(numbers[place])
        changes.note(now_ns, place, value if texts is None else texts.number(value))

    def end(self) -> None:
        """Sample nothing any more; what is kept can still be asked for."""
        self._is_ended = True
        while self._ends:
            self._ends.pop()()

    def close(self) -> None:
        """End it; nothing will be asked for any more."""
        self.end()

    def flush(self) -> None:
        """Publish everything up to now."""
        taken = [part for taker in self._takers for part in (taker.whole.take(), taker.take())]
        parts = [*self._new_texts(), *(part for part in taken if part is not None)]
        now_ns = self._source.now_ns()
        if not parts and now_ns - self._until_ns < MARK_NS:
            return
        self._until_ns = now_ns
        data = batch.encode(self._next, now_ns, parts)
        self._keep(data)
        self._next += 1
        if self._next - self._acknowledged <= MOST_BEHIND or self._is_lossless:
            self._publish(data)

    def _new_texts(self) -> list[bytes]:
        parts = []
        for number, texts in self._texts.items():
            if texts.has_grown:
                texts.has_grown = False
                parts.append(batch.texts_part(number, json.dumps(texts.states).encode()))
        return parts

    def _keep(self, data: bytes) -> None:
        kept = self._kept
        kept.append((self._next, data))
        self._kept_bytes += len(data)
        while len(kept) > MOST_KEPT or self._kept_bytes > MOST_KEPT_BYTES:
            if len(kept) == 1 or (
                self._is_lossless and kept[0][0] >= self._acknowledged and not self._is_left_behind()
            ):
                return
            self._kept_bytes -= len(kept.popleft()[1])

    def again(self, first: int, end: int) -> bytes:
        """Return the batches from `first` to before `end` that are kept, as far as one answer holds them."""
        chosen: list[bytes] = []
        size = 0
        for number, data in self._kept:
            if first <= number < end:
                size += len(data)
                if chosen and size > LONGEST_BUNDLE:
                    break
                chosen.append(data)
        return batch.bundle(chosen)

    @property
    def next(self) -> int:
        """The number of the next batch."""
        return self._next

    @property
    def oldest(self) -> int:
        """The number of the oldest batch that is kept."""
        return self._kept[0][0] if self._kept else self._next

    def acknowledge(self, number: int) -> None:
        """Take note that the reader has all batches before this one."""
        self._heard_s = time.monotonic()
        self._acknowledged = max(self._acknowledged, min(number, self._next))
        while self._is_lossless and self._kept and self._kept[0][0] < self._acknowledged:
            self._kept_bytes -= len(self._kept.popleft()[1])

    @property
    def is_behind(self) -> bool:
        """True if a rig in virtual time has to wait for the reader."""
        return (
            self._is_lossless
            and not self._is_ended
            and self._next - self._acknowledged >= MOST_BEHIND
            and not self._is_left_behind()
        )

    def _is_left_behind(self) -> bool:
        return time.monotonic() - self._heard_s > PATIENCE_S
