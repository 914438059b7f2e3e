"""A rig that a service works with, maybe from another process: it runs in slices, and keeps what listeners get.

Its calls take and give data only, so that they cross a pipe.  A branch of it has neither listeners nor recordings:
those of its rig are not its own.
"""

import os
import signal
import time
from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import Any, Final, NamedTuple

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS
from fieldrig.config.rig_file import RigConfig
from fieldrig.recording.record_set import RecordSet
from fieldrig.recording.signals import Column, Rhythm
from fieldrig.system.this_process import brief_facts, facts
from fieldrig.virtual.branch_process import Asked, repeat_one
from fieldrig.virtual.recorded import RigSource
from fieldrig.virtual.rig import Rig

LATEST_NS: Final = 10 * MS
"""How much later a device may notice that it is there."""
CALLS: Final = ("again", "acknowledge", "flush", "end")
"""The calls of a recording."""


class News(NamedTuple):
    """The messages and batches for listeners and recordings since the last news."""

    heard: Sequence[tuple[str, Delivery[Any]]]
    """Messages of the buses that are listened to; their receivers are left out."""
    batches: Sequence[tuple[str, bytes]]
    """Batches of recordings, by the name of the recording."""
    is_behind: bool
    """True while a reader of a recording has to read before the rig goes on."""


class Played(NamedTuple):
    """The end of a slice."""

    is_reached: bool
    next_ns: int | None
    """The instant at which something happens next."""
    news: News


class Begun(NamedTuple):
    """The beginning of a recording."""

    columns: Sequence[Column]
    tracks: Sequence[Sequence[int]]


class Recorded(NamedTuple):
    """The answer of a recording, with the numbers of its next batch and of the oldest that it keeps."""

    answer: Any
    next: int
    oldest: int


class ServedRig(Rig):
    def __init__(self, config: RigConfig) -> None:
        """RigError if a device cannot be built."""
        self._ears: frozenset[str] = frozenset()
        self._end_ears: Callable[[], None] | None = None
        self._heard: list[tuple[str, Delivery[Any]]] = []
        self._batches: list[tuple[str, bytes]] = []
        self._sets: dict[str, RecordSet] = {}
        super().__init__(config)

    @property
    def pid(self) -> int:
        """The process that has the rig."""
        return os.getpid()

    def outlive_signals(self) -> None:
        """Ignore the signals that end a group of processes: this one ends with its pipe, when all is in order."""
        for name in ("SIGTERM", "SIGHUP"):
            if hasattr(signal, name):
                signal.signal(getattr(signal, name), signal.SIG_IGN)

    def play(self, until_ns: int | None, for_s: float) -> Played:
        """Run for at most `for_s` of real time, and to `until_ns`, unless that is None.

        It ends early if a reader of a recording has enough to read, so that nothing is lost at full speed.
        """
        give_up_s = time.monotonic() + for_s
        while (next_ns := self.next_ns()) is not None and (until_ns is None or next_ns <= until_ns):
            self.step()
            if time.monotonic() > give_up_s or self._is_behind():
                return Played(False, self.next_ns(), self.news())
        if until_ns is not None:
            self.run_until(max(until_ns, self.now_ns))
        return Played(True, next_ns, self.news())

    def news(self) -> News:
        """Return what listeners and recordings have not got yet."""
        heard, self._heard = self._heard, []
        batches, self._batches = self._batches, []
        return News(heard, batches, self._is_behind())

    def hear(self, buses: Collection[str]) -> None:
        """Keep the messages of these buses for `news` from now on; without any, the rig keeps its shortcuts."""
        self._ears = frozenset(buses)
        if self._ears and self._end_ears is None:
            self._end_ears = self.on_delivery(self._hear)
        elif not self._ears and self._end_ears is not None:
            self._end_ears()
            self._end_ears = None

    def begin_recording(self, name: str, signals: Sequence[str], rhythm: Rhythm) -> Begun:
        """Record signals from now on; the batches are in the `news`.  ControlError for a signal that does not exist."""
        put = partial(self._put, name)
        made = self._sets[name] = RecordSet(RigSource(self), signals, rhythm, put, is_lossless=True)
        return Begun(made.columns, made.tracks)

    def of_recording(self, name: str, call: str, *arguments: Any) -> Recorded:
        """Make one of the `CALLS` of a recording."""
        assert call in CALLS
        made = self._sets[name]
        answer = getattr(made, call)(*arguments)
        return Recorded(answer, made.next, made.oldest)

    def forget_recording(self, name: str) -> None:
        """End a recording, and keep nothing of it."""
        made = self._sets.pop(name, None)
        if made is not None:
            made.end()

    def process_facts(self, *, is_brief: bool) -> dict[str, float | None]:
        """Return the facts of the process that has the rig, for `status`."""
        return brief_facts() if is_brief else facts()

    def repeat_until_there(self, asked: Sequence[Asked], until_ns: int, is_there: Callable[["ServedRig"], bool]) -> int:
        """Repeat what was asked up to `until_ns`; return how much it was.

        It is repeated only until `is_there(rig)` is true, because a program that stood at its goal already must not be
        asked to go on from there.  The rig goes on until it is: a device may notice later, by the time of its
        processor, what happened then.
        """
        done = 0
        for at_ns, has_run, call, arguments in asked:
            if at_ns > until_ns:
                break
            if has_run:
                self.run_until(at_ns)
            if is_there(self):
                return done
            repeat_one(self, call, arguments)
            done += 1
        self.run_until(max(until_ns, self.now_ns))
        while not is_there(self) and (next_ns := self.next_ns()) is not None and next_ns <= until_ns + LATEST_NS:
            self.step()
        return done

    def _become_branch(self, seed: int | None) -> None:
        super()._become_branch(seed)
        self.outlive_signals()
        for name in tuple(self._sets):
            self.forget_recording(name)
        self.hear(())
        self._heard, self._batches = [], []

    def _is_behind(self) -> bool:
        return any(made.is_behind for made in self._sets.values())

    def _hear(self, bus: Bus[Any], delivery: Delivery[Any]) -> None:
        if bus.name in self._ears:
            self._heard.append((bus.name, delivery._replace(receivers=())))

    def _put(self, name: str, data: bytes) -> None:
        self._batches.append((name, data))
