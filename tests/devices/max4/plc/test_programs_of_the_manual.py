"""Programs of the manual run on the controller: the lamp, the division error, the endless loop, the enabled axis."""

import re
from pathlib import Path

import pytest
from plc_bench import PlcBench, task_of

START_MS = 92
"""Autostart (manual 4322)."""

LAMP = """
PROGRAM PowerIndicatorH1
VAR
  IState : INT := 1;
  IEndWaitTime : UDINT;
  IWaitTime : UDINT := 500;
END_VAR
CASE IState OF
  1: (* Initialisierung *)
    IEndWaitTime:=PacDriveM.Timer1+IWaitTime;
    IState:=IState+1;
  2: (* Ausgang HIGH setzen *)
    IF PacDriveM.Timer1 > IEndWaitTime THEN
      O_bBetriebsanzeigeH1.Value:= TRUE;
      IEndWaitTime:=PacDriveM.Timer1+IWaitTime;
      IState:=IState+1;
    END_IF;
  3: (* Ausgang LOW setzen *)
    IF PacDriveM.Timer1 > IEndWaitTime THEN
      O_bBetriebsanzeigeH1.Value:= FALSE;
      IEndWaitTime:=PacDriveM.Timer1+IWaitTime;
      IState:=2;
      (* Fehler *)
    END_IF;
END_CASE;
END_PROGRAM
"""
OUTPUTS = {"O_bBetriebsanzeigeH1": "panel.h1"}
TASK_1 = task_of("PowerIndicatorH1", 100, 31, "Task1")


@pytest.mark.manual("PD-229", "PD-081", "PD-083", "PD-024")
def test_the_lamp_changes_every_600_ms_because_its_task_runs_every_100_ms(tmp_path: Path) -> None:
    """Listing PD-L52: strictly longer than 500 ms, seen every 100 ms, so the period is 1.2 s and not 1 s."""
    bench = PlcBench(tmp_path, LAMP + TASK_1, outputs=OUTPUTS).run(2_000)
    assert bench.get("plc/task/Task1/priority") == 31
    assert bench.edges("panel.h1") == [
        (0, False), (START_MS + 600, True), (START_MS + 1_200, False), (START_MS + 1_800, True)
    ]  # fmt: skip


@pytest.mark.manual("PD-101", "PD-099", "PD-368")
def test_a_division_by_zero_stops_its_task_with_the_diagnosis_of_the_manual(tmp_path: Path) -> None:
    """Listing PD-L53: the same lamp with a division by 0 in state 3."""
    text = LAMP.replace("(* Fehler *)", "IEndWaitTime:=IEndWaitTime / IWaitTime0;").replace(
        "IWaitTime : UDINT := 500;", "IWaitTime : UDINT := 500; IWaitTime0 : UDINT;"
    )
    bench = PlcBench(tmp_path, text + TASK_1, outputs=OUTPUTS, err_wire="panel.err", language="en")
    bench.run(START_MS + 1_199)
    assert (bench.get("DiagCode"), bench.get("led.err")) == (0, "off")
    bench.run(20)
    line = text[: text.index("/ IWaitTime0")].count("\n") + 1
    assert bench.get("DiagCode") == 4190
    assert bench.get("DiagExtCode") == f"PowerIndicatorH1 {line}"
    assert bench.get("DiagMsg") == "IEC-TASK/Task1: Division error"
    assert bench.get("led.err") == "flashing"
    assert bench.edges("panel.err")[-1][1] is True
    assert bench.log()[0].split("\t")[2:] == [
        "0x0002", "IEC_TASK", "Task1", "4190", f"PowerIndicatorH1 {line}", "Division error"
    ]  # fmt: skip
    assert bench.get("plc/fault") == f"PowerIndicatorH1 (plc.st:{line})"
    assert (bench.state("Task1"), bench.get("plc/state")) == (6, "error")
    cycles = bench.get("cycles")
    bench.run(1_000)
    assert int(bench.get("cycles")) == int(cycles) + 250, "the controller goes on"
    bench.do("quit")
    assert bench.get("DiagCode") == 0
    assert bench.state("Task1") == 6
    bench.do("reset").do("start").run(1_000)
    assert bench.state("Task1") == 3


CALLED = """
FUNCTION Share : DINT
VAR_INPUT lAll, lParts : DINT; END_VAR
Share := lAll / lParts;
END_FUNCTION
FUNCTION_BLOCK Split
VAR_INPUT lParts : DINT; END_VAR
VAR_OUTPUT lShare : DINT; END_VAR
lShare := Share(100, lParts);
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR fbSplit : Split; END_VAR
fbSplit(lParts := 0);
END_PROGRAM
"""


@pytest.mark.manual("PD-101")
def test_the_call_hierarchy_ends_with_the_component_at_which_processing_stands(tmp_path: Path) -> None:
    bench = PlcBench(tmp_path, CALLED + task_of("PLC_PRG")).run(200)
    assert str(bench.get("plc/fault")).splitlines() == [
        "PLC_PRG (plc.st:13)", "Split (plc.st:9)", "Share (plc.st:4)"
    ]  # fmt: skip


@pytest.mark.manual("PD-102")
@pytest.mark.parametrize(
    ("declaration", "statement", "code"),
    [
        ("a : ARRAY[1..3] OF INT; i : INT := 4;", "a[i] := 1;", 4191),
        ("r : INT(1..3); i : INT := 4;", "r := i;", 4192),
        ("p : POINTER TO INT;", "p^ := 1;", 4193),
    ],
)
def test_run_time_faults_have_codes_of_their_own(tmp_path: Path, declaration: str, statement: str, code: int) -> None:
    text = f"PROGRAM PLC_PRG VAR {declaration} END_VAR\n{statement}\nEND_PROGRAM" + task_of("PLC_PRG")
    bench = PlcBench(tmp_path, text).run(200)
    assert bench.get("DiagCode") == code
    assert bench.get("DiagExtCode") == "PLC_PRG 2"


@pytest.mark.manual("PD-023", "PD-102")
@pytest.mark.parametrize("access", ["n := r.AxisState;", "r.ControllerEnable := TRUE;", "r.DiagQuit := TRUE;"])
def test_a_reference_to_no_object_is_an_invalid_pointer(tmp_path: Path, access: str) -> None:
    text = f"""
    FUNCTION_BLOCK Watch
    VAR_INPUT r : MC_4; END_VAR VAR n : UINT; END_VAR
    {access}
    END_FUNCTION_BLOCK
    PROGRAM PLC_PRG VAR fb : Watch; END_VAR fb(); END_PROGRAM""" + task_of("PLC_PRG")
    bench = PlcBench(tmp_path, text, simulated=("Axis_9",)).run(200)
    assert (bench.get("DiagCode"), bench.get("DiagExtCode")) == (4193, "Watch 4")


ENDLESS = """
PROGRAM Doubling
VAR iCounter : INT := 1; iVar : INT := 1; END_VAR
WHILE iCounter <> 0 DO
  iVar := iVar * 2;
END_WHILE;
END_PROGRAM
"""


@pytest.mark.manual("PD-073", "PD-074", "PD-075", "PD-071")
def test_an_endless_loop_gives_317_then_313_and_only_a_reset_ends_it(tmp_path: Path) -> None:
    """Listing PD-L26: the loop with a wrong condition."""
    bench = PlcBench(tmp_path, ENDLESS + task_of("Doubling", 10, 20), iec_tasks=["Task_1"], language="en")
    bench.run(START_MS + 10.2)
    assert (bench.get("DiagCode"), bench.get("Task_1.State")) == (0, 3)
    bench.run(0.8)
    assert bench.get("DiagCode") == 6317
    bench.run(88)
    assert bench.get("DiagCode") == 6317
    bench.run(3)
    assert bench.get("DiagCode") == 4313
    minor, serious = (line.split("\t") for line in bench.log()[1::-1])
    assert minor[3:6] == ["IEC_TASK", "T", "6317"]
    assert minor[7] == "cycle time transgression"
    assert serious[5] == "4313"
    assert re.fullmatch(r"Doubling \(plc\.st:[45]\)", str(bench.get("plc/fault")))
    assert serious[7] == "serious cycle time transgression"
    actual, _, configured = minor[6].partition("/")
    assert 10.25 < float(actual) < 11
    assert configured == "10"
    assert bench.get("Task_1.State") == 6
    bench.do("quit")
    assert bench.get("DiagCode") == 4313, "it is not quittable"
    bench.do("stop").do("start").run(50)
    assert bench.get("Task_1.State") == 6
    bench.do("reset")
    assert (bench.get("DiagCode"), bench.get("Task_1.State")) == (0, 1)


AXIS = """
FUNCTION_BLOCK Procedure
VAR_INPUT r_MC_4 : MC_4; END_VAR
VAR lDone : DINT := 99; END_VAR
lDone := ControllerEnableSet(r_MC_4.logAdr, TRUE); (* enable for MC-4 *)
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR fbProcedure : Procedure; lAddress : DINT; END_VAR
fbProcedure(r_MC_4 := Axis_10);
lAddress := _Axis_10;
END_PROGRAM
"""


@pytest.mark.manual("PD-023", "PD-025", "PD-227")
def test_a_block_enables_the_axis_that_it_received_by_reference(tmp_path: Path) -> None:
    """Listing PD-L50."""
    bench = PlcBench(tmp_path, AXIS + task_of("PLC_PRG"), simulated=("Axis_9", "Axis_10")).run(150)
    assert bench.value("PLC_PRG.fbProcedure.lDone") == 0
    assert bench.value("PLC_PRG.lAddress") == bench.get("Axis_10.logAdr")
    assert (bench.get("Axis_9.ControllerEnable"), bench.get("Axis_10.ControllerEnable")) == (False, True)
