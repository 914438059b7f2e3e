"""The numbers that a page draws: buckets of signals, gaps, values at cursors, and points of the XY view.

Values go as float64: a position that has counted beyond 2**24 would stand still in float32.
"""

from array import array
from collections.abc import Iterable, Mapping, Sequence
from math import isfinite
from typing import Any, Final, Protocol

from fieldrig_page.scope.store import Gap, Track, by_track

MOST_POINTS: Final = 8_000
"""Points of an XY view; of more samples each n-th is drawn, and the page says so."""


class Drawn(Protocol):
    """A signal that is drawn, live or in a capture."""

    @property
    def name(self) -> str: ...
    @property
    def kind(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def states(self) -> Sequence[str]: ...
    @property
    def is_open(self) -> bool: ...
    @property
    def holds(self) -> bool: ...
    @property
    def track(self) -> Track | None: ...
    @property
    def column(self) -> int: ...


Rows = Mapping[int, Drawn]
"""Signals by the row in which they are drawn, from the top."""


def tracks_of(rows: Rows) -> list[tuple[Track, list[int]]]:
    """Return the tracks of the rows, each with its rows."""
    return by_track((drawn.track, row) for row, drawn in rows.items())


def part(rows: Rows, numbers: Sequence[int], first_ns: int, bucket_ns: int, count: int) -> dict[str, Any]:
    """Return `count` buckets of the rows of one track, row after row."""
    track = rows[numbers[0]].track
    assert track is not None
    found = track.reduced([rows[number].column for number in numbers], first_ns, bucket_ns, count)
    return {
        "rows": list(numbers),
        "n": count,
        "low": b"".join(buckets.low.tobytes() for buckets in found),
        "high": b"".join(buckets.high.tobytes() for buckets in found),
    }


def columns(names: Sequence[str], rows: Rows, troubles: Mapping[int, str]) -> list[dict[str, Any]]:
    """Return what each row is."""
    return [_column(name, rows.get(row), troubles.get(row, "")) for row, name in enumerate(names)]


def _column(name: str, drawn: Drawn | None, trouble: str) -> dict[str, Any]:
    if drawn is None:
        return {
            "name": name,
            "kind": "",
            "unit": "",
            "states": [],
            "is_open": False,
            "holds": False,
            "is_there": False,
            "trouble": trouble,
        }
    return {
        "name": name,
        "kind": drawn.kind,
        "unit": drawn.unit,
        "states": list(drawn.states),
        "is_open": drawn.is_open,
        "holds": drawn.holds,
        "is_there": drawn.track is not None,
        "trouble": trouble,
    }


def gaps(rows: Rows, first_ns: int, end_ns: int, origin_ns: int) -> list[dict[str, Any]]:
    """Return the gaps of a time, each with the rows that have it."""
    return [
        {"rows": numbers, "first_ns": gap.first_ns - origin_ns, "end_ns": gap.end_ns - origin_ns, "lost": gap.lost}
        for track, numbers in tracks_of(rows)
        for gap in _within(track.gaps, first_ns, end_ns)
    ]


def _within(all_gaps: Iterable[Gap], first_ns: int, end_ns: int) -> list[Gap]:
    return [gap for gap in all_gaps if gap.end_ns > first_ns and gap.first_ns < end_ns]


def values_at(rows: Rows, count: int, instant_ns: int) -> list[float | None]:
    """Return the value of each row at an instant; None where there is none."""
    found: list[float | None] = [None] * count
    for row, drawn in rows.items():
        if drawn.track is not None:
            value = drawn.track.value_at(drawn.column, instant_ns)
            found[row] = value if isfinite(value) else None
    return found


def at_cursor(rows: Rows, count: int, instant_ns: int) -> list[float | str | None]:
    """Return the value of each row at an instant as a person reads it: a whole number beyond 2^53 as a text."""
    found: list[float | str | None] = list(values_at(rows, count, instant_ns))
    for row, drawn in rows.items():
        whole = drawn.track.whole_at(drawn.column, instant_ns) if drawn.track is not None else None
        if found[row] is not None and whole is not None:
            found[row] = str(whole)
    return found


def xy(across: Drawn, up: Drawn, first_ns: int, end_ns: int) -> dict[str, Any]:
    """Return the points of two signals over each other: at each sample of the first one, what the other has then."""
    track, other = across.track, up.track
    if track is None or other is None:
        return {"x": b"", "y": b"", "each": 1}
    first, end = track.position(first_ns), track.position(end_ns)
    each = max(1, -(-(end - first) // MOST_POINTS))
    xs = track.values[across.column][first:end:each]
    if other is track:
        ys = track.values[up.column][first:end:each]
    else:
        ys = array("d", [other.value_at(up.column, instant_ns) for instant_ns in track.times_ns[first:end:each]])
    return {"x": xs.tobytes(), "y": ys.tobytes(), "each": each}
