"""The result of a run: its counts, and plain data for scripts."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from fieldrig.points.values import counted
from fieldrig_devices.conformance.bench import show
from fieldrig_devices.conformance.line import Seen
from fieldrig_devices.conformance.suite import Result, Verdict


@dataclass(frozen=True, slots=True)
class Report:
    node_id: int
    eds: str
    bus: str
    date: str
    version: str
    results: Sequence[Result]
    notes: Sequence[str]

    def count(self, verdict: Verdict, family: str | None = None) -> int:
        return sum(1 for result in self.results if result.verdict is verdict and family in (None, result.case.family))

    @property
    def families(self) -> list[str]:
        return list(dict.fromkeys(result.case.family for result in self.results))

    @property
    def executed(self) -> int:
        return len(self.results) - self.count(Verdict.NOT_APPLICABLE)

    def of(self, verdict: Verdict) -> list[Result]:
        return [result for result in self.results if result.verdict is verdict]

    @property
    def summary(self) -> str:
        passed, failed = self.count(Verdict.PASSED), self.count(Verdict.FAILED)
        rest, doubtful = self.count(Verdict.NOT_APPLICABLE), self.count(Verdict.WARNING)
        warned = f"{doubtful} with a warning, " if doubtful else ""
        return f"{counted(len(self.results), 'case')}: {passed} passed, {warned}{failed} failed, {rest} not applicable"


def seconds(result: Result) -> float:
    return (result.ended_ns - result.started_ns) / 1e9


MOST_FRAMES = 60
"""Most frames of a case that a report shows, the first and the last ones."""


def shown_frames(result: Result, most: int = MOST_FRAMES) -> list[str]:
    """Return a line for each frame, with the time since the start of the case; too many are cut in the middle."""
    lines = [_line(seen, result.started_ns) for seen in result.frames]
    if len(lines) <= most:
        return lines
    half = most // 2
    return [*lines[:half], f"... {len(lines) - most} more frames ...", *lines[-half:]]


def _line(seen: Seen, started_ns: int) -> str:
    arrow = ">" if seen.is_ours else "<"
    return f"{(seen.time_ns - started_ns) / 1e9:10.6f} {arrow} {show(seen.frame)}"


def as_data(report: Report) -> dict[str, Any]:
    return {
        "node_id": report.node_id,
        "eds": report.eds,
        "bus": report.bus,
        "date": report.date,
        "version": report.version,
        "passed": report.count(Verdict.PASSED),
        "warnings": report.count(Verdict.WARNING),
        "failed": report.count(Verdict.FAILED),
        "not_applicable": report.count(Verdict.NOT_APPLICABLE),
        "notes": list(report.notes),
        "cases": [
            {
                "number": result.case.number,
                "name": result.case.name,
                "requirement": result.case.requirement,
                "clause": result.case.clause,
                "verdict": result.verdict.value,
                "reason": result.reason,
                "expected": result.expected,
                "came": result.came,
                "seconds": seconds(result),
                "notes": result.notes,
                "remarks": result.remarks,
                "frames": shown_frames(result),
            }
            for result in report.results
        ],
    }
