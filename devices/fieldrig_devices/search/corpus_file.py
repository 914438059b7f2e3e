"""The SQLite file of a corpus: its tables, and what is said of a file that cannot be used."""

import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, Final, TypeVar

from fieldrig.errors import UsageError

T = TypeVar("T")

_TABLES: Final = """
CREATE TABLE IF NOT EXISTS run (
    acts TEXT, world TEXT, strategy TEXT, length_ns INTEGER, violations TEXT, PRIMARY KEY (acts, world)
);
CREATE TABLE IF NOT EXISTS finding (
    id INTEGER PRIMARY KEY, property TEXT, acts TEXT, found TEXT, length_ns INTEGER, at_ns INTEGER, what TEXT,
    world TEXT, cause TEXT, reason TEXT, hash TEXT, UNIQUE (property, acts, world)
);
CREATE TABLE IF NOT EXISTS plan (file TEXT, rig TEXT, overrides TEXT, UNIQUE (file, rig, overrides));
CREATE TABLE IF NOT EXISTS covered (data BLOB PRIMARY KEY);
CREATE TABLE IF NOT EXISTS outcome (
    key BLOB PRIMARY KEY, violations TEXT, refused TEXT, shrunk TEXT, states BLOB, marks BLOB, way BLOB, times INTEGER
);
"""
LATER: Final = frozenset({"outcome"})
"""Tables that older corpora do not have; they are made."""


class CorpusFile:
    """A file, or memory only.  Another program's file, or one of another version, is refused and stays as it is."""

    def __init__(self, file: Path | None) -> None:
        """UsageError for a file that is no corpus of this version."""
        self._file = file
        try:
            self._store = sqlite3.connect(file if file is not None else ":memory:")
            tables = _columns(self._store)
        except sqlite3.OperationalError as wrong:  # such as for a folder, or in one that does not exist
            raise UsageError(f"{file} cannot be used as a corpus", str(wrong)) from wrong
        except sqlite3.Error as wrong:
            raise UsageError(f"{file} is no corpus of a search", str(wrong)) from wrong
        wanted = _wanted()
        older = {name: columns for name, columns in wanted.items() if name not in LATER}
        if tables and tables not in (wanted, older):
            is_one = tables.keys() >= older.keys()
            what = "is the corpus of another version of fieldrig" if is_one else "is no corpus of a search"
            raise UsageError(f"{file} {what}", "expected another file; a search makes it")
        if tables.keys() != wanted.keys():
            self._make_tables()

    def _make_tables(self) -> None:
        """Make all tables in one step, as others may look at the file meanwhile, or this process may be killed."""
        try:
            with self._used():
                self._store.executescript(f"BEGIN IMMEDIATE; {_TABLES} COMMIT;")
        except UsageError:
            self._store.close()
            raise

    @contextmanager
    def changing(self) -> Iterator[sqlite3.Connection]:
        """Have all changes of a block on the disk at its end, or none of them.  UsageError if they cannot be."""
        with self._used(), self._store:
            yield self._store

    def rows(self, sql: str, values: Sequence[Any] = ()) -> Iterator[tuple[Any, ...]]:
        """Yield the rows of a question.  UsageError for a file that is damaged."""
        with self._used(), closing(self._store.execute(sql, values)) as rows:
            yield from rows

    def made(self, sql: str, make: Callable[..., T], values: Sequence[Any] = ()) -> Iterator[T]:
        """Yield what `make` makes of the columns of each row.  UsageError for a row that is damaged."""
        for row in self.rows(sql, values):
            try:
                one = make(*row)
            except (LookupError, TypeError, ValueError, RecursionError) as wrong:
                what = f"{self._file} is damaged: a row of {sql.partition(' FROM ')[2].split()[0]} cannot be read"
                raise UsageError(what, str(wrong)) from wrong
            yield one

    def close(self) -> None:
        self._store.close()

    @contextmanager
    def _used(self) -> Iterator[None]:
        """UsageError for a disk that is full, or a file that is damaged or locked."""
        try:
            yield
        except sqlite3.Error as wrong:
            remedy = "it keeps the runs and findings before, unless it is damaged"
            raise UsageError(f"{self._file} cannot be used any more: {wrong}", remedy) from wrong


def _columns(store: sqlite3.Connection) -> dict[str, set[str]]:
    """Return the columns of each table, by its name."""
    sql = "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT GLOB 'sqlite_*'"
    about = "SELECT * FROM pragma_table_info(?)"
    return {name: {column for _, column, *_ in store.execute(about, (name,))} for (name,) in store.execute(sql)}


def _wanted() -> dict[str, set[str]]:
    """Return the columns of a new corpus."""
    with closing(sqlite3.connect(":memory:")) as store:
        store.executescript(_TABLES)
        return _columns(store)
