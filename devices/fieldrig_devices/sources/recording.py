"""A column of a CSV file as a recording of one value."""

from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from fieldrig.clock import NEVER_NS, S
from fieldrig_devices.sources.sheet import Sheet, read_sheet


class Recording(NamedTuple):
    """The rows of one column that have a value: ages in nanoseconds, which rise from 0, and values."""

    ages_ns: tuple[int, ...]
    values: tuple[float, ...]
    period_ns: int
    """The age at which the recording begins again: its last row lasts as long as the one before."""


def read_recording(file: Path, column: str, time_column: str | None, step_ns: int) -> Recording:
    """Read a column; without `time_column` its rows are `step_ns` apart.

    ValueError, with the line, for a file or a column that cannot be read, and for times that do not rise.
    """
    sheet = read_sheet(file)
    numbers = tuple(_numbers(sheet, column))
    count = len(numbers)
    ages = range(0, count * step_ns, step_ns) if time_column is None else _ages(sheet, time_column)
    row_ns = ages[-1] - ages[-2] if count > 1 else step_ns
    rows = [(age_ns, number) for age_ns, number in zip(ages, numbers, strict=True) if number is not None]
    return Recording(tuple(age_ns for age_ns, _ in rows), tuple(number for _, number in rows), ages[-1] + row_ns)


def _numbers(sheet: Sheet, column: str) -> Iterator[float | None]:
    """Yield the values; None for an empty cell, which keeps the value before it."""
    is_first = True
    for line, cell in sheet.cells(column):
        number = sheet.number(cell) if cell else None
        if cell and number is None:
            raise ValueError(f"line {line}: expected a number in column {column!r}, got {cell!r}")
        if is_first and number is None:
            raise ValueError(f"line {line}: expected a number in the first row of column {column!r}")
        is_first = False
        yield number


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
