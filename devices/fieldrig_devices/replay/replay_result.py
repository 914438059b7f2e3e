"""The result of playing a log back to a rig."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, Final

from fieldrig.points.values import counted
from fieldrig.traces.parts import PartDifference

MOST_KEPT: Final = 10_000
"""Differences that are kept with their words; any more are only counted."""


class What(Enum):
    """The kinds of difference."""

    OTHER = "other data"
    MISSING = "missing"
    MORE = "not in the log"
    LATE = "at another time"
    NO_ANSWER = "no answer"
    REFUSED = "other result"
    """The log has an abort or an exception where the rig has a value, or the other way round, or another code."""
    PERIOD = "another period"


@dataclass(frozen=True, slots=True)
class Difference:
    """One answer or message of the rig that is not as in the log."""

    time_ns: int
    """The instant of the message in the log, from its beginning."""
    what: What
    bus: str
    node: str
    """The device, as far as it is known."""
    subject: str
    """The object, register, PDO or identifier."""
    words: str
    """The whole of it in one sentence, without the instant."""
    late_ns: int = 0
    parts: tuple[PartDifference, ...] = ()
    """The values that differ, one by one."""

    def __str__(self) -> str:
        return f"at {self.time_ns / 1e9:.3f} s {self.words}"


@dataclass(slots=True)
class ReplayResult:
    """The behaviour of a rig compared with a log."""

    differences: list[Difference] = field(default_factory=list)
    """In the order in which they were found; the first `MOST_KEPT` of them."""
    count: int = 0
    """All differences."""
    played: int = 0
    """Messages of the log that were sent to the rig."""
    compared: int = 0
    """Messages and answers of the log that the rig was expected to send."""
    by_subject: dict[tuple[str, str, str], int] = field(default_factory=dict)
    """Comparisons by bus, node and subject; the keys of JUnit cases."""
    shift_ns: int = 0
    """How much later the log ended because the rig answered later than the log."""
    duration_ns: int = 0
    """The time from the first message to the last one, in the rig."""
    notes: list[str] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    """The messages that are neither played nor compared, by bus."""

    @property
    def is_same(self) -> bool:
        """True if there is no difference."""
        return self.count == 0

    def add(self, difference: Difference) -> None:
        """Count a difference, and keep it if there is room."""
        self.count += 1
        if len(self.differences) < MOST_KEPT:
            self.differences.append(difference)

    def note(self, text: str) -> None:
        """Keep a text once."""
        if text not in self.notes:
            self.notes.append(text)

    def forget(self, why: str) -> None:
        """Forget all differences, as there was nothing to compare with."""
        self.differences.clear()
        self.by_subject.clear()
        self.count = self.compared = 0
        self.note(why)

    def raise_if_different(self) -> None:
        """Raise AssertionError with the first differences; for tests."""
        if not self.is_same:
            raise AssertionError("\n".join([self.summary, *map(str, self.differences[:MOST_SHOWN])]))

    @property
    def summary(self) -> str:
        """One line: how much was played, compared, and found."""
        found = "no difference" if self.is_same else f"{self.count} difference{'s' if self.count > 1 else ''}"
        return f"{found}; {counted(self.played, 'message')} played, {self.compared} compared"

    def as_data(self) -> dict[str, Any]:
        """Return the result in values that JSON has."""
        return {
            "same": self.is_same,
            "differences": [_data(each) for each in self.differences],
            "count": self.count,
            "played": self.played,
            "compared": self.compared,
            "shift_ns": self.shift_ns,
            "duration_ns": self.duration_ns,
            "notes": self.notes,
            "left_out": self.left_out,
        }


MOST_SHOWN: Final = 20


def _data(each: Difference) -> Mapping[str, Any]:
    return {
        "time_ns": each.time_ns,
        "what": each.what.value,
        "bus": each.bus,
        "node": each.node,
        "subject": each.subject,
        "words": each.words,
        "late_ns": each.late_ns,
        "values": _values(each.parts),
    }


def _values(parts: Sequence[PartDifference]) -> list[dict[str, Any]]:
    return [
        {
            "key": part.key,
            "log": None if part.expected is None else part.expected.value,
            "rig": None if part.actual is None else part.actual.value,
            "bits": part.bits,
        }
        for part in parts
    ]
