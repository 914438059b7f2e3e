"""What the straight way of a drive's cycle (`mc4/straight.py`) brings where each drive has a process of its own.

Rings of 40 full drives over Zenoh run in turn, one with the straight way and one without, so that whatever else the
computer does meets both.
"""

import json
import sys
import time
from pathlib import Path
from statistics import mean, stdev
from typing import Any

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from report import Report, progress  # noqa: E402  found beside this file
from ring import CAN_BE_REALTIME, DEVICES, DRIVES, devices  # noqa: E402
from running_rig import RunningRig  # noqa: E402

from fieldrig.control import Client  # noqa: E402

CYCLE_US = 4_000
ROUNDS = 8
SECONDS = 8.0


def rig_of(is_straight: bool) -> str:
    drives = devices(CYCLE_US, CYCLE_US, 1, is_full=True)
    for name, drive in drives.items():
        if name.startswith("drive"):
            drive["is_straight"] = is_straight
    ring = {"kind": "ring.zenoh", "mbaud": 16, "patience_ms": 5_000, "realtime": CAN_BE_REALTIME}
    return json.dumps({"time": "real", "start_timeout_s": 300, "buses": {"ring0": ring}, "devices": drives})


def look(client: Client) -> tuple[float, float, float]:
    """CPU of the drives' processes so far, cycles, and the round trip's p50 of late."""
    processes: dict[str, Any] = client.ask_all("process/*/status")
    cpu_s = sum(float(status["cpu_s"] or 0) for name, status in processes.items() if "rack" in name)
    ring = client.ask("bus/ring0/status")
    return cpu_s, ring["cycles"], ring["trip_p50_us"]


def measured(is_straight: bool) -> tuple[float, float]:
    """CPU of a drive's process for one cycle, and the ring's round trip, in microseconds."""
    with RunningRig(rig_of(is_straight), DEVICES) as rig:
        rig.until_there()
        while rig.status()["state"] != "ready" or rig.value("max4/moving") != DRIVES:
            time.sleep(1.0)
        with Client(rig.endpoint) as client:
            cpu_s, cycles, _ = look(client)
            time.sleep(SECONDS)
            cpu_after_s, cycles_after, trip_us = look(client)
    return (cpu_after_s - cpu_s) / (cycles_after - cycles) / DRIVES * 1e6, trip_us


def run() -> Report:
    report = Report(
        "A drive's cycle in a process of its own",
        f"Rings of {DRIVES} drives over Zenoh, cycles of {CYCLE_US // 1000} ms, {ROUNDS} rounds of {SECONDS:g} s in"
        " turn, with the straight way and without.  CPU is that of a drive's process for a cycle, all that it does.",
        ("drives", "CPU a cycle", "round trip p50", "ratio of CPU", "ratio of round trips"),
    )
    found: dict[bool, list[tuple[float, float]]] = {True: [], False: []}
    for number in range(ROUNDS):
        for way in (True, False):
            progress(f"ring: round {number + 1}, {'with' if way else 'without'} the straight way")
            found[way].append(measured(way))
            progress(str(found[way][-1]))
    for way, name in ((False, "without the straight way"), (True, "with it")):
        cpu, trips = zip(*found[way], strict=True)
        ratios = [[a[place] / b[place] for a, b in zip(found[way], found[False], strict=True)] for place in range(2)]
        shown = [f"{mean(several):.2f} ± {stdev(several):.2f}" for several in ratios]
        report.add(
            name, f"{mean(cpu):.0f} ± {stdev(cpu):.0f} us", f"{mean(trips):,.0f} ± {stdev(trips):,.0f} us", *shown
        )
    return report


if __name__ == "__main__":
    print(run().markdown())
