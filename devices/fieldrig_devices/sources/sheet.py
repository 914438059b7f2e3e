"""CSV files as people have them: the first line has the names of the columns.

Columns are separated by a comma, a semicolon or a tab, whichever the first line has most of; numbers may have a decimal
comma where the semicolon or the tab separates.
"""

import csv
import io
import re
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterator
from functools import lru_cache
from math import isfinite
from pathlib import Path
from typing import Final, NamedTuple

from fieldrig.text.nearest import closest

MOST_ROWS: Final = 1_000_000


class Sheet(NamedTuple):
    """The rows below the names of the columns, without empty ones, and the line of each."""

    names: list[str]
    rows: list[list[str]]
    lines: list[int]
    separator: str

    def cells(self, column: str) -> Iterator[tuple[int, str]]:
        """Yield the line and the text of each row of a column.  ValueError if there is no such column."""
        if column not in self.names:
            raise ValueError(f"there is no column {column!r}; {closest(column, self.names)}")
        if self.names.count(column) > 1:
            raise ValueError(f"there are {self.names.count(column)} columns {column!r}; give each its own name")
        place = self.names.index(column)
        for line, row in zip(self.lines, self.rows, strict=True):
            yield line, row[place].strip() if place < len(row) else ""

    def number(self, cell: str) -> float | None:
        """Return the number in a cell, 1 and 0 for true and false; None if it has none."""
        text = cell if self.separator == "," else cell.replace(",", ".")
        truth = {"true": 1.0, "false": 0.0}.get(text.casefold())
        if truth is not None:
            return truth
        try:
            number = float(text)
        except ValueError:
            return None
        return number if isfinite(number) else None


def read_sheet(file: Path) -> Sheet:
    """Read a file.  ValueError for one without rows, or that is no CSV; OSError if it cannot be read."""
    return sheet_of(text_of(file.read_bytes()))


def text_of(data: bytes) -> str:
    """Return the text of a file in UTF-8, in UTF-16 with its mark, or else in the code page of Windows."""
    try:
        return data.decode("utf-16" if data.startswith((BOM_UTF16_LE, BOM_UTF16_BE)) else "utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


@lru_cache(maxsize=8)
def sheet_of(text: str) -> Sheet:
    """Split the text of a file, once for all of its columns.  ValueError as for `read_sheet`."""
    head, newline, below = text.partition("\n")
    given = re.fullmatch("sep=([,;\t])", head.strip(" \r"))  # a line of Excel's
    separator = given[1] if given else max(",;\t", key=head.count)
    text = f"{newline}{below}" if given else text
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator)
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
    return Sheet([name.strip() for name in rows[0]], rows[1:], lines[1:], separator)
