"""The CPU time of the HMISCU's pulse outputs without a rig: of a move, of its edges, and of a MAST cycle."""

import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from hmiscu_bench import PtoBench, edges, shown  # noqa: E402  found in tests/support
from report import Report, progress  # noqa: E402  found beside this file

from fieldrig.clock import MS, S  # noqa: E402

TIMES = 200
CYCLES = 20_000
SHORT, LONG = 100_000, 2**32 - 1
HOUR_CYCLES = 360_000


def cpu_s(work: Callable[[], object]) -> float:
    """Return the CPU time of some work, the median of many."""
    taken = []
    for _ in range(TIMES):
        begin_s = time.process_time()
        work()
        taken.append(time.process_time() - begin_s)
    return median(taken)


def move(distance: int) -> float:
    """Return the CPU time of a whole move, from the edge of Execute to Done."""

    def whole() -> None:
        bench.relative(Velocity=50_000, Distance=distance, Acceleration=100, Deceleration=100)
        bench.rest_ns()
        bench.cycle()
        assert shown(bench.move) == {"Done"}

    bench = PtoBench()
    return cpu_s(whole)


def edges_per_s(**settings: str) -> float:
    """Return how many edges of a move are computed in a second."""
    bench = PtoBench(**settings)
    bench.relative(Velocity=50_000, Distance=SHORT, Acceleration=1_000, Deceleration=1_000)
    begin_s = time.process_time()
    bench.rest_ns()
    count = len(edges(bench.segments))
    assert count == 2 * SHORT
    return count / (time.process_time() - begin_s)


def cycle_s() -> float:
    """Return the CPU time of a MAST cycle with all seven blocks, at 50 kHz."""
    bench = PtoBench()
    bench.run(Velocity=50_000)
    bench.cycle(2 * S)
    begin_s = time.process_time()
    bench.cycles(CYCLES, 10 * MS)
    return (time.process_time() - begin_s) / CYCLES


def run() -> Report:
    report = Report(
        "Pulse outputs of the HMISCU",
        "This table shows what a pulse output costs in CPU time, without a rig and without wires.",
        ("work", "CPU time or rate", "compared with"),
    )
    progress("pulse outputs: moves, edges and cycles")
    short_s, long_s = move(SHORT), move(LONG)
    report.add(f"move of {SHORT:,} pulses", f"{short_s * 1e3:.2f} ms", "at most 1 ms")
    report.add(f"move of {LONG:,} pulses", f"{long_s * 1e3:.2f} ms", f"{long_s / short_s:.2f} of the short one")
    for name, settings in (("smooth ramps", {}), ("rounded periods", {"ramps": "periods"})):
        rate = edges_per_s(**settings)
        report.add(f"edges in order, {name}", f"{rate:,.0f}/s", f"{rate / 100_000:.1f} outputs at 50 kHz")
    per_cycle_s = cycle_s()
    hour_s = per_cycle_s * HOUR_CYCLES
    report.add(
        "MAST cycle with all seven blocks", f"{per_cycle_s * 1e6:.0f} us", f"an hour of 10 ms cycles: {hour_s:.1f} s"
    )
    return report


if __name__ == "__main__":
    print(run().markdown())
