"""The single CiA 402 drive: steps a second against the axis of a MAx-4, and 32 drives in CSP with a SYNC of 1 ms."""

import sys
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from report import COMPARED, Report, progress  # noqa: E402  found beside this file
from running_rig import RunningRig  # noqa: E402

from fieldrig.clock import MS, S  # noqa: E402
from fieldrig.config.rig_file import from_dict  # noqa: E402
from fieldrig.virtual.rig import Rig  # noqa: E402
from fieldrig_bus.can.frame import CanFrame  # noqa: E402

WALL_S = 2.0
BUSES, DRIVES = 8, 4
"""A bus of 1 Mbit/s carries the set-points and answers of four drives in a millisecond, and no more."""
REAL_S = 5.0
PLATE = str(HERE.parents[1] / "configs/plates/sm-100-30-080.yaml")
NODE = 3
SPEED = 5_000_000
CYCLE_OF_DRIVE_NS, CYCLE_OF_RING_NS = MS, 4 * MS


def rig_of(device: dict[str, Any], buses: dict[str, Any], more: dict[str, Any]) -> dict[str, Any]:
    can = {"can0": {"kind": "can.virtual", "bitrate": 1_000_000}}
    return {"time": "virtual", "buses": can | buses, "devices": {"axis": device, **more}}


def single_drive() -> dict[str, Any]:
    return rig_of({"kind": "cia402.drive", "node_id": NODE, "links": {"can": "can0"}}, {}, {})


def axis_of_a_max4() -> dict[str, Any]:
    links = {"can": "can0", "ring": "ring"}
    drives = {"belt": {"ring_address": 1}}
    max4 = {"kind": "max4", "links": links, "drives": drives, "can_axes": {"node_ids": [NODE]}}
    mc4 = {"kind": "mc4", "ring_address": 1, "motor": {"name_plate": PLATE}, "links": {"ring": "ring"}}
    return rig_of(max4, {"ring": {"kind": "ring.virtual"}}, {"belt": mc4})


def steps_per_s(content: dict[str, Any], boot_ns: int, cycle_ns: int) -> float:
    """Steps of an axis per second of wall time, while it turns at a constant speed and a SYNC comes every 10 ms."""
    with Rig(from_dict(content)) as rig:
        can = rig.attach("master").link("can0")
        rig.run_until(boot_ns)
        can.send(CanFrame(0x000, bytes((1, NODE))))
        for head, value in (
            ("2f 60 60 00", 3), ("23 ff 60 00", SPEED),
            ("2b 40 60 00", 0x06), ("2b 40 60 00", 0x07), ("2b 40 60 00", 0x0F),
        ):  # fmt: skip
            can.send(CanFrame(0x600 + NODE, bytes.fromhex(head) + value.to_bytes(4, "little")))
            rig.run_until(rig.now_ns + 200 * MS)
        rig.run_until(rig.now_ns + 2 * S)
        begin_ns, begin_s = rig.now_ns, time.perf_counter()
        while (wall_s := time.perf_counter() - begin_s) < WALL_S:
            can.send(CanFrame(0x080, b""))
            rig.run_until(rig.now_ns + 10 * MS)
        return (rig.now_ns - begin_ns) / cycle_ns / wall_s


def cells(time_of: str, kind: str) -> dict[str, Any]:
    """Eight buses with four drives and a master each; every cell is one process in real time."""
    off = 0x8000_0000  # TPDOs besides TPDO 3, for which the bus has no room
    objects = {"6060:00": 8, "1402:02": 1, "1800:01": off, "1801:01": off, "1803:01": off}
    content: dict[str, Any] = {"time": time_of, "buses": {}, "devices": {}}
    for cell in range(BUSES):
        bus, process = f"can{cell}", {"process": f"cell{cell}"} if time_of == "real" else {}
        content["buses"][bus] = {"kind": kind, "bitrate": 1_000_000, **process}
        for node in range(1, DRIVES + 1):
            content["devices"][f"axis{cell}{node}"] = {
                "kind": "cia402.drive", "node_id": node, "links": {"can": bus}, "objects": objects, **process,
            }  # fmt: skip
        content["devices"][f"master{cell}"] = {
            "kind": "bench_kinds:CspMaster", "first": 1, "drives": DRIVES, "links": {"can": bus}, **process,
        }  # fmt: skip
    return content


def csp_in_virtual_time() -> tuple[float, float]:
    """Virtual seconds per second of wall time, and the share of cycles that were kept."""
    with Rig(from_dict(cells("virtual", "can.virtual"), HERE)) as rig:
        rig.run_until(2 * S)
        begin_ns, begin_s = rig.now_ns, time.perf_counter()
        while (wall_s := time.perf_counter() - begin_s) < WALL_S:
            rig.run_until(rig.now_ns + 10 * MS)
        masters = [f"master{cell}" for cell in range(BUSES)]
        kept = sum(int(rig.get(name, "kept")) for name in masters)
        cycles = sum(int(rig.get(name, "cycles")) - 1 for name in masters)
        return (rig.now_ns - begin_ns) / S / wall_s, kept / cycles


def csp_in_real_time() -> float:
    """The share of cycles that all drives kept."""
    import json

    with RunningRig(json.dumps(cells("real", "can.hub")), HERE / "bench_kinds.py") as rig:
        rig.until_ready()
        time.sleep(2)
        before = _counts(rig)
        time.sleep(REAL_S)
        after = _counts(rig)
        return (after[1] - before[1]) / (after[0] - before[0])


def _counts(rig: RunningRig) -> tuple[int, int]:
    values = [(rig.value(f"master{cell}/cycles"), rig.value(f"master{cell}/kept")) for cell in range(BUSES)]
    return sum(int(cycles) for cycles, _ in values), sum(int(kept) for _, kept in values)


def run() -> Report:
    report = Report(
        "CiA 402 drive",
        "This table shows how fast a single drive computes its cycles at a constant speed, and how "
        f"{BUSES * DRIVES} of them in cyclic synchronous position follow a SYNC of 1 ms, on {BUSES} buses of 1 Mbit/s.",
        COMPARED,
    )
    progress("single drive: steps")
    own = steps_per_s(single_drive(), 100 * MS, CYCLE_OF_DRIVE_NS)
    progress("axis of a MAx-4: steps")
    other = steps_per_s(axis_of_a_max4(), 10 * S, CYCLE_OF_RING_NS)
    report.add(
        "cycles of 1 ms of a drive in virtual time", f"{own:,.0f}/s", f"an axis of a MAx-4 {other:,.0f}/s", own / other
    )
    progress("32 drives in virtual time")
    speed, kept = csp_in_virtual_time()
    report.add(f"{BUSES * DRIVES} drives in CSP, virtual time", f"{speed:.2f} virtual s per s", "real time", speed)
    report.add("cycles kept of these", f"{100 * kept:.2f} %", "all", kept)
    progress("32 drives in real time")
    kept = csp_in_real_time()
    report.add(f"{BUSES * DRIVES} drives in CSP, real time: cycles kept", f"{100 * kept:.1f} %", "all", kept)
    report.notes.append(
        "the axis of a MAx-4 has cycles of 4 ms, with its controller, its ring and its drive in the rig"
    )
    return report


if __name__ == "__main__":
    print(run().markdown())
