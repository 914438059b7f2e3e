"""The network that a ring over Zenoh needs between two hosts: which delay, and what a loss costs.

The master is on one host and ten empty drives in a process on the other; the line between them is `two_hosts`.
Processes and line run with SCHED_FIFO, so that the host's other work takes no part.
"""

import json
import os
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import network_namespace
from report import Report, progress
from ring import devices
from two_hosts import Host, Line, two_hosts

CONTROL: Final = "tcp/10.77.0.1:7450"
DRIVES: Final = 10
CYCLES_US: Final = (1_000, 2_000, 4_000)
TRIES: Final = 8
"""Looks at a ring that starts, before it counts as not kept."""
KEPT: Final = 0.99
"""The part of cycles with all answers from which on a ring counts as kept."""
STEPS: Final = 7
"""Halvings between a delay that is kept and one that is not."""
LOSS_CYCLE_US: Final = 4_000
LOSSES_PERCENT: Final = (0.01, 0.1, 1.0)
SECONDS: Final = 3.0
LOSS_SECONDS: Final = 30.0


class Ring:
    """A ring over two hosts."""

    def __init__(self, host: Host, folder: Path) -> None:
        self._host, self._folder = host, folder

    def status(self) -> dict[str, Any]:
        words = [sys.executable, "-m", "fieldrig", "status", "--json", "--control", CONTROL]
        told = self._host.run(words, self._folder).stdout
        return json.loads(told) if told else {"state": ""}

    def becomes_kept(self) -> bool:
        """Wait until the ring is up; return whether it is kept without any delay."""
        while self.status()["state"] != "ready":
            pass
        return any(self.late_part(SECONDS) <= 1 - KEPT for _ in range(TRIES))

    def late_part(self, seconds: float) -> float:
        """Return the part of cycles in the next time in which an answer was late."""
        before = self._figures()
        time.sleep(seconds)
        after = self._figures()
        cycles, late = (after[name] - before[name] for name in ("cycles", "late_cycles"))
        return late / cycles if cycles else 1.0

    def most_cycles_late(self) -> float:
        return self._figures()["most_cycles_late"]

    def _figures(self) -> dict[str, float]:
        while "cycles" not in (ring := self.status().get("buses", {}).get("ring0", {}).get("statistics", {})):
            pass
        return {name: float(ring[name]) for name in ("cycles", "late_cycles", "most_cycles_late")}


@contextmanager
def ring_over(cycle_us: int) -> Iterator[tuple[Ring, Line]]:
    rig = {
        "time": "real",
        "control": CONTROL,
        "start_timeout_s": 120,
        "buses": {"ring0": {"kind": "ring.zenoh", "mbaud": 16, "endpoint": "tcp/10.77.0.1:7104", "realtime": True,
                            "patience_ms": 10_000}},
        "devices": {
            name: {**device, "drives": DRIVES} if "drives" in device else device
            for name, device in devices(cycle_us, 1_000, DRIVES, is_full=False).items()
            if name == "max4" or device["ring_address"] <= DRIVES
        },
    }  # fmt: skip
    os.environ["FIELDRIG_TOKEN"] = "known to both hosts"
    with tempfile.TemporaryDirectory(prefix="net") as name, two_hosts() as (near, far, line):
        folder = Path(name)
        (folder / "rig.yaml").write_text(json.dumps(rig))
        (folder / "ring_devices.py").symlink_to(Path(__file__).with_name("ring_devices.py"))
        os.sched_setscheduler(line.pid, os.SCHED_FIFO, os.sched_param(30))
        started = [
            host.start([sys.executable, "-m", "fieldrig", "up", "rig.yaml", *words], folder, folder / "out")
            for host, words in (
                (near, ["--control-only"]),
                (near, ["--only", "max4"]),
                (far, ["--only", "rack0", "--set", "run=run/far"]),
            )
        ]
        try:
            yield Ring(near, folder), line
        finally:
            for process in started:
                process.send_signal(signal.SIGKILL)
                process.wait()


def largest_delay_ms(ring: Ring, line: Line, cycle_ms: float) -> float:
    """Return the largest delay of each way with which the ring is kept."""
    kept_ms, lost_ms = 0.0, cycle_ms / 2
    for _ in range(STEPS):
        delay_ms = (kept_ms + lost_ms) / 2
        line.delay(delay_ms)
        time.sleep(0.3)
        is_kept = any(ring.late_part(SECONDS) <= 1 - KEPT for _ in range(2))  # the host may have been late
        kept_ms, lost_ms = (delay_ms, lost_ms) if is_kept else (kept_ms, delay_ms)
    return kept_ms


def run() -> Report:
    report = Report(
        "Ring over two hosts",
        f"This table shows what a ring of {DRIVES} drives over Zenoh needs of the network between the host of the"
        f" master and that of the drives. A cycle is kept if all answers are there in time; {KEPT:.0%} have to be.",
        ("cycle", "network", "result"),
    )
    if why := network_namespace.why_not():
        report.notes.append(f"not measured: {why}")
        return report
    for cycle_us in CYCLES_US:
        cycle_ms = cycle_us / 1000
        progress(f"ring over two hosts: {cycle_ms:g} ms")
        with ring_over(cycle_us) as (ring, line):
            if not ring.becomes_kept():
                report.add(f"{cycle_ms:g} ms", "no loss, no delay", "not kept")
                continue
            delay_ms = largest_delay_ms(ring, line, cycle_ms)
            report.add(f"{cycle_ms:g} ms", "no loss", f"kept with a delay of {delay_ms:.2f} ms each way")
            if cycle_us != LOSS_CYCLE_US:
                continue
            line.delay(0.2)
            for percent in LOSSES_PERCENT:
                line.loss(percent)
                late = ring.late_part(LOSS_SECONDS)
                most = ring.most_cycles_late()
                result = f"{late:.2%} of cycles late; an answer was at most {most * cycle_ms:,.0f} ms late"
                report.add(f"{cycle_ms:g} ms", f"{percent:g} % of packets lost, 0.2 ms each way", result)
    return report


if __name__ == "__main__":
    print(run().markdown())
