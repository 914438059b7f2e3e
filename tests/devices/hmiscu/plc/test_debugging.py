"""The debugging service of the controller: downloads, online changes, breakpoints, and points that stay valid."""

from pathlib import Path
from typing import Any

import pytest
from hmiscu_device_bench import PTO, DeviceBench

COUNTING = """
VAR_GLOBAL
    g_uCycles : UINT;
    g_uStep : UINT := 1;
END_VAR
PROGRAM PLC_PRG
g_uCycles := g_uCycles + g_uStep;
END_PROGRAM
"""
TWICE = COUNTING.replace("+ g_uStep", "+ 2 * g_uStep").replace("g_uStep : UINT", "g_uMore : DINT;\n    g_uStep : UINT")


def ask(bench: DeviceBench, command: str, **message: Any) -> Any:
    return bench.device.answer("debug", {"command": command, **message})


def download(bench: DeviceBench, text: str, *, is_online: bool = False) -> None:
    ask(bench, "part", file="program.st", text=text)
    ask(bench, "download", online=is_online)
    bench.run(1_000)


@pytest.fixture
def bench(tmp_path: Path) -> DeviceBench:
    bench = DeviceBench(tmp_path, COUNTING, channel_0=PTO)
    bench.run(95)
    return bench


@pytest.mark.long
def test_a_download_replaces_the_program_which_waits_for_its_start(bench: DeviceBench) -> None:
    point = bench.device.find("g_uCycles")
    assert point is not None
    assert point.read() == 10
    download(bench, TWICE)
    assert (bench.get("plc/state"), point.read()) == ("stop", 0)
    assert ask(bench, "start")["state"] == "running"
    bench.run(95)
    assert point.read() == bench.get("g_uCycles") == 20


@pytest.mark.long
def test_an_online_change_keeps_the_values(bench: DeviceBench) -> None:
    point = bench.device.find("g_uCycles")
    assert point is not None
    before = int(point.read())
    download(bench, TWICE, is_online=True)
    assert bench.get("plc/state") == "run"
    assert int(point.read()) > before + 100
    assert bench.get("g_uMore") == 0


@pytest.mark.long
def test_an_online_change_is_refused_while_a_task_is_at_a_breakpoint(bench: DeviceBench) -> None:
    ask(bench, "breakpoints", file="program.st", breakpoints=[{"line": 7}])
    bench.run(100)
    download(bench, TWICE, is_online=True)
    assert bench.get("plc/progress") == "waiting for the end of a cycle"
    bench.run(10_000)
    assert bench.get("plc/progress") == ""
    assert "some task was within a cycle" in str(bench.get("plc/problem"))


@pytest.mark.long
def test_a_program_with_a_mistake_leaves_the_present_one(bench: DeviceBench) -> None:
    download(bench, "PROGRAM PLC_PRG\nVAR END_VAR\nwrong := 1;\nEND_PROGRAM\n")
    assert bench.get("plc/state") == "run"
    assert "wrong is not declared" in str(bench.get("plc/problem"))


@pytest.mark.long
def test_a_breakpoint_stops_the_task_and_not_the_pulses(tmp_path: Path) -> None:
    program = """
VAR_GLOBAL g_bStart : BOOL; END_VAR
PROGRAM PLC_PRG
VAR Move : PTOMoveRelative; END_VAR
PTO00();
Move(PTO_REF_IN := PTO00.PTO_REF, Execute := g_bStart, Velocity := 1000, Distance := 1000, Acceleration := 20,
    Deceleration := 20);
END_PROGRAM
"""
    bench = DeviceBench(tmp_path, program, channel_0=PTO)
    bench.set("g_bStart", True)
    bench.run(100)
    ask(bench, "breakpoints", file="program.st", breakpoints=[{"line": 5}])
    bench.run(2_000)
    assert ask(bench, "state")["state"] == "paused"
    assert bench.get("PTO00.Position") == 1_000
    ask(bench, "breakpoints", file="program.st", breakpoints=[])
    ask(bench, "continue")
    bench.run(100)
    assert bench.get("PTO00.Distance") == 1_000


@pytest.mark.long
def test_a_reset_to_the_origin_leaves_no_program(bench: DeviceBench) -> None:
    point = bench.device.find("g_uCycles")
    assert point is not None
    assert point.write is not None
    ask(bench, "reset", kind="origin")
    assert (bench.get("plc/state"), point.read()) == ("stop", 0)
    with pytest.raises(ValueError, match="no variable g_uCycles any more"):
        point.write(1)
    with pytest.raises(ValueError, match="there is no program"):
        ask(bench, "start")


@pytest.mark.manual("SCU-063")
@pytest.mark.parametrize("is_online", [True, False])
def test_a_download_finds_an_open_reference_too(tmp_path: Path, is_online: bool) -> None:
    bench = DeviceBench(tmp_path, COUNTING, channel_0=PTO)
    download(
        bench,
        "PROGRAM PLC_PRG\nVAR Block : PTOStop; END_VAR\nBlock(Execute := TRUE);\nEND_PROGRAM",
        is_online=is_online,
    )
    assert "Block.PTO_REF_IN is open" in str(bench.get("plc/problem"))


@pytest.mark.long
@pytest.mark.parametrize("is_online", [True, False])
def test_breakpoints_stay_over_a_download(bench: DeviceBench, is_online: bool) -> None:
    text = COUNTING.replace("PROGRAM PLC_PRG", "PROGRAM PLC_PRG  (* as before *)")
    loads = ask(bench, "state")["loads"]
    ask(bench, "stop")
    ask(bench, "breakpoints", file="program.st", breakpoints=[{"line": 7}])
    download(bench, text, is_online=is_online)
    assert ask(bench, "state")["loads"] == loads + 1
    ask(bench, "start")
    bench.run(100)
    assert ask(bench, "state")["state"] == "paused"
