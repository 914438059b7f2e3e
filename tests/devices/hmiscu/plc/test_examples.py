"""The manual's own examples of programs (acceptance cases SCU-A23 to SCU-A25 of the digest)."""

from pathlib import Path

import pytest
from hmiscu_device_bench import PTO, DeviceBench

TIMER = """
VAR_GLOBAL
    g_xRun, g_xOutput : BOOL;
    g_tElapsed : TIME;
END_VAR
PROGRAM PLC_PRG
VAR
    Timer_ON : TON;
    Preset : TIME := T#5S;
END_VAR
CALL
END_PROGRAM
"""
ST = "Timer_ON(IN := g_xRun, PT := Preset, Q => g_xOutput, ET => g_tElapsed);"
IL = "CAL Timer_ON(IN := g_xRun, PT := Preset, Q => g_xOutput, ET => g_tElapsed)"


@pytest.mark.long
@pytest.mark.parametrize("call", [ST, IL], ids=["ST", "IL"])
def test_a_timer_called_with_all_its_parameters(tmp_path: Path, call: str) -> None:
    bench = DeviceBench(tmp_path, TIMER.replace("CALL", call), channel_0=PTO)
    bench.set("g_xRun", True)
    bench.run(4_990)
    assert not bench.get("g_xOutput")
    bench.run(30)
    assert bench.get("g_xOutput")
    assert bench.get("g_tElapsed") == 5_000


FIRST_CYCLE = """
VAR_GLOBAL
    g_uFirst, g_uCycles : UINT;
END_VAR
PROGRAM PLC_PRG
VAR FirstCycle : BOOL; END_VAR
CALL
IF FirstCycle THEN g_uFirst := g_uFirst + 1; END_IF;
g_uCycles := g_uCycles + 1;
END_PROGRAM
"""


@pytest.mark.long
def test_the_first_cycle_after_each_start(tmp_path: Path) -> None:
    bench = DeviceBench(tmp_path, FIRST_CYCLE.replace("CALL", "FirstCycle := IsFirstMastCycle();"), channel_0=PTO)
    bench.run(100)
    assert (bench.get("g_uFirst"), bench.get("g_uCycles")) == (1, 11)
    bench.set("plc/command", "stop")
    bench.set("plc/command", "run")
    bench.run(100)
    assert bench.get("g_uFirst") == 2


DRIFT = """
VAR_GLOBAL
    g_iDrift : SINT := 5;
    g_eError : RTCDRIFT_ERROR;
    g_uHour : HOUR := 12;
END_VAR
PROGRAM PLC_PRG
VAR
    myDay : DAY_OF_WEEK := SUNDAY;
    myMinute : MINUTE;
END_VAR
CALL
END_PROGRAM
"""
DRIFT_ST = "g_eError := SetRTCDrift(g_iDrift, myDay, g_uHour, myMinute);"
DRIFT_IL = "LD g_iDrift\nSetRTCDrift myDay, g_uHour, myMinute\nST g_eError"


@pytest.mark.long
@pytest.mark.parametrize("call", [DRIFT_ST, DRIFT_IL], ids=["ST", "IL"])
def test_a_function_with_four_parameters(tmp_path: Path, call: str) -> None:
    bench = DeviceBench(tmp_path, DRIFT.replace("CALL", call), channel_0=PTO)
    bench.run(20)
    assert (bench.get("rtc.drift"), bench.get("g_eError")) == (5, 0)
    bench.set("g_iDrift", -30)
    bench.run(20)
    assert (bench.get("rtc.drift"), bench.get("g_eError")) == (5, 1)
    bench.set("g_iDrift", -29)
    bench.set("g_uHour", 24)
    bench.run(20)
    assert (bench.get("rtc.drift"), bench.get("g_eError")) == (5, 3)
