"""The result of `fieldrig diff` for people and for scripts."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, Final

import typer

from fieldrig.clock import MS, S
from fieldrig.points.values import counted
from fieldrig.traces.trace import is_time_of_day
from fieldrig_devices.replay.diff_result import Around, DiffResult, DiffRow, FirstDifference
from fieldrig_devices.replay.log_names import LogNames
from fieldrig_devices.replay.words import late_words

MOST_ROWS: Final = 100
COLUMNS: Final = ("missing", "more", "other", "earlier", "later")


def as_data(result: DiffResult) -> dict[str, Any]:
    """Return the result in values that JSON has."""
    first = result.first
    return {
        "same": result.is_same,
        "offset_ns": result.offset_ns,
        "first": None
        if first is None
        else {
            "time_ns": first.time_ns,
            "bus": first.row.bus,
            "stream": first.row.stream,
            "node": first.row.node,
            "what": first.what,
            "left": _around_data(first.around_left),
            "right": _around_data(first.around_right),
        },
        "streams": [asdict(row) for row in result.rows],
        "notes": list(result.notes),
    }


def _around_data(around: Sequence[Around]) -> list[dict[str, Any]]:
    return [
        {"time_ns": each.time_ns, "bus": each.entry.bus, "data": each.entry.data.hex(), "is_it": each.is_it}
        for each in around
    ]


def show(result: DiffResult, left: str, right: str, names: LogNames) -> None:
    """Print the result."""
    for note in result.notes:
        typer.echo(f"note: {note}")
    if result.offset_ns:
        typer.echo(f"note: {right} is compared as if it had begun {_seconds(result.offset_ns)} s earlier")
    total = sum(row.left for row in result.rows), sum(row.right for row in result.rows)
    if result.is_same:
        typer.echo(f"no difference in {counted(total[0], 'message')} of {counted(len(result.rows), 'stream')}")
        return
    if result.first is not None:
        _show_first(result.first, left, right, names)
    typer.echo(f"\n{left}: {counted(total[0], 'message')}; {right}: {counted(total[1], 'message')}")
    _table(result)


def _show_first(first: FirstDifference, left: str, right: str, names: LogNames) -> None:
    row = first.row
    where = " ".join(part for part in (row.bus, row.stream, row.kind, row.node) if part)
    typer.echo(f"first difference at {_instant(first.time_ns)}: {where}: {first.what}")
    for name, around in ((left, first.around_left), (right, first.around_right)):
        typer.echo(f"\n  {name}")
        for each in around:
            mark = ">" if each.is_it else " "
            typer.echo(f"  {mark} {_instant(each.time_ns)}  {each.entry.bus:8}  {names.words(each.entry)}")


def _table(result: DiffResult) -> None:
    from fieldrig.cli.common import echo_table

    different = [row for row in result.rows if not row.is_same]
    same = len(result.rows) - len(different)
    has_nodes = any(row.node for row in different)
    headings = (
        "bus",
        "stream",
        *(("node", "kind") if has_nodes else ()),
        "A",
        "B",
        *COLUMNS,
        "most",
        "first other data",
    )
    echo_table(headings, [_cells(row, has_nodes) for row in different[:MOST_ROWS]])
    if len(different) > MOST_ROWS:
        typer.echo(f"and {len(different) - MOST_ROWS} more; --json lists all")
    if same:
        typer.echo(f"{counted(same, 'stream')} without a difference")
    if has_nodes:
        typer.echo("\nby node")
        totals = [row for row in result.by("node") if not row.is_same]
        echo_table(("bus", "node", "A", "B", *COLUMNS), [_sums(row) for row in totals[:MOST_ROWS]])
    buses = result.by("bus")
    if len(buses) > 1:
        typer.echo("\nby bus")
        echo_table(("bus", "A", "B", *COLUMNS), [[row.bus, row.left, row.right, *_counts(row)] for row in buses])


def _cells(row: DiffRow, has_nodes: bool) -> list[object]:
    names = [row.node, row.kind] if has_nodes else []
    most = late_words(row.most_late_ns) if row.most_late_ns else ""
    return [row.bus, row.stream, *names, row.left, row.right, *_counts(row), most, row.words]


def _sums(row: DiffRow) -> list[object]:
    return [row.bus, row.node or "-", row.left, row.right, *_counts(row)]


def _counts(row: DiffRow) -> list[object]:
    return [getattr(row, name) or "" for name in COLUMNS]


def _instant(time_ns: int) -> str:
    """Return seconds from the start of a rig, or the time of day as candump has it."""
    return f"{_seconds(time_ns)} s" if not is_time_of_day(time_ns) else f"({_seconds(time_ns)})"


def _seconds(time_ns: int) -> str:
    sign, size = ("-" if time_ns < 0 else ""), abs(time_ns)
    return f"{sign}{size // S}.{size % S // (MS // 1000):06}"
