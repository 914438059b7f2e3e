"""The runs and the findings of searches in one SQLite file."""

import json
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from hashlib import sha256
from pathlib import Path
from typing import Any, Final, NamedTuple

from fieldrig.errors import UsageError
from fieldrig_devices.scenarios.act import Act, Schedule
from fieldrig_devices.search.piece import Run

_TABLES: Final = """
CREATE TABLE IF NOT EXISTS run (acts TEXT PRIMARY KEY, strategy TEXT, length_ns INTEGER, violations TEXT);
CREATE TABLE IF NOT EXISTS finding (
    id INTEGER PRIMARY KEY, property TEXT, acts TEXT, found TEXT, length_ns INTEGER, at_ns INTEGER, what TEXT,
    UNIQUE (property, acts)
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
    length_ns: int
    """The time after which it is over."""
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
        row = (acts_text(run.acts), strategy, run.length_ns, violations)
        with self._store:
            return self._store.execute("INSERT OR IGNORE INTO run VALUES (?, ?, ?, ?)", row).rowcount == 1

    def note(self, finding: Finding) -> bool:
        """Keep a finding, whose number the corpus gives; false if it was there."""
        acts, found = acts_text(finding.acts), acts_text(finding.found)
        row = (finding.property, acts, found, finding.length_ns, finding.at_ns, finding.what)
        with self._store:
            columns = "property, acts, found, length_ns, at_ns, what"
            sql = f"INSERT OR IGNORE INTO finding ({columns}) VALUES (?, ?, ?, ?, ?, ?)"
            return self._store.execute(sql, row).rowcount == 1

    def runs(self) -> Iterator[tuple[Schedule, str, int, list[Any]]]:
        """Yield the actions, the strategy, the length in nanoseconds and the violations of each run."""
        sql = "SELECT acts, strategy, length_ns, violations FROM run ORDER BY rowid"
        with closing(self._store.execute(sql)) as rows:
            for acts, strategy, length_ns, violations in rows:
                yield acts_of(acts), strategy, length_ns, json.loads(violations)

    def findings(self) -> list[Finding]:
        sql = "SELECT id, property, acts, found, length_ns, at_ns, what FROM finding ORDER BY id"
        rows = self._store.execute(sql).fetchall()
        return [Finding(one[0], one[1], acts_of(one[2]), acts_of(one[3]), *one[4:]) for one in rows]

    def merge(self, other: "Corpus") -> None:
        """Add everything of another corpus."""
        with self._store:
            for row in other._store.execute("SELECT acts, strategy, length_ns, violations FROM run"):
                self._store.execute("INSERT OR IGNORE INTO run VALUES (?, ?, ?, ?)", row)
        for one in other.findings():
            self.note(one)

    def hash(self) -> str:
        """Return a hash of all runs and findings.  It does not depend on the order in which they came."""
        rows = [repr(row) for row in self._store.execute("SELECT acts, length_ns, violations FROM run ORDER BY acts")]
        rows += sorted(repr(one[1:]) for one in self.findings())
        return sha256("\n".join(rows).encode()).hexdigest()[:16]

    def close(self) -> None:
        self._store.close()


def acts_text(acts: Schedule) -> str:
    return json.dumps([list(act) for act in acts])


def acts_of(text: str) -> Schedule:
    return tuple(Act(*fields) for fields in json.loads(text))
