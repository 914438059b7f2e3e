"""Virtual time: messages a second in one process and with a process per device; the tank lab against the wall."""

import time
from pathlib import Path
from typing import Any

from report import COMPARED, Report, progress

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict, load
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame

HERE = Path(__file__).parent
LAB = HERE.parents[1] / "configs/lab.yaml"
RELAYS = 8
WALL_S = 2.0


def relay_rig(processes: str) -> dict[str, Any]:
    relay = {"kind": "bench_kinds:Relay", "of": RELAYS, "links": {"can": "can0"}}
    return {
        "time": "virtual",
        "processes": processes,
        "buses": {"can0": {"kind": "can.virtual", "bitrate": 1_000_000}},
        "devices": {f"relay{number}": {**relay, "number": number} for number in range(RELAYS)},
    }


def run_for_a_while(rig: Rig, stride_ns: int) -> tuple[float, float]:
    """Wall and virtual seconds that went by."""
    start_s, start_ns = time.perf_counter(), rig.now_ns
    while (spent_s := time.perf_counter() - start_s) < WALL_S:
        rig.run_until(rig.now_ns + stride_ns)
    return spent_s, (rig.now_ns - start_ns) / S


def messages_per_s(processes: str) -> float:
    count = 0

    def on_delivery(_bus: Bus[Any], _delivery: Delivery[Any]) -> None:
        nonlocal count
        count += 1

    with Rig(from_dict(relay_rig(processes), HERE), on_delivery) as rig:
        rig.run_until(10 * MS)
        count = 0
        wall_s, _ = run_for_a_while(rig, 10 * MS)
    return count / wall_s


def run() -> Report:
    report = Report(
        "Virtual time",
        f"This table shows how fast virtual time runs, over about {WALL_S:g} s of real time each.",
        COMPARED,
    )
    progress("virtual time: one process")
    alone = messages_per_s("one")
    report.add(f"{RELAYS} nodes on a full CAN bus, one process", f"{alone:,.0f} messages/s", "50,000/s", alone / 50_000)
    progress("virtual time: a process per device")
    each = messages_per_s("each")
    report.add(
        f"{RELAYS} nodes on a full CAN bus, one process per device",
        f"{each:,.0f} messages/s",
        "one process",
        each / alone,
    )
    progress("virtual time: the lab")
    start_s = time.perf_counter()
    with Rig(load(LAB, ["time=virtual"])) as rig:
        ready_s = time.perf_counter() - start_s
        rig.attach("master").link("can0").send(CanFrame(0, bytes([0x01, 0])))  # start all nodes
        rig.set("drive", "speed_set", 80)
        rig.set("drive", "run", True)
        wall_s, virtual_s = run_for_a_while(rig, S)
    report.add(
        "filling the tank of the lab", f"{virtual_s:,.0f} virtual s in {wall_s:.1f} s", "real time", virtual_s / wall_s
    )
    report.add("time from file to ready, lab", f"{ready_s:.3f} s", "0.3 s", ready_s / 0.3)
    return report


if __name__ == "__main__":
    print(run().markdown())
