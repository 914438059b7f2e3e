"""The SQLite file of a corpus: its tables, and what is said of a file that cannot be used."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, Final

from fieldrig.errors import UsageError

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
"""
_COLUMNS: Final = {
    "run": {"acts", "world", "strategy", "length_ns", "violations"},
    "finding": {"id", "property", "acts", "found", "length_ns", "at_ns", "what", "world", "cause", "reason", "hash"},
    "plan": {"file", "rig", "overrides"},
    "covered": {"data"},
}


class CorpusFile:
    """A file, or memory only.  Another program's file, or one of another version, is refused and stays as it is."""

    def __init__(self, file: Path | None) -> None:
        """UsageError for a file that is no corpus of this version."""
        self._file = file
        try:
            self._store = sqlite3.connect(file if file is not None else ":memory:")
            tables = dict(self._tables())
        except sqlite3.Error as wrong:
            raise UsageError(f"{file} is no corpus of a search", str(wrong)) from wrong
        if tables and tables != _COLUMNS:
            is_one = tables.keys() >= _COLUMNS.keys()
            what = "is the corpus of another version of fieldrig" if is_one else "is no corpus of a search"
            raise UsageError(f"{file} {what}", "expected another file; a search makes it")
        with self._used():
            self._store.executescript(_TABLES)

    @contextmanager
    def changing(self) -> Iterator[sqlite3.Connection]:
        """Have all changes of a block on the disk at its end, or none of them.  UsageError if they cannot be."""
        with self._used(), self._store:
            yield self._store

    def rows(self, sql: str) -> Iterator[tuple[Any, ...]]:
        """Yield the rows of a question.  UsageError for a file that is damaged."""
        with self._used(), closing(self._store.execute(sql)) as rows:
            yield from rows

    def close(self) -> None:
        self._store.close()

    def _tables(self) -> Iterator[tuple[str, set[str]]]:
        sql = "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT GLOB 'sqlite_*'"
        for (name,) in self._store.execute(sql).fetchall():
            yield name, {column for _, column, *_ in self._store.execute("SELECT * FROM pragma_table_info(?)", (name,))}

    @contextmanager
    def _used(self) -> Iterator[None]:
        """UsageError for a disk that is full, or a file that is damaged or locked."""
        try:
            yield
        except sqlite3.Error as wrong:
            remedy = "it keeps the runs and findings before, unless it is damaged"
            raise UsageError(f"{self._file} cannot be used any more: {wrong}", remedy) from wrong
