"""A MAx-4 with a large IEC program: ten tasks, and the forty axes of the packaging line on cams.

In virtual time beside the bare ring of the same drives (`shipped_rigs`): both run in this process and take turns.  In
real time `configs/conveyor.yaml` shows how many cycles of its ring and of its tasks are kept, and what the program
takes of the processor.
"""

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import mean, stdev

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from report import Report, progress  # noqa: E402  found beside this file
from running_rig import RunningRig, until  # noqa: E402
from shipped_rigs import BOOT_NS, SETTLING_NS, WINDOW_NS, WINDOWS, bare_drives, bare_ring, in_turn  # noqa: E402

from fieldrig.clock import S  # noqa: E402
from fieldrig.config.rig_file import from_dict  # noqa: E402
from fieldrig.control.messages import Client  # noqa: E402
from fieldrig.virtual.rig import Rig  # noqa: E402

EDS = HERE.parents[1] / "configs/eds/io32.eds"
CONVEYOR = HERE.parents[1] / "configs/conveyor.yaml"
INTERVALS_MS = (1, 2, 5, 10, 10, 20, 20, 50, 50, 100)
STATIONS = 16
"""Number of stations that each task looks after."""
STATEMENTS = 290
"""Number of statements in a cycle of a task: 13 of the program and 5 of its timer for each station."""
MOTION_MS = 10
"""The first task with this interval also gives the axes their cams."""
PART, SPEED, FEED = 200.0, 200.0, 100.0
"""Length and height of a cam, speed of the master, and units in a turn of a motor: two turns a second on average."""
REAL_S = 20.0
CYCLE_MS = 4

BLOCKS = """
VAR_GLOBAL
    g_bMotion : BOOL;
    g_lCams : DINT;
    g_lDone : ARRAY[0..9] OF DINT;
END_VAR

(* One station: a state machine with a waiting time, a filtered measurement, and counters. *)
FUNCTION_BLOCK Station
VAR_INPUT
    bEnable, bSensor : BOOL;
    rTarget : REAL;
END_VAR
VAR_OUTPUT
    bDone, bAlarm : BOOL;
END_VAR
VAR
    iState : INT;
    tonWait : TON;
    rLevel, rFiltered : REAL;
    lCount, lMissed : DINT;
    wStatus : WORD;
    bLast, bEdge : BOOL;
END_VAR
bEdge := bSensor AND NOT bLast;
bLast := bSensor;
rFiltered := rFiltered + (rLevel - rFiltered) * 0.125;
bAlarm := bAlarm AND bEnable OR rFiltered > 2.0 * rTarget;
tonWait(IN := iState = 2, PT := T#20ms);
CASE iState OF
0:
    bDone := FALSE;
    IF bEnable AND NOT bAlarm THEN
        iState := 1;
    END_IF;
1:
    rLevel := rLevel + (rTarget - rLevel) * 0.25;
    IF ABS(rTarget - rLevel) < 0.5 THEN
        iState := 2;
    END_IF;
2:
    IF tonWait.Q THEN
        lCount := lCount + 1;
        rLevel := 0.0;
        bDone := TRUE;
        iState := 0;
    ELSIF bEdge THEN
        lMissed := lMissed + 1;
    END_IF;
END_CASE;
wStatus := (wStatus AND 16#FF00) OR INT_TO_WORD(iState);
IF bDone THEN
    wStatus := wStatus OR 16#0010;
END_IF;
END_FUNCTION_BLOCK
"""

STATIONS_TEXT = """
PROGRAM Machine{number}
VAR
    stations : ARRAY[0..{last}] OF Station;
    i : INT;
    lDone : DINT;
    bClock : BOOL;
END_VAR
bClock := NOT bClock;
lDone := 0;
FOR i := 0 TO {last} DO
    stations[i](bEnable := g_bMotion, bSensor := bClock, rTarget := 10.0);
    IF stations[i].bDone THEN
        lDone := lDone + 1;
    END_IF;
END_FOR;
g_lDone[{number}] := g_lDone[{number}] + lDone;
END_PROGRAM
"""

MOTION_TEXT = """
PROGRAM Motion
VAR
    {cams} : MultiCam3;
    last : CAM;
    axes : ARRAY[0..{most}] OF DINT := {addresses};
    iState, i : INT;
    lProfil : DINT;
    lrHeight : LREAL := {height};
END_VAR
CASE iState OF
0:
    lProfil := ProfilLoad('inclsin');
    FOR i := 0 TO {most} DO
        ControllerEnableSet(axes[i]);
    END_FOR;
    iState := 1;
1:
    {calls}
    last(lAxisId := {last}, lEncId := _MasterEncoder, lProfilId := lProfil,
        lrXFactor := {part}, lrYFactor := lrHeight, lrXLimMax := {part}, bXLimMaxOn := TRUE, bXLimMinOn := TRUE,
        iXSetposMode := ABSOLUTE, iYSetposMode := ABSOLUTE, bReset := last.lResult = 0);
    IF last.lResult = 0 THEN
        g_lCams := g_lCams + 1;
    END_IF;
    IF NOT g_bMotion AND {active} THEN
        MasterEncoder.Velocity := {speed};
        g_bMotion := TRUE;
    END_IF;
END_CASE;
END_PROGRAM
"""
CALL = """{name}(lEncId := _MasterEncoder, lrXFactor := {part},
        lAxisId1 := {first}, lProfilId1 := lProfil, lrYFactor1 := lrHeight,
        lAxisId2 := {second}, lProfilId2 := lProfil, lrYFactor2 := lrHeight,
        lAxisId3 := {third}, lProfilId3 := lProfil, lrYFactor3 := lrHeight, bReset := {name}.lResult = 0);"""


def program_of(axes: list[str]) -> str:
    """Return the program: the stations of each task, the cams of all axes, and the tasks."""
    threes = [axes[place : place + 3] for place in range(0, len(axes) - 1, 3)]
    names = [f"cams{number}" for number in range(len(threes))]
    calls = [
        CALL.format(name=name, part=PART, first=f"_{one}", second=f"_{two}", third=f"_{three}")
        for name, (one, two, three) in zip(names, threes, strict=True)
    ]
    motion = MOTION_TEXT.format(
        cams=", ".join(names),
        most=len(axes) - 1,
        addresses=", ".join(f"_{axis}" for axis in axes),
        active=" AND ".join(f"{name}.bActive" for name in [*names, "last"]),
        calls="\n    ".join(calls),
        last=f"_{axes[-1]}",
        part=PART,
        speed=SPEED,
        height=PART,
    )
    groups = "".join(STATIONS_TEXT.format(number=number, last=STATIONS - 1) for number in range(len(INTERVALS_MS)))
    tasks, runs = [], []
    for number, interval_ms in enumerate(INTERVALS_MS):
        tasks.append(f"TASK Task{number}(INTERVAL := T#{interval_ms}ms, PRIORITY := {number + 8});")
        runs.append(f"PROGRAM P{number} WITH Task{number} : Machine{number};")
    runs.append(f"PROGRAM PMotion WITH Task{INTERVALS_MS.index(MOTION_MS)} : Motion;")
    configuration = "\n".join(
        ["CONFIGURATION c", "RESOURCE r ON PLC", *tasks, *runs, "END_RESOURCE", "END_CONFIGURATION"]
    )
    return BLOCKS + groups + motion + configuration + "\n"


def on_cams() -> Rig:
    """The drives of the packaging line on a MAx-4, all on cams of its program."""
    drives = bare_drives()
    with tempfile.TemporaryDirectory(prefix="plc") as folder:
        program = Path(folder) / "line.st"
        program.write_text(program_of(list(drives)), encoding="ascii")
        controller = {
            "kind": "max4",
            "links": {"ring": "ring", "can": "can", "modbus": "modbus", "wires": "wires"},
            "cycle_ms": 4,
            "drives": {name: {"ring_address": drive["ring_address"]} for name, drive in drives.items()},
            "parameters": {f"{name}.FeedConst": FEED for name in drives},
            "can_axes": {"node_ids": [1, 2, 3, 4, 5]},
            "logic_encoders": ["MasterEncoder"],
            "program": str(program),
            "autostart": True,
        }
        kinds = {"ring": "ring.virtual", "can": "can.virtual", "modbus": "modbus.virtual", "wires": "wires.virtual"}
        panel = {"kind": "canopen.node", "node_id": 20, "eds": str(EDS), "links": {"can": "can", "wires": "wires"}}
        buses = {name: {"kind": kind} for name, kind in kinds.items()}
        devices = {"max4": controller, "panel": panel, **drives}
        rig = Rig(from_dict({"time": "virtual", "buses": buses, "devices": devices}, HERE))
        rig.run_until(BOOT_NS)
    while rig.get("max4", "ring.state") != "up" or not rig.get("max4", "MasterEncoder.Velocity"):
        rig.run_until(rig.now_ns + S)
        assert rig.now_ns < 60 * S, "the cams do not begin"
    rig.run_until(rig.now_ns + SETTLING_NS)
    assert rig.get("max4", "plc/state") == "running", rig.get("max4", "plc/fault")
    return rig


def virtual(report: Report) -> None:
    """Add the rows in virtual time."""
    rigs: dict[str, Rig] = {}
    for name, make in RIGS.items():
        progress(f"program on the ring: {name}")
        rigs[name] = make()
    controller = rigs[ON_CAMS]
    loads = [int(controller.get("max4", f"plc/task/Task{number}/cpu")) for number in range(len(INTERVALS_MS))]
    found = in_turn(rigs)
    for name, speeds in found.items():
        ratios = [a / b for a, b in zip(speeds, found[SAME_MOTION], strict=True)]
        report.add(name, f"{mean(speeds):.1f} ± {stdev(speeds):.1f}", f"{mean(ratios):.2f} ± {stdev(ratios):.2f}")
    cycles = [f"{interval_ms} ms: {used / 1000:,.0f} ms" for interval_ms, used in zip(INTERVALS_MS, loads, strict=True)]
    report.notes.append(f"processor time of the emulated controller since its boot by task: {', '.join(cycles)}")
    assert controller.get("max4", "plc/state") == "running"
    assert controller.get("max4", "DiagCode") == 0


def real(report: Report) -> None:
    """Add what `configs/conveyor.yaml` keeps in real time, while its belt runs."""
    with RunningRig(CONVEYOR, None) as rig:
        rig.until_ready()
        until(lambda: bool(rig.value("max4/booted")))
        assert rig.tool("set", "panel/6200:01=3").returncode == 0  # switch S1
        until(lambda: float(rig.value("line/speed")) > 0.2)
        before, cpu_s = rig.json("get", *WATCHED), _cpu_s(rig)
        time.sleep(REAL_S)
        after, cpu_s = rig.json("get", *WATCHED), _cpu_s(rig) - cpu_s
    gone = {point: int(after[point]) - int(before[point]) for point in WATCHED}
    cycles, missed = gone["max4/cycles"], gone["max4/missed_cycles"]
    spent_s = (cycles + missed) * CYCLE_MS / 1000
    report.notes.append(
        f"in real time, `configs/conveyor.yaml` with four drives: {cycles:,} cycles of {CYCLE_MS} ms kept and"
        f" {missed:,} missed; the process of the controller took {100 * cpu_s / spent_s:.0f} % of a core"
    )
    for task, interval_ms in CONVEYOR_TASKS.items():
        ran, used_us = gone[f"max4/plc/task/{task}/cycles"], gone[f"max4/plc/task/{task}/cpu"]
        report.notes.append(
            f"its task {task} of {interval_ms} ms: {ran:,} of {spent_s * 1000 / interval_ms:,.0f} cycles,"
            f" {used_us / max(ran, 1):,.0f} us of the emulated processor in each"
        )


def _cpu_s(rig: RunningRig) -> float:
    with Client(rig.endpoint) as client:
        return float(client.ask("process/max4/status")["cpu_s"])


CONVEYOR_TASKS = {"Positioning": 10, "Task1": 100}
"""Tasks of `configs/conveyor.yaml` with their intervals in ms."""
WATCHED = (
    "max4/cycles",
    "max4/missed_cycles",
    *(f"max4/plc/task/{task}/{what}" for task in CONVEYOR_TASKS for what in ("cycles", "cpu")),
)
SAME_MOTION = "the bare ring, its drives moved through the same cams"
ON_CAMS = "a MAx-4 with ten tasks, all axes on cams"
RIGS: dict[str, Callable[[], Rig]] = {
    "the bare ring, its drives at one speed": bare_ring,
    SAME_MOTION: lambda: bare_ring(round(PART / FEED * 1_000_000)),
    ON_CAMS: on_cams,
}


def run() -> Report:
    report = Report(
        "A program on a ring of 40 drives",
        "This table compares a MAx-4, whose program moves the forty drives of the packaging line through cams, with the"
        " bare ring of the same drives: its master only sends set positions, through the same cams or at one speed."
        f" The program has ten tasks with intervals of {', '.join(map(str, INTERVALS_MS))} ms, which execute about"
        f" {STATEMENTS} statements in each cycle. The rigs take turns in one process: {WINDOWS} windows of"
        f" {WINDOW_NS // S} simulated s each, mean and standard deviation. Ratios compare the windows of one turn.",
        ("rig", "simulated s per second of CPU time", "ratio to the same motion, at least 0.4"),
    )
    virtual(report)
    progress("program on the ring: real time")
    real(report)
    return report


if __name__ == "__main__":
    print(run().markdown())
