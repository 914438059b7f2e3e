"""The life of a program: boot, start, stop, reset, cold start, download, online change, and files that are wrong."""

import os
from pathlib import Path
from typing import Any

import pytest
from max4_bench import Bench
from plc_bench import PlcBench, task_of

from fieldrig.errors import ConfigError, ControlError
from fieldrig.real import progress
from fieldrig.storage.store import MemoryStore
from fieldrig_devices.max4.messages.catalogue import MESSAGES
from fieldrig_devices.max4.storage.disk import FlashDisk

COUNTER = """
VAR_GLOBAL RETAIN
  lKept : DINT := 5;
END_VAR
PROGRAM PLC_PRG
VAR lCount : DINT := 100; END_VAR
lCount := lCount + 1;
lKept := lKept + 1;
END_PROGRAM
"""
TASK = task_of("PLC_PRG", 10)


@pytest.fixture
def bench(tmp_path: Path) -> PlcBench:
    """After ten cycles: the program has started at 92 ms."""
    return PlcBench(tmp_path, COUNTER + TASK, iec_tasks=["Task_1", "Task_2"]).run(187)


def power_cycle(bench: PlcBench, days: float = 0.0) -> None:
    number = bench.fault("max4", what="power_off", days=days)
    bench.run(5).heal("max4", number).run(107)  # two cycles, at 92 and at 102 ms


def test_the_program_counts_once_per_cycle(bench: PlcBench) -> None:
    assert (bench.value("PLC_PRG.lCount"), bench.value("lKept")) == (110, 15)
    assert bench.get("plc/task/T/cycles") == 10


# ---- commands


@pytest.mark.manual("PD-220")
def test_stop_interrupts_and_start_continues(bench: PlcBench) -> None:
    bench.do("stop").run(1_000)
    assert (bench.get("program"), bench.get("plc/state"), bench.get("Task_1.State")) == ("stopped", "stopped", 4)
    assert bench.value("PLC_PRG.lCount") == 110
    bench.do("start").run(20)
    assert bench.value("PLC_PRG.lCount") == 112
    assert bench.codes()[-1] == 8004


@pytest.mark.manual("PD-220", "PD-056")
def test_reset_ends_the_program_and_keeps_retained_values_only(bench: PlcBench) -> None:
    bench.do("reset").run(100)
    assert (bench.value("PLC_PRG.lCount"), bench.value("lKept")) == (100, 15)
    assert (bench.get("plc/state"), bench.get("Task_1.State")) == ("ready", 1)
    bench.do("start").run(5)
    assert (bench.value("PLC_PRG.lCount"), bench.value("lKept")) == (101, 16)


@pytest.mark.manual("PD-051")
def test_a_cold_start_gives_all_variables_their_start_values(bench: PlcBench) -> None:
    bench.do("cold start").run(5)
    assert (bench.value("PLC_PRG.lCount"), bench.value("lKept")) == (101, 6)
    power_cycle(bench)
    assert bench.value("lKept") == 8


@pytest.mark.manual("PD-042")
def test_without_autostart_it_is_loaded_and_waits(tmp_path: Path) -> None:
    bench = PlcBench(tmp_path, COUNTER + TASK, autostart=False).run(500)
    assert (bench.get("plc/state"), bench.value("PLC_PRG.lCount")) == ("ready", 100)
    bench.do("start").run(5)
    assert bench.value("PLC_PRG.lCount") == 101


# ---- retained values


@pytest.mark.manual("PD-056", "PD-048")
def test_retained_values_survive_power_off_and_others_begin_anew(bench: PlcBench) -> None:
    power_cycle(bench, days=7)
    assert (bench.value("PLC_PRG.lCount"), bench.value("lKept")) == (102, 17)
    power_cycle(bench, days=7.1)
    assert (bench.value("PLC_PRG.lCount"), bench.value("lKept")) == (102, 7)


@pytest.mark.manual("PD-031")
def test_retain_init_clears_retained_values_at_a_boot(bench: PlcBench) -> None:
    bench.set("RetainInit", True).do("save parameters")
    power_cycle(bench)
    assert bench.value("lKept") == 7


@pytest.mark.manual("PD-049", "PD-050")
@pytest.mark.parametrize("retain", ["nvram", "ups", "pn4"])
def test_each_memory_keeps_the_values_over_a_system_reset(tmp_path: Path, retain: str) -> None:
    bench = PlcBench(tmp_path, COUNTER + TASK, retain=retain).run(187)
    bench.do("system reset").run(107)
    assert bench.value("lKept") == 17


def test_values_on_the_flash_disk_outlive_a_flat_capacitor(tmp_path: Path) -> None:
    bench = PlcBench(tmp_path, COUNTER + TASK, retain="ups").run(187)
    power_cycle(bench, days=400)
    assert bench.value("lKept") == 17


@pytest.mark.long
@pytest.mark.manual("PD-048")
@pytest.mark.parametrize("ms", range(150, 171))
def test_a_kill_at_any_instant_leaves_the_values_of_one_cycle(tmp_path: Path, ms: int) -> None:
    """Two tasks write two values each, which belong together; the process is killed without a stop."""
    text = """
    VAR_GLOBAL RETAIN a1, a2, b1, b2 : DINT; sName : STRING(20); END_VAR
    PROGRAM A
    a1 := a1 + 1; a2 := 3 * a1; sName := DINT_TO_STRING(a1);
    END_PROGRAM
    PROGRAM B
    VAR i : DINT; END_VAR
    b1 := b1 + 1;
    FOR i := 1 TO 30000 DO ; END_FOR; (* some 2 ms *)
    b2 := 3 * b1;
    END_PROGRAM
    CONFIGURATION c RESOURCE r ON PLC
    TASK TA(INTERVAL := T#1ms, PRIORITY := 1);
    TASK TB(INTERVAL := T#5ms, PRIORITY := 9);
    PROGRAM pa WITH TA : A; PROGRAM pb WITH TB : B;
    END_RESOURCE END_CONFIGURATION
    """
    store = MemoryStore()
    bench = PlcBench(tmp_path, text, store=store).run(ms)
    before = bench.value("a1")
    again = PlcBench(tmp_path, text, store=store, autostart=False).run(100)
    a1, a2, b1, b2 = (again.value(name) for name in ("a1", "a2", "b1", "b2"))
    assert isinstance(a1, int)
    assert isinstance(b1, int)
    assert (a2, b2, again.value("sName")) == (3 * a1, 3 * b1, str(a1))
    assert a1 + 4 >= int(before)


@pytest.mark.manual("PD-048", "PD-049", "PD-050")
@pytest.mark.parametrize(
    ("retain", "battery", "days", "is_kept"),
    [
        ("nvram", False, 7.0, True),
        ("nvram", False, 7.1, False),
        ("ups", False, 400.0, True),
        ("pn4", False, 7.1, False),
        ("pn4", True, 400.0, True),
    ],
)
def test_a_killed_controller_keeps_its_values_for_as_long_as_its_memory(
    tmp_path: Path, retain: str, battery: bool, days: float, is_kept: bool
) -> None:
    """A kill is a power failure, at which a UPS saves; `off_days` is the time until the next start."""
    store = MemoryStore()
    settings: dict[str, Any] = {"store": store, "retain": retain, "retain_battery": battery}
    PlcBench(tmp_path, COUNTER + TASK, **settings).run(187)
    for passed_days in (days, 0.0):
        again = PlcBench(tmp_path, COUNTER + TASK, autostart=False, off_days=passed_days, **settings)
        assert again.run(100).value("lKept") == (15 if is_kept else 5)


@pytest.mark.long
def test_a_ups_saves_what_a_kill_has_left_in_the_middle_of_a_commit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = MemoryStore()
    bench = PlcBench(tmp_path, COUNTER + TASK, store=store, retain="ups").run(187)
    retained = bench.max4.firmware.memory.ram.retained
    before = retained.values
    assert before is not None

    def killed(head: bytes, data: bytes) -> None:
        raise SystemExit

    monkeypatch.setattr(retained, "_write", killed)
    with pytest.raises(SystemExit):
        retained.commit(before._replace(data=(77).to_bytes(4, "little")))
    again = PlcBench(tmp_path, COUNTER + TASK, store=store, retain="ups", autostart=False, off_days=400.0).run(100)
    assert again.value("lKept") == 77


@pytest.mark.long
@pytest.mark.manual("PD-048")
@pytest.mark.parametrize(
    "body",
    ["r := WAITT(T#60s);", "WHILE TRUE DO lOther := lOther + 1; END_WHILE;"],
    ids=["a task that waits", "a task that never ends"],
)
def test_a_kill_loses_little_where_some_task_is_always_within_a_cycle(tmp_path: Path, body: str) -> None:
    text = f"""
    VAR_GLOBAL RETAIN lFast, lOther : DINT; END_VAR
    PROGRAM Fast lFast := lFast + 1; END_PROGRAM
    PROGRAM Slow VAR r : DINT; END_VAR {body} END_PROGRAM
    CONFIGURATION c RESOURCE r ON PLC
    TASK TF(INTERVAL := T#10ms, PRIORITY := 1);
    TASK TS(PRIORITY := 20);
    PROGRAM p WITH TF : Fast; PROGRAM q WITH TS : Slow;
    END_RESOURCE END_CONFIGURATION
    """
    store = MemoryStore()
    bench = PlcBench(tmp_path, text, store=store).run(1_000)
    fast, other = int(bench.value("lFast")), int(bench.value("lOther"))
    assert fast == 91
    again = PlcBench(tmp_path, text, store=store, autostart=False).run(100)
    assert fast - 1 <= int(again.value("lFast")) <= fast
    assert other * 0.99 <= int(again.value("lOther")) <= other


@pytest.mark.manual("PD-048")
def test_what_a_tool_writes_while_the_program_stands_is_retained(tmp_path: Path) -> None:
    store = MemoryStore()
    bench = PlcBench(tmp_path, COUNTER + TASK, store=store, autostart=False).run(200)
    bench.put("lKept", 77).run(8)
    assert PlcBench(tmp_path, COUNTER + TASK, store=store, autostart=False).run(100).value("lKept") == 77


@pytest.mark.manual("PD-315")
def test_too_many_retained_variables_are_refused_with_the_place(tmp_path: Path) -> None:
    text = "VAR_GLOBAL RETAIN\n  a : ARRAY[1..200] OF DINT;\n  s : ARRAY[1..4] OF STRING(60);\nEND_VAR\n"
    with pytest.raises(ConfigError, match="the RETAIN variables need 1044 bytes") as caught:
        PlcBench(tmp_path, text + COUNTER.replace("RETAIN", "") + TASK)
    assert f"{tmp_path / 'plc.st'}:3:" in str(caught.value)
    assert "at most 1024 bytes" in str(caught.value)
    PlcBench(tmp_path, text + COUNTER.replace("RETAIN", "") + TASK, retain="ups")


MARKERS = """
TYPE Tank : STRUCT level : REAL := 1.5; name : STRING(5) := 'oil'; END_STRUCT END_TYPE
VAR_GLOBAL RETAIN
  wKept AT %MW3 : WORD := 7;
  bKept AT %MX0.9 : BOOL;
  lBoth AT %MD20 : DINT := -5;
  pair AT %MB60 : Tank;
  list AT %MW100 : ARRAY[1..3] OF INT;
END_VAR
VAR_GLOBAL wPlain AT %MW4 : WORD := 3; END_VAR
FUNCTION_BLOCK Hours
VAR RETAIN total AT %M* : DINT := 10; END_VAR
total := total + 1;
END_FUNCTION_BLOCK
VAR_CONFIG PLC_PRG.a.total AT %MD30 : DINT; PLC_PRG.b.total AT %MD31 : DINT; END_VAR
PROGRAM PLC_PRG
VAR RETAIN own AT %MB50 : USINT := 200; lCell : DINT; END_VAR
VAR a, b : Hours; END_VAR
wKept := wKept + 1; wPlain := wPlain + 1; lBoth := lBoth - 1; own := own + 1; lCell := lCell + 1;
pair.level := pair.level + 1.0; pair.name := 'water'; list[2] := list[2] - 2; bKept := NOT bKept;
a(); b(); b();
END_PROGRAM
"""
MARKED = ("wKept", "bKept", "lBoth", "pair.level", "pair.name", "list[2]", "PLC_PRG.own", "PLC_PRG.a.total")
MORE_MARKED = ("PLC_PRG.b.total", "PLC_PRG.lCell", "wPlain")


def marked(bench: PlcBench) -> list[object]:
    return [bench.value(name) for name in (*MARKED, *MORE_MARKED)]


@pytest.mark.manual("PD-056", "PD-351", "PD-364")
def test_retained_variables_at_addresses_of_the_markers_survive_power_off_and_a_warm_start(tmp_path: Path) -> None:
    bench = PlcBench(tmp_path, MARKERS + TASK).run(187)
    assert marked(bench) == [17, False, -15, 11.5, "water", -20, 210, 20, 30, 10, 13]
    bench.do("reset").run(100)
    assert marked(bench) == [17, False, -15, 11.5, "water", -20, 210, 20, 30, 10, 3]
    power_cycle(bench)
    bench.do("start").run(5)
    assert marked(bench) == [20, True, -18, 14.5, "water", -26, 213, 23, 36, 13, 6]
    bench.do("cold start").run(5)
    assert marked(bench) == [8, True, -6, 2.5, "water", -2, 201, 11, 12, 1, 4]


@pytest.mark.manual("PD-364")
def test_a_retained_marker_leaves_the_other_bits_and_bytes_of_the_area_cleared(tmp_path: Path) -> None:
    text = """VAR_GLOBAL RETAIN bKept AT %MX5.3 : BOOL; END_VAR
    VAR_GLOBAL wAll AT %MW5 : WORD; wNext AT %MW6 : WORD; END_VAR
    PROGRAM PLC_PRG wAll := 16#FFFF; wNext := 16#FFFF; END_PROGRAM"""
    store = MemoryStore()
    PlcBench(tmp_path, text + task_of("PLC_PRG", 10), store=store).run(187)
    again = PlcBench(tmp_path, text + task_of("PLC_PRG", 10), store=store, autostart=False).run(100)
    assert (again.value("bKept"), again.value("wAll"), again.value("wNext")) == (True, 8, 0)


@pytest.mark.parametrize("ms", range(150, 160))
def test_a_kill_leaves_markers_and_other_variables_of_the_same_cycle(tmp_path: Path, ms: int) -> None:
    text = """VAR_GLOBAL RETAIN a AT %MD5 : DINT; b : DINT; END_VAR
    PROGRAM PLC_PRG a := a + 1; b := 3 * a; END_PROGRAM"""
    store = MemoryStore()
    bench = PlcBench(tmp_path, text + task_of("PLC_PRG", 1), store=store).run(ms)
    before = bench.value("a")
    again = PlcBench(tmp_path, text + task_of("PLC_PRG", 1), store=store, autostart=False).run(100)
    a, b = again.value("a"), again.value("b")
    assert isinstance(a, int)
    assert b == 3 * a
    assert a + 1 >= int(before) > 50


def test_a_variable_keeps_its_value_when_it_gets_an_address(tmp_path: Path) -> None:
    bench = PlcBench(tmp_path, COUNTER + TASK).run(187)
    bench.write(COUNTER.replace("lKept :", "lKept AT %MD7 :") + TASK).do("online change").run(10)
    power_cycle(bench)
    assert bench.value("lKept") == 18


@pytest.mark.parametrize("where", ["%IW3", "%QW3"])
def test_a_retained_input_or_output_is_refused_with_the_place(tmp_path: Path, where: str) -> None:
    with pytest.raises(ConfigError, match="no inputs or outputs are kept over power-off") as caught:
        PlcBench(tmp_path, f"VAR_GLOBAL RETAIN\n  w AT {where} : WORD;\nEND_VAR\n" + COUNTER + TASK)
    assert f"{tmp_path / 'plc.st'}:2:" in str(caught.value)
    assert f"w is at an address of {where[:2]}" in str(caught.value)


def test_a_retained_output_of_one_instance_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="total is at an address of %Q"):
        PlcBench(
            tmp_path,
            MARKERS.replace("AT %M*", "AT %Q*")
            .replace("b.total AT %MD31", "b.total AT %QD31")
            .replace("a.total AT %MD30", "a.total AT %QD30")
            + TASK,
        )


def test_a_changed_program_gets_the_values_that_have_the_same_name_and_type(tmp_path: Path) -> None:
    """The program on the disk is changed by an online change, and then the power fails."""
    bench = PlcBench(tmp_path, COUNTER + TASK).run(187)
    changed = COUNTER.replace("lKept : DINT := 5;", "nNew : INT := 7; lKept : DINT := 5; sNew : STRING := 'x';")
    bench.write(changed + TASK).do("online change").run(10)
    power_cycle(bench)
    assert (bench.value("lKept"), bench.value("nNew"), bench.value("sNew")) == (18, 7, "x")
    changed = COUNTER.replace("lKept : DINT := 5;", "lKept : INT := 5;")
    bench.write(changed + TASK).do("online change").run(10)
    assert bench.value("lKept") == 6


# ---- download


@pytest.mark.manual("PD-043", "PD-051")
def test_a_download_stops_the_program_and_waits_for_its_start(bench: PlcBench) -> None:
    bench.write(COUNTER.replace(":= 100", ":= 500") + TASK).do("download").run(8_000)
    assert (bench.get("plc/state"), bench.value("PLC_PRG.lCount"), bench.value("lKept")) == ("ready", 500, 5)
    bench.do("start").run(5)
    assert bench.value("PLC_PRG.lCount") == 501
    power_cycle(bench)
    assert bench.value("PLC_PRG.lCount") == 502


@pytest.mark.manual("PD-033")
def test_a_download_that_does_not_compile_leaves_the_running_program(bench: PlcBench) -> None:
    for words in ("download", "online change"):
        bad = COUNTER.replace("lCount + 1", "lCuont + 1").replace("lKept + 1", "TRUE")
        bench.write(bad + TASK).do(words).run(1_000)
        first, second = (line for line in str(bench.get("plc/problem")).splitlines() if "hint" not in line)
        assert first.startswith("plc.st:7:")
        assert second.startswith("plc.st:8:")
        assert bench.log()[0].split("\t")[3:7] == ["LZS", "LZS", "8198", first.partition(": ")[0]]
    bench.run(6_000)
    assert (bench.get("plc/state"), bench.value("PLC_PRG.lCount")) == ("running", 910)
    assert 8010 not in bench.codes()
    assert bench.get("DiagCode") == 0
    bench.file.unlink()
    with pytest.raises(ControlError, match="a source cannot be read"):
        bench.do("download")


def test_compiling_shows_its_progress_and_a_later_download_replaces_it(bench: PlcBench) -> None:
    bench.write(COUNTER + "(*" + 20_000 * "x" + "*)" + TASK).do("download").run(50)
    assert bench.get("plc/state") == "running"
    assert str(bench.get("plc/progress")).endswith("%")
    bench.write(COUNTER.replace(":= 100", ":= 700") + TASK).do("download").run(50)
    assert (bench.get("plc/state"), bench.get("plc/progress")) == ("ready", "")
    bench.run(500)
    assert bench.value("PLC_PRG.lCount") == 700


@pytest.mark.long
def test_a_reset_of_the_system_ends_a_download(bench: PlcBench) -> None:
    bench.write(COUNTER.replace(":= 100", ":= 700") + TASK).do("download").do("system reset").run(8_000)
    assert bench.value("PLC_PRG.lCount") == 891


def test_a_changed_source_in_the_rig_file_begins_with_start_values(tmp_path: Path) -> None:
    store = MemoryStore()
    PlcBench(tmp_path, COUNTER + TASK, store=store).run(187)
    assert PlcBench(tmp_path, COUNTER + TASK, store=store).run(97).value("lKept") == 16
    assert PlcBench(tmp_path, COUNTER + "(* *)" + TASK, store=store).run(97).value("lKept") == 6


# ---- online change


@pytest.mark.manual("PD-225")
def test_an_online_change_takes_effect_between_two_cycles_and_keeps_the_values(bench: PlcBench) -> None:
    text = COUNTER.replace("lCount + 1", "lCount + 10").replace(
        "VAR lCount", "VAR aMore : ARRAY[1..5] OF INT; lMore : DINT := 3; lCount"
    )
    bench.write(text + TASK).do("online change").run(10)
    assert (bench.value("PLC_PRG.lCount"), bench.value("PLC_PRG.lMore"), bench.value("lKept")) == (120, 3, 16)
    assert bench.get("plc/task/T/cycles") == 11
    bench.do("system reset").run(97)
    assert bench.value("PLC_PRG.lCount") == 110, "the changed program is stored"


@pytest.mark.manual("PD-225")
def test_an_online_change_waits_for_the_end_of_the_cycle(tmp_path: Path) -> None:
    text = """
    PROGRAM PLC_PRG
    VAR i, lFirst, lSecond : DINT; END_VAR
    lFirst := lFirst + 1;
    FOR i := 1 TO 60000 DO ; END_FOR;
    lSecond := lSecond + 1;
    END_PROGRAM"""
    bench = PlcBench(tmp_path, text + task_of("PLC_PRG", 100)).run(93)
    assert (bench.value("PLC_PRG.lFirst"), bench.value("PLC_PRG.lSecond")) == (1, 0)
    bench.write(text.replace("+ 1", "+ 1000") + task_of("PLC_PRG", 100)).do("online change").run(50)
    assert (bench.value("PLC_PRG.lFirst"), bench.value("PLC_PRG.lSecond")) == (1, 1)
    bench.run(100)
    assert (bench.value("PLC_PRG.lFirst"), bench.value("PLC_PRG.lSecond")) == (1001, 1001)


def test_an_online_change_gives_up_where_some_task_is_always_within_a_cycle(tmp_path: Path) -> None:
    text = """
    PROGRAM PLC_PRG
    VAR lCount : DINT; t : TON; r : DINT; END_VAR
    t(IN := TRUE, PT := T#100ms);
    WHILE t.Q AND lCount < 1000 DO  (* longer than any limit *)
        r := WAITT(T#60s);
    END_WHILE;
    lCount := lCount + 1;
    END_PROGRAM"""
    tasks = """
    CONFIGURATION c RESOURCE r ON PLC
    TASK Free(PRIORITY := 20);
    PROGRAM q WITH Free : PLC_PRG;
    END_RESOURCE END_CONFIGURATION"""
    bench = PlcBench(tmp_path, text + tasks).run(200)
    bench.write(text.replace("+ 1", "+ 1000") + tasks).do("online change").run(9_000)
    assert bench.get("plc/progress") == "waiting for the end of a cycle"
    assert bench.get("plc/problem") == ""
    bench.run(2_000)
    assert bench.get("plc/progress") == ""
    assert "some task was within a cycle at every instant of 10 s: expected less load" in str(bench.get("plc/problem"))
    assert bench.get("plc/state") == "running", "the present program goes on"


def test_a_download_takes_the_place_of_an_online_change_that_waits(tmp_path: Path) -> None:
    waiting = COUNTER.replace("lCount := lCount + 1;", "lCount := lCount + 1 + WAITT(T#60s);")
    tasks = task_of("PLC_PRG", 100)
    bench = PlcBench(tmp_path, waiting + tasks).run(200)
    bench.write(waiting.replace("+ 1", "+ 2") + tasks).do("online change").run(100)
    assert bench.get("plc/progress") == "waiting for the end of a cycle"
    bench.write(COUNTER + tasks).do("download").run(8_000).do("start").run(5_000)
    assert (bench.get("plc/progress"), bench.get("plc/problem")) == ("", "")
    assert 8198 not in bench.codes(), "no change is refused 10 s after it was asked for"


@pytest.mark.parametrize("words", ["download", "online change"])
def test_the_inputs_stay_with_the_running_program_when_another_is_refused(tmp_path: Path, words: str) -> None:
    text = """
    PROGRAM PLC_PRG
    VAR is_on : BOOL; END_VAR
    is_on := %IX0.0;
    END_PROGRAM""" + task_of("PLC_PRG", 10)
    bench = PlcBench(tmp_path, text, inputs={"S1": ""}).run(200)
    bench.write(text.replace("is_on :=", "is_no :=")).do(words).run(1_000)
    bench.set("S1.Value", True)
    bench.run(20)
    assert bench.value("PLC_PRG.is_on") is True


@pytest.mark.manual("PD-225")
def test_a_changed_task_configuration_needs_a_download(bench: PlcBench) -> None:
    bench.write(COUNTER + task_of("PLC_PRG", 20)).do("online change").run(10)
    assert "the task configuration has changed: expected a download" in str(bench.get("plc/problem"))
    assert bench.value("PLC_PRG.lCount") == 111


# ---- tasks


@pytest.mark.manual("PD-071")
def test_state_of_an_iec_task_object_has_the_values_of_table_5_1(tmp_path: Path) -> None:
    text = """
    VAR_GLOBAL bEvent : BOOL; END_VAR
    PROGRAM Cyclic VAR n : DINT; END_VAR n := n + 1; END_PROGRAM
    PROGRAM Free ; END_PROGRAM
    PROGRAM Single ; END_PROGRAM
    PROGRAM Wrong VAR n : DINT; END_VAR n := 1 / n; END_PROGRAM
    CONFIGURATION c RESOURCE r ON PLC
    TASK T1(INTERVAL := T#10ms, PRIORITY := 5);
    TASK T2(PRIORITY := 20);
    TASK T3(SINGLE := bEvent, PRIORITY := 4);
    TASK T4(INTERVAL := T#10ms, PRIORITY := 6);
    PROGRAM p1 WITH T1 : Cyclic; PROGRAM p2 WITH T2 : Free;
    PROGRAM p3 WITH T3 : Single; PROGRAM p4 WITH T4 : Wrong;
    END_RESOURCE END_CONFIGURATION
    """
    objects = ["O1", "O2", "O3", "O4", "O5"]
    bench = PlcBench(tmp_path, text, iec_tasks=objects, autostart=False).run(150)

    def states() -> list[object]:
        return [bench.get(f"{name}.State") for name in objects]

    assert states() == [1, 1, 1, 1, 0]  # ready; there is no fifth task
    bench.do("start").run(50)
    assert states() == [3, 2, 1, 6, 0]  # cyclic operation, running, still ready, error
    bench.put("bEvent", True).run(5)
    assert states() == [3, 2, 7, 6, 0]  # finished
    bench.do("stop").run(5)
    assert states() == [4, 4, 4, 6, 0]
    bench.do("start").run(5)
    bench.loaded.runtime.break_at({"plc.st": {3}})
    bench.run(20)
    assert states() == [5, 2, 7, 6, 0]
    bench.do("reset")
    assert states() == [1, 1, 1, 1, 0]


@pytest.mark.manual("PD-060")
def test_the_programs_of_a_task_run_one_after_the_other_in_each_of_its_cycles(tmp_path: Path) -> None:
    text = """
    VAR_GLOBAL sOrder : STRING(255); END_VAR
    PROGRAM A VAR i : DINT; END_VAR FOR i := 1 TO 5000 DO ; END_FOR; sOrder := CONCAT(sOrder, 'A'); END_PROGRAM
    PROGRAM B sOrder := CONCAT(sOrder, 'B'); END_PROGRAM
    CONFIGURATION c RESOURCE r ON PLC
    TASK T(INTERVAL := T#10ms, PRIORITY := 5);
    PROGRAM b1 WITH T : B; PROGRAM a1 WITH T : A; PROGRAM b2 WITH T : B;
    END_RESOURCE END_CONFIGURATION
    """
    bench = PlcBench(tmp_path, text).run(92 + 25)
    assert bench.value("sOrder") == 3 * "BAB"
    assert bench.get("plc/task/T/cycles") == 3


# ---- the cost of a program


BUSY = """
PROGRAM PLC_PRG
VAR i, n : DINT; r, s : REAL; END_VAR
FOR i := 1 TO 1000 DO n := n + i; r := r * s + 1.0; END_FOR;
END_PROGRAM"""


def load_us(folder: Path, **costs: float) -> int:
    """Return the load of a program in microseconds on a controller with these costs."""
    text = BUSY + task_of("PLC_PRG", 100, 0)
    load = {"base_us": 0, "axis_us": 0}
    bench = PlcBench(folder, text, iec_tasks=["Task_1"], load=load, costs=costs)
    bench.set("Task_1.EnableLoad", True).run(250)
    return int(bench.get("Task_1.Load"))


@pytest.mark.manual("PD-072")
def test_the_load_follows_the_costs_of_the_rig_file(tmp_path: Path) -> None:
    plain = load_us(tmp_path)
    assert load_us(tmp_path, scale=2.5) == pytest.approx(2.5 * plain, abs=10)  # a cost is a whole number of ns
    # a pass of the loop has two operations on REAL, of 1000 us here instead of 60 ns
    assert load_us(tmp_path, real_ns=1_060) == pytest.approx(plain + 2_000, abs=2)


def test_a_controller_is_calibrated_to_the_load_that_a_machine_shows(tmp_path: Path) -> None:
    """max4-plc.md: the scale is the load of the machine divided by the load here; the machine is another one."""
    machine = load_us(tmp_path, access_ns=55, real_ns=170, jump_ns=35, operation_ns=40)
    scale = machine / load_us(tmp_path)
    assert scale > 2
    assert load_us(tmp_path, scale=scale) == pytest.approx(machine, rel=0.01)


def test_a_downloaded_and_a_changed_program_have_the_costs_of_the_rig_file_too(tmp_path: Path) -> None:
    text = BUSY + task_of("PLC_PRG", 100, 0)
    bench = PlcBench(tmp_path, text, costs={"scale": 2.5}, load={"base_us": 0}).run(250)
    before = bench.get("plc/task/T/load")
    bench.write("(* changed *)" + text).do("online change").run(500)
    assert bench.get("plc/task/T/load") == before
    bench.write("(* loaded *)" + text).do("download").run(8_000).do("start").run(250)
    assert bench.get("plc/task/T/load") == before


@pytest.mark.manual("PD-073")
def test_an_overload_that_is_made_by_the_costs_repeats_exactly(tmp_path: Path) -> None:
    def overloaded(scale: float) -> tuple[list[str], object]:
        text = BUSY + task_of("PLC_PRG", 1, 0)
        bench = PlcBench(tmp_path, text, costs={"scale": scale}).run(400)
        return bench.log(), bench.value("PLC_PRG.n")

    first = overloaded(6.0)
    assert any("6317" in line for line in first[0])
    assert overloaded(6.0) == first
    assert not any("6317" in line for line in overloaded(1.0)[0])


# ---- wrong files


def test_a_program_that_does_not_compile_is_refused_at_the_start_with_file_line_and_key(tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as caught:
        PlcBench(tmp_path, COUNTER.replace("lCount + 1", "lCuont + 1").replace("lKept + 1", "TRUE") + TASK)
    first, second = caught.value.mistakes
    assert (first.file, first.line) == (str(tmp_path / "plc.st"), 7)
    assert (second.file, second.line) == (str(tmp_path / "plc.st"), 8)
    assert "program" in first.key


@pytest.mark.long
@pytest.mark.long
@pytest.mark.manual("PD-312", "PD-316")
@pytest.mark.parametrize(
    ("version", "kilobytes", "arrays", "refusal"),
    [
        ("V00.12.00", 33, 1, ""),
        ("V00.12.00", 128, 1, ""),
        ("V00.12.00", 129, 1, "at most 131072 bytes"),
        ("V00.11.99", 33, 1, "at most 32768 bytes"),
        ("V00.07.00", 32, 31, ""),
        ("V00.06.99", 32, 31, "at most 851968 bytes"),  # 1 MByte without the three areas of 64 kByte
    ],
)
def test_the_version_of_the_controller_decides_how_much_a_program_may_need(
    tmp_path: Path, version: str, kilobytes: int, arrays: int, refusal: str
) -> None:
    lists = "".join(
        f"VAR_GLOBAL a{number} : ARRAY[1..{kilobytes * 1024}] OF BYTE; END_VAR\n" for number in range(arrays)
    )
    text = lists + COUNTER + TASK
    if not refusal:
        assert PlcBench(tmp_path, text, version=version).run(200).get("plc/state") == "running"
        return
    with pytest.raises(ConfigError, match=refusal):
        PlcBench(tmp_path, text, version=version)


@pytest.mark.manual("PD-204", "PD-335")
def test_iec_steps_need_a_controller_of_version_6(tmp_path: Path) -> None:
    """Manual 3372: IECsfc.lib is for V00.06.00 or higher."""
    text = """
    PROGRAM PLC_PRG
    VAR bOn : BOOL; END_VAR
    INITIAL_STEP Wait: bOn(N); END_STEP
    TRANSITION FROM Wait TO Wait := TRUE; END_TRANSITION
    END_PROGRAM"""
    assert PlcBench(tmp_path, text + TASK, version="V00.06.00").run(200).value("PLC_PRG.bOn") is True
    with pytest.raises(ConfigError, match=r"Wait is an IEC step, for which the controller has no IECsfc\.lib"):
        PlcBench(tmp_path, text + TASK, version="V00.05.99")
    simple = text.replace("bOn(N);", "ACTIVE bOn := TRUE; END_ACTIVE")
    assert PlcBench(tmp_path, simple + TASK, version="V00.05.99").run(200).value("PLC_PRG.bOn") is True


@pytest.mark.manual("PD-033")
def test_a_task_configuration_without_a_program_is_refused(tmp_path: Path) -> None:
    task = TASK.replace("PROGRAM p WITH T : PLC_PRG;", "")
    with pytest.raises(ConfigError):
        PlcBench(tmp_path, COUNTER + task)


@pytest.mark.parametrize(
    "data", [b"PROGRAM PLC_PRG", b"\x00\xff\xfe", b"{}", b'{"format":"IEC sources","dialect":"x","files":[]}',
             b'{"format":"IEC sources","dialect":"epas-4","files":[{"name":"a.st","text":"PROGRAM"}]}']
)  # fmt: skip
def test_a_program_file_with_other_content_is_reported_and_not_started(data: bytes) -> None:
    store = MemoryStore()
    Bench(store=store, autostart=True).run(100)
    FlashDisk(store, 4_000_000).write("\\DEFAULT.PRG", data)
    bench = Bench(store=store, autostart=True).run(200)
    assert bench.get("DiagCode") == 4197
    assert bench.get("DiagExtCode") == "\\DEFAULT.PRG"
    assert bench.get("program") == "stopped"
    assert 8004 not in bench.codes()
    assert bench.get("plc/problem")
    with pytest.raises(ControlError, match="the stored program cannot be loaded"):
        bench.do("start")


def test_a_controller_without_a_program_has_no_points_of_the_plc() -> None:
    bench = Bench().run(100)
    assert not [key for key in bench.max4.points() if key.startswith("plc/")]
    with pytest.raises(ControlError, match="there is no program to start: expected a download first"):
        bench.do("start")


# ---- IEC Task objects


@pytest.mark.manual("PD-029", "PD-072")
def test_the_first_task_object_observes_the_first_task(tmp_path: Path) -> None:
    text = "PROGRAM PLC_PRG VAR i : DINT; END_VAR FOR i := 1 TO 1000 DO ; END_FOR; END_PROGRAM"
    bench = PlcBench(tmp_path, text + TASK, iec_tasks=["Task_1", "Task_2"]).run(187)
    assert (bench.get("Task_1.State"), bench.get("Task_2.State")) == (3, 0)
    assert (bench.get("Task_1.Load"), bench.get("Task_1.Cycle")) == (0, 0)
    bench.set("Task_1.EnableLoad", True)
    assert bench.get("Task_1.Cycle") == 10_000
    assert bench.get("Task_1.Load") == bench.get("plc/task/T/load")
    assert 10 < int(bench.get("Task_1.Load")) < 1_000


@pytest.mark.long
@pytest.mark.manual("PD-085")
def test_cycle_load_is_measured_while_a_program_runs(tmp_path: Path) -> None:
    text = """PROGRAM PLC_PRG VAR i : DINT; END_VAR
    FOR i := 1 TO 20000 DO ; END_FOR;
    END_PROGRAM"""
    bench = PlcBench(tmp_path, text + task_of("PLC_PRG", 10), load={"base_us": 400}).run(1_000)
    process_percent, task_percent = 100 * 400 / 4_000, 100 * int(bench.get("plc/task/T/cpu")) / 908_000
    assert task_percent > 5
    assert bench.get("CycleLoad") == pytest.approx(process_percent + task_percent, abs=3)
    bench.do("reset").run(10)
    assert bench.get("CycleLoad") == 10


# ---- sizes and numbers


@pytest.mark.manual("PD-032")
def test_code_size_and_data_size_are_shown(tmp_path: Path) -> None:
    sizes = []
    for more, statement in (("", ""), ("aMore : ARRAY[1..100] OF INT; sMore : STRING(19);", "aMore[3] := 5;")):
        text = f"PROGRAM PLC_PRG VAR a : INT; {more} END_VAR\na := a + 1; {statement}\nEND_PROGRAM"
        bench = PlcBench(tmp_path, text + TASK).run(100)
        sizes.append((int(bench.get("plc/code_size")), int(bench.get("plc/data_size"))))
    (code, data), (more_code, more_data) = sizes
    assert 0 < code < more_code
    assert more_data == data + 200 + 20


def tasks(count: int) -> str:
    lines = (
        f"TASK T{n}(INTERVAL := T#20ms, PRIORITY := {n % 32}); PROGRAM I{n} WITH T{n} : P{n};" for n in range(count)
    )
    programs = (f"PROGRAM P{n} VAR x : INT; END_VAR x := x + 1; END_PROGRAM" for n in range(count))
    return "\n".join((*programs, "CONFIGURATION c RESOURCE r ON PLC", *lines, "END_RESOURCE END_CONFIGURATION"))


@pytest.mark.long
@pytest.mark.manual("PD-063", "PD-310")
def test_there_are_at_most_64_tasks(tmp_path: Path) -> None:
    bench = PlcBench(tmp_path, tasks(64)).run(187)
    assert {bench.get(f"plc/task/T{number}/cycles") for number in range(64)} == {5}
    with pytest.raises(ConfigError, match="64"):
        PlcBench(tmp_path, tasks(65))


def test_the_numbers_505_and_506_are_not_used_for_anything_else() -> None:
    assert not [code for code in MESSAGES if code % 1000 in (505, 506)]


def test_a_project_has_several_files_and_a_dialect(tmp_path: Path) -> None:
    other = tmp_path / "values.st"
    other.write_text("VAR_GLOBAL lBig : LINT := 16#1_0000_0000; END_VAR // of edition 3\n")
    main = "PROGRAM PLC_PRG lBig := lBig ** 1 + 1; END_PROGRAM" + TASK
    settings = {"dialect": "edition-3"}
    bench = PlcBench(tmp_path, main.replace(" ** 1", ""), files=[other], **settings).run(100)
    assert bench.value("lBig") == 2**32 + 1
    with pytest.raises(ConfigError) as caught:
        PlcBench(tmp_path, main.replace(" ** 1", ""), files=[other])
    assert str(other) in str(caught.value)


@pytest.mark.manual("PD-228")
def test_active_steps_of_a_chart_are_seen_while_it_runs(tmp_path: Path) -> None:
    text = """
    PROGRAM PLC_PRG
    VAR bGo : BOOL; lCount : DINT; END_VAR
    INITIAL_STEP Waiting: END_STEP
    TRANSITION FROM Waiting TO Counting := bGo; END_TRANSITION
    STEP Counting: Count(N); END_STEP
    TRANSITION FROM Counting TO Waiting := NOT bGo; END_TRANSITION
    ACTION Count: lCount := lCount + 1; END_ACTION
    END_PROGRAM
    """
    bench = PlcBench(tmp_path, text + TASK).run(150)
    assert (bench.value("PLC_PRG.Waiting.x"), bench.value("PLC_PRG.Counting.x")) == (True, False)
    bench.put("PLC_PRG.bGo", True).run(30)
    assert (bench.value("PLC_PRG.Waiting.x"), bench.value("PLC_PRG.Counting.x")) == (False, True)
    assert int(bench.value("PLC_PRG.lCount")) >= 2


def test_compiling_at_the_start_counts_as_progress_of_the_process(tmp_path: Path) -> None:
    reader, writer = os.pipe()
    progress.report_to(writer)
    try:
        PlcBench(tmp_path, COUNTER + TASK)
    finally:
        progress.finish()
        steps = os.read(reader, 1 << 16).decode().splitlines()
        os.close(reader)
    assert "parse 0 %" in steps
    assert "check 100 %" in steps
    assert "lower 100 %" in steps
    assert "compile 100 %" in steps


@pytest.mark.parametrize(("resource", "count"), [("One", 10), ("Two", 5)])
def test_the_controller_runs_the_resource_of_its_key(tmp_path: Path, resource: str, count: int) -> None:
    text = """PROGRAM PLC_PRG VAR n : INT; END_VAR n := n + 1; END_PROGRAM
    CONFIGURATION c
    RESOURCE One ON PLC TASK T(INTERVAL := T#10ms); PROGRAM p WITH T : PLC_PRG; END_RESOURCE
    RESOURCE Two ON PLC TASK T(INTERVAL := T#20ms); PROGRAM p WITH T : PLC_PRG; END_RESOURCE
    END_CONFIGURATION"""
    assert PlcBench(tmp_path, text, resource=resource).run(187).value("PLC_PRG.n") == count
    with pytest.raises(ConfigError, match="there are the resources One, Two"):
        PlcBench(tmp_path, text)
