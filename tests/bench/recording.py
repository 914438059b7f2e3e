"""Recordings: 200 signals at 1 kHz in real and virtual time, and the positions of a ring of 40 drives.

Windows with and without a recording alternate in one run, so that a busy host treats both alike.
"""

import asyncio
import json
import time
from collections.abc import Callable
from pathlib import Path
from statistics import mean
from typing import Any

from report import Report, progress
from ring import CASES, DEVICES, DRIVES, Outcome, measured, rig_of
from running_rig import RunningRig, until

from fieldrig.clock import S
from fieldrig.config.rig_file import from_dict
from fieldrig.control.endpoint import connect
from fieldrig.control.messages import Client, Control
from fieldrig.recording.reader import Reader, Rows
from fieldrig.virtual.rig import Rig

HERE = Path(__file__).parent
KINDS = HERE / "bench_kinds.py"
SIGNALS = 200
SECONDS = 10.0
ROUNDS = 3
VIRTUAL_SECONDS = 10
RING = CASES[-1]
"""All drives in one process, over shared memory, 1 ms."""


def source(time_of_rig: str) -> dict[str, Any]:
    return {"time": time_of_rig, "devices": {"source": {"kind": "bench_kinds:Counting", "signals": SIGNALS}}}


class Recorded:
    """A recording that counts what arrives."""

    def __init__(self) -> None:
        self.rows = self.lost = 0
        self.cycles = 0.0
        """Cycles of the device meanwhile, as its first signal counts them."""
        self._last = 0.0

    def take(self, rows: Rows) -> None:
        self.rows += len(rows.times_ns)
        self.lost += rows.lost
        counted = rows.values[0]
        self.cycles += counted[-1] - (counted[0] - 1 if rows.first == 0 else self._last)
        self._last = counted[-1]

    async def run(self, endpoint: str, rig: str, signals: list[str], meanwhile: Callable[[], Any]) -> Any:
        """Record these signals while `meanwhile` works in a thread, and return its result."""
        control = Control(connect(endpoint), rig)
        try:
            reader = Reader(control, signals, "cycle", self.take)
            await reader.begin()
            result = await asyncio.to_thread(meanwhile)
            await reader.end()
        finally:
            await control.close()
        return result


def cpu_s(rig: RunningRig, process: str) -> float:
    with Client(rig.endpoint) as client:
        return float(client.ask(f"process/{process}/status")["cpu_s"])


def real(report: Report) -> None:
    signals = [f"source/v{number}" for number in range(SIGNALS)]
    recorded, without, within = Recorded(), list[float](), list[float]()

    def window() -> float:
        before = cpu_s(rig, "source")
        time.sleep(SECONDS)
        return (cpu_s(rig, "source") - before) / SECONDS

    with RunningRig(json.dumps(source("real")), KINDS) as rig:
        rig.until_ready()
        name = rig.status()["rig"]
        for _ in range(ROUNDS):
            without.append(window())
            within.append(asyncio.run(recorded.run(rig.endpoint, name, signals, window)))
    rows_per_s = recorded.rows / ROUNDS / SECONDS
    cost_us = (mean(within) - mean(without)) / max(rows_per_s, 1) * 1e6
    report.add(f"rows of {SIGNALS} signals at 1 kHz, real time", f"{recorded.rows:,}",
               f"cycles of the device {recorded.cycles:,.0f}", recorded.rows / recorded.cycles)  # fmt: skip
    report.add("CPU of the device's process", f"{mean(within):.1%} of a core", f"not recorded {mean(without):.1%}",
               mean(within) / mean(without))  # fmt: skip
    report.add(f"a row of {SIGNALS} signals, all its work", f"{cost_us:.0f} us", "-", "-")
    report.add("rows lost", recorded.lost, f"of {recorded.rows:,}", recorded.lost / max(recorded.rows, 1))


def virtual(report: Report) -> None:
    def second_s(is_recorded: bool) -> float:
        with Rig(from_dict(source("virtual"), HERE)) as rig:
            rig.run_for(S)
            recording = rig.record([f"source/v{number}" for number in range(SIGNALS)]) if is_recorded else None
            start_s = time.process_time()
            rig.run_for(VIRTUAL_SECONDS * S)
            spent_s = time.process_time() - start_s
            assert recording is None or len(recording.values["source/v0"]) == VIRTUAL_SECONDS * 1_000
        return spent_s / VIRTUAL_SECONDS

    without, within = second_s(False), second_s(True)
    cost_us = (within - without) * 1e3
    report.add(f"{SIGNALS} signals at 1 kHz, virtual time", f"{1 / within:.1f} virtual s per s",
               f"not recorded {1 / without:.0f}", without / within)  # fmt: skip
    report.add(f"a row of {SIGNALS} signals in virtual time", f"{cost_us:.0f} us", "-", "-")


def ring(report: Report) -> None:
    signals = [f"drive{address}/position" for address in range(1, DRIVES + 1)]
    recorded, without, within = Recorded(), list[Outcome](), list[Outcome]()
    with RunningRig(json.dumps(rig_of(RING, is_full=True)), DEVICES) as rig:
        rig.until_ready()
        until(lambda: rig.value("max4/moving") == DRIVES)
        name = rig.status()["rig"]
        for _ in range(ROUNDS):
            without.append(measured(rig))
            within.append(asyncio.run(recorded.run(rig.endpoint, name, signals, lambda: measured(rig))))
    for what, of_it in (
        ("cycles kept", lambda run: run.kept_percent),
        ("round trip p99 in us", lambda run: run.p99_us),
        ("CPU of all processes in cores", lambda run: run.cores),
    ):
        plain, taken = mean(map(of_it, without)), mean(map(of_it, within))
        report.add(f"{DRIVES} positions of the ring, {RING.what}: {what}", taken, f"not recorded {plain:,.3g}",
                   taken / plain)  # fmt: skip
    report.add("values lost", recorded.lost, f"of {recorded.rows:,}", recorded.lost / max(recorded.rows, 1))


def run() -> Report:
    report = Report(
        "Recording signals",
        f"This table shows what a recording costs: {ROUNDS} windows of {SECONDS:g} s with it between as many without.",
        ("quantity", "measured", "compared with", "ratio"),
    )
    progress("recording: virtual time")
    virtual(report)
    progress("recording: real time")
    real(report)
    progress("recording: the ring")
    ring(report)
    return report


if __name__ == "__main__":
    print(run().markdown())
