"""A column of a CSV file as a recording of one value.

Columns are separated by a comma, a semicolon or a tab, whichever the first line has most of; numbers with a decimal
comma are read where the semicolon or the tab separates.  The first line has the names of the columns.
"""

import csv
from collections.abc import Iterator, Sequence
from datetime import datetime
from functools import lru_cache
from math import isfinite
from pathlib import Path
from typing import Final, NamedTuple

from fieldrig.clock import NEVER_NS, S
from fieldrig.text.nearest import closest

MOST_ROWS: Final = 1_000_000


class Recording(NamedTuple):
    """The rows of one column: ages in nanoseconds, which rise from 0, and values."""

    ages_ns: tuple[int, ...]
    values: tuple[float, ...]


class _Sheet(NamedTuple):
    names: list[str]
    rows: list[list[str]]
    lines: list[int]
    separator: str


def read_recording(file: Path, column: str, time_column: str | None, step_ns: int) -> Recording:
    """Read a column; without `time_column` its rows are `step_ns` apart.

    ValueError, with the line, for a file or a column that cannot be read, and for times that do not rise.
    """
    sheet = _sheet(file.read_text(encoding="utf-8-sig", errors="replace"))
    values = tuple(_numbers(sheet, column))
    if time_column is None:
        return Recording(tuple(range(0, len(values) * step_ns, step_ns)), values)
    return Recording(tuple(_ages(sheet, time_column)), values)


@lru_cache(maxsize=8)
def _sheet(text: str) -> _Sheet:
    """Split a file once for all of its columns."""
    head = text.partition("\n")[0]
    separator = max(",;\t", key=head.count)
    reader = csv.reader(text.splitlines(), delimiter=separator)
    rows, lines = [], []
    try:
        for row in reader:
            if any(cell.strip() for cell in row):
                rows.append(row)
                lines.append(reader.line_num)
            if len(rows) > MOST_ROWS:
                raise ValueError(f"it has more than {MOST_ROWS} rows")
    except csv.Error as cause:
        raise ValueError(f"line {reader.line_num}: {cause}") from cause
    if len(rows) < 2:
        raise ValueError("expected a line with the names of the columns, and rows of values after it")
    return _Sheet([name.strip() for name in rows[0]], rows[1:], lines[1:], separator)


def _cells(sheet: _Sheet, column: str) -> Iterator[tuple[int, str]]:
    """Yield the line and the text of each row of a column."""
    if column not in sheet.names:
        raise ValueError(f"there is no column {column!r}; {closest(column, sheet.names)}")
    place = sheet.names.index(column)
    for line, row in zip(sheet.lines, sheet.rows, strict=True):
        yield line, row[place].strip() if place < len(row) else ""


def _numbers(sheet: _Sheet, column: str) -> Iterator[float]:
    """Yield the values; an empty cell keeps the value before it."""
    last: float | None = None
    for line, cell in _cells(sheet, column):
        if cell:
            last = _number(cell, sheet.separator)
            if last is None:
                raise ValueError(f"line {line}: expected a number in column {column!r}, got {cell!r}")
        elif last is None:
            raise ValueError(f"line {line}: expected a number in the first row of column {column!r}")
        yield last


def _number(cell: str, separator: str) -> float | None:
    text = cell if separator == "," else cell.replace(",", ".")
    truth = {"true": 1.0, "false": 0.0}.get(text.casefold())
    if truth is not None:
        return truth
    try:
        number = float(text)
    except ValueError:
        return None
    return number if isfinite(number) else None


def _ages(sheet: _Sheet, column: str) -> Sequence[int]:
    """Return the times of the rows since the first one, in nanoseconds, from seconds or dates."""
    ages: list[int] = []
    first: float | None = None
    for line, cell in _cells(sheet, column):
        seconds = _seconds(cell, sheet.separator)
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


def _seconds(cell: str, separator: str) -> float | None:
    number = _number(cell, separator)
    if number is not None:
        return number
    try:
        date = datetime.fromisoformat(cell)
    except ValueError:
        return None
    return (date.replace(tzinfo=None) - datetime(1970, 1, 1)).total_seconds()  # noqa: DTZ001 - only the distance counts
