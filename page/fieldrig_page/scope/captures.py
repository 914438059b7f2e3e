"""Pictures that stand still: a copy of the samples around a trigger, or of all that there are when a scope stops."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import count
from typing import Final, NamedTuple

from fieldrig.errors import ControlError
from fieldrig_page.scope.recordings import Signal
from fieldrig_page.scope.setup import Setup
from fieldrig_page.scope.store import Track, by_track
from fieldrig_page.scope.triggers import Hit

MOST: Final = 64
LARGEST: Final = 192 << 20
"""Number and bytes of all captures that are kept; the oldest go first, the newest never."""


class Trace(NamedTuple):
    """A signal with its samples."""

    name: str
    kind: str
    unit: str
    states: Sequence[str]
    holds: bool
    track: Track
    column: int
    is_open: bool = False


class Capture(NamedTuple):
    """A picture that stands still."""

    number: int
    """Its number for pages and for the HTTP API; 1 is the first one."""
    setup: Setup
    first_ns: int
    end_ns: int
    hit: Hit | None
    """The trigger; None if the scope was stopped by hand."""
    traces: Mapping[str, Trace]

    @property
    def lost(self) -> int:
        """Samples that are missing in it."""
        return sum(track.lost for track in self._tracks)

    @property
    def size(self) -> int:
        return sum(track.size for track in self._tracks)

    @property
    def _tracks(self) -> list[Track]:
        return [track for track, _ in by_track((trace.track, trace) for trace in self.traces.values())]


class Captures:
    """The captures of all scopes, by number."""

    def __init__(self) -> None:
        self._kept: dict[int, Capture] = {}
        self._numbers = count(1)
        self._size = 0

    def add(self, setup: Setup, first_ns: int, end_ns: int, hit: Hit | None, traces: Mapping[str, Trace]) -> Capture:
        ordered = {name: traces[name] for name in setup.all_signals if name in traces}
        capture = Capture(next(self._numbers), setup, first_ns, end_ns, hit, ordered)
        self._kept[capture.number] = capture
        self._size += capture.size
        while len(self._kept) > MOST or (len(self._kept) > 1 and self._size > LARGEST):
            self._size -= self._kept.pop(min(self._kept)).size
        return capture

    def get(self, number: int) -> Capture | None:
        return self._kept.get(number)

    def __getitem__(self, number: int) -> Capture:
        """ControlError if there is none, or none any more."""
        capture = self.get(number)
        if capture is None:
            there = ", ".join(map(str, self._kept)) or "none"
            raise ControlError(f"there is no capture {number}", f"captures that are kept: {there}")
        return capture

    def all(self) -> list[Capture]:
        return list(self._kept.values())


def cut(signals: Iterable[Signal], first_ns: int, end_ns: int) -> dict[str, Trace]:
    """Copy the samples of a time; signals without any yet are left out."""
    found: dict[str, Trace] = {}
    for track, together in by_track((signal.track, signal) for signal in signals):
        part = track.cut([signal.column for signal in together], first_ns, end_ns)
        for column, signal in enumerate(together):
            found[signal.name] = Trace(
                signal.name, signal.kind, signal.unit, signal.states, signal.holds, part, column, signal.is_open
            )
    return found
