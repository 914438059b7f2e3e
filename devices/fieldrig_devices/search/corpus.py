"""The runs and the findings of searches in one SQLite file."""

import json
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, Final, NamedTuple

from fieldrig.errors import UsageError
from fieldrig_devices.scenarios.act import Act, Schedule
from fieldrig_devices.search.run import Run

_TABLES: Final = """
CREATE TABLE IF NOT EXISTS run (acts TEXT PRIMARY KEY, strategy TEXT, hash TEXT, violations TEXT);
CREATE TABLE IF NOT EXISTS finding (
    id INTEGER PRIMARY KEY, property TEXT, acts TEXT, found TEXT, at_ns INTEGER, what TEXT, UNIQUE (property, acts)
);
"""


class Finding(NamedTuple):
    """A property that does not hold with some actions."""

    number: int
    property: str
    acts: Schedule
    """The fewest actions."""
    found: Schedule
    """The actions with which it was found."""
    at_ns: int
    what: str


class Corpus:
    """A file, or memory only; every change is on the disk before the next one."""

    def __init__(self, file: Path | None) -> None:
        """UsageError for a file that is no corpus."""
        try:
            self._store = sqlite3.connect(file if file is not None else ":memory:")
            self._store.executescript(_TABLES)
        except sqlite3.Error as wrong:
            raise UsageError(f"{file} is no corpus of a search", str(wrong)) from wrong

    def add(self, run: Run, strategy: str) -> bool:
        """Keep a run; false if there was one with the same actions."""
        violations = json.dumps([[one.property, one.at_ns, one.what] for one in run.violations])
        row = (acts_text(run.acts), strategy, run.hash, violations)
        with self._store:
            return self._store.execute("INSERT OR IGNORE INTO run VALUES (?, ?, ?, ?)", row).rowcount == 1

    def note(self, property_name: str, acts: Schedule, found: Schedule, at_ns: int, what: str) -> bool:
        """Keep a finding; false if it was there."""
        row = (property_name, acts_text(acts), acts_text(found), at_ns, what)
        with self._store:
            sql = "INSERT OR IGNORE INTO finding (property, acts, found, at_ns, what) VALUES (?, ?, ?, ?, ?)"
            return self._store.execute(sql, row).rowcount == 1

    def runs(self) -> Iterator[tuple[Schedule, str, str, list[Any]]]:
        """Yield the actions, the strategy, the hash and the violations of each run."""
        with closing(self._store.execute("SELECT acts, strategy, hash, violations FROM run ORDER BY rowid")) as rows:
            for acts, strategy, run_hash, violations in rows:
                yield acts_of(acts), strategy, run_hash, json.loads(violations)

    def findings(self) -> list[Finding]:
        rows = self._store.execute("SELECT id, property, acts, found, at_ns, what FROM finding ORDER BY id").fetchall()
        return [Finding(one[0], one[1], acts_of(one[2]), acts_of(one[3]), one[4], one[5]) for one in rows]

    def merge(self, other: "Corpus") -> None:
        """Add everything of another corpus."""
        with self._store:
            for row in other._store.execute("SELECT acts, strategy, hash, violations FROM run"):
                self._store.execute("INSERT OR IGNORE INTO run VALUES (?, ?, ?, ?)", row)
        for one in other.findings():
            self.note(one.property, one.acts, one.found, one.at_ns, one.what)

    def close(self) -> None:
        self._store.close()


def acts_text(acts: Schedule) -> str:
    return json.dumps([list(act) for act in acts])


def acts_of(text: str) -> Schedule:
    return tuple(Act(*fields) for fields in json.loads(text))
