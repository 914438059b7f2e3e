"""The recordings of one process: `process/NAME/record`, and batches on `record/NAME/ID`.

A question is an object with a `command`:

    begin        id, owner, signals, rhythm ("cycle", "change", or a period in ns) -> columns, tracks, epoch_ns, now_ns
    again        id, first, end: the batches with these numbers, as a bundle of bytes; one that is not kept is missing
    acknowledge  id, number: the reader has all batches before this one -> next, oldest
    stop         id: nothing is sampled any more, and all that was is published -> next
    end          id

The owner of a recording shows its life at `recorder/OWNER`; all of its recordings end with it.  On a busy host an owner
that lives may be reported to be gone: it begins them again, and has them for as long as it acknowledges.  Several
recordings run beside each other.  Batches are published with a low priority, and dropped rather than waited for: with a
publisher that waits, a reader that stood still held the loop of a device for 1.3 s.
"""

import asyncio
import logging
import re
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from math import inf
from typing import Any, Final, NamedTuple, Protocol

from fieldrig.clock import S
from fieldrig.control.question_words import asked
from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError, field, items, shown
from fieldrig.recording.signals import NO_RECORDING, OWN_PERIOD_NS, Column, Rhythm, rhythm_of

log = logging.getLogger(__name__)

MOST_SETS: Final = 16
MOST_SIGNALS: Final = 1_000
MOST_VALUES_PER_S: Final = 2_000_000
"""Values that one process samples in a second by a period or in cycles; at 0.16 us each, a third of a core."""
SHORTEST_NS: Final = 100_000
LONGEST_NS: Final = 3_600 * S
LONGEST_NAME: Final = 500
FLUSH_S: Final = 0.033
"""Time between two batches, unless one is full before."""
LATEST_S: Final = 0.05
"""Time after which a batch is made without waiting for the end of a cycle.  At any other time it delays a cycle: 40
parts and their publication take 0.3 ms."""
OWNER_S: Final = 10.0
"""How long a recording waits for the first sign of life of its owner, or for another acknowledgement without one."""
WAIT_S: Final = 0.1
_IDENTIFIER: Final = re.compile(r"[a-z0-9][a-z0-9-]{0,47}")


class Outlet(Protocol):
    """A publisher of bytes."""

    def put(self, data: bytes) -> None: ...

    def end(self) -> None: ...


class Line(Protocol):
    """The control messages of the process, as far as recordings need them."""

    def serve(self, path: str, answer: Callable[[str, Any], Any]) -> None: ...

    def outlet(self, path: str) -> Outlet: ...

    def watch_life(self, path: str, handler: Callable[[str, bool], None]) -> None: ...


class Recorded(Protocol):
    """One recording, as `RecordSet` is."""

    @property
    def columns(self) -> Sequence[Column]: ...

    @property
    def tracks(self) -> Sequence[Sequence[int]]: ...

    @property
    def next(self) -> int: ...

    @property
    def oldest(self) -> int: ...

    @property
    def is_behind(self) -> bool: ...

    def again(self, first: int, end: int) -> bytes: ...

    def acknowledge(self, number: int) -> None: ...

    def flush(self) -> None: ...

    def end(self) -> None: ...

    def close(self) -> None: ...


Make = Callable[[Sequence[str], Rhythm, Callable[[bytes], None]], Recorded]
"""Begins to record signals; the batches go to the last argument.  ControlError for a signal that does not exist."""


class Times(Protocol):
    """The clock of a source, and when it has time."""

    on_rows: Callable[[], None]

    def now_ns(self) -> int: ...


class _Recording(NamedTuple):
    owner: str
    record_set: Recorded
    outlet: Outlet
    values_per_s: float


class Recorders:
    """All recordings of one process."""

    def __init__(
        self, line: Line, process: str, times: Times, make: Make, *, epoch_ns: int = 0, is_lossless: bool = False
    ) -> None:
        """Add `epoch_ns` to the instants for the time of day; it is 0 in virtual time."""
        self._line, self._process, self._times, self._make = line, process, times, make
        self._epoch_ns, self._is_lossless = epoch_ns, is_lossless
        self._recordings: dict[str, _Recording] = {}
        self._is_closed = False
        self._back_ns: int | None = None
        """The instant to which a rig in virtual time last went back."""
        self._alive: set[str] | None = None
        """The owners that show their life; None before the first recording."""
        self._heard_s: dict[str, float] = {}
        """When each owner has acknowledged last, whether it shows its life or not."""
        self._flusher: asyncio.Task[None] | None = None
        self._flushed_s = 0.0
        self._room = asyncio.Event()
        times.on_rows = self._flush_if_due
        line.serve(f"process/{process}/record", self.answer)

    async def answer(self, _verb: str, message: Any) -> Any:
        command = field(message, "command", str)
        if command == "begin" and self._is_closed:
            raise ControlError(f"{self._process} is stopping", "begin again when the rig is back")
        if command == "begin":
            return self._begin(message)
        name = field(message, "id", str)
        if command not in ("again", "acknowledge", "stop", "end"):
            raise ControlError(
                f"a recording cannot {asked(command, None)}", "it can: begin, again, acknowledge, stop, end"
            )
        recording = self._recordings.get(name)
        if recording is None:
            raise ControlError(f"{self._process} {NO_RECORDING} {shown(name)}", "begin it again")
        record_set = recording.record_set
        if command == "again":
            return record_set.again(field(message, "first", int), field(message, "end", int))
        if command == "acknowledge":
            record_set.acknowledge(field(message, "number", int))
            self._heard_s[recording.owner] = asyncio.get_running_loop().time()
            self._room.set()
            return {"next": record_set.next, "oldest": record_set.oldest}
        if command == "stop":
            record_set.end()
            record_set.flush()
            return {"next": record_set.next}
        self._end(name)
        return {}

    def _begin(self, message: Any) -> dict[str, Any]:
        name, owner = _identifier(message, "id"), _identifier(message, "owner")
        signals = items(field(message, "signals", list), str, MOST_SIGNALS, "signals")
        if not signals or any(len(signal) > LONGEST_NAME for signal in signals):
            raise MalformedError(f"signals: expected 1 to {MOST_SIGNALS} names of at most {LONGEST_NAME} characters")
        rhythm = rhythm_of(message.get("rhythm"), SHORTEST_NS, LONGEST_NS)
        self._end(name)
        values_per_s = self._check_room(signals, rhythm)
        outlet = self._line.outlet(f"record/{self._process}/{name}")
        try:
            record_set = self._make(signals, rhythm, outlet.put)
        except BaseException:
            outlet.end()
            raise
        self._recordings[name] = _Recording(owner, record_set, outlet, values_per_s)
        self._watch_over(owner)
        return {
            "columns": [column._asdict() for column in record_set.columns],
            "tracks": record_set.tracks,
            "epoch_ns": self._epoch_ns,
            "now_ns": self._times.now_ns(),
            "back_ns": self._back_ns,
        }

    def _check_room(self, signals: Sequence[str], rhythm: Rhythm) -> float:
        """Return the values per second of a new recording.  ControlError if they are too many."""
        if len(self._recordings) >= MOST_SETS:
            raise ControlError(f"{self._process} has {MOST_SETS} recordings already", "end one of them")
        values_per_s = len(signals) * S / (rhythm if isinstance(rhythm, int) else OWN_PERIOD_NS)
        present = sum(recording.values_per_s for recording in self._recordings.values())
        if not self._is_lossless and present + values_per_s > MOST_VALUES_PER_S:
            raise ControlError(
                f"{len(signals)} signals are too many values in a second for {self._process}",
                f"record fewer, or with a longer period; it samples {MOST_VALUES_PER_S:,} values in a second",
            )
        return values_per_s

    def _watch_over(self, owner: str) -> None:
        """Flush while there are recordings, and end those whose owner is gone."""
        loop = asyncio.get_running_loop()
        if self._alive is None:
            self._alive = set()
            self._line.watch_life("recorder/*", self._on_life)
        if self._flusher is None or self._flusher.done():
            self._flusher = loop.create_task(self._flush_on())
        loop.call_later(OWNER_S, self._check_owner, owner)

    def _check_owner(self, owner: str) -> None:
        """End the recordings of an owner without a sign of life, or look again later if it is heard all the same."""
        if self._alive is None or owner in self._alive:
            return
        loop = asyncio.get_running_loop()
        if loop.time() - self._heard_s.get(owner, -inf) < OWNER_S:
            loop.call_later(OWNER_S, self._check_owner, owner)
        else:
            self._end_of(owner)

    def _on_life(self, owner: str, is_alive: bool) -> None:
        assert self._alive is not None
        if is_alive:
            self._alive.add(owner)
        else:
            self._alive.discard(owner)
            self._end_of(owner)

    def _end_of(self, owner: str) -> None:
        self._heard_s.pop(owner, None)
        for name in [name for name, recording in self._recordings.items() if recording.owner == owner]:
            log.info("the recording %s ends, because its reader is gone", name)
            self._end(name)

    def _end(self, name: str) -> None:
        recording = self._recordings.pop(name, None)
        if recording is not None:
            recording.record_set.close()
            recording.outlet.end()
            self._room.set()

    def close(self) -> None:
        """End all recordings, and begin no other; what they have is published."""
        self._is_closed = True
        self.flush()
        for name in tuple(self._recordings):
            self._end(name)
        if self._flusher is not None:
            self._flusher.cancel()

    def forget(self) -> None:
        """End all recordings in a rig that went back: their readers begin them again."""
        self._back_ns = self._times.now_ns()
        for name in tuple(self._recordings):
            self._end(name)

    def _flush_if_due(self) -> None:
        """Flush right after the rows of a cycle, as the process has time until the next one."""
        if time.monotonic() - self._flushed_s >= FLUSH_S:
            self.flush()

    def flush(self) -> None:
        self._flushed_s = time.monotonic()
        for recording in self._recordings.values():
            recording.record_set.flush()

    async def _flush_on(self) -> None:
        while self._recordings:
            await asyncio.sleep(FLUSH_S)
            if time.monotonic() - self._flushed_s >= LATEST_S:
                self.flush()

    @property
    def is_behind(self) -> bool:
        """True while a rig in virtual time has to wait for a reader."""
        return bool(self._recordings) and any(recording.record_set.is_behind for recording in self._recordings.values())

    async def until_room(self) -> None:
        """Wait until no reader is behind."""
        while self.is_behind:
            self._room.clear()
            with suppress(TimeoutError):
                async with asyncio.timeout(WAIT_S):
                    await self._room.wait()


def _identifier(message: Any, key: str) -> str:
    name = field(message, key, str)
    if _IDENTIFIER.fullmatch(name) is None:
        raise MalformedError(f"{key}: expected up to 48 small letters, digits and hyphens, found {shown(name)}")
    return name
