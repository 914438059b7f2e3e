"""A column of a CSV file as a recording of one value."""

from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from fieldrig.clock import NEVER_NS, S
from fieldrig_devices.sources.sheet import Sheet, read_sheet


class Recording(NamedTuple):
    """The rows of one column: ages in nanoseconds, which rise from 0, and values."""

    ages_ns: tuple[int, ...]
    values: tuple[float, ...]


def read_recording(file: Path, column: str, time_column: str | None, step_ns: int) -> Recording:
    """Read a column; without `time_column` its rows are `step_ns` apart.

    ValueError, with the line, for a file or a column that cannot be read, and for times that do not rise.
    """
    sheet = read_sheet(file)
    values = tuple(_numbers(sheet, column))
    if time_column is None:
        return Recording(tuple(range(0, len(values) * step_ns, step_ns)), values)
    return Recording(tuple(_ages(sheet, time_column)), values)


def _numbers(sheet: Sheet, column: str) -> Iterator[float]:
    """Yield the values; an empty cell keeps the value before it."""
    last: float | None = None
    for line, cell in sheet.cells(column):
        if cell:
            last = sheet.number(cell)
            if last is None:
                raise ValueError(f"line {line}: expected a number in column {column!r}, got {cell!r}")
        elif last is None:
            raise ValueError(f"line {line}: expected a number in the first row of column {column!r}")
        yield last


def _ages(sheet: Sheet, column: str) -> Sequence[int]:
    """Return the times of the rows since the first one, in nanoseconds, from seconds or dates."""
    ages: list[int] = []
    first: float | None = None
    for line, cell in sheet.cells(column):
        seconds = _seconds(cell, sheet)
        if seconds is None:
            raise ValueError(f"line {line}: expected seconds or a date in column {column!r}, got {cell!r}")
        first = seconds if first is None else first
        age_ns = round((seconds - first) * S)
        if ages and age_ns <= ages[-1]:
            raise ValueError(f"line {line}: expected a later time than in the row before, got {cell!r}")
        if age_ns >= NEVER_NS:
            raise ValueError(f"line {line}: {cell!r} is too long after the first row")
        ages.append(age_ns)
    return ages


def _seconds(cell: str, sheet: Sheet) -> float | None:
    number = sheet.number(cell)
    if number is not None:
        return number
    try:
        date = datetime.fromisoformat(cell)
    except ValueError:
        return None
    return (date.replace(tzinfo=None) - datetime(1970, 1, 1)).total_seconds()  # noqa: DTZ001 - only the distance counts
