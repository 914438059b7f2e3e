"""Python-can's table of messages in an SQLite database, for CAN.

The table is that of python-can, and rows are written and read here: its writer ends 0.25 s after it was stopped, with
what it has written until then (501 of 100,000 messages that come at once), and its reader loads data of any size.  A
time is a float of seconds, so it is exact to a microsecond.  What a row cannot say is in `rows`.
"""

import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import closing
from typing import Any, BinaryIO, Final

from fieldrig.clock import US, S
from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.traces.named_file import path_to_read, path_to_write
from fieldrig_bus.traces.plain_heads import HEAD_BYTES, HeadsOfNumbers, PlainHeads
from fieldrig_bus.traces.rows import BUS, Columns, Row, message_of_row, row_of

SUFFIXES = (".db", ".sqlite")
FAMILIES = frozenset({"can"})
WRITES_BACK = True
REMEDY: Final = "expected a database of python-can or `fieldrig trace`, with the table `messages`"
_TABLE: Final = (
    "CREATE TABLE messages (ts REAL, arbitration_id INTEGER, extended INTEGER, remote INTEGER, error INTEGER,"
    " dlc INTEGER, data BLOB)"
)
_INSERT: Final = "INSERT INTO messages VALUES (?, ?, ?, ?, ?, ?, ?)"
_SELECT: Final = "SELECT ts, arbitration_id, extended, remote, error, dlc, substr(data, 1, 65) FROM messages"
_new = tuple.__new__
_BATCH: Final = 10_000
"""Rows that are written at once."""
_LEAST_ROW: Final = 6
"""The fewest bytes of a row in a file: its place in the page, two lengths, and a head."""
_COMPUTED: Final = "SELECT name FROM pragma_table_xinfo('messages') WHERE hidden <> 0"
_SORT: Final = "SELECT type FROM sqlite_master WHERE lower(name) = 'messages'"


def recognises(head: bytes) -> bool:
    return head.startswith(b"SQLite format 3\0")


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int, odd: Oddities | None = None) -> int:
    """Write entries; `start_unix_ns` is the time of day at their instant 0.  Returns the number of messages."""
    columns = Columns(Oddities() if odd is None else odd)
    heads = PlainHeads(lambda identifier, is_extended, length: (identifier, is_extended, False, False, length))
    with path_to_write(file) as path, closing(sqlite3.connect(path)) as database:
        database.executescript(
            "PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF"
        )  # the file is new, and whole at the end
        database.execute(_TABLE)
        batch, written = [], 0
        for entry in entries:
            time_ns, bus, family, _, message = entry
            head = heads[message[:HEAD_BYTES]] if family == "can" and bus == columns.bus else None
            if head is not None and message[4] == len(message) - HEAD_BYTES:
                batch.append(((start_unix_ns + time_ns) / S, *head, message[HEAD_BYTES:]))
            elif (fields := columns.fields(entry)) is not None:
                batch.append(((start_unix_ns + time_ns) / S, *row_of(fields)))
            if len(batch) >= _BATCH:
                written += database.executemany(_INSERT, batch).rowcount
                batch.clear()
        written += database.executemany(_INSERT, batch).rowcount if batch else 0
        database.commit()
        return written


def read(file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
    """Yield the entries.  A row that is no frame is odd; UsageError for a file that is no such database."""
    odd = Oddities() if odd is None else odd
    odd.unit, odd.number = "row", 0
    with path_to_read(file) as path:
        try:
            with closing(sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True)) as database:
                _check(database)
                most, heads = path.stat().st_size // _LEAST_ROW, HeadsOfNumbers()
                for number, values in enumerate(database.execute(_SELECT), 1):
                    if number > most:  # pages that lead to each other have rows without end
                        raise sqlite3.DatabaseError("there are more rows than a file of this size can hold")
                    odd.number = number
                    try:
                        seconds, identifier, extended, remote, error, _, data = values
                        if type(seconds) is float and type(data) is bytes and len(data) <= 8 and not (remote or error):
                            sized = heads[identifier, extended]  # nearly all rows are such frames
                            if sized:
                                time_ns = round(seconds * 1_000_000) * US
                                yield _new(TraceEntry, (time_ns, BUS, "can", "", sized[len(data)] + data))
                                continue
                        yield _entry(values)
                    except (ValueError, TypeError, OverflowError) as wrong:
                        odd.report("rows that cannot be read are left out", f": {wrong}")
        except (sqlite3.Error, sqlite3.Warning, UnicodeDecodeError) as cause:
            where = f"after row {odd.number}: " if odd.number else ""
            raise UsageError(f"{where}{cause}", REMEDY) from cause


def _check(database: sqlite3.Connection) -> None:
    """Raise sqlite3.DatabaseError for messages that the file computes: they may have no end, and need any memory."""
    for (sort,) in database.execute(_SORT):
        if sort != "table":
            raise sqlite3.DatabaseError(f"messages is a {sort} and no table")
    for (column,) in database.execute(_COMPUTED):
        raise sqlite3.DatabaseError(f"the column {column} of messages is computed")


def _entry(values: tuple[Any, ...]) -> TraceEntry:
    seconds, identifier, extended, remote, error, length, data = values
    if not isinstance(seconds, int | float):
        raise ValueError("the time is no number")
    time_ns = round(seconds * 1_000_000) * US
    data = bytes(data or b"")
    row = Row(int(identifier), bool(extended), bool(remote), bool(error), int(length), data)
    return TraceEntry(time_ns, BUS, "can", "", message_of_row(row))
