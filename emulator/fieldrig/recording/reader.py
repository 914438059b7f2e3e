"""The reader of recorded signals: `Reader` begins a recording, and calls a handler with its rows, in order and once.

    reader = Reader(control, ["drive/position", "wires/lamp.on"], "cycle", on_rows)
    columns = await reader.begin()
    ...
    await reader.end()

Signals of several processes are recorded in each of them.  What is lost on the way is asked for again until it is
there.  `Rows.lost` counts what the process no longer has, and what it could not sample because its host was late.
"""

import asyncio
import json
import logging
import uuid
from array import array
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from math import isfinite
from types import MappingProxyType
from typing import Any, Final, NamedTuple, Protocol

from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError, field, items
from fieldrig.recording import batch
from fieldrig.recording.batch import Batch, Kind, Part
from fieldrig.recording.sampler import MOST_TEXTS
from fieldrig.recording.signals import NAN, NO_RECORDING, Column, Rhythm, column_of, split_signal
from fieldrig.text.nearest import closest

log = logging.getLogger(__name__)

PATIENCE_S: Final = 5.0
"""Time limit for one answer."""
END_S: Final = 1.0
"""Time limit for the answers at the end, when the rig may be gone."""
ACKNOWLEDGE_S: Final = 0.4
"""Longest time between two acknowledgements.  Each is a question that may delay a cycle: 10 a second would be 1 % of
the cycles of a ring of 1 ms, and in its p99."""
EVERY: Final = 8
"""Batches after which an acknowledgement is sent at once."""
MOST_WAITING: Final = 512
"""Batches behind a gap that are kept until it is filled; each of them can be asked for again."""
MOST_STATES: Final = 10 * MOST_TEXTS
"""Texts of a column, over all restarts of its process."""
LEAST_LOST: Final = 1
"""The rows that count as lost where their number is not known, as after the restart of a process."""


class Rows(NamedTuple):
    """Values of some signals at some instants, from one process; or what is known to be missing before them."""

    process: str
    columns: tuple[int, ...]
    """The signals, as places in the reader's list."""
    first: int
    """Number of the first row among all rows of these columns."""
    lost: int
    """Rows that are missing before the first one."""
    times_ns: "array[int]"
    """Instants on the clock of the rig: from 0 in virtual time, else of the system's monotonic clock."""
    values: "list[array[float]]"
    """One array for each column, as long as `times_ns`; NaN where a signal had no value."""
    whole: Mapping[tuple[int, int], int] = MappingProxyType({})
    """The exact values of whole numbers beyond 2^53, by their places in `values` and in the array."""


class Ears(Protocol):
    """A session with a rig, as a reader needs it; `fieldrig.control.messages.Control` is one."""

    rig: str

    async def ask(self, path: str, message: Any, timeout_s: float) -> Any: ...

    async def ask_bytes(self, path: str, message: Any, timeout_s: float) -> bytes: ...

    def listen_to_bytes(self, path: str, handler: Callable[[str, bytes], None]) -> Callable[[], None]: ...

    def show_life(self, path: str) -> Callable[[], None]: ...


OnRows = Callable[[Rows], None]


class Reader:
    """A recording of signals of a running rig.  Use it in the event loop of its control session."""

    def __init__(
        self,
        control: Ears,
        signals: Sequence[str],
        rhythm: Rhythm,
        on_rows: OnRows,
        on_complete: Callable[[int], None] = lambda until_ns: None,
    ) -> None:
        """`rhythm` is "cycle", "change", or a period in nanoseconds.

        `on_complete(until_ns)` is called when all rows up to this instant have been handed over.
        """
        self._control, self._signals, self._rhythm = control, list(dict.fromkeys(signals)), rhythm
        self._on_rows, self._on_complete = on_rows, on_complete
        self.owner = f"r{uuid.uuid4().hex[:16]}"
        self.columns: list[Column] = []
        """The recorded signals, in the order in which they were given, each once."""
        self.epoch_ns = 0
        """Add it to an instant for the time of day; it is 0 in virtual time."""
        self.begin_ns = 0
        """The instant at which the recording began."""
        self.lost = 0
        """All rows that are missing so far."""
        self._streams: list[_Stream] = []
        self._complete_ns = 0
        self._end_life: Callable[[], None] = lambda: None

    async def begin(self) -> list[Column]:
        """Begin the recording, and return its columns.

        ControlError, with the nearest names, for a signal that the rig does not have.
        """
        places = await self._places()
        self._end_life = self._control.show_life(f"recorder/{self.owner}")
        columns: dict[int, Column] = {}
        try:
            for process, numbers in places.items():
                names = [self._signals[number] for number in numbers]
                stream = _Stream(
                    self._control, process, self.owner, names, self._rhythm, self._taker(numbers), self._look
                )
                self._streams.append(stream)
                await stream.begin()
                columns |= dict(zip(numbers, stream.columns, strict=True))
                self.epoch_ns = stream.epoch_ns
                self.begin_ns = max(self.begin_ns, stream.begin_ns)
        except BaseException:
            await self.end()
            raise
        self.columns = [columns[number] for number in range(len(self._signals))]
        for stream in self._streams:
            stream.start()
        return self.columns

    async def end(self) -> None:
        """End the recording.  Everything that was sampled before has been handed over."""
        for stream in self._streams:
            await stream.end()
        self._streams.clear()
        self._end_life()

    async def _places(self) -> dict[str, list[int]]:
        """Return the places of the signals in the list, by the process that has them."""
        status = await self._control.ask("rig/status", None, PATIENCE_S)
        homes = {name: process for process, facts in status["processes"].items() for name in facts["buses"]}
        homes |= {name: entry["process"] for name, entry in status["devices"].items()}
        places: dict[str, list[int]] = {}
        for number, signal in enumerate(self._signals):
            part, _ = split_signal(signal)
            if part not in homes:
                if part in status["buses"]:
                    raise ControlError(f"{part} has no wires that can be recorded", "record values of devices on it")
                raise ControlError(f"the rig has no device or bus {part!r}", closest(part, list(homes)))
            places.setdefault(homes[part], []).append(number)
        return places

    def _taker(self, numbers: Sequence[int]) -> OnRows:
        def take(rows: Rows) -> None:
            self.lost += rows.lost
            self._on_rows(rows._replace(columns=tuple(numbers[column] for column in rows.columns)))

        return take

    def _look(self) -> None:
        complete_ns = min(stream.complete_ns for stream in self._streams)
        if complete_ns > self._complete_ns:
            self._complete_ns = complete_ns
            self._on_complete(complete_ns)


class Assembler:
    """Puts the batches of one recording in order, each once, and makes rows of them."""

    def __init__(
        self, process: str, tracks: Sequence[Sequence[int]], columns: Sequence[Column], on_rows: OnRows
    ) -> None:
        self._process, self._tracks, self._columns, self._on_rows = process, tracks, columns, on_rows
        self._waiting: dict[int, Batch] = {}
        self.next = 0
        """The number of the next batch to hand over."""
        self.complete_ns = 0
        self._rows_next = [0] * len(tracks)
        self._missed = [0] * len(tracks)
        self._unknown = 0
        self._numbers: dict[int, list[float]] = {}
        """The places of texts in `states` by what the process calls them, for columns where the two differ."""
        self._rests: dict[int, Part] = {}
        """The rests of whole numbers in the next rows, by track."""

    @property
    def gap(self) -> tuple[int, int] | None:
        """The numbers of the batches that are missing before those that wait: first, and end; None without a gap."""
        return (self.next, min(self._waiting)) if self._waiting else None

    def put(self, data: bytes) -> None:
        """Take a batch as it comes: early, late, or again.  Bytes that are no batch are dropped."""
        try:
            number = batch.number_of(data)
            if number < self.next or number in self._waiting:
                return
            if number > self.next and len(self._waiting) >= MOST_WAITING:
                return
            self._waiting[number] = batch.decode(data)
        except MalformedError as fault:
            log.debug("%s: %s", self._process, fault)
            return
        self._hand_over()

    def lose_until(self, number: int) -> None:
        """Go on with this batch, because those before it are not there any more."""
        self.next = max(self.next, number)
        for early in [early for early in self._waiting if early < self.next]:
            del self._waiting[early]
        self._hand_over()

    def restart(self, tracks: Sequence[Sequence[int]], columns: Sequence[Column], lost: int = LEAST_LOST) -> None:
        """Go on with another recording of the same columns, after the process was restarted or its rig went back.

        `lost` is the number of rows that count as lost between the two.
        """
        for number, column in enumerate(columns):
            self._learn(number, column.states)
        self._waiting.clear()
        self.next = 0
        self._tracks = tracks
        self._rows_next, self._missed = [0] * len(tracks), [0] * len(tracks)
        self._unknown = lost

    def _hand_over(self) -> None:
        while (due := self._waiting.pop(self.next, None)) is not None:
            self.next += 1
            for part in due.parts:
                self._take(part)
            self.complete_ns = max(self.complete_ns, due.until_ns)

    def _take(self, part: Part) -> None:
        if part.kind is Kind.TEXTS:
            self._take_texts(part)
            return
        if part.track >= len(self._tracks):
            return
        if part.kind is Kind.WHOLE:
            self._rests[part.track] = part
            return
        rests = self._rests.pop(part.track, None)
        exact = {} if rests is None else _exact(part, rests)
        columns = self._tracks[part.track]
        if part.kind is Kind.ROWS and len(part.values) != len(columns):
            return
        lost = max(part.first - self._rows_next[part.track], 0) + max(part.missed - self._missed[part.track], 0)
        lost += self._unknown if part.first == 0 else 0
        self._rows_next[part.track], self._missed[part.track] = part.first + len(part.times_ns), part.missed
        for place, column in enumerate(columns) if part.kind is Kind.ROWS else ():
            part.values[place] = self._translated(column, part.values[place])
        if part.kind is Kind.ROWS:
            self._on_rows(Rows(self._process, tuple(columns), part.first, lost, part.times_ns, part.values, exact))
            return
        if lost:  # it is not known of which of the columns
            none = [array("d") for _ in columns]
            self._on_rows(Rows(self._process, tuple(columns), part.first, lost, array("q"), none))
        found: dict[int, tuple[array[int], array[float], dict[tuple[int, int], int]]] = {}
        for row, (time_ns, column, value) in enumerate(zip(part.times_ns, part.columns, part.values[0], strict=True)):
            if column not in found:
                found[column] = array("q"), array("d"), {}
            times_ns, values, whole = found[column]
            if (column, row) in exact:
                whole[0, len(values)] = exact[column, row]
            times_ns.append(time_ns)
            values.append(value)
        for column, (times_ns, values, whole) in found.items():
            if column < len(columns):
                shown = self._translated(columns[column], values)
                self._on_rows(Rows(self._process, (columns[column],), part.first, 0, times_ns, [shown], whole))

    def _take_texts(self, part: Part) -> None:
        try:
            texts = items(json.loads(part.text), str, MOST_TEXTS, "texts")
        except (ValueError, RecursionError) as fault:
            log.debug("%s: texts: %s", self._process, fault)
            return
        if part.track < len(self._columns):
            self._learn(part.track, texts)

    def _learn(self, column: int, texts: Sequence[str]) -> None:
        """Take the texts of a column, which may have other places in a process that was restarted."""
        states = self._columns[column].states
        if len(states) > MOST_STATES:
            return
        states += [text for text in dict.fromkeys(texts) if text not in states]
        self._numbers.pop(column, None)
        if list(texts) != states[: len(texts)]:
            self._numbers[column] = [float(states.index(text)) for text in texts]

    def _translated(self, column: int, values: "array[float]") -> "array[float]":
        numbers = self._numbers.get(column)
        if numbers is None:
            return values
        return array("d", (numbers[int(value)] if 0 <= value < len(numbers) else NAN for value in values))


def _exact(part: Part, rests: Part) -> dict[tuple[int, int], int]:
    """Return the whole numbers of a part of ROWS or EVENTS, by column and place of the row."""
    found: dict[tuple[int, int], int] = {}
    for number, column, rest in zip(rests.times_ns, rests.columns, rests.values[0], strict=True):
        row, place = number - part.first, column if part.kind is Kind.ROWS else 0
        if 0 <= row < len(part.times_ns) and place < len(part.values):
            value = part.values[place][row]
            if isfinite(value) and isfinite(rest):
                found[column, row] = int(value) + int(rest)
    return found


class _Stream:
    """The part of a recording that one process has."""

    def __init__(
        self,
        control: Ears,
        process: str,
        owner: str,
        signals: list[str],
        rhythm: Rhythm,
        on_rows: OnRows,
        on_complete: Callable[[], None],
    ) -> None:
        self._control, self._process, self._owner, self._on_rows = control, process, owner, on_rows
        self._signals, self._rhythm, self._on_complete = signals, rhythm, on_complete
        self._path = f"process/{process}/record"
        self._runs = 0
        self._id = ""
        self._stop_listening: Callable[[], None] = lambda: None
        self._task: asyncio.Task[None] | None = None
        self._wake = asyncio.Event()
        self._early: list[bytes] = []
        """Batches that came before the answer that tells what is in them."""
        self._assembler: Assembler | None = None
        self._acknowledged = self._promised = 0
        self.columns: list[Column] = []
        self.epoch_ns = self.begin_ns = 0

    @property
    def complete_ns(self) -> int:
        return self._assembler.complete_ns if self._assembler is not None else 0

    async def begin(self) -> None:
        """Begin, or begin again after the process was restarted."""
        self._stop_listening()
        self._runs += 1
        self._id = f"{self._owner}-{self._runs}"
        self._acknowledged = self._promised = 0
        self._early, is_first = [], not self.columns
        self._stop_listening = self._control.listen_to_bytes(f"record/{self._process}/{self._id}", self._on_batch)
        wish = {"id": self._id, "owner": self._owner, "signals": self._signals, "rhythm": self._rhythm}
        answer = await self._control.ask(self._path, {"command": "begin", **wish}, PATIENCE_S)
        tracks = [items(track, int, len(self._signals)) for track in field(answer, "tracks", list)]
        columns = [column_of(column) for column in field(answer, "columns", list)]
        self.epoch_ns, self.begin_ns = field(answer, "epoch_ns", int), field(answer, "now_ns", int)
        if is_first:
            self.columns = columns
            self._assembler = Assembler(self._process, tracks, self.columns, self._on_rows)
        else:
            assert self._assembler is not None
            is_all_there = answer.get("back_ns") == self.begin_ns <= self._assembler.complete_ns
            self._assembler.restart(tracks, columns, LEAST_LOST if not is_all_there else 0)

    def start(self) -> None:
        """Hand over rows from now on."""
        self._task = asyncio.get_running_loop().create_task(self._work())
        self._take_early()

    async def end(self) -> None:
        if self._task is not None:
            self._task.cancel()
            with suppress(asyncio.CancelledError):
                await self._task
            with suppress(ControlError, MalformedError):
                state = await self._control.ask(self._path, {"command": "stop", "id": self._id}, END_S)
                await self._fill(field(state, "next", int))
        with suppress(ControlError):
            await self._control.ask(self._path, {"command": "end", "id": self._id}, END_S)
        self._stop_listening()

    def _on_batch(self, _: str, data: bytes) -> None:
        assembler = self._assembler
        if assembler is None or self._task is None:
            self._early.append(data)
            return
        assembler.put(data)
        self._on_complete()
        if assembler.gap is not None or assembler.next - self._acknowledged >= EVERY:
            self._wake.set()

    def _take_early(self) -> None:
        early, self._early = self._early, []
        for data in early:
            self._on_batch("", data)

    async def _work(self) -> None:
        """Acknowledge, and fill gaps, for as long as the recording runs."""
        while True:
            self._wake.clear()
            with suppress(TimeoutError):
                async with asyncio.timeout(ACKNOWLEDGE_S):
                    await self._wake.wait()
            try:
                await self._catch_up()
            except (ControlError, MalformedError) as cause:
                log.debug("%s: %s", self._process, cause)
                await asyncio.sleep(ACKNOWLEDGE_S)

    async def _catch_up(self) -> None:
        """Acknowledge what is there, and ask for what the process has and we have not."""
        assembler = self._assembler
        assert assembler is not None
        self._acknowledged = number = assembler.next
        message = {"command": "acknowledge", "id": self._id, "number": number}
        try:
            state = await self._control.ask(self._path, message, PATIENCE_S)
        except ControlError as cause:
            if NO_RECORDING not in cause.what:
                raise
            await self.begin()
            self._take_early()
            return
        # A batch that was published just now is still on its way; one of the last time is lost.
        promised, self._promised = self._promised, field(state, "next", int)
        await self._fill(max(promised, assembler.gap[1]) if assembler.gap is not None else promised)

    async def _fill(self, end: int) -> None:
        """Ask for the batches before `end` until they are there, or the process does not have them any more."""
        assembler = self._assembler
        assert assembler is not None
        while assembler.next < end:
            first = assembler.next
            gap_end = min(end, assembler.gap[1]) if assembler.gap is not None else end
            wish = {"command": "again", "id": self._id, "first": first, "end": gap_end}
            found = batch.unbundle(await self._control.ask_bytes(self._path, wish, PATIENCE_S))
            for data in found:
                assembler.put(data)
            if assembler.next == first:
                later = [number for number in map(batch.number_of, found) if number > first]
                assembler.lose_until(min(later, default=gap_end))
            self._on_complete()
