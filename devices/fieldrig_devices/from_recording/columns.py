"""The values that moved, as columns of a CSV file that the emulated device replays."""

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Final, NamedTuple

from fieldrig.clock import S
from fieldrig_devices.from_recording.series import Change, Series

MOST_CELLS: Final = 500_000
"""Cells of a file with values; what a rig takes in at its start."""
TIME: Final = "time"
"""Name of the column of times, in seconds."""


class Column(NamedTuple):
    """The values of one object or register by their instants."""

    rows: list[tuple[int, str]]
    left_out: int = 0
    """Changes that were too many."""

    @property
    def moves(self) -> bool:
        return len(self.rows) > 1


def column_of(
    series: Series,
    begin_ns: int,
    show: Callable[[int], str],
    *,
    is_event: bool = False,
    written: Collection[int] = (),
) -> Column:
    """Return the column of a series; see `column_from`."""
    changes = series.changes(begin_ns)
    return column_from(changes, series.left_out, begin_ns, show, is_event=is_event, written=written)


def column_from(
    changes: Iterable[Change],
    left_out: int,
    begin_ns: int,
    show: Callable[[int], str],
    *,
    is_event: bool = False,
    written: Collection[int] = (),
) -> Column:
    """Return the column of changes, whose rows count from `begin_ns`; `left_out` changes are missing.

    The changes at the places `written` are those of a client, which writes again: the column has none of them.

    A value that was polled has changed at an unknown instant between two polls; the middle keeps a replay right even if
    it polls a little earlier or later.  A PDO that an event has sent (`is_event`) tells the instant of the change.
    """
    rows: list[tuple[int, str]] = []
    is_written = False
    for change in changes:
        if rows and change.place in written:
            is_written = True
            continue
        at_ns = max(_instant(change, is_event) - begin_ns, 0) if rows else 0
        text = show(change.value)
        if rows and rows[-1][1] == text and not is_written:
            continue
        is_written = False
        if rows and at_ns <= rows[-1][0]:
            rows[-1] = rows[-1][0], text
        else:
            rows.append((at_ns, text))
    return Column(rows, left_out)


def _instant(change: Change, is_event: bool) -> int:
    return change.seen_ns if is_event else (change.before_ns + change.seen_ns) // 2


def csv_of(columns: Mapping[str, Column], end_ns: int) -> tuple[bytes, int | None]:
    """Return the file, and from which instant on rows were left out because they are too many (None: there are all).

    The last row is at `end_ns`, so that a replay begins again after the time of the recording.
    """
    by_time: dict[int, dict[str, str]] = {}
    for name, column in columns.items():
        for at_ns, text in column.rows:
            by_time.setdefault(at_ns, {})[name] = text
    instants = sorted(by_time)
    most = max(MOST_CELLS // max(len(columns), 1), 2)
    cut_ns = instants[most] if len(instants) > most else None
    lines = [",".join((TIME, *columns))]
    lines += (_line(at_ns, by_time[at_ns], columns) for at_ns in instants[:most])
    if cut_ns is None and end_ns > instants[-1]:
        lines.append(_line(end_ns, {}, columns))
    return ("\n".join(lines) + "\n").encode(), cut_ns


def _line(at_ns: int, cells: Mapping[str, str], names: Iterable[str]) -> str:
    return ",".join((f"{at_ns / S:.9f}".rstrip("0").rstrip("."), *(cells.get(name, "") for name in names)))
