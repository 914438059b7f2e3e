"""Twenty planted bugs: how many each strategy of a search finds, after how many runs, and how small they become.

`python tests/bench/planted_bugs.py [NAME...]` searches for some of them.  PLANTED_BUDGET_S is the time of the host for
each search (180 s: an hour for all twenty), PLANTED_SEEDS the number of seeds (3), PLANTED_MOST limits the runs.  A
search ends at its first finding.  The shipped program is searched with the first seed for the whole budget: a finding
there would be a false alarm.
"""

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Final, NamedTuple

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from planted_in import PlantedBug, planted_bugs  # noqa: E402  found in tests/support
from report import Report, progress  # noqa: E402  found beside this file

from fieldrig_devices.search.corpus import Corpus  # noqa: E402

DEFAULT, DICE = "sweep,archive", "swarm"
BUDGET_S: Final = int(os.environ.get("PLANTED_BUDGET_S", "180"))
SEEDS: Final = range(1, 1 + int(os.environ.get("PLANTED_SEEDS", "3")))
MOST: Final = int(os.environ.get("PLANTED_MOST", "1000000"))
MOST_FAULTS: Final = 3
WORKERS: Final = 2
FOUND, NOTHING = 1, 0
"""Exit codes of `fieldrig search run`."""


class Trial(NamedTuple):
    """The outcome of one search."""

    faults: int | None
    """Actions of the smallest finding; None if nothing was found."""
    runs: int
    wall_s: float


def searched(bug: PlantedBug, strategy: str, seed: int, *, clean: bool = False) -> Trial:
    """Search for a bug until it is found, or through the program without it for the whole budget."""
    with TemporaryDirectory() as folder:
        plan, corpus = bug.plan_in(Path(folder), clean=clean), Path(folder) / "corpus.sqlite"
        limits = ["--budget", f"{BUDGET_S}s", "--most", str(MOST), *([] if clean else ["--first"])]
        options = ["--strategy", strategy, "--seed", str(seed), "-j", str(WORKERS), "--corpus", str(corpus), "--json"]
        begin_s = perf_counter()
        program = Path(sys.executable).with_name("fieldrig")
        ended = subprocess.run(
            [program, "search", "run", plan, *limits, *options], capture_output=True, text=True, check=False
        )
        wall_s = perf_counter() - begin_s
        if ended.returncode not in (FOUND, NOTHING):
            raise RuntimeError(f"{bug.name}, {strategy}: {ended.stderr[-2000:]}")
        found = json.loads(ended.stdout)
        runs = sum(1 for _ in Corpus(corpus).all_runs())
        return Trial(min((len(one["acts"]) for one in found), default=None), runs, wall_s)


def run(names: Sequence[str] = ()) -> Report:
    report = Report(
        "Planted bugs",
        f"This table shows for {BUDGET_S} s of the host at most with {WORKERS} workers, and {len(SEEDS)} seeds, how"
        " often each planted bug was found, and medians of the runs and the time until then. The size is that of the"
        " largest finding, in actions. The bugs are the files in tests/support/planted.",
        ("bug", "kind", DEFAULT.replace(",", ", "), "dice (swarm)", "size", "false alarms"),
    )
    found = dict.fromkeys((DEFAULT, DICE), 0)
    largest, alarms = 0, 0
    chosen = [bug for bug in planted_bugs() if not names or bug.name in names]
    for bug in chosen:
        cells = []
        sizes: list[int] = []
        for strategy in (DEFAULT, DICE):
            progress(f"planted bugs: {bug.name} by {strategy}")
            trials = [searched(bug, strategy, seed) for seed in SEEDS]
            hits = [trial for trial in trials if trial.faults is not None]
            found[strategy] += len(hits) * 2 > len(trials)
            sizes += [trial.faults for trial in hits if trial.faults is not None]
            cells.append(_shown(hits, trials))
        progress(f"planted bugs: {bug.name} without its bug")
        is_alarm = searched(bug, DEFAULT, SEEDS[0], clean=True).faults is not None
        alarms += is_alarm
        largest = max([largest, *sizes])
        report.add(bug.name, bug.kind, *cells, max(sizes, default="-"), "one" if is_alarm else "none")
    report.notes += [
        f"found by most seeds: {found[DEFAULT]} of {len(chosen)} by default, {found[DICE]} by dice",
        f"largest finding: {largest} actions, of {MOST_FAULTS} that are aimed at; programs with false alarms: {alarms}",
    ]
    return report


def _shown(hits: Sequence[Trial], trials: Sequence[Trial]) -> str:
    if not hits:
        return f"0 of {len(trials)}, {median(trial.runs for trial in trials):.0f} runs"
    runs, wall_s = median(trial.runs for trial in hits), median(trial.wall_s for trial in hits)
    return f"{len(hits)} of {len(trials)}, {runs:.0f} runs, {wall_s:.0f} s"


if __name__ == "__main__":
    print(run(sys.argv[1:]).markdown())
