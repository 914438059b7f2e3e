"""The scope of one page: what it draws, its trigger, and which part of that the page has already.

run      the newest window rolls
auto     as normal, but without a trigger for some windows it rolls
normal   each trigger is drawn, and stays until the next one
single   the first trigger is drawn, and the scope stops
stopped  by hand: all that is recorded, to look around in
"""

from collections.abc import Callable, Hashable, Mapping
from typing import Any, Final, NamedTuple

from fieldrig.errors import RigError
from fieldrig.outside.untrusted import MalformedError, field, shown, typed
from fieldrig_page.scope import drawing
from fieldrig_page.scope.captures import Capture, Captures, Trace, cut
from fieldrig_page.scope.drawing import Drawn, Rows
from fieldrig_page.scope.hunt import Hunt
from fieldrig_page.scope.recordings import Recordings, Signal
from fieldrig_page.scope.setup import Setup, read_setup
from fieldrig_page.scope.store import Track, by_track
from fieldrig_page.scope.triggers import Hit, Trigger

PIXELS: Final = (16, 4096)
AUTO_WINDOWS: Final = 2
"""Windows without a trigger after which `auto` rolls."""
LONGEST_NS: Final = 1 << 62


class Wish(NamedTuple):
    """The view that a page asks for, checked."""

    setup: Setup
    pixels: int
    arm: int = 0
    """Each other number arms the trigger again."""
    is_stopped: bool = False
    capture: int | None = None
    """The capture that it shows, or None for the newest of its own."""
    view_ns: tuple[int, int] | None = None
    """Part of the capture that it shows, in nanoseconds from the origin of the page's instants."""
    cursors_ns: tuple[int, ...] = ()


def read_wish(data: Any) -> Wish:
    """Return what a page asks for.  MalformedError for anything that is none."""
    setup = read_setup(field(data, "setup", dict))
    view = [_instant(value) for value in _list(data, "view_ns", 2)]
    if view and (len(view) != 2 or view[0] >= view[1]):
        raise MalformedError("view_ns: expected two instants, the first one before the second")
    capture = data.get("capture")
    return Wish(
        setup,
        min(max(_whole(field(data, "pixels", float)), PIXELS[0]), PIXELS[1]),
        _whole(typed(data.get("arm", 0), float, "arm")),
        typed(data.get("is_stopped", False), bool, "is_stopped"),
        None if capture is None else _whole(typed(capture, float, "capture")),
        (view[0], view[1]) if view else None,
        tuple(_instant(value) for value in _list(data, "cursors_ns", 2)),
    )


def _list(data: Any, key: str, most: int) -> list[Any]:
    found = typed(data.get(key) or [], list, key)
    if len(found) > most:
        raise MalformedError(f"{key}: expected at most {most} values")
    return found


def _instant(value: Any) -> int:
    return _whole(typed(value, float, "instant"))


def _whole(number: float) -> int:
    if not abs(number) < LONGEST_NS:  # also NaN
        raise MalformedError(f"expected a number below 2**62, found {shown(number)}")
    return round(number)


class Session:
    """Call everything in the thread of the event loop."""

    def __init__(
        self,
        recordings: Recordings,
        captures: Captures,
        origin_ns: int,
        now_s: Callable[[], float],
        user: Hashable,
    ) -> None:
        """`origin_ns` is instant 0 of the page; `now_s` is the time of the host, for processes that fall silent."""
        self._recordings, self._captures, self._origin_ns, self._now_s = recordings, captures, origin_ns, now_s
        self._user = user
        self._wish: Wish | None = None
        self._signals: Mapping[str, Signal] = {}
        self._hunt: Hunt | None = None
        self._caught: Capture | None = None
        """The newest capture of this scope."""
        self._stopped: Capture | None = None
        self._trouble: RigError | None = None
        self.hits = 0
        self.messages_lost = 0
        """Messages of a bus that did not get here, so that a trigger by a message may have missed one."""
        self._is_whole = True
        self._sent: dict[int, int] = {}
        """The bucket after the last one that the page has, by the identity of the track."""
        self._noted: dict[int, int] = {}
        """How many gaps of each track the page has."""
        self._shape: Any = None
        self._status: Any = None

    def want(self, wish: Wish) -> None:
        """Show this from now on, beginning with the whole of it."""
        before, self._wish, self._is_whole = self._wish, wish, True
        self._signals = self._recordings.want(self._user, wish.setup.all_signals, wish.setup.rhythm)
        if before is None or _hunted(before) != _hunted(wish):
            self._hunt, self._caught, self._trouble, self.hits = None, None, None, 0
            self._arm()
        if not wish.is_stopped:
            self._stopped = None

    def forget(self) -> None:
        self._recordings.forget(self._user)

    def on_rows(self, track: Track, first: int) -> None:
        """Look at new rows, from the one numbered `first` on, of a track that this scope may use."""
        if self._hunt is None:
            self._arm(track, first)
        if self._hunt is not None:
            self._hunt.look(self._now_s())

    def tick(self) -> None:
        """Look whether a picture is complete now."""
        if self._hunt is not None:
            self._hunt.look(self._now_s())

    def strike(self, hit: Hit) -> None:
        """Take a hit of a trigger that is no signal."""
        if self._hunt is not None:
            self._hunt.strike(hit, self._now_s())

    @property
    def trigger(self) -> Trigger | None:
        """The trigger that is waited for."""
        is_waiting = self._wish is not None and not self._wish.is_stopped and self._wish.setup.mode != "run"
        return self._wish.setup.trigger if self._wish is not None and is_waiting else None

    @property
    def caught(self) -> Capture | None:
        return self._caught

    @property
    def trouble(self) -> RigError | None:
        """Why the trigger cannot be armed, or a signal not be recorded."""
        wrong = [signal.trouble for signal in self._signals.values() if signal.trouble is not None]
        return self._trouble or (wrong[0] if wrong else None)

    def frame(self) -> dict[str, Any] | None:
        """Return what the page does not have yet; None if it has everything."""
        wish = self._wish
        if wish is None:
            return None
        self.tick()
        if wish.is_stopped and self._stopped is None:
            self._stopped = (self._captures.get(wish.capture) if wish.capture is not None else None) or self.stop()
        shown_capture = self._shown(wish)
        frame = self._live(wish) if shown_capture is None else self._still(wish, shown_capture)
        status = self._state(wish, shown_capture)
        if frame is None and status == self._status:
            return None
        self._status = status
        return {**(frame or {}), "status": status}

    def stop(self) -> Capture | None:
        """Copy everything that is recorded; None if nothing is yet."""
        wish, tracks = self._wish, self._tracks()
        if wish is None or not tracks:
            return None
        end_ns = max(track.known_ns for track in tracks)
        first_ns = min(track.times_ns[0] for track in tracks)
        traces = cut(self._signals.values(), first_ns, end_ns + 1)
        return self._captures.add(wish.setup, first_ns, end_ns, None, traces)

    def whole_window(self) -> Capture | None:
        """Copy the newest window, once everything is recorded for so long; None until then."""
        wish, tracks = self._wish, self._tracks()
        if wish is None or not tracks or any(signal.track is None for signal in self._signals.values()):
            return None
        end_ns = min(track.known_ns for track in tracks)
        first_ns = end_ns - wish.setup.window_ns
        if any(track.times_ns[0] > first_ns and not track.base for track in tracks):
            return None
        return self._captures.add(wish.setup, first_ns, end_ns, None, cut(self._signals.values(), first_ns, end_ns + 1))

    def _tracks(self) -> list[Track]:
        """The tracks of all signals that have samples."""
        found = by_track((signal.track, signal) for signal in self._signals.values())
        return [track for track, _ in found if track.times_ns]

    def _arm(self, track: Track | None = None, first: int = 0) -> None:
        """Begin the hunt, once the trigger's signal is known: with the new rows of a track, or with the next."""
        wish = self._wish
        if (
            wish is None
            or wish.is_stopped
            or wish.setup.trigger is None
            or wish.setup.mode == "run"
            or self._trouble is not None
        ):
            return
        signal = self._signals.get(wish.setup.trigger.signal)
        if wish.setup.trigger.signal and (signal is None or signal.track is None):
            return
        try:
            self._hunt = Hunt(wish.setup, self._signals, self._on_caught, {} if track is None else {id(track): first})
        except RigError as wrong:
            self._trouble = wrong

    def _on_caught(self, hit: Hit, first_ns: int, end_ns: int, traces: dict[str, Trace]) -> None:
        if self._wish is not None:
            self._caught = self._captures.add(self._wish.setup, first_ns, end_ns, hit, traces)
            self.hits += 1
            self._is_whole = True

    def _shown(self, wish: Wish) -> Capture | None:
        """The capture that is drawn; None for the newest samples."""
        if wish.is_stopped:
            return self._stopped
        if wish.setup.mode == "run" or self._caught is None:
            return None
        if wish.setup.mode == "auto" and not (self._hunt is not None and self._hunt.is_struck):
            newest_ns = max((track.known_ns for track in self._tracks()), default=0)
            if newest_ns - self._caught.end_ns > AUTO_WINDOWS * wish.setup.window_ns:
                return None
        return self._caught

    def _rows(self, drawn: Mapping[str, Drawn]) -> Rows:
        names = self._wish.setup.signals if self._wish is not None else ()
        return {row: drawn[name] for row, name in enumerate(names) if name in drawn}

    def _live(self, wish: Wish) -> dict[str, Any] | None:
        rows = self._rows(self._signals)
        tracks = [(track, numbers) for track, numbers in drawing.tracks_of(rows) if track.times_ns]
        bucket_ns = max(wish.setup.window_ns // wish.pixels, 1)
        count = -(-wish.setup.window_ns // bucket_ns)
        end = max((track.known_ns // bucket_ns for track, _ in tracks), default=0)
        news = [(id(track), track.epoch, tuple(numbers)) for track, numbers in tracks]
        facts = [(signal.kind, len(signal.states), signal.trouble is None) for signal in self._signals.values()]
        self._begin_whole(("live", news, facts))
        if any(self._sent.get(id(track), end) < end - count for track, _ in tracks):
            self._is_whole, self._sent = True, {}  # more is new than the page can show
        parts, has_gaps = [], False
        for track, numbers in tracks:
            known = track.known_ns // bucket_ns
            begin = self._sent.get(id(track), 0)
            if gaps := track.gaps_since(self._noted.get(id(track), 0)):
                begin = min(begin, gaps[0].first_ns // bucket_ns)  # what was no news then is a gap now
                self._noted[id(track)], has_gaps = track.noted, True
            begin = max(begin, end - count)
            if known > begin:
                data = drawing.part(rows, numbers, begin * bucket_ns, bucket_ns, known - begin)
                parts.append({**data, "first": begin - self._origin(bucket_ns)})
                self._sent[id(track)] = known
        return self._dressed(wish, rows, parts, bucket_ns, (end - count, count), has_gaps=has_gaps)

    def _still(self, wish: Wish, capture: Capture) -> dict[str, Any] | None:
        rows = self._rows(capture.traces)
        first_ns, end_ns = capture.first_ns, capture.end_ns
        if wish.view_ns is not None:
            first_ns, end_ns = (instant_ns + self._origin_ns for instant_ns in wish.view_ns)
        bucket_ns = max(-(-(end_ns - first_ns) // wish.pixels), 1)
        first, count = first_ns // bucket_ns, -(-end_ns // bucket_ns) - first_ns // bucket_ns
        self._begin_whole(("still", capture.number))
        if not self._is_whole:
            return None
        parts = [
            {
                **drawing.part(rows, numbers, first * bucket_ns, bucket_ns, count),
                "first": first - self._origin(bucket_ns),
            }
            for _, numbers in drawing.tracks_of(rows)
        ]
        return self._dressed(wish, rows, parts, bucket_ns, (first, count))

    def _begin_whole(self, shape: Any) -> None:
        if shape != self._shape:
            self._is_whole = True
        if self._is_whole:
            self._shape, self._sent, self._noted = shape, {}, {}

    def _origin(self, bucket_ns: int) -> int:
        """Number of the bucket that the page calls 0; numbers stay small there."""
        return self._origin_ns // bucket_ns

    def _dressed(
        self,
        wish: Wish,
        rows: Rows,
        parts: list[dict[str, Any]],
        bucket_ns: int,
        buckets: tuple[int, int],
        *,
        has_gaps: bool = True,
    ) -> dict[str, Any] | None:
        """Add everything else to the buckets of a frame."""
        if not parts and not self._is_whole:
            return None
        first, count = buckets
        first_ns, end_ns = first * bucket_ns, (first + count) * bucket_ns
        names = wish.setup.signals
        frame: dict[str, Any] = {
            "whole": self._is_whole,
            "first": first - self._origin(bucket_ns),
            "count": count,
            "bucket_ns": bucket_ns,
            "offset_ns": self._origin(bucket_ns) * bucket_ns - self._origin_ns,
            "parts": parts,
        }
        if wish.cursors_ns:
            instants = [instant_ns + self._origin_ns for instant_ns in wish.cursors_ns]
            frame["cursors"] = [drawing.at_cursor(rows, len(names), instant_ns) for instant_ns in instants]
        if wish.setup.xy is not None:
            across, up = (self._any(name, rows) for name in wish.setup.xy)
            frame["xy"] = None if across is None or up is None else drawing.xy(across, up, first_ns, end_ns)
        if has_gaps or self._is_whole:
            frame["gaps"] = drawing.gaps(rows, first_ns, end_ns, self._origin_ns)
        if self._is_whole:
            troubles = {row: str(self._signals[name].trouble or "") for row, name in enumerate(names)}
            frame["columns"] = drawing.columns(names, rows, troubles)
            frame["before"] = drawing.values_at(rows, len(names), first_ns - 1)
        self._is_whole = False
        return frame

    def _any(self, name: str, rows: Rows) -> Drawn | None:
        drawn = {each.name: each for each in rows.values()}
        shown_capture = self._shown(self._wish) if self._wish is not None else None
        of_capture = shown_capture.traces.get(name) if shown_capture is not None else self._signals.get(name)
        return drawn.get(name) or of_capture

    def _state(self, wish: Wish, capture: Capture | None) -> dict[str, Any]:
        rows = self._rows(self._signals if capture is None else capture.traces)
        lost, pauses, away_ns = ([0] * len(wish.setup.signals) for _ in range(3))
        for track, numbers in drawing.tracks_of(rows):
            for row in numbers:
                lost[row], pauses[row], away_ns[row] = track.lost, track.pauses, track.away_ns
        return {
            "state": self._word(wish, capture),
            "hits": self.hits,
            "messages_lost": self.messages_lost,
            "trouble": "" if self.trouble is None else str(self.trouble),
            "lost": lost,
            "pauses": pauses,
            "away_ns": away_ns,
            "capture": None if capture is None else self._about(capture),
        }

    def _word(self, wish: Wish, capture: Capture | None) -> str:
        if wish.is_stopped:
            return "stopped"
        if wish.setup.mode == "run":
            return "running"
        if self._hunt is not None and self._hunt.is_done:
            return "caught"
        if self._hunt is not None and self._hunt.is_struck:
            return "triggered"
        return "running" if capture is None and wish.setup.mode == "auto" else "armed"

    def _about(self, capture: Capture) -> dict[str, Any]:
        hit = capture.hit
        return {
            "number": capture.number,
            "first_ns": capture.first_ns - self._origin_ns,
            "end_ns": capture.end_ns - self._origin_ns,
            "lost": capture.lost,
            "trigger_ns": None if hit is None else hit.instant_ns - self._origin_ns,
            "after_ns": None if hit is None else hit.after_ns - self._origin_ns,
        }


def _hunted(wish: Wish) -> Any:
    """Return everything that arms a trigger again when it changes."""
    setup = wish.setup
    return (
        setup.trigger,
        setup.mode,
        setup.window_ns,
        setup.before,
        setup.rhythm,
        setup.all_signals,
        wish.arm,
        wish.is_stopped,
    )
