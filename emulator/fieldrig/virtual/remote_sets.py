"""The recordings of a rig that is served, as those see them who read: the rig takes the samples, in its own process."""

from collections.abc import Callable, Sequence
from typing import Any

from fieldrig.recording.signals import Column, Rhythm
from fieldrig.virtual.journey import Journey
from fieldrig.virtual.served import News

Publish = Callable[[bytes], None]


class RemoteSets:
    """All recordings of one rig (`recording.recorders.Times` and `Make`)."""

    def __init__(self, journey: Journey, take: Callable[[News], None]) -> None:
        """`take` gets the news of the rig, and calls `publish` with each batch in it."""
        self._journey, self._take = journey, take
        self._outlets: dict[str, Publish] = {}
        self._count = 0
        self.is_behind = False
        """True while a reader has to read before the rig goes on."""
        self.on_rows: Callable[[], None] = lambda: None
        """Never called: a rig in virtual time is in no hurry."""

    def now_ns(self) -> int:
        return self._journey.now_ns

    def begin(self, signals: Sequence[str], rhythm: Rhythm, publish: Publish) -> "RemoteSet":
        """Begin a recording.  ControlError for a signal that does not exist."""
        self._count += 1
        name = str(self._count)
        begun = self._journey.rig.begin_recording(name, signals, rhythm)
        self._outlets[name] = publish
        return RemoteSet(self, name, begun.columns, begun.tracks)

    def publish(self, name: str, data: bytes) -> None:
        """Publish a batch; one of a recording that has ended goes nowhere."""
        if name in self._outlets:
            self._outlets[name](data)

    def is_still_behind(self) -> bool:
        """Look again at a reader that was behind, as it may have been left behind meanwhile."""
        if self.is_behind:
            self._take(self._journey.rig.news())
        return self.is_behind

    def ask(self, name: str, call: str, *arguments: Any) -> Any:
        """Make a call of a recording, and publish what it has led to."""
        rig = self._journey.rig
        recorded = rig.of_recording(name, call, *arguments)
        self._take(rig.news())
        return recorded

    def forget(self, name: str) -> None:
        """Forget a recording, which a rig that has gone back does not have."""
        self._journey.rig.forget_recording(name)
        self._outlets.pop(name, None)


class RemoteSet:
    """One recording (`recording.recorders.Recorded`)."""

    def __init__(self, sets: RemoteSets, name: str, columns: Sequence[Column], tracks: Sequence[Sequence[int]]) -> None:
        self._sets, self._name, self.columns, self.tracks = sets, name, columns, tracks
        self.next = self.oldest = 0

    @property
    def is_behind(self) -> bool:
        return self._sets.is_still_behind()

    def again(self, first: int, end: int) -> bytes:
        return bytes(self._ask("again", first, end))

    def acknowledge(self, number: int) -> None:
        self._ask("acknowledge", number)

    def flush(self) -> None:
        self._ask("flush")

    def end(self) -> None:
        self._ask("end")

    def close(self) -> None:
        self._sets.forget(self._name)

    def _ask(self, call: str, *arguments: Any) -> Any:
        answer, self.next, self.oldest = self._sets.ask(self._name, call, *arguments)
        return answer
