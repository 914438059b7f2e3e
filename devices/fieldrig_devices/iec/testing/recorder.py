"""The signals around a failure: the values of variables at the statements of a test, and their diagram as text."""

from collections import deque
from collections.abc import Callable
from typing import Final, NamedTuple

from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.literal_texts import long_time_text
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.symbols import Symbol
from fieldrig_devices.iec.testing.assertions import Assertion
from fieldrig_devices.iec.testing.case import Failure
from fieldrig_devices.iec.testing.extension import CaseBlock
from fieldrig_devices.iec.testing.texts import value_text
from fieldrig_devices.iec.types import Type, Value

WIDTH: Final = 48
"""Characters of a line of levels."""
MOST_SIGNALS: Final = 8
MOST_VALUES: Final = 4
"""Values of a signal that are no levels, the last of them."""
MOST_EDGES: Final = 8
"""Edges in the lines of levels, the last of them; the time in front of them is not shown."""
MOST_CHANGES: Final = 1_000
"""Changes of a signal that are kept."""
HIGH, LOW = "▔", "▁"


class Change(NamedTuple):
    at_ns: int
    value: Value


class Track:
    """The changes of one signal."""

    def __init__(self, name: str, kind: Type) -> None:
        self.name, self.kind = name, kind
        self.changes: deque[Change] = deque(maxlen=MOST_CHANGES)

    def note(self, at_ns: int, value: Value) -> None:
        if not self.changes or self.changes[-1].value != value:
            self.changes.append(Change(at_ns, value))

    def at(self, at_ns: int) -> Value:
        """Return the value at an instant."""
        return next((one.value for one in reversed(self.changes) if one.at_ns <= at_ns), self.changes[0].value)


class Recorder:
    """Looks at the variables that the statements of a test name."""

    def __init__(self, runtime: Runtime, block: CaseBlock, now_ns: Callable[[], int]) -> None:
        self._runtime, self._block, self._now_ns = runtime, block, now_ns
        self._symbols: dict[str, Symbol | None] = {}
        self._tracks: dict[str, Track] = {}
        for name in block.places:
            self._follow(name)

    def look(self, assertion: Assertion) -> None:
        for name in assertion.names:
            self._follow(name)
            if name in self._tracks:  # the signals of the last statement are shown, whatever others there are
                self._tracks[name] = self._tracks.pop(name)
        for name, track in self._tracks.items():
            symbol = self._symbols[name]
            assert symbol is not None
            try:
                track.note(self._now_ns(), self._runtime.read(symbol))
            except ValueError:  # a reference to nothing yet
                continue

    def _follow(self, name: str) -> None:
        symbol = self._symbol(name)
        if symbol is not None:
            self._tracks.setdefault(name, Track(name, symbol.type))

    def _symbol(self, name: str) -> Symbol | None:
        """Return what a name in the test means, if it is a variable with one value."""
        if name not in self._symbols:
            root = self._runtime.compiled.program.globals[self._block.instance.lower()]
            found = self._runtime.symbols.within(root, f".{name}") or self._runtime.symbols.find(name)
            self._symbols[name] = found if found is not None and found.is_value else None
        return self._symbols[name]

    def diagram(self, failure: Failure) -> tuple[str, ...]:
        """Return the lines for a person."""
        return diagram([track for track in self._tracks.values() if track.changes], failure.at_ns)


def diagram(tracks: list[Track], end_ns: int) -> tuple[str, ...]:
    """Return one line for each signal: levels over time, or the last values with their instants."""
    shown = tracks[-MOST_SIGNALS:]
    if not shown:
        return ()
    width = max(len(track.name) for track in shown)
    levels = [track for track in shown if track.kind is Elementary.BOOL] if end_ns > 0 else []
    begin_ns = _begin_of(levels, end_ns)
    lines = []
    for track in shown:
        drawn = _drawn(track, begin_ns, end_ns) if track in levels else _told(track)
        lines.append(f"{track.name:<{width}}  {drawn}")
    if levels:
        begin, end = _instant(begin_ns), _instant(end_ns)
        lines.append(f"{'':<{width}}  {begin}{end:>{WIDTH - len(begin)}}")
    return tuple(lines)


def _begin_of(levels: list[Track], end_ns: int) -> int:
    """Return the instant at which the lines begin: some time in front of the last edges."""
    edges = sorted({change.at_ns for track in levels for change in list(track.changes)[1:]})
    if len(edges) <= MOST_EDGES:
        return 0
    first_ns = edges[-MOST_EDGES]
    return max(0, first_ns - (end_ns - first_ns) // MOST_EDGES)


def _drawn(track: Track, begin_ns: int, end_ns: int) -> str:
    span_ns = end_ns - begin_ns
    levels = [bool(track.at(begin_ns + span_ns * (place + 1) // WIDTH)) for place in range(WIDTH - 1)]
    levels.append(bool(track.changes[-1].value))
    return "".join(HIGH if level else LOW for level in levels)


def _told(track: Track) -> str:
    last = list(track.changes)[-MOST_VALUES:]
    before = "... " if len(track.changes) > len(last) else ""
    texts = [f"{value_text(track.kind, change.value)} ({_instant(change.at_ns)})" for change in last]
    return before + "  ".join(texts)


def _instant(at_ns: int) -> str:
    return long_time_text(at_ns).partition("#")[2] if at_ns else "0"
