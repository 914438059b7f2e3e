"""Rigs of configs/ in virtual time, whole: simulated seconds in a second of CPU, and what an hour does to the memory.

Beside the packaging line runs the bare ring of its forty drives: the same drives with their motors and loads, a master
that only sets positions, and nothing else.  Both run in this process and take turns, window by window, so that
whatever else the computer does meets both.
"""

import gc
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import mean, stdev
from typing import Any

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from report import Report, progress  # noqa: E402  found beside this file
from rig_hands import CanMaster, ModbusClient  # noqa: E402

from fieldrig.clock import S  # noqa: E402
from fieldrig.config.rig_file import from_dict, load  # noqa: E402
from fieldrig.virtual.rig import Rig  # noqa: E402
from fieldrig_devices.max4.ring.drive_end import AT, MDT  # noqa: E402

CONFIGS = HERE.parents[1] / "configs"
LINE = CONFIGS / "packaging-line.yaml"
BOOT_NS = 10 * S
WINDOW_NS = 1 * S
WINDOWS = 20
SETTLING_NS = 2 * S
SPEED = 2_000_000
"""Increments per second: two turns."""
CAN_AXES = 8
"""Number of axes of each node."""
HOUR_S = 3600
"""Simulated."""


def bare_drives() -> dict[str, Any]:
    """The drives of the packaging line with nothing but their ring."""
    return {
        name: {"kind": "mc4", "links": {"ring": "ring"}, **_plain(entry.settings)}
        for name, entry in load(LINE, ["time=virtual"]).devices.items()
        if entry.kind == "mc4"
    }


def bare_ring(cam: int = 0) -> Rig:
    """The drives of the packaging line under a master that does nothing but move them.

    They have the speed `SPEED`, or go through cams of this height in increments at this mean speed.
    """
    drives = bare_drives()
    addresses = [drive["ring_address"] for drive in drives.values()]
    telegrams = {"mdt": [MDT["position"]], "at": AT, "cam": cam}
    master = {"kind": "ring_devices:Runner", "addresses": addresses, "cycle_us": 4_000, "speed": SPEED, **telegrams}
    rig = {
        "time": "virtual",
        "buses": {"ring": {"kind": "ring.virtual"}},
        "devices": {"master": {**master, "links": {"ring": "ring"}}, **drives},
    }
    running = Rig(from_dict(rig, HERE))
    while running.get("master", "moving") != len(drives):
        running.run_until(running.now_ns + S)
        assert running.now_ns < 60 * S, "the bare ring does not come up"
    running.run_until(running.now_ns + SETTLING_NS)
    return running


def _plain(settings: Any) -> dict[str, Any]:
    given: dict[str, Any] = settings.model_dump(mode="json", exclude_unset=True)
    return {key: value for key, value in given.items() if not key.endswith("_wire")}


def line() -> Rig:
    """The packaging line, booted: nothing is enabled."""
    rig = Rig(load(LINE, ["time=virtual"]))
    rig.run_until(BOOT_NS)
    assert rig.get("max4", "booted") is True
    return rig


def axes_of(rig: Rig) -> list[str]:
    return [name for name, entry in rig.config.devices.items() if entry.kind == "mc4"]


def holding() -> Rig:
    """All axes enabled, standing under control."""
    rig = line()
    client = ModbusClient(rig, "modbus")
    for place in range(len(axes_of(rig))):
        client.write(1000 + 100 * place, 1)
    rig.run_until(rig.now_ns + SETTLING_NS)
    _assert_speeds(rig, 0)
    return rig


def moving_by_modbus() -> Rig:
    """All axes at one speed, commanded by a Modbus client."""
    rig = holding()
    client = ModbusClient(rig, "modbus", member="client")
    for place in range(len(axes_of(rig))):  # a speed; -, -, accelerations, the speed in thousandths of a turn, start
        ramp = (0, 10_000, 0, 10_000)
        client.write(1001 + 100 * place, 1, 0, 0, 0, 10_000, *ramp, 0, SPEED // 1_000, 0, 1)
    rig.run_until(rig.now_ns + SETTLING_NS)
    _assert_speeds(rig, SPEED)
    return rig


def moving_by_can() -> Rig:
    """All axes at one speed by CiA 402, profile velocity; their nodes are operational, so that they send their PDOs."""
    rig = line()
    master = CanMaster(rig, "can0")
    nodes = rig.config.devices["max4"].settings.can_axes.node_ids  # type: ignore[attr-defined]
    for node in nodes:
        for axis in range(CAN_AXES):
            master.run_at(node, axis, SPEED)
    master.start_all()
    rig.run_until(rig.now_ns + SETTLING_NS)
    _assert_speeds(rig, SPEED)
    return rig


def _assert_speeds(rig: Rig, wanted: int) -> None:
    for name in axes_of(rig):
        speed = float(rig.get(name, "speed")) * 1_000_000 / 60
        assert abs(speed - wanted) <= 0.02 * SPEED, f"{name} runs at {speed:.0f} increments/s instead of {wanted}"


def _cpu_s(rig: Rig) -> float:
    """Return the CPU time of one window."""
    begin_s = time.process_time()
    rig.run_until(rig.now_ns + WINDOW_NS)
    return time.process_time() - begin_s


def in_turn(rigs: dict[str, Rig], windows: int = WINDOWS) -> dict[str, list[float]]:
    """Simulated seconds in a second of CPU of each window; the rigs take turns."""
    found: dict[str, list[float]] = {name: [] for name in rigs}
    for rig in rigs.values():
        _cpu_s(rig)
    for _ in range(windows):
        for name, rig in rigs.items():
            found[name].append(WINDOW_NS / S / _cpu_s(rig))
    return found


BARE = "the bare ring of its 40 drives, all moving"
RIGS: dict[str, Callable[[], Rig]] = {
    BARE: bare_ring,
    "the line, nothing enabled": line,
    "the line, all axes held": holding,
    "the line, all axes moving, by Modbus": moving_by_modbus,
    "the line, all axes moving, by CiA 402 on CAN": moving_by_can,
}


def hour() -> tuple[tuple[int, float], tuple[int, float]]:
    """The objects and memory of the process while all axes move: a minute after the start, and an hour later."""
    rig = moving_by_modbus()
    rig.run_until(rig.now_ns + 60 * S)
    before = held()
    rig.run_until(rig.now_ns + HOUR_S * S)
    return before, held()


def held() -> tuple[int, float]:
    """Objects, and MB of resident memory."""
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1])
    return len(gc.get_objects()), pages * resource.getpagesize() / 2**20


def run() -> Report:
    report = Report(
        "Packaging line in virtual time",
        f"This table compares `configs/packaging-line.yaml` with the bare ring of its forty drives and the same"
        f" telegrams. They take turns in one process: {WINDOWS} windows of {WINDOW_NS // S} simulated s each, mean and"
        " standard deviation. Ratios compare the windows of one turn.",
        ("rig", "simulated s per second of CPU time", "ratio to the bare ring"),
    )
    rigs: dict[str, Rig] = {}
    for name, make in RIGS.items():
        progress(f"packaging line: {name}")
        rigs[name] = make()
    found = in_turn(rigs)
    for name, speeds in found.items():
        ratios = [a / b for a, b in zip(speeds, found[BARE], strict=True)]
        report.add(name, f"{mean(speeds):.1f} ± {stdev(speeds):.1f}", f"{mean(ratios):.2f} ± {stdev(ratios):.2f}")
    rigs.clear()
    progress("packaging line: an hour")
    before, after = hour()
    report.notes.append(
        f"an hour of simulated time with all axes moving: {before[0]:,} objects and {before[1]:.1f} MB before it,"
        f" {after[0]:,} objects and {after[1]:.1f} MB after it"
    )
    return report


if __name__ == "__main__":
    print(run().markdown())
