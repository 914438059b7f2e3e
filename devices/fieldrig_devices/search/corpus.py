"""The runs and the findings of searches in one SQLite file."""

import json
from collections import deque
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from sqlite3 import Connection
from typing import Final, NamedTuple

from fieldrig.coverage.data import read, written
from fieldrig.coverage.summary import Coverage
from fieldrig.outside.untrusted import shown
from fieldrig_devices.scenarios.act import Schedule
from fieldrig_devices.search.corpus_file import CorpusFile
from fieldrig_devices.search.outcome import STATE_SIZE, Outcome, Record, packed, unpacked
from fieldrig_devices.search.piece import Run, World, acts_of, acts_text

_FINDING: Final = "property, acts, found, length_ns, at_ns, what, world, cause, reason, hash"


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
    world: World = ()
    """The overrides with which it happens, beside those of the scenario."""
    cause: str = ""
    """Findings of one property with different causes are different faults of a program, as far as its way shows it."""
    reason: tuple[str, ...] = ()
    """The reason in words, with what happened in the 50 ms before."""
    hash: str = ""
    """The number of all messages and their hash: a replay has the same one."""


class Origin(NamedTuple):
    """The plan of a search."""

    file: str
    rig: str
    """The rig file, if the file has only properties; otherwise nothing."""
    overrides: tuple[str, ...]


class Corpus:
    """A file, or memory only; every change is on the disk before the next one."""

    def __init__(self, file: Path | None) -> None:
        """UsageError for a file that is no corpus, or one of another version; it stays as it is."""
        self._store = CorpusFile(file)

    def add(self, run: Run, strategy: str, record: Record | None = None) -> bool:
        """Keep a run, and the outcome of its piece; false if there was one with the same actions."""
        violations = json.dumps([[one.property, one.at_ns, one.what] for one in run.violations])
        row = (acts_text(run.acts), json.dumps(run.world), strategy, run.length_ns, violations)
        with self._store.changing() as store:
            if record is not None:
                _keep(store, *record)
            return store.execute("INSERT OR IGNORE INTO run VALUES (?, ?, ?, ?, ?)", row).rowcount == 1

    def note(self, finding: Finding) -> bool:
        """Keep a finding, whose number the corpus gives; false if it was there."""
        with self._store.changing() as store:
            return self._insert(store, finding, None)

    def _insert(self, store: Connection, finding: Finding, number: int | None) -> bool:
        row = (
            number,
            finding.property,
            acts_text(finding.acts),
            acts_text(finding.found),
            *finding[4:7],
            json.dumps(finding.world),
            finding.cause,
            json.dumps(finding.reason),
            finding.hash,
        )
        sql = f"INSERT OR IGNORE INTO finding (id, {_FINDING}) VALUES ({', '.join('?' * len(row))})"
        return store.execute(sql, row).rowcount == 1

    def replace(self, number: int, finding: Finding) -> None:
        """Keep a finding instead of the one with a number, which it gets."""
        with self._store.changing() as store:
            store.execute("DELETE FROM finding WHERE id = ?", (number,))
            self._insert(store, finding, number)

    def runs(self) -> Iterator[tuple[Schedule, str, int, list[tuple[str, int, str]]]]:
        """Yield actions, strategy, length in nanoseconds and violations of each run of the first world."""
        for run, strategy, violations in self.all_runs():
            if not run.world:
                yield run.acts, strategy, run.length_ns, violations

    def all_runs(self) -> Iterator[tuple[Run, str, list[tuple[str, int, str]]]]:
        """Yield each run without its violations, the strategy, and property, instant and reason of each violation."""
        sql = "SELECT acts, world, strategy, length_ns, violations FROM run ORDER BY rowid"
        yield from self._store.made(sql, _run_of)

    def findings(self) -> list[Finding]:
        """Return the findings: of those of each property the one with the fewest actions first."""
        found = list(self._store.made(f"SELECT id, {_FINDING} FROM finding ORDER BY id", _finding_of))
        return sorted(found, key=lambda one: (one.property, len(one.acts), one.acts and one.acts[-1].at_ns, one.number))

    def cover(self, coverage: Coverage) -> None:
        """Add the coverage of the programs by a search."""
        with self._store.changing() as store:
            store.execute("INSERT OR IGNORE INTO covered VALUES (?)", (written(coverage),))

    def coverage(self) -> Coverage:
        """Return the coverage of the programs by all searches together."""
        found = Coverage()
        for news in self._store.made("SELECT data FROM covered ORDER BY rowid", read):
            found.add(news)
        return found

    def come_from(self, origin: Origin) -> None:
        """Note the plan of the search, for those who play its findings again."""
        with self._store.changing() as store:
            row = (origin.file, origin.rig, json.dumps(origin.overrides))
            store.execute("INSERT OR IGNORE INTO plan VALUES (?, ?, ?)", row)

    def origins(self) -> list[Origin]:
        return list(self._store.made("SELECT file, rig, overrides FROM plan ORDER BY rowid", _origin_of))

    def merge(self, other: "Corpus") -> None:
        """Add everything of another corpus.  UsageError for one that is damaged, of which nothing is added."""
        deque(other.all_runs(), 0)
        other.coverage()
        found, origins = other.findings(), other.origins()
        with self._store.changing() as store:
            for row in other._store.rows("SELECT acts, world, strategy, length_ns, violations FROM run"):
                store.execute("INSERT OR IGNORE INTO run VALUES (?, ?, ?, ?, ?)", row)
            for row in other._store.rows("SELECT * FROM outcome"):
                store.execute("INSERT OR IGNORE INTO outcome VALUES (?, ?, ?, ?, ?, ?, ?, ?)", row)
            for row in other._store.rows("SELECT data FROM covered ORDER BY rowid"):
                store.execute("INSERT OR IGNORE INTO covered VALUES (?)", row)
        known = {(one.property, one.cause) for one in self.findings() if one.cause}
        for one in found:
            if (one.property, one.cause) not in known:
                self.note(one)
        for origin in origins:
            self.come_from(origin)

    def outcome(self, key: bytes) -> Outcome | None:
        """Return the outcome of a piece that was played before.  UsageError for one that is damaged."""
        sql = "SELECT violations, refused, shrunk, states, marks, way, times FROM outcome WHERE key = ?"
        return next(self._store.made(sql, _outcome_of, (key,)), None)

    def keep(self, record: Record) -> None:
        """Keep the outcome of a piece."""
        with self._store.changing() as store:
            _keep(store, *record)

    def hash(self) -> str:
        """Return a hash of all runs and findings.  It does not depend on the order in which they came."""
        rows = [
            repr(row) for row in self._store.rows("SELECT acts, world, length_ns, violations FROM run ORDER BY 1, 2")
        ]
        rows += sorted(repr(one[1:]) for one in self.findings())
        return sha256("\n".join(rows).encode()).hexdigest()[:16]

    def close(self) -> None:
        self._store.close()


def _keep(store: Connection, key: bytes, outcome: Outcome) -> None:
    violations, shrunk = json.dumps(outcome.violations), json.dumps(outcome.shrunk)
    packs = packed(outcome.marks), packed(outcome.way)
    row = (key, violations, outcome.refused, shrunk, outcome.states, *packs, outcome.times)
    sql = "INSERT INTO outcome VALUES (?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT DO UPDATE SET times = times + 1"
    store.execute(sql, row)


def _run_of(
    acts: str, world: str, strategy: str, length_ns: int, violations: str
) -> tuple[Run, str, list[tuple[str, int, str]]]:
    wrong = [(str(name), int(at_ns), str(what)) for name, at_ns, what in json.loads(violations)]
    return Run(acts_of(acts), (), int(length_ns), world=_texts(world)), strategy, wrong


def _outcome_of(
    violations: str, refused: str, shrunk: str, states: bytes, marks: bytes, way: bytes, times: int
) -> Outcome:
    wrong = tuple((str(name), int(at_ns), str(what)) for name, at_ns, what in json.loads(violations))
    if len(states) % STATE_SIZE:
        raise ValueError(f"expected states of {STATE_SIZE} bytes each")
    return Outcome(wrong, str(refused), _texts(shrunk), bytes(states), unpacked(marks), unpacked(way), int(times))


def _origin_of(file: str, rig: str, overrides: str) -> Origin:
    return Origin(file, rig, _texts(overrides))


def _texts(data: str) -> tuple[str, ...]:
    """Return a list of texts.  ValueError for anything else."""
    found = json.loads(data)
    if not isinstance(found, list) or not all(isinstance(one, str) for one in found):
        raise ValueError(f"expected a list of texts, got {shown(data)}")
    return tuple(found)


def _finding_of(
    number: int, name: str, acts: str, found: str, length_ns: int, at_ns: int, what: str, *others: str
) -> Finding:
    world, cause, reason, messages = others
    return Finding(
        number,
        name,
        acts_of(acts),
        acts_of(found),
        int(length_ns),
        int(at_ns),
        what,
        _texts(world),
        cause,
        _texts(reason),
        messages,
    )
