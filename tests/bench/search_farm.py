"""The same search by a pool of processes, by a Dask cluster, and by one that loses a worker: what the cluster costs.

Two at a time in each case, on this machine; runs of `swarm` depend on nothing, as those of a cluster mostly do.
"""

import os
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Final

from dask_cluster import Cluster, cluster
from report import Report, progress

from fieldrig_devices.search.bench import Bench
from fieldrig_devices.search.cluster import ClusterCrew
from fieldrig_devices.search.corpus import Corpus
from fieldrig_devices.search.crew import LocalCrew
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.plan import load_plan
from fieldrig_devices.search.rig_files import luggage_of
from fieldrig_devices.search.search import Limits, Search

FEEDER: Final = Path(__file__).parents[2] / "configs/feeder.yaml"
PLAN: Final = f"""
rig: {FEEDER}
after: 60s
for: 4s
steps:
  - {{at: 100ms, set: {{feeder/g_bStart: true}}}}
  - {{at: 1500ms, set: {{feeder/g_bStart: false}}}}
properties:
  the bar is never too hot: {{never: heater/temperature > 165.0}}
vary:
  - {{fault: stepper trip duration_ms=300}}
  - {{press: {{feeder/panel.key1: true}}, hold: 50ms}}
  - {{press: {{feeder/g_bReset: true}}, hold: 50ms}}
"""
"""The property holds, so that nothing is made small: that is done by one process in each case."""
RUNS: Final = int(os.environ.get("RUNS", "60"))
WARM: Final = 8
"""Runs before the measurement, so that all workers have their rig."""


class Losing:
    """A crew in the middle of whose work a worker is killed."""

    def __init__(self, crew: ClusterCrew, workers: Cluster | None) -> None:
        self._crew, self._workers, self._count = crew, workers, 0
        self.drop, self.start = crew.drop, crew.start

    def next(self) -> Run:
        self._count += 1
        if self._workers is not None and self._count == RUNS // 3:
            self._workers.kill_worker()
        return self._crew.next()


def measured(name: str, *, losing: bool = False, have_nannies: bool = False) -> tuple[float, str, int]:
    """Return the time of a search, its hash and the number of its runs."""
    progress(f"search farm: {name}")
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        (folder / "plan.yaml").write_text(PLAN)
        plan = load_plan(folder / "plan.yaml")
        bench = stack.enter_context(Bench(plan))
        if name == "pool":
            crew: LocalCrew | Losing = stack.enter_context(LocalCrew(bench, 2))
        else:
            workers = stack.enter_context(cluster(2, folder, have_nannies=have_nannies))
            cluster_crew = stack.enter_context(ClusterCrew(workers.address, luggage_of(plan)))
            crew = Losing(cluster_crew, workers if losing else None)
        for _ in range(WARM):
            crew.start(Piece((), 0, plan.scenario.length_ns))
        for _ in range(WARM):
            crew.next()
        corpus = Corpus(None)
        search = Search(plan, bench, crew, corpus, 1)
        start_s = time.monotonic()
        search.go(["swarm"], Limits(86_400, RUNS), lambda _line: None)
        return time.monotonic() - start_s, corpus.hash(), sum(1 for _ in corpus.runs())


def run() -> Report:
    report = Report(
        "A search on a cluster",
        f"This table compares {RUNS} runs of 4 s of configs/feeder.yaml by dice: two at a time in a pool, by two"
        " workers of Dask on the same machine, and by two of which one is killed after a third; a nanny, which"
        " `dask worker` has by default, starts it again.",
        ("who runs them", "time", "of the pool's", "different runs", "hash of all runs"),
    )
    cases: dict[str, Callable[[], tuple[float, str, int]]] = {
        "pool": lambda: measured("pool"),
        "two workers of Dask": lambda: measured("dask"),
        "two workers, one killed": lambda: measured("dask with a lost worker", losing=True),
        "two with nannies, one killed": lambda: measured("dask with nannies", losing=True, have_nannies=True),
    }
    first_s = 0.0
    for name, measure in cases.items():
        taken_s, outcome, runs = measure()
        first_s = first_s or taken_s
        report.add(name, f"{taken_s:.1f} s", f"{taken_s / first_s:.2f}", runs, outcome)
    return report


if __name__ == "__main__":
    print(run().markdown())
