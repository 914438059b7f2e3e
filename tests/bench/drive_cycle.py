"""The cycle of a drive with its fast form and without it: by the fold, and by the steps that are its reference.

The decision of docs/developers/architecture.md ("A drive's cycle") rests on this table: a second form of the cycle has
to save at least 20 % of the CPU time.
"""

import sys
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from statistics import mean, stdev
from unittest.mock import patch

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from report import Report, progress  # noqa: E402  found beside this file
from shipped_rigs import SPEED, WINDOW_NS, bare_ring  # noqa: E402

from fieldrig.clock import S  # noqa: E402
from fieldrig.virtual.rig import Rig  # noqa: E402
from fieldrig_devices.drives.axis import Axis  # noqa: E402
from fieldrig_devices.mc4.feedback import Feedback  # noqa: E402

WINDOWS = 10
DRIVES = 40


@contextmanager
def by_steps() -> Iterator[None]:
    """Let every drive take its cycles by the reference form."""

    def cycle(axis: Axis) -> None:
        axis.go(axis._cycle_steps)

    def following(_feedback: Feedback, _axis: Axis, *, is_published: bool) -> None:
        """Offer no folded cycle."""

    with patch.object(Axis, "cycle", cycle), patch.object(Feedback, "following", following):
        yield


def cpu_s(rig: Rig, form: AbstractContextManager[None]) -> float:
    """Return the CPU time of one window in this form."""
    with form:
        begin_s = time.process_time()
        rig.run_until(rig.now_ns + WINDOW_NS)
        return time.process_time() - begin_s


def run() -> Report:
    report = Report(
        "Cycle of a drive",
        "This table compares the fold with the steps that it replaces, on the bare ring of"
        f" {DRIVES} drives that move at {SPEED // 1_000_000} turns/s with a cycle of 4 ms. The two rings take turns in"
        f" one process: {WINDOWS} windows of {WINDOW_NS // S} simulated s each, mean and standard deviation.",
        ("form of the cycle", "CPU time per drive and cycle", "ratio to the steps"),
    )
    progress("cycle of a drive: fold and steps")
    with by_steps():
        stepped = bare_ring()
    folded = bare_ring()
    cycles = DRIVES * WINDOW_NS // 4_000_000
    steps, folds = [], []
    for _ in range(WINDOWS):
        steps.append(cpu_s(stepped, by_steps()) / cycles * 1e6)
        folds.append(cpu_s(folded, nullcontext()) / cycles * 1e6)
    ratios = [fold / step for fold, step in zip(folds, steps, strict=True)]
    report.add("steps, the reference", f"{mean(steps):.1f} ± {stdev(steps):.1f} us", "1.00")
    report.add("fold", f"{mean(folds):.1f} ± {stdev(folds):.1f} us", f"{mean(ratios):.2f} ± {stdev(ratios):.2f}")
    report.notes.append("a form that saves less than 20 % is not kept: architecture.md, A drive's cycle")
    return report


if __name__ == "__main__":
    print(run().markdown())
