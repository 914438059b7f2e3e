"""The common part of all kinds of program tests: a case, its outcome, and the source that finds and runs cases.

A kind of test, such as TEST blocks or suites of TcUnit, is one `Source`.  Reports, choice by name, time-outs and exit
codes are written once, against this file.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Final, NamedTuple, Protocol, runtime_checkable

from fieldrig.clock import S

MISTAKE: Final = "mistake"
"""The kind of a failure that is a mistake of the test file, or of the rig that it names."""

FAULT: Final = "fault"
"""The kind of a failure that is a fault of the program, or what the rig refuses."""
TIMEOUT: Final = "timeout"
"""The kind of a failure that is a limit of time."""


class Verdict(StrEnum):
    """How a test ended."""

    PASSED = "passed"
    FAILED = "failed"
    """An assertion failed."""
    SKIPPED = "skipped"
    ERROR = "error"
    """The test could not be judged: a fault of the program, a time-out, or a mistake in the test."""


@dataclass(frozen=True, slots=True)
class Case:
    """One test, as `--list` shows it."""

    name: str
    suite: str
    """The file or the suite that it belongs to, as reports group it."""
    file: Path
    line: int
    """Its number from 1; 0 if it is not known, as that of a test whose name a program makes."""

    def __str__(self) -> str:
        return f"{self.suite}::{self.name}"


class Failure(NamedTuple):
    """One assertion that failed, or what kept the test from being judged."""

    kind: str
    """The name of the assertion, or one of FAULT, TIMEOUT and MISTAKE."""
    expected: str
    """The value as the language writes it; empty if nothing was compared."""
    actual: str
    message: str
    file: Path
    line: int
    """Its number from 1; 0 if it is not known."""
    at_ns: int
    """The instant in virtual time, from the begin of the test."""
    diagram: tuple[str, ...] = ()
    """Lines for people: the signals around the instant; empty without any."""


class Outcome(NamedTuple):
    """The outcome of one case."""

    case: Case
    verdict: Verdict
    failures: tuple[Failure, ...] = ()
    asserts: int = 0
    """The number of assertions that were judged."""
    duration_ns: int = 0
    """In virtual time."""
    wall_s: float = 0.0
    """In seconds of the host."""
    output: tuple[str, ...] = ()
    """Lines that the test wrote."""
    reason: str = ""
    """Why it was skipped; empty for other verdicts."""
    busy_s: float = 0.0
    """In seconds of a processor of the host."""


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits at which a test is ended that does not end by itself."""

    timeout_s: float = 10.0
    """The longest time of a processor that one test may take, in seconds; a busy host ends no test."""
    longest_ns: int = 3600 * S
    """The longest virtual time of one test."""
    has_diagrams: bool = True
    """True if a failure shows the signals around it, which takes time."""


class Source(Protocol):
    """One kind of tests in one place."""

    def cases(self) -> Sequence[Case]:
        """Return all cases in the order of their declaration.  It may be called several times."""

    def run(self, chosen: Sequence[Case], limits: Limits) -> Iterator[Outcome]:
        """Run these cases, and yield each one's outcome as soon as it is there.

        A fault of a program, and a limit that is reached, is an outcome; it never raises for them.
        """


@runtime_checkable
class Dependent(Protocol):
    """A source that knows the files on which its tests depend, for `--watch`."""

    @property
    def path(self) -> Path:
        """The file or folder of its tests."""

    def files(self) -> Collection[Path]: ...
