"""The pipes of a PAM: 16 axes behind 8 pipes of 5 blocks in a basic cycle of 1 ms."""

import sys
import time
from pathlib import Path
from statistics import median

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from pam_machine import PIPES, pipes_text  # noqa: E402  found in the folder of the tests' support
from pam_objects import Bench  # noqa: E402
from report import COMPARED, Report  # noqa: E402

LIMIT_US = 120.0
"""The share of the objects in a basic cycle of 500 us of Python, for the whole machine twice as fast as real time."""
CYCLES = 2_000
RUNS = 5


def machine() -> Bench:
    """Return a machine whose pipes all move."""
    bench = Bench(pipes_text())
    for n in range(PIPES):
        bench.connect(f"CNV_{n}", f"PHA_{n}", f"CMP_{n}", f"AMP_{n}", f"TMP_{n}")
        bench.do(f"TMP_{n}", "run", 300 + n)
    bench.cycle(200)
    return bench


def microseconds_per_cycle(bench: Bench) -> float:
    """Return the time of `take`, `flow` and `give` in a basic cycle."""
    objects, kernel = bench.objects, bench.kernel
    begin = time.process_time()
    for _ in range(CYCLES):
        kernel.cycle_number += 1
        objects.take()
        objects.flow()
        objects.give()
    return (time.process_time() - begin) / CYCLES * 1e6


def run() -> Report:
    report = Report(
        "Pipes of a PAM",
        "Sixteen axes in eight pipes of generator, amplifier, comparator, phaser and converter, all moving: the Python "
        "of a basic cycle of 1 ms, without the ring and the programs.",
        COMPARED,
    )
    bench = machine()
    taken = median(microseconds_per_cycle(bench) for _ in range(RUNS))
    report.add("basic cycle of the objects in us", taken, LIMIT_US, taken / LIMIT_US)
    for n in range(PIPES):
        bench.do(f"TMP_{n}", "run", 0)
    bench.cycle(1000)
    still = median(microseconds_per_cycle(bench) for _ in range(RUNS))
    report.add("the same with all generators at rest", still, LIMIT_US, still / LIMIT_US)
    return report


if __name__ == "__main__":
    print(run().markdown())
