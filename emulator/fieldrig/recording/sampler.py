"""Tracks: columns that are sampled together, with their rows since the last batch.

A row costs one call of its reader and one `pack_into`; everything else is done once for a batch.  Values are float64;
what this takes from a whole number beyond 2^53 goes beside it.
"""

import struct
from collections.abc import Callable, Sequence
from math import isfinite
from typing import Any, Final

from fieldrig.device import Value
from fieldrig.recording.batch import Kind, events_part, rows_part
from fieldrig.recording.signals import NAN, REST_NS

MOST_BYTES: Final = 1 << 18
"""Size of the rows of a track at which a batch is made at once."""
MOST_ROWS: Final = 4_096
MOST_TEXTS: Final = 1_000
"""Different texts of one column; further ones are recorded as no value."""
LONGEST_TEXT: Final = 200
EXACT: Final = 1 << 53
"""Whole numbers up to here are exact as float64 (IEEE 754)."""


class Texts:
    """The texts of a column, each with the number that stands for it."""

    def __init__(self, states: Sequence[str] = ()) -> None:
        self.states = list(states)
        self._numbers = {text: float(number) for number, text in enumerate(self.states)}
        self.has_grown = False
        """Set when there is a new text, and cleared by what tells the reader."""

    def number(self, value: Any) -> float:
        if not isinstance(value, str):
            return NAN
        text = value[:LONGEST_TEXT]
        number = self._numbers.get(text)
        if number is None:
            if len(self.states) >= MOST_TEXTS:
                return NAN
            number = self._numbers[text] = float(len(self.states))
            self.states.append(text)
            self.has_grown = True
        return number


def number_of(value: Value) -> float:
    """Return a value that is no text as it is recorded."""
    try:
        return float(value) if not isinstance(value, str) else NAN
    except OverflowError:  # a whole number beyond every float
        return NAN


class Whole:
    """The rests that are to be added to the values of a track which are whole numbers beyond `EXACT`."""

    def __init__(self, number: int) -> None:
        self._number = number
        self._rests: list[tuple[int, int, float]] = []

    def note(self, row: int, column: int, value: int) -> None:
        rounded = number_of(value)
        if isfinite(rounded):
            self._rests.append((row, column, float(value - int(rounded))))

    def take(self) -> bytes | None:
        """Return those since the last call as a part of a batch; None if there are none."""
        rests, self._rests = self._rests, []
        return events_part(self._number, 0, rests, Kind.WHOLE) if rests else None


class Track:
    """Rows of columns that are read at the same instants."""

    def __init__(
        self,
        number: int,
        read: Callable[[], Sequence[Value]],
        texts: Sequence[Texts | None],
        on_full: Callable[[], None],
        whole: Sequence[int] = (),
    ) -> None:
        """`texts` has an entry for each column: the texts of one that has them.  `whole` are those of whole numbers."""
        self.number, self.whole = number, Whole(number)
        self._whole_columns = whole
        self._read, self._on_full = read, on_full
        self._row = struct.Struct(f"<{len(texts)}d")
        self._texts = [(place, of_it) for place, of_it in enumerate(texts) if of_it is not None]
        self._width = len(texts)
        self._depth = min(max(MOST_BYTES // self._row.size, 1), MOST_ROWS)
        self._data = bytearray(self._row.size * self._depth)
        self._times: list[int] = []
        self._first = self._missed = 0
        self._last_ns = -REST_NS

    def sample_at_rest(self, now_ns: int, missed: int) -> None:
        """Take a row unless there was one lately; nothing is missed, as it is the cycles that count."""
        if now_ns - self._last_ns >= REST_NS:
            self.sample(now_ns)

    def sample(self, now_ns: int, missed: int = 0) -> None:
        """Take a row; the host was too late for `missed` rows before it."""
        values = self._read()
        if self._texts:
            values = list(values)
            for place, texts in self._texts:
                values[place] = texts.number(values[place])
        times, self._missed = self._times, self._missed + missed
        at = len(times) * self._row.size
        try:
            self._row.pack_into(self._data, at, *values)
        except (struct.error, OverflowError):  # a point that had numbers has a text, or too large a number
            self._row.pack_into(self._data, at, *map(number_of, values))
        for place in self._whole_columns:
            value = values[place]
            if type(value) is int and not -EXACT <= value <= EXACT:
                self.whole.note(self._first + len(times), place, value)
        times.append(now_ns)
        self._last_ns = now_ns
        if len(times) == self._depth:
            self._on_full()

    def take(self) -> bytes | None:
        """Return the rows since the last call as a part of a batch; None if there are none."""
        times = self._times
        if not times:
            return None
        rows = bytes(memoryview(self._data)[: len(times) * self._row.size])
        part = rows_part(self.number, self._first, self._missed, times, self._width, rows)
        self._first += len(times)
        times.clear()
        return part


class Changes:
    """Changes of single columns, in the order in which they happened."""

    def __init__(self, number: int, on_full: Callable[[], None]) -> None:
        self.number, self.whole, self._on_full = number, Whole(number), on_full
        self._events: list[tuple[int, int, float]] = []
        self._first = 0

    def note(self, now_ns: int, column: int, value: Value) -> None:
        if type(value) is int and not -EXACT <= value <= EXACT:
            self.whole.note(self._first + len(self._events), column, value)
        self._events.append((now_ns, column, number_of(value)))
        if len(self._events) == MOST_ROWS:
            self._on_full()

    def take(self) -> bytes | None:
        events, self._events = self._events, []
        if not events:
            return None
        part = events_part(self.number, self._first, events)
        self._first += len(events)
        return part
