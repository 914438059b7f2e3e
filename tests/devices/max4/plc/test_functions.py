"""Functions of the controller that programs call."""

from pathlib import Path

import pytest
from plc_bench import PlcBench, task_of


def once(declarations: str, statements: str, ms: float = 10_000) -> str:
    """A program that runs the statements in its first cycle."""
    return f"""
    PROGRAM PLC_PRG
    VAR bDone : BOOL; {declarations} END_VAR
    IF NOT bDone THEN {statements} bDone := TRUE; END_IF;
    END_PROGRAM
    """ + task_of("PLC_PRG", ms, 20)


@pytest.mark.manual("PD-119")
def test_a_program_saves_resets_and_deletes_the_log(tmp_path: Path) -> None:
    text = once(
        "a, b, c, d : DINT := 9; bNow : BOOL;",
        "a := MsgLogSave('RUN1.LOG'); b := MsgLogReset(); "
        "c := MsgLogSave('\\run2.log'); d := MsgLogDelete('RUN1.LOG');",
    )
    bench = PlcBench(tmp_path, text).run(1_500)
    assert [bench.value(f"PLC_PRG.{name}") for name in "abcd"] == [0, 0, 0, 0]
    assert "\\RUN2.LOG" in bench.max4.firmware.disk.names
    assert "\\RUN1.LOG" not in bench.max4.firmware.disk.names
    lines = bench.max4.firmware.disk.read("\\RUN2.LOG").decode()
    assert "8004" not in lines, "it was saved after the reset"


@pytest.mark.manual("PD-119")
def test_the_log_is_saved_and_deleted_as_the_manual_prints_it(tmp_path: Path) -> None:
    """Table 6-2: MsgLogSave(), MsgLogReset(), MsgLogDelete()."""
    bench = PlcBench(tmp_path, once("", "MsgLogSave(); MsgLogReset();")).run(600)
    assert b"8004" in bench.max4.firmware.disk.read("\\MSG.LOG")
    bench = PlcBench(tmp_path, once("", "MsgLogSave(); MsgLogDelete();")).run(1_500)
    assert "\\MSG.LOG" not in bench.max4.firmware.disk.names


@pytest.mark.manual("PD-201")
@pytest.mark.manual("PD-119", "PD-117")
def test_a_program_inserts_entries_into_the_log(tmp_path: Path) -> None:
    text = once("a : DINT := 9;", "a := MsgLogInsert(16#0004, 4711, 'lane 3', 'film torn');")
    bench = PlcBench(tmp_path, text).run(110)
    assert bench.log()[0].split("\t")[1:] == ["98", "0x0001", "MAX4", "MAX4", "8003", "", "Max4-Boot beendet"]
    line = next(line for line in bench.log() if "film torn" in line)
    assert line.split("\t")[1:] == ["92", "0x0004", "IEC_TASK", "T", "4711", "lane 3", "film torn"]


@pytest.mark.manual("PD-201", "PD-025")
def test_an_axis_is_enabled_and_disabled_by_its_logical_address(tmp_path: Path) -> None:
    """Manual 3072: ControllerEnableSet(r_MC_4.logAdr) is the enable."""
    text = once("a, b, c, d : DINT := 9; bOn, bOff : BOOL;", "a := ControllerEnableSet(_belt); bOn := "
                "belt.ControllerEnable; b := ControllerEnableSet(belt.logAdr, FALSE); bOff := belt.ControllerEnable;"
                "c := ControllerEnableSet(_belt, TRUE); d := ControllerEnableSet(_belt + 1);")  # fmt: skip
    bench = PlcBench(tmp_path, text, simulated=("belt",)).run(150)
    assert [bench.value(f"PLC_PRG.{name}") for name in "abcd"] == [0, 0, 0, -1]
    assert (bench.value("PLC_PRG.bOn"), bench.value("PLC_PRG.bOff")) == (True, False)
    assert bench.get("belt.ControllerEnable") is True


@pytest.mark.manual("PD-080")
def test_multicam_takes_12_us(tmp_path: Path) -> None:
    def cpu_us(call: str) -> int:
        text = f"PROGRAM PLC_PRG VAR fb : MultiCam3; i : INT; END_VAR\nFOR i := 1 TO 100 DO {call} END_FOR\nEND_PROGRAM"
        bench = PlcBench(tmp_path, text + task_of("PLC_PRG", 10_000, 0)).run(200)
        return int(bench.get("plc/task/T/cpu"))

    assert 1_200 <= cpu_us("fb(bReset := FALSE);") - cpu_us(";") <= 1_250  # 100 times, with the calls themselves


@pytest.mark.manual("PD-080")
def test_append_to_write_file_holds_the_task_for_several_100_ms(tmp_path: Path) -> None:
    text = once(
        "a, b : DINT := 9; uStart, uTook : UDINT;",
        "uStart := PacDriveM.Timer1; a := AppendToWriteFile('DATA.TXT', 'one'); "
        "uTook := PacDriveM.Timer1 - uStart; b := AppendToWriteFile('DATA.TXT', ' two');",
    )
    bench = PlcBench(tmp_path, text).run(2_000)
    assert bench.max4.firmware.disk.read("\\DATA.TXT") == b"one two"
    assert (bench.value("PLC_PRG.a"), bench.value("PLC_PRG.b")) == (0, 0)
    assert 200 <= int(bench.value("PLC_PRG.uTook")) <= 900


@pytest.mark.manual("PD-046")
def test_files_are_written_read_and_deleted(tmp_path: Path) -> None:
    text = once(
        "f, g, h, w, c, n, m, x : DINT; s, t : STRING(255); e, e2 : BOOL;",
        "f := FileOpen('A.TXT', 'w'); w := FileWrite(f, 'hello, '); w := w + FileWrite(f, 'world'); c := FileClose(f);"
        "n := FileSize('A.TXT'); g := FileOpen('a.txt', 'r'); s := FileRead(g, 5); e := FileEof(g);"
        "t := FileRead(g, 200); e2 := FileEof(g); c := c + FileClose(g); x := FileDelete('A.TXT');"
        "h := FileOpen('A.TXT', 'r'); m := FileSize('A.TXT');",
    )
    bench = PlcBench(tmp_path, text).run(3_000)
    found = {name: bench.value(f"PLC_PRG.{name}") for name in ("f", "w", "c", "n", "g", "s", "e", "t", "e2", "x")}
    assert found == {
        "f": 1, "w": 12, "c": 0, "n": 12, "g": 1, "s": "hello", "e": False, "t": ", world", "e2": True, "x": 0
    }  # fmt: skip
    assert (bench.value("PLC_PRG.h"), bench.value("PLC_PRG.m")) == (-1, -1)


@pytest.mark.manual("PD-078")
def test_waitt_holds_its_task_and_leaves_the_processor_to_others(tmp_path: Path) -> None:
    text = """
    PROGRAM Slow
    VAR lBefore, lAfter, r : DINT; END_VAR
    lBefore := lBefore + 1; r := WAITT(T#35ms); lAfter := lAfter + 1;
    END_PROGRAM
    PROGRAM Low
    VAR lCount : DINT; END_VAR
    lCount := lCount + 1;
    END_PROGRAM
    CONFIGURATION c RESOURCE r ON PLC
    TASK A(INTERVAL := T#100ms, PRIORITY := 2);
    TASK B(INTERVAL := T#10ms, PRIORITY := 31);
    PROGRAM pa WITH A : Slow; PROGRAM pb WITH B : Low;
    END_RESOURCE END_CONFIGURATION
    """
    bench = PlcBench(tmp_path, text).run(92 + 34)
    assert (bench.value("Slow.lBefore"), bench.value("Slow.lAfter"), bench.value("Low.lCount")) == (1, 0, 4)
    bench.run(2)
    assert bench.value("Slow.lAfter") == 1
    assert 35_000 <= int(bench.get("plc/task/A/load")) < 35_100


@pytest.mark.manual("PD-077")
def test_cycle_check_time_set_allows_a_longer_cycle(tmp_path: Path) -> None:
    text = """
    PROGRAM PLC_PRG
    VAR r : DINT; bLong : BOOL; END_VAR
    IF bLong THEN r := CycleCheckTimeSet(60); ELSE r := CycleCheckTimeSet(0); END_IF;
    r := WAITT(T#40ms);
    END_PROGRAM
    """
    bench = PlcBench(tmp_path, text + task_of("PLC_PRG", 10), autostart=False).run(200)
    bench.put("PLC_PRG.bLong", True).do("start").run(200)
    assert bench.get("DiagCode") == 0
    bench.put("PLC_PRG.bLong", False).run(100)
    assert bench.get("DiagCode") == 6317


def test_a_wait_that_ends_after_a_reset_wakes_nothing(tmp_path: Path) -> None:
    text = """
    PROGRAM PLC_PRG
    VAR lAfter, r : DINT; END_VAR
    r := WAITT(T#50ms); lAfter := lAfter + 1;
    END_PROGRAM
    """
    bench = PlcBench(tmp_path, text + task_of("PLC_PRG", 500)).run(110)
    bench.do("reset").do("start").run(40)
    assert bench.value("PLC_PRG.lAfter") == 0
    bench.run(12)
    assert bench.value("PLC_PRG.lAfter") == 1


@pytest.mark.manual("PD-163")
def test_an_address_that_is_no_axis_is_refused(tmp_path: Path) -> None:
    text = once("a, b : DINT := 9;", "a := ControllerEnableSet(12345, TRUE); b := ControllerEnableSet(_belt);")
    bench = PlcBench(tmp_path, text, simulated=("belt",)).run(110)
    assert (bench.value("PLC_PRG.a"), bench.value("PLC_PRG.b")) == (-1, 0)
    assert bench.get("belt.ControllerEnable") is True
