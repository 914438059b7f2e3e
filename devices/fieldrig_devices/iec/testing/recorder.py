"""The signals around a failure: the values of variables at the statements of a test, and their diagram as text."""

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
HIGH, LOW = "▔", "▁"


class Change(NamedTuple):
    at_ns: int
    value: Value


class Track:
    """The changes of one signal."""

    def __init__(self, name: str, kind: Type) -> None:
        self.name, self.kind = name, kind
        self.changes: list[Change] = []

    def note(self, at_ns: int, value: Value) -> None:
        if not self.changes or self.changes[-1].value != value:
            self.changes.append(Change(at_ns, value))

    def at(self, at_ns: int) -> Value:
        """Return the value at an instant."""
        known = [change.value for change in self.changes if change.at_ns <= at_ns]
        return known[-1] if known else self.changes[0].value


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
    has_levels = end_ns > 0 and any(track.kind is Elementary.BOOL for track in shown)
    lines = [f"{track.name:<{width}}  {_drawn(track, end_ns)}" for track in shown]
    if has_levels:
        begin, end = "0", long_time_text(end_ns).partition("#")[2]
        lines.append(f"{'':<{width}}  {begin}{end:>{WIDTH - len(begin)}}")
    return tuple(lines)


def _drawn(track: Track, end_ns: int) -> str:
    if track.kind is Elementary.BOOL and end_ns > 0:
        levels = [bool(track.at(end_ns * (place + 1) // WIDTH)) for place in range(WIDTH - 1)]
        levels.append(bool(track.changes[-1].value))
        return "".join(HIGH if level else LOW for level in levels)
    last = track.changes[-MOST_VALUES:]
    before = "... " if len(track.changes) > len(last) else ""
    texts = [f"{value_text(track.kind, change.value)} ({_instant(change.at_ns)})" for change in last]
    return before + "  ".join(texts)


def _instant(at_ns: int) -> str:
    return long_time_text(at_ns).partition("#")[2] if at_ns else "0"
