"""A whole ARP card: two axes, PST, six cams, six events and a program that never rests, at a control loop of 1 ms.

In virtual time against the wall, on one core; and in real time, where the card itself counts the loops that a
busy host has skipped.
"""

import json
import tempfile
import time
from pathlib import Path
from typing import Any

from report import COMPARED, Report, progress
from running_rig import RunningRig, until

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig

WALL_S = 3.0
REAL_S = 10.0

PROGRAM = """\
BEG BUSY
@PAR2[4] == 1
@PAR1[4] == {kind}
V10 == 3
V11 == 0
V12 == 0
V13 == 5000
V14 == 5000
V15 == 10000
V16 == 0
V20 == 2500
CAM1 1, 100, 1000, O101
CAM2 1, 1000, 100, O102
CAM3 1, 2000, 3000, !O103
CAM4 2, 1000, 9000, O104
CAM5 2, 9000, 1000, F100
CAM6 2, 4000, 6000, F101
SET F1
ON1 F1 & /F100 WENT
ON2 F1 & \\F100 CAME
ON3 F1 & /F101 WENT
ON4 F1 & \\I101 CAME
ON5 F2 & 1 > V20 WENT
ON6 F1 & /I102 CAME
WAIT 0.1
PST 2, 1, V10
LOOP:
V1 += 1
V2 == @POS1 * 0.5 + V1
IF V2 > 100000, V1 == 0
V3 == V2 & H00FF
IF F292 = LO, LOOP
IF V4 = 0, BACK
V4 == 0
PAC 2, 10000
GOTO LOOP
BACK:
V4 == 1
PAC 2, 0
GOTO LOOP
END
BEGA WENT
V5 += 1
ENDA
BEGA CAME
V6 += 1
ENDA
"""
SIMULATED, CONTROLLED = 1, 2
SLAVE = {1: 8, 7: 6000, 8: 50000, 11: 0.251, 13: 0.005, 14: 5000, 24: 5000, 25: 50}
"""8 counts a unit, so that the servo's 40000 counts are 5000 units."""
CARD: dict[str, Any] = {
    "kind": "arp",
    "links": {"wires": "wires"},
    "inputs": {"I108": True},
    "parameters": {"general": {1: 1, 16: 20}, "axis1": SLAVE, "axis2": {7: 5000, 8: 50000}},
    "signals": {"dac1": "servo.reference", "encoder1": "servo.encoder"},
}
SERVO: dict[str, Any] = {
    "kind": "plant.servo",
    "links": {"wires": "wires"},
    "rated_torque_nm": 1.0,
    "motor_inertia_kg_m2": 0.002,
    "encoder_lines": 10_000,
}


def rig_of(time_: str, folder: Path, kind: int, *, has_servo: bool) -> dict[str, Any]:
    program = folder / f"busy{kind}.I01"
    program.write_text(PROGRAM.format(kind=kind))
    devices = {"card1": {**CARD, "program": program.name}} | ({"servo": SERVO} if has_servo else {})
    if time_ == "real":
        for device in devices.values():
            device["process"] = "wires"
    return {
        "time": time_,
        "buses": {"wires": {"kind": f"wires.{'hub' if time_ == 'real' else 'virtual'}"}},
        "devices": devices,
    }


def virtual(folder: Path, kind: int, *, has_servo: bool) -> float:
    """Times real time."""
    with Rig(from_dict(rig_of("virtual", folder, kind, has_servo=has_servo), folder)) as rig:
        rig.run_until(2 * S)
        assert rig.get("card1", "state") == "run", rig.get("card1", "state")
        assert rig.get("card1", "F261"), "the slave is in the cam"
        start_s, start_ns = time.perf_counter(), rig.now_ns
        while (spent_s := time.perf_counter() - start_s) < WALL_S:
            rig.run_until(rig.now_ns + 500 * MS)
        assert rig.get("card1", "F261"), "the slave has stayed in the cam"
        assert rig.get("card1", "error") == 0
        return (rig.now_ns - start_ns) / S / spent_s


def real(folder: Path) -> tuple[int, int]:
    """Control loops, and those that the card has missed."""
    file = folder / "card.json"
    file.write_text(json.dumps(rig_of("real", folder, CONTROLLED, has_servo=True)))
    with RunningRig(file, None) as rig:
        rig.until_ready()
        until(lambda: bool(rig.json("get", "card1/F261")["card1/F261"]))
        before = rig.json("get", "card1/cycles", "card1/missed_cycles")
        time.sleep(REAL_S)
        after = rig.json("get", "card1/cycles", "card1/missed_cycles")
    loops, missed = (int(after[key]) - int(before[key]) for key in ("card1/cycles", "card1/missed_cycles"))
    return loops, missed


def run() -> Report:
    report = Report(
        "ARP card",
        "This table shows the speed of a card with a control loop of 1 ms, two axes, PST, six cams, six events and a"
        " program that fills its slices.",
        COMPARED,
    )
    with tempfile.TemporaryDirectory(prefix="arp") as name:
        folder = Path(name)
        progress("ARP card: virtual time, both axes simulated")
        times = virtual(folder, SIMULATED, has_servo=False)
        report.add("virtual time, both axes simulated", f"{times:.1f} times real time", "20 times", times / 20)
        progress("ARP card: virtual time, slave on a servo")
        times = virtual(folder, CONTROLLED, has_servo=True)
        report.add(
            "virtual time, slave axis as a servo on wires", f"{times:.1f} times real time", "20 times", times / 20
        )
        progress("ARP card: real time")
        loops, missed = real(folder)
        report.add(
            f"real time, card and servo in one process, {REAL_S:g} s",
            f"{loops:,} loops, {missed} missed",
            "every loop in time",
            loops / (loops + missed),
        )
    return report


if __name__ == "__main__":
    print(run().markdown())
