"""The hunt of one scope for its trigger: armed, hit, caught.

Every row of the trigger's signal is looked at once, in the order of the rows and not of the batches.  After a hit the
rows behind the trigger are awaited; each track gives its part as soon as it has come so far, before old rows go.  The
hunt for the next hit goes on from the first row behind the picture.
"""

from collections.abc import Callable, Mapping
from typing import Final

from fieldrig_page.scope.captures import Trace, cut
from fieldrig_page.scope.recordings import Signal
from fieldrig_page.scope.setup import Setup
from fieldrig_page.scope.store import Track, by_track
from fieldrig_page.scope.triggers import Hit, Range

PATIENCE_S: Final = 1.0
"""How long a picture waits for samples of other processes after those of the trigger have come."""

OnCaught = Callable[[Hit, int, int, dict[str, Trace]], None]
"""Called with a hit, the first and the last instant of its picture, and the samples."""


class _Picture:
    """A picture that is not complete yet."""

    def __init__(self, hit: Hit, setup: Setup, signals: Mapping[str, Signal], now_s: float) -> None:
        self.hit = hit
        self.first_ns = hit.instant_ns - setup.before_ns
        self.end_ns = self.first_ns + setup.window_ns
        self.until_s = now_s + PATIENCE_S
        self.traces: dict[str, Trace] = {}
        self._signals = signals

    def look(self, now_s: float, is_last: bool = False) -> bool:
        """Take what has come, and return whether nothing is missing any more."""
        is_missing = any(signal.track is None and signal.trouble is None for signal in self._left())
        for track, together in by_track((signal.track, signal) for signal in self._left()):
            if is_last or track.known_ns >= self.end_ns:
                self.traces |= cut(together, self.first_ns, self.end_ns + 1)
            else:
                is_missing = True
        return not is_missing

    @property
    def is_recorded(self) -> bool:
        """True if there is a reader of any of its signals."""
        return any(signal.track is not None for signal in self._signals.values())

    def is_waiting_for(self, track: Track) -> bool:
        return any(signal.track is track for signal in self._left())

    def _left(self) -> list[Signal]:
        """Return the signals that are not in the picture yet: a reader may begin to read after the hit."""
        return [signal for name, signal in self._signals.items() if name not in self.traces]


class Hunt:
    def __init__(
        self, setup: Setup, signals: Mapping[str, Signal], on_caught: OnCaught, begin: Mapping[int, int] | None = None
    ) -> None:
        """`begin` has numbers of the first row to look at, by the identity of the track; else it is the next one.

        ControlError if the trigger does not fit its signal.
        """
        self._setup, self._signals, self._on_caught = setup, signals, on_caught
        trigger = setup.trigger
        self._signal = signals.get(trigger.signal) if trigger is not None else None
        self._range: Range | None = None
        self._bind()
        self._picture: _Picture | None = None
        self._track = self._signal.track if self._signal is not None else None
        self._next = self._epoch = 0
        if self._track is not None:
            self._next, self._epoch = (begin or {}).get(id(self._track), self._track.end), self._track.epoch
        self.hits = 0
        self.is_done = False
        """True if it has caught the only one that it was armed for."""

    def _bind(self) -> None:
        """Take the range of values of the trigger, unless it is a text that its signal has not had yet."""
        trigger, signal = self._setup.trigger, self._signal
        if trigger is None or signal is None:
            return
        if not (trigger.kind == "state" and signal.is_open and trigger.what not in signal.states):
            self._range = trigger.range_of(signal.states)

    @property
    def is_struck(self) -> bool:
        """True while the rest of a picture is awaited."""
        return self._picture is not None

    def look(self, now_s: float) -> None:
        """Look at what is new, and wait no longer for processes that have fallen silent."""
        if self._picture is not None:
            self._finish(now_s)
        if self._track is not None:
            self._search(self._track, now_s)

    def strike(self, hit: Hit, now_s: float) -> None:
        """Take a hit that is no value of a signal: a message or a fault."""
        if self._picture is None and not self.is_done:
            self._begin(hit, now_s)

    def _search(self, track: Track, now_s: float) -> None:
        if track.epoch != self._epoch:
            self._epoch, self._next, self._picture = track.epoch, track.base, None
        if self._range is None:
            self._bind()
        if self._range is None or self._signal is None:
            return
        while self._picture is None and not self.is_done and self._next < track.end:
            hit = self._range.first(track, self._signal.column, self._next, track.end)
            if hit is None:
                self._next = track.end
                return
            self._next = hit.number + 1
            self._begin(hit, now_s)

    def _begin(self, hit: Hit, now_s: float) -> None:
        self.hits += 1
        self._picture = _Picture(hit, self._setup, self._signals, now_s)
        self._finish(now_s)

    def _finish(self, now_s: float) -> None:
        picture = self._picture
        if picture is None:
            return
        is_complete = picture.look(now_s)
        is_before_end = not picture.traces and picture.is_recorded
        if is_before_end or (self._track is not None and picture.is_waiting_for(self._track)):
            picture.until_s = now_s + PATIENCE_S  # the time behind the trigger is not over yet
        if not is_complete and now_s < picture.until_s:
            return
        picture.look(now_s, is_last=True)
        self._picture = None
        if self._track is not None:
            self._next = max(self._next, self._track.base + self._track.position(picture.end_ns))
        self.is_done = self._setup.mode == "single"
        self._on_caught(picture.hit, picture.first_ns, picture.end_ns, picture.traces)
