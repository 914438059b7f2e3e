"""A fibre ring of 40 drives: in real time over Zenoh and shared memory, and in virtual time.

Each ring is measured twice in one run: with full drives (an MC-4 with motor, plate and load, which swings), and with
empty ones (a whole slave of the ring that echoes).  A cycle is kept when all 40 ATs of the cycle before are there.
Beside a process per drive over Zenoh stands what Zenoh alone leaves of such a cycle (`ring_floor`).
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from statistics import mean, stdev
from typing import Any

from report import Report, progress
from ring_floor import Floor
from running_rig import RunningRig, until

from fieldrig.clock import S
from fieldrig.config.rig_file import from_dict
from fieldrig.control.messages import Client
from fieldrig.virtual.rig import Rig

HERE = Path(__file__).parent
DEVICES = HERE / "ring_devices.py"
PLATE = HERE.parents[1] / "configs/plates/sm-100-30-080.yaml"
DRIVES = 40
SECONDS = 10.0
ROUNDS = 5
SETTLING_S = 0.5
"""After all processes were asked how they are: with smaps, that takes each of them the better part of a cycle."""
VIRTUAL_SECONDS = 60
CAN_BE_REALTIME = hasattr(os, "geteuid") and os.geteuid() == 0


@dataclass(frozen=True)
class Case:
    what: str
    kind: str
    cycle_us: int
    in_process: int = 1
    """Drives."""

    @property
    def early_us(self) -> int:
        """Cycle on the way up: what a process per drive keeps over Zenoh."""
        return 4_000 if self.kind == "ring.zenoh" and self.in_process == 1 else 1_000

    @property
    def is_loaded_too(self) -> bool:
        """True if the case is also measured while every core is busy."""
        return self.in_process == 1 and CAN_BE_REALTIME


CASES = (
    Case("over Zenoh, a process per drive, 4 ms", "ring.zenoh", 4_000),
    Case("over Zenoh, racks of 10, 2 ms", "ring.zenoh", 2_000, in_process=10),
    Case("over Zenoh, racks of 20, 1 ms", "ring.zenoh", 1_000, in_process=20),
    Case("over Zenoh, all drives in one process, 1 ms", "ring.zenoh", 1_000, in_process=DRIVES),
    Case("over shared memory, a process per drive, 1 ms", "ring.shm", 1_000),
    Case("over shared memory, all drives in one process, 1 ms", "ring.shm", 1_000, in_process=DRIVES),
)


@dataclass(frozen=True)
class Outcome:
    kept_percent: float
    late: int
    """Number of late ATs."""
    p50_us: float
    p99_us: float
    cores: float
    own_mb: float
    """Memory of all processes."""


Row = tuple[str, ...]


def devices(cycle_us: int, early_us: int, in_process: int, *, is_full: bool) -> dict[str, Any]:
    ring = {"cycle_us": cycle_us, "early_us": early_us, "drives": DRIVES, "links": {"ring": "ring0"}}
    drive = {"kind": "ring_devices:Full", "name_plate": str(PLATE)} if is_full else {"kind": "ring_devices:Echo"}
    drives = {
        f"drive{address}": {**ring, **drive, "ring_address": address, "process": f"rack{(address - 1) // in_process}"}
        for address in range(1, DRIVES + 1)
    }
    return {"max4": {**ring, "kind": "ring_devices:Master"}, **drives}


def rig_of(case: Case, *, is_full: bool) -> dict[str, Any]:
    return {
        "time": "real",
        "start_timeout_s": 60,
        "buses": {"ring0": {"kind": case.kind, "mbaud": 16, "patience_ms": 1_000, "realtime": CAN_BE_REALTIME}},
        "devices": devices(case.cycle_us, case.early_us, case.in_process, is_full=is_full),
    }


@contextmanager
def busy_cores() -> Iterator[None]:
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(os.cpu_count() or 1)]
    try:
        yield
    finally:
        for process in busy:
            process.kill()
            process.wait()


def rounds(measure_once: Callable[[], Outcome]) -> Row:
    """All of them: mean and standard deviation."""
    found = [measure_once() for _ in range(ROUNDS)]

    def shown(numbers: Iterable[float], form: str) -> str:
        several = list(numbers)
        return f"{mean(several):{form}} ± {stdev(several):{form}}"

    return (
        f"{shown((run.kept_percent for run in found), '.2f')} %",
        shown((run.late for run in found), ",.0f"),
        f"{shown((run.p50_us for run in found), ',.0f')} / {shown((run.p99_us for run in found), ',.0f')} us",
        f"{shown((run.cores for run in found), '.2f')} cores",
        f"{mean(run.own_mb for run in found):,.0f} MB",
    )


def measure(case: Case, *, is_full: bool) -> list[Row]:
    with RunningRig(json.dumps(rig_of(case, is_full=is_full)), DEVICES) as rig:  # a rig file may be JSON
        rig.until_ready()
        until(lambda: rig.value("max4/moving") == DRIVES)
        return rows_of(case, lambda: measured(rig))


def rows_of(case: Case, measure_once: Callable[[], Outcome]) -> list[Row]:
    """Idle, and where it is asked for loaded."""
    rows = [rounds(measure_once)]
    if case.is_loaded_too:
        with busy_cores():
            rows.append(rounds(measure_once))
    return rows


def measured(rig: RunningRig) -> Outcome:
    with Client(rig.endpoint) as client:
        start_s, before = time.monotonic(), _processes(client)
        time.sleep(SETTLING_S)
        ring_before = client.ask("bus/ring0/status")
        time.sleep(SECONDS)
        ring, after = client.ask("bus/ring0/status"), _processes(client)
        spent_s = time.monotonic() - start_s
    cycles, late_cycles, late = (ring[name] - ring_before[name] for name in ("cycles", "late_cycles", "late"))
    return Outcome(
        kept_percent=100 * (cycles - late_cycles) / max(cycles, 1),
        late=round(late),
        p50_us=ring["trip_p50_us"],
        p99_us=ring["trip_p99_us"],
        cores=(_sum(after, "cpu_s") - _sum(before, "cpu_s")) / spent_s,
        own_mb=_sum(after, "own_mb"),
    )


def floor(case: Case) -> list[Row]:
    """The rows of Zenoh alone."""
    with Floor(SECONDS) as alone:
        return rows_of(case, lambda: Outcome(**alone.measured(), late=0, own_mb=0.0))


def _processes(client: Client) -> dict[str, Any]:
    return client.ask_all("process/*/status")


def _sum(processes: dict[str, Any], what: str) -> float:
    return sum(float(process[what] or 0) for process in processes.values())


def virtual(drives: str) -> list[float]:
    """Simulated seconds in one of CPU, at 4 ms in one process: of each of `VIRTUAL_SECONDS`."""
    rig = {
        "time": "virtual",
        "buses": {"ring0": {"kind": "ring.virtual", "mbaud": 16}},
        "devices": devices(4_000, 1_000, DRIVES, is_full=drives != "empty"),
    }
    with Rig(from_dict(rig, HERE)) as running:
        running.run_until(12 * S)  # all swing
        assert running.get("max4", "moving") == DRIVES
        return [1 / _second(running) for _ in range(VIRTUAL_SECONDS)]


def _second(running: Rig) -> float:
    """CPU that a simulated one takes."""
    start_s = time.process_time()
    running.run_until(running.now_ns + S)
    return time.process_time() - start_s


def run() -> Report:
    scheduling = "with SCHED_FIFO" if CAN_BE_REALTIME else "without SCHED_FIFO, which needs root"
    report = Report(
        "Fibre ring of 40 drives",
        f"This table shows which cycles a ring keeps in real time, {scheduling}: mean and standard deviation of"
        f" {ROUNDS} rounds of {SECONDS:g} s each. A round trip lasts from the MDT until the last process is done.",
        ("ring", "drives", "cycles kept", "late ATs", "round trip p50 / p99", "total CPU", "total memory"),
    )
    for case in CASES:
        progress(f"ring: {case.what}")
        rows = {drives: measure(case, is_full=drives == "full") for drives in ("full", "empty")}
        if case is CASES[0]:
            rows["none (Zenoh alone)"] = [(kept, "-", trip, cores, "-") for kept, _, trip, cores, _ in floor(case)]
        for number, load in enumerate(("", ", cores loaded")[: 1 + case.is_loaded_too]):
            for drives, found in rows.items():
                report.add(case.what + load, drives, *found[number])
    progress("ring: virtual time")
    for drives in ("full", "empty"):
        with ProcessPoolExecutor(1, get_context("spawn")) as fresh:  # memory is in order there
            speeds = fresh.submit(virtual, drives).result()
        shown = f"{mean(speeds):.1f} ± {stdev(speeds):.1f} simulated s per second of CPU time"
        report.add(f"virtual time, one process, 4 ms, {VIRTUAL_SECONDS} s", drives, shown, *"----")
    return report


if __name__ == "__main__":
    print(run().markdown())
