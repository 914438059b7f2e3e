"""Branches of a rig in virtual time: an empty one, a scenario against a new rig, the way back, and the memory."""

import sys
import time
from collections.abc import Callable
from pathlib import Path
from random import Random
from statistics import median

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from report import COMPARED, Report, progress  # noqa: E402  found beside this file

from fieldrig.clock import MS, S  # noqa: E402
from fieldrig.config.rig_file import load  # noqa: E402
from fieldrig.virtual.rig import Rig  # noqa: E402

CONFIGS = HERE.parents[1] / "configs"
HOT_NS = 30 * S
"""The bar of the feeder has its temperature."""
SCENARIO_NS = 3 * S
RUN_S = 600
TIMES = 10


def rig_of(name: str) -> Rig:
    return Rig(load(CONFIGS / name, ["time=virtual"]))


def feed(rig: Rig, _seed: int = 0) -> None:
    rig.set("feeder", "panel.key1", True)
    rig.run_for(SCENARIO_NS)


def wall_ms(work: Callable[[], object]) -> float:
    found = []
    for _ in range(TIMES):
        begin_s = time.perf_counter()
        work()
        found.append(1e3 * (time.perf_counter() - begin_s))
    return median(found)


def run() -> Report:
    report = Report(
        "Branches of a rig",
        f"This table shows the costs of branches and checkpoints, medians of {TIMES}. A new rig is one that is loaded,"
        " built and run to the instant of the branch.",
        COMPARED,
    )
    progress("branches: the feeder")
    with rig_of("feeder.yaml") as rig:
        rig.run_until(HOT_NS)
        empty = wall_ms(lambda: rig.branch().close())
        branched = wall_ms(lambda: rig.branches(feed, [0], workers=1))
    anew = wall_ms(_feed_anew)
    report.add("empty branch of the feeder", f"{empty:.1f} ms", "5 ms", empty / 5)
    report.add(
        f"{SCENARIO_NS // S} s of the hot feeder, in a branch",
        f"{branched:.0f} ms",
        f"a new rig, {anew:.0f} ms",
        branched / anew,
    )
    progress(f"branches: back over {RUN_S} s of the conveyor")
    with rig_of("conveyor.yaml") as rig:
        rig.checkpoint_every(5 * S)
        rig.set("panel", "6200:01", 3)
        rig.run_until(RUN_S * S)
        random = Random(1)
        ways = sorted(_back_s(rig, random.randrange(RUN_S * 1000) * MS) for _ in range(TIMES))
        memory = rig.checkpoints()
    report.add(f"back over {RUN_S} s of the conveyor, median", f"{median(ways):.2f} s", "2 s", median(ways) / 2)
    report.add(f"back over {RUN_S} s of the conveyor, longest", f"{ways[-1]:.2f} s", "2 s", ways[-1] / 2)
    each = median(memory.values()) / 2**20
    total = sum(memory.values()) / 2**20
    report.add(f"memory of a checkpoint, {len(memory)} of them {total:.0f} MB", f"{each:.1f} MB", "5 MB", each / 5)
    return report


def _feed_anew() -> None:
    with rig_of("feeder.yaml") as rig:
        rig.run_until(HOT_NS)
        feed(rig)


def _back_s(rig: Rig, ns: int) -> float:
    begin_s = time.perf_counter()
    rig.back(ns).close()
    return time.perf_counter() - begin_s


if __name__ == "__main__":
    print(run().markdown())
