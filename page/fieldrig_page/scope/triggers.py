"""Triggers of the scope: what makes a picture stand still, and at which instant.

A trigger on a signal runs over every row of its track, after lost batches were asked for again; nothing is polled, and
it does not matter how rows are divided into batches, because the row before the first new one is in the track.  Each
kind is a range of values that the signal enters or leaves:

    edge     rising: reaches the level from below; falling: falls below it; both
    level    is at or above the level, or below it, at the first row that is so
    state    enters the state of this name
    window   enters the range of both limits (which belong to it), or leaves it
    message  a message on a bus in which all of these words are, by its names or as it is on the bus
    fault    a fault begins or ends, of any part or of one

An edge that falls into a gap is not missed: the first row after the gap shows it.  Its instant is then known only to
lie in the gap, and the trigger says so.
"""

from array import array
from collections.abc import Mapping, Sequence
from math import inf, isfinite, nextafter
from typing import Any, Final, NamedTuple

from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError, field, shown, typed
from fieldrig.text.nearest import closest
from fieldrig_page.scope.store import Track

ENTERS, LEAVES, BOTH, IS = "enters", "leaves", "both", "is"

KINDS: Final = ("edge", "level", "state", "window", "message", "fault")
ON_SIGNALS: Final = ("edge", "level", "state", "window")
SLOPES: Final = {"rising": ENTERS, "falling": LEAVES, "both": BOTH}
MOST_WORDS: Final = 16
LONGEST_TEXT: Final = 1000


class Hit(NamedTuple):
    """An instant at which a trigger fired."""

    number: int
    """Number of the row that shows it."""
    instant_ns: int
    after_ns: int
    """The last instant at which it was not so, if a gap lies between; else the same as `instant_ns`."""


class Range(NamedTuple):
    """Values from `low` up to, but not with, `high`; and what a signal has to do with them."""

    low: float
    high: float
    change: str

    def first(self, track: Track, column: int, begin: int, end: int) -> Hit | None:
        """The first row of those numbered `begin` to `end` at which the trigger fires."""
        values = track.values[column]
        first, last = max(begin - track.base, 0), end - track.base
        part = values[first:last]
        before = _before(values, first)
        if before is None and self.change != IS:  # the first value ever is no change
            before = next((place for place in range(first, last) if values[place] == values[place]), None)
        if not part or (before is None and self.change != IS):
            return None
        was_in = before is not None and self.has(values[before])
        if self._cannot(part, was_in):
            return None
        return self._look(track, values, first, last, before, was_in)

    def has(self, value: float) -> bool:
        return self.low <= value < self.high

    def _cannot(self, part: "array[float]", was_in: bool) -> bool:
        """True if all values lie on the side where the signal was, by two calls instead of a look at each value."""
        low, high = min(part), max(part)
        if low != low:
            return False
        all_out = high < self.low or low >= self.high
        all_in = self.low <= low and high < self.high
        return (all_out and not was_in) or (all_in and was_in and self.change != IS)

    def _look(
        self, track: Track, values: "array[float]", first: int, last: int, before: int | None, was_in: bool
    ) -> Hit | None:
        low, high, change = self
        for place in range(first, last):
            value = values[place]
            if value != value:
                continue
            is_in = low <= value < high
            if (is_in and change == IS) or (
                is_in != was_in and (change == BOTH or is_in == (change == ENTERS)) and change != IS
            ):
                return self._hit(track, place, before)
            was_in, before = is_in, place
        return None

    def _hit(self, track: Track, place: int, before: int | None) -> Hit:
        instant_ns = track.times_ns[place]
        has_gap = before is not None and place - before > 1 and self.change != IS
        after_ns = track.times_ns[before] if has_gap and before is not None else instant_ns
        return Hit(track.base + place, instant_ns, after_ns)


def _before(values: "array[float]", place: int) -> int | None:
    """Place of the last value before, over gaps; None if there is none."""
    place -= 1
    while place >= 0 and values[place] != values[place]:
        place -= 1
    return place if place >= 0 else None


class Trigger(NamedTuple):
    """A trigger as a page or a file describes it, checked but not yet bound to a column."""

    kind: str
    signal: str = ""
    level: float = 0.0
    high: float = 0.0
    what: str = ""
    """The slope, the side, the name of the state, or begin and end."""
    part: str = ""
    """The bus of a message; the part of a fault, or "" for any."""
    words: tuple[str, ...] = ()

    def range_of(self, states: Sequence[str]) -> Range:
        """The range of a trigger on a signal that has these states.  ControlError for a state that it does not have."""
        match self.kind:
            case "edge":
                return Range(self.level, inf, SLOPES[self.what])
            case "level":
                return Range(self.level, inf, IS) if self.what == "above" else Range(-inf, self.level, IS)
            case "state":
                number = _state(self.what, states, self.signal)
                return Range(number, nextafter(number, inf), ENTERS)
        return Range(self.level, nextafter(self.high, inf), ENTERS if self.what == "inside" else LEAVES)

    def fits_message(self, bus: str, text: str) -> bool:
        return self.kind == "message" and bus == self.part and all(word.lower() in text for word in self.words)

    def fits_fault(self, part: str, is_over: bool) -> bool:
        return self.kind == "fault" and self.part in ("", part) and self.what == ("end" if is_over else "begin")

    def as_data(self) -> dict[str, Any]:
        return {key: list(value) if isinstance(value, tuple) else value for key, value in self._asdict().items()}


def _state(name: str, states: Sequence[str], signal: str) -> float:
    if name in states:
        return float(states.index(name))
    if states:
        raise ControlError(f"{signal} has no state {name!r}", closest(name, list(states)))
    raise ControlError(f"{signal} has no states with names", "choose an edge, a level or a window for a number")


WHATS: Final[Mapping[str, Sequence[str]]] = {
    "edge": tuple(SLOPES),
    "level": ("above", "below"),
    "window": ("inside", "outside"),
    "fault": ("begin", "end"),
}
"""The events that a trigger of a kind may wait for, the usual one first."""


def read_trigger(data: Any) -> Trigger:
    """Return the trigger that `data` from outside describes.  MalformedError if it is none."""
    kind = field(data, "kind", str)
    if kind not in KINDS:
        raise MalformedError(f"kind: expected one of {', '.join(KINDS)}, found {shown(kind)}")
    unknown = data.keys() - set(Trigger._fields)
    if unknown:
        raise MalformedError(f"{shown(min(map(str, unknown)))}: expected one of {', '.join(Trigger._fields)}")
    trigger = Trigger(
        kind,
        signal=_text(data, "signal") if kind in ON_SIGNALS else "",
        level=_number(data, "level") if kind in ("edge", "level", "window") else 0.0,
        high=_number(data, "high") if kind == "window" else 0.0,
        what="" if kind == "message" else _what(data, kind),
        part=typed(data.get("part", ""), str, "part") if kind in ("message", "fault") else "",
        words=tuple(_words(data)) if kind == "message" else (),
    )
    if trigger.high < trigger.level and kind == "window":  # a page sends both limits while one of them is typed
        return trigger._replace(level=trigger.high, high=trigger.level)
    return trigger


def _what(data: Any, kind: str) -> str:
    known = WHATS.get(kind)
    what = typed(data.get("what", known[0] if known else ""), str, "what")
    if known is not None and what not in known:
        raise MalformedError(f"what: expected one of {', '.join(known)}, found {shown(what)}")
    if len(what) > LONGEST_TEXT:
        raise MalformedError(f"what: expected at most {LONGEST_TEXT} characters")
    return what


def _text(data: Any, key: str) -> str:
    text = field(data, key, str)
    if not 0 < len(text) <= LONGEST_TEXT:
        raise MalformedError(f"{key}: expected 1 to {LONGEST_TEXT} characters")
    return text


def _number(data: Any, key: str) -> float:
    number = field(data, key, float)
    if not isfinite(number):
        raise MalformedError(f"{key}: expected a number, found {number}")
    return number


def _words(data: Any) -> list[str]:
    words = data.get("words", [])
    if isinstance(words, str):
        words = words.split()
    if not isinstance(words, list) or len(words) > MOST_WORDS:
        raise MalformedError(f"words: expected at most {MOST_WORDS} words")
    return [typed(word, str, "words")[:LONGEST_TEXT] for word in words]
