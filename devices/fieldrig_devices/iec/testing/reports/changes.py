"""The fates of the changes of a program, for people and as JSON."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from fieldrig.points.values import counted
from fieldrig_devices.iec.mutation import accepted
from fieldrig_devices.iec.mutation.changes import Change
from fieldrig_devices.iec.testing.trial import Fate, Result


def line_of(result: Result) -> str:
    """Return the line about a change."""
    seen = "  (no test runs it)" if result.fate is Fate.NOT_RUN else ""
    return f"  {accepted.line_of(result.change)}{seen}"


def score(results: Sequence[Result]) -> float:
    """Return the share of changes that a test noticed, in per cent; no programs and accepted ones do not count."""
    counts = Counter(result.fate for result in results)
    all_of_them = counts[Fate.NOTICED] + counts[Fate.MISSED] + counts[Fate.NOT_RUN]
    return 100.0 * counts[Fate.NOTICED] / all_of_them if all_of_them else 100.0


def summary(results: Sequence[Result], wall_s: float) -> Iterator[str]:
    counts = Counter(result.fate for result in results)
    parts = [f"{counts[Fate.NOTICED]} noticed", f"{counts[Fate.MISSED]} not noticed"]
    if counts[Fate.NOT_RUN]:
        parts.append(f"{counts[Fate.NOT_RUN]} where no test runs")
    if counts[Fate.ACCEPTED]:
        parts.append(f"{counts[Fate.ACCEPTED]} accepted")
    if counts[Fate.NO_PROGRAM]:
        parts.append(f"{counts[Fate.NO_PROGRAM]} no program")
    per_cent = int(score(results) * 10) / 10
    yield f"{counted(len(results), 'change')}: {', '.join(parts)} ({per_cent:.1f} %) in {wall_s:.1f} s"


def as_json(results: Sequence[Result]) -> dict[str, Any]:
    return {
        "score": round(score(results), 2),
        "changes": [
            {**_shown(one.change), "fate": str(one.fate), "by": None if one.by is None else str(one.by)}
            for one in results
        ],
    }


def _shown(change: Change) -> dict[str, Any]:
    return {name: value for name, value in change._asdict().items() if name != "statement"}
