"""The parts that all benchmarks share: a table of results, percentiles, progress on stderr.

A benchmark is a script with `run() -> Report`; `python tests/bench/NAME.py` prints its Markdown, `make bench` runs all
and writes docs/developers/benchmarks.md.  Figures are ratios within one run wherever there is a peer: seconds differ
between machines, ratios much less.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field

COMPARED = ("quantity", "measured", "compared with", "ratio")
"""The columns of a table that sets each measured value against a known one."""


@dataclass
class Report:
    title: str
    says: str
    """The purpose of the table and what was measured, in a sentence or two."""
    columns: Sequence[str]
    rows: list[Sequence[str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def add(self, *cells: object) -> None:
        self.rows.append([f"{cell:,.3g}" if isinstance(cell, float) else str(cell) for cell in cells])

    def markdown(self) -> str:
        lines = [f"## {self.title}", "", self.says, "", "| " + " | ".join(self.columns) + " |"]
        lines.append("|" + "---|" * len(self.columns))
        lines += ["| " + " | ".join(row) + " |" for row in self.rows]
        if self.notes:
            lines += ["", *(f"- {note}" for note in self.notes)]
        return "\n".join(lines) + "\n"


def percentile(values: Sequence[float], percent: float) -> float:
    """The value that `percent` of the sorted values don't exceed (nearest rank)."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(len(ordered) * percent / 100))]


def progress(what: str) -> None:
    print(f"  {what} ...", file=sys.stderr, flush=True)
