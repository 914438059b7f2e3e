"""Twenty planted bugs: how many each strategy of a search finds, after how many runs, and how small they become.

`python tests/bench/planted_bugs.py [NAME...]` searches for some of them.  PLANTED_BUDGET_S is the processor time of
each search, of all its branches together (120 s), so that the table means the same on every host; PLANTED_SEEDS is the
number of seeds (3), PLANTED_MOST limits the runs.  A search ends at its first finding, whose shrinking counts as well.
The shipped program is searched with the first seed for the whole budget: a finding there would be a false alarm.

Each outcome is kept at once in a file of the user, so that what was stopped can be continued; a table with other
options, or of another version of the project, needs a file of its own: PLANTED_RESULTS.
"""

import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Final, NamedTuple

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from planted_in import PlantedBug, planted_bugs  # noqa: E402  found in tests/support
from report import Report, progress  # noqa: E402  found beside this file

from fieldrig_devices.search.bench import Bench  # noqa: E402
from fieldrig_devices.search.corpus import Corpus  # noqa: E402
from fieldrig_devices.search.crew import LocalCrew  # noqa: E402
from fieldrig_devices.search.plan import load_plan  # noqa: E402
from fieldrig_devices.search.search import Limits, Search  # noqa: E402

DEFAULT, DICE = "sweep,archive", "swarm"
BUDGET_S: Final = int(os.environ.get("PLANTED_BUDGET_S", "120"))
SEEDS: Final = range(1, 1 + int(os.environ.get("PLANTED_SEEDS", "3")))
MOST: Final = int(os.environ.get("PLANTED_MOST", "1000000"))
CACHE: Final = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "fieldrig"
RESULTS: Final = Path(os.environ.get("PLANTED_RESULTS", CACHE / "planted-bugs.jsonl"))
MOST_FAULTS: Final = 3
WORKERS: Final = 2


class Trial(NamedTuple):
    """The outcome of one search."""

    faults: int | None
    """Actions of the smallest finding; None if nothing was found."""
    runs: int
    """Runs of the strategy, without those of shrinking."""
    cpu_s: float
    """Processor time of the search, with its branches and its shrinking, without building the rig."""


class Ledger:
    """The outcomes so far, in a file with a line for each."""

    def __init__(self, file: Path) -> None:
        self._file = file
        file.parent.mkdir(parents=True, exist_ok=True)
        lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
        self._known = {tuple(key): Trial(*trial) for key, trial in map(json.loads, lines)}

    def trial(self, bug: PlantedBug, strategy: str, seed: int, *, clean: bool = False) -> Trial:
        """Return the outcome of a search, which is made if it is not in the file."""
        key = (bug.name, strategy, seed, clean, BUDGET_S, MOST)
        if key not in self._known:
            progress(f"planted bugs: {bug.name}{' without its bug' if clean else ''} by {strategy}, seed {seed}")
            self._known[key] = searched(bug, strategy, seed, clean=clean)
            with self._file.open("a", encoding="utf-8") as file:
                file.write(json.dumps([key, self._known[key]]) + "\n")
        return self._known[key]


def searched(bug: PlantedBug, strategy: str, seed: int, *, clean: bool = False) -> Trial:
    """Search for a bug until it is found, or through the program without it for the whole budget."""
    with TemporaryDirectory() as folder:
        plan, corpus = load_plan(bug.plan_in(Path(folder), clean=clean)), Corpus(None)
        with Bench(plan) as bench, LocalCrew(bench, WORKERS) as crew:
            search = Search(plan, bench, crew, corpus, seed)
            search.go(strategy.split(","), Limits(float("inf"), MOST, BUDGET_S, not clean), lambda _: None)
        faults = min((len(one.acts) for one in corpus.findings()), default=None)
        return Trial(faults, sum(1 for _ in corpus.all_runs()), round(search.cpu_s, 1))


def run(names: Sequence[str] = ()) -> Report:
    report = Report(
        "Planted bugs",
        f"This table shows for {BUDGET_S} s of processor time at most for each search, and {len(SEEDS)} seeds, how"
        " often each planted bug was found, and medians of the runs and the processor time until then. The size is that"
        " of the largest finding, in actions. The bugs are the files in tests/support/planted.",
        ("bug", "kind", DEFAULT.replace(",", ", "), "dice (swarm)", "size", "false alarms"),
    )
    chosen = [bug for bug in planted_bugs() if not names or bug.name in names]
    ledger = Ledger(RESULTS)
    for seed in SEEDS:  # all bugs with one seed first, as a table that was stopped is read as well
        for bug in chosen:
            for strategy in (DEFAULT, DICE):
                ledger.trial(bug, strategy, seed)
    found = dict.fromkeys((DEFAULT, DICE), 0)
    largest, alarms = 0, 0
    for bug in chosen:
        cells = []
        sizes: list[int] = []
        for strategy in (DEFAULT, DICE):
            trials = [ledger.trial(bug, strategy, seed) for seed in SEEDS]
            hits = [trial for trial in trials if trial.faults is not None]
            found[strategy] += len(hits) * 2 > len(trials)
            sizes += [trial.faults for trial in hits if trial.faults is not None]
            cells.append(_shown(hits, trials))
        is_alarm = ledger.trial(bug, DEFAULT, SEEDS[0], clean=True).faults is not None
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
    runs, cpu_s = median(trial.runs for trial in hits), median(trial.cpu_s for trial in hits)
    return f"{len(hits)} of {len(trials)}, {runs:.0f} runs, {cpu_s:.0f} s"


if __name__ == "__main__":
    print(run(sys.argv[1:]).markdown())
