"""The recordings behind all scopes of a page's process: each signal is recorded once, however many pages draw it.

A signal is recorded for as long as someone uses it and `LINGER_S` longer, so that a page that is loaded again finds its
past.  Names that a rig does not have are said beside the signal, and take nothing from the others.
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Hashable, Iterable, Sequence
from typing import Any, Final, Protocol

from fieldrig.errors import RigError
from fieldrig_page.scope.setup import Rhythm
from fieldrig_page.scope.store import Track

log = logging.getLogger(__name__)

LINGER_S: Final = 20.0
MOST_READERS: Final = 6
"""Readers of one rhythm, after which one takes over from all of them; a process has room for 16 recordings."""


class ReaderLike(Protocol):
    """`fieldrig.recording.reader.Reader`."""

    def begin(self) -> Awaitable[Sequence[Any]]: ...
    def end(self) -> Awaitable[None]: ...


MakeReader = Callable[[Sequence[str], Any, Callable[[Any], None], Callable[[int], None]], ReaderLike]
"""Makes a reader for signals and a rhythm.  It calls with rows, and with the instant up to which it has all of them."""
OnRows = Callable[[Track, int], None]
"""Called after rows were taken into a track, with the number of the first one."""
OnProgress = Callable[[], None]
"""Called when more is known, with or without rows."""


class Signal:
    """A signal that is recorded: what it is, and where its samples are."""

    def __init__(self, name: str, rhythm: Rhythm) -> None:
        self.name, self.rhythm = name, rhythm
        self.is_held = False
        """True if there is a sample for each change."""
        self.kind, self.unit = "", ""
        self.states: Sequence[str] = ()
        self.is_open = False
        """True if it may have texts that are not among `states` yet."""
        self.trouble: RigError | None = None
        """Why it cannot be recorded."""
        self.track: Track | None = None
        self.column = 0
        self.users: set[Hashable] = set()

    @property
    def holds(self) -> bool:
        """True if a value holds until the next one, as of a wire or a state, and is drawn so."""
        return self.is_held or self.kind in ("truth", "text")


class _Recording:
    """One reader, with its signals and their tracks: one for all signals that are sampled together."""

    def __init__(self, signals: Sequence[Signal], rhythm: Rhythm, on_rows: OnRows, on_progress: OnProgress) -> None:
        self.signals = signals
        self.reader: ReaderLike | None = None
        self._tracks: dict[tuple[int, ...], Track] = {}
        self._rhythm, self._on_rows, self._on_progress = rhythm, on_rows, on_progress

    def take(self, rows: Any) -> None:
        if not rows.times_ns:  # changes of one of these are lost, and it is unknown of which
            for columns, track in self._tracks.items():
                if not set(columns).isdisjoint(rows.columns):
                    track.lose(rows.lost)
            return
        track = self._tracks.get(rows.columns) or self._track(rows.columns)
        self._on_rows(track, track.add(rows))

    def reach(self, until_ns: int) -> None:
        for track in self._tracks.values():
            track.reach(until_ns)
        self._on_progress()

    def _track(self, columns: tuple[int, ...]) -> Track:
        track = Track(len(columns), self._rhythm if isinstance(self._rhythm, int) else None)
        self._tracks[columns] = track
        for column, index in enumerate(columns):
            self.signals[index].track, self.signals[index].column = track, column
        return track


class Recordings:
    """Call it in the thread of the event loop."""

    def __init__(self, make_reader: MakeReader) -> None:
        self._make_reader = make_reader
        self._signals: dict[tuple[str, Rhythm], Signal] = {}
        self._recordings: list[_Recording] = []
        self._tasks: set[asyncio.Task[None]] = set()
        self.on_rows: list[OnRows] = []
        self.on_progress: list[OnProgress] = []

    def want(self, user: Hashable, names: Sequence[str], rhythm: Rhythm) -> dict[str, Signal]:
        """Record these signals for a user from now on, and no others, and return them by name."""
        missing = [name for name in names if (name, rhythm) not in self._signals]
        for name in missing:
            self._signals[name, rhythm] = Signal(name, rhythm)
        wanted = {name: self._signals[name, rhythm] for name in names}
        self._leave(user, wanted.values())
        for signal in wanted.values():
            signal.users.add(user)
        if missing:
            self._start(self._begin([wanted[name] for name in missing], rhythm))
        return wanted

    def forget(self, user: Hashable) -> None:
        """End what only this user records, after a while."""
        self._leave(user, ())

    async def close(self) -> None:
        for task in tuple(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        for recording in self._recordings:
            await _end(recording)

    def _leave(self, user: Hashable, kept: Iterable[Signal]) -> None:
        left = [signal for signal in self._signals.values() if user in signal.users]
        for signal in left:
            signal.users.discard(user)
        if any(signal not in set(kept) for signal in left):
            asyncio.get_running_loop().call_later(LINGER_S, self._sweep)

    def _sweep(self) -> None:
        """End recordings without a user, and forget signals that could not be recorded, to try them again."""
        for recording in [each for each in self._recordings if not any(signal.users for signal in each.signals)]:
            self._recordings.remove(recording)
            self._drop(recording.signals)
            self._start(_end(recording))
        self._drop([signal for signal in self._signals.values() if signal.trouble is not None and not signal.users])

    def _drop(self, signals: Iterable[Signal]) -> None:
        for signal in list(signals):
            self._signals.pop((signal.name, signal.rhythm), None)

    def _start(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _begin(self, signals: Sequence[Signal], rhythm: Rhythm) -> None:
        if len(self._recordings) >= MOST_READERS:
            self._sweep()  # a page that often changes its set-up must not take the room of others
        recording = _Recording(signals, rhythm, self._hear, self._progress)
        names = [signal.name for signal in signals]
        reader = recording.reader = self._make_reader(names, rhythm, recording.take, recording.reach)
        try:
            columns = await reader.begin()
        except RigError as trouble:
            await self._begin_others(signals, rhythm, trouble)
            return
        for signal, column in zip(signals, columns, strict=True):
            signal.kind, signal.unit, signal.states = str(column.kind), column.unit, column.states
            signal.is_held, signal.is_open = column.is_held, column.is_open
        self._recordings.append(recording)
        alike = [each for each in self._recordings if each.signals[0].rhythm == rhythm]
        if len(alike) > MOST_READERS:
            await self._gather(alike, rhythm)

    async def _begin_others(self, signals: Sequence[Signal], rhythm: Rhythm, trouble: RigError) -> None:
        """One name that is wrong must not take the others with it: try both halves."""
        if len(signals) == 1:
            signals[0].trouble = trouble
            return
        middle = len(signals) // 2
        await self._begin(signals[:middle], rhythm)
        await self._begin(signals[middle:], rhythm)

    async def _gather(self, recordings: Sequence[_Recording], rhythm: Rhythm) -> None:
        """Let one reader have all signals of these; their past goes, as they are sampled together from now on."""
        for recording in recordings:
            self._recordings.remove(recording)
            await _end(recording)
        await self._begin([signal for recording in recordings for signal in recording.signals if signal.users], rhythm)

    def _hear(self, track: Track, first: int) -> None:
        for on_rows in tuple(self.on_rows):
            on_rows(track, first)

    def _progress(self) -> None:
        for on_progress in tuple(self.on_progress):
            on_progress()


async def _end(recording: _Recording) -> None:
    if recording.reader is not None:
        try:
            await recording.reader.end()
        except RigError as trouble:  # its process has gone, and the recording with it
            log.debug("a recording ends: %s", trouble)
