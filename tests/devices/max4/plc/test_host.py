"""The controller as programs see it: areas, parameters, events of inputs, and the system's work beside a program."""

from pathlib import Path
from typing import Any

import pytest
from max4_faces_bench import FacesBench
from plc_bench import PlcBench, task_of

from fieldrig.clock import MS
from fieldrig_bus.modbus.message import ModbusMessage, ModbusRequest, ModbusResponse


def names(letter: str, count: int) -> dict[str, str]:
    return {f"{letter}{number}": f"panel.{letter.lower()}{number}" for number in range(count)}


# ---- immediate I/O


@pytest.mark.manual("PD-070", "PD-314")
def test_inputs_and_outputs_are_bits_of_the_areas_in_the_order_of_the_configuration(tmp_path: Path) -> None:
    text = """
    VAR_GLOBAL bIn AT %IX0.9 : BOOL; END_VAR
    PROGRAM PLC_PRG
    VAR wIn : WORD; END_VAR
    wIn := %IW0;
    %QW0 := wIn;
    %QX1.0 := bIn;
    END_PROGRAM
    """
    bench = PlcBench(tmp_path, text + task_of("PLC_PRG", 10), inputs=names("I", 17), outputs=names("Q", 17))
    bench.run(100)
    for number in (0, 9, 15):
        bench.signal(f"panel.i{number}", 1)
    bench.run(10)
    assert bench.value("PLC_PRG.wIn") == 1 << 0 | 1 << 9 | 1 << 15
    on = [number for number in range(17) if bench.get(f"Q{number}.Value")]
    assert on == [0, 9, 15, 16]
    assert {wire for _, wire, value in bench.wires if value is True} >= {"panel.q0", "panel.q9", "panel.q16"}
    bench.signal("panel.i9", 0).run(10)
    assert [number for number in range(17) if bench.get(f"Q{number}.Value")] == [0, 15]


@pytest.mark.manual("PD-070")
def test_an_output_changes_when_the_instruction_runs_and_not_at_the_end_of_the_cycle(tmp_path: Path) -> None:
    text = """
    PROGRAM PLC_PRG
    VAR i : DINT; END_VAR
    Lamp.Value := TRUE;
    FOR i := 1 TO 50000 DO ; END_FOR;
    Lamp.Value := FALSE;
    END_PROGRAM
    """
    bench = PlcBench(tmp_path, text + task_of("PLC_PRG", 100), outputs={"Lamp": "panel.lamp"}).run(150)
    (_, first), (on_ms, on), (off_ms, off) = bench.edges("panel.lamp")
    assert (first, on, off) == (False, True, False)
    assert 92 <= on_ms < 92.1, "after the real-time process"
    load_ms = int(bench.get("plc/task/T/load")) / 1000
    assert 1 < load_ms < 50
    assert on_ms + load_ms - 0.5 <= off_ms <= on_ms + load_ms


def test_an_output_of_the_area_shows_what_its_parameter_has_set(tmp_path: Path) -> None:
    text = """
    PROGRAM PLC_PRG
    VAR bSeen : BOOL; END_VAR
    Lamp.Value := TRUE; bSeen := %QX0.0;
    END_PROGRAM
    """
    bench = PlcBench(tmp_path, text + task_of("PLC_PRG"), outputs={"Lamp": ""}).run(150)
    assert bench.value("PLC_PRG.bSeen") is True


@pytest.mark.manual("PD-060", "PD-071")
def test_an_edge_of_an_input_starts_an_event_task_at_once(tmp_path: Path) -> None:
    text = """
    VAR_GLOBAL bStart AT %IX0.0 : BOOL; lCount : DINT; lTime : UDINT; END_VAR
    PROGRAM OnStart
    lCount := lCount + 1; lTime := PacDriveM.Timer1;
    END_PROGRAM
    CONFIGURATION c RESOURCE r ON PLC
    TASK E(SINGLE := bStart, PRIORITY := 3);
    PROGRAM p WITH E : OnStart;
    END_RESOURCE END_CONFIGURATION
    """
    bench = PlcBench(tmp_path, text, inputs={"S1": "panel.s1"}, iec_tasks=["Task_E"]).run(500.5)
    assert (bench.value("lCount"), bench.get("Task_E.State")) == (0, 1)
    bench.signal("panel.s1", 1).run(5)
    assert (bench.value("lCount"), bench.value("lTime"), bench.get("Task_E.State")) == (1, 500, 7)
    bench.signal("panel.s1", 0).run(5).signal("panel.s1", 1).run(5)
    assert bench.value("lCount") == 2


# ---- parameters

SLOW = """
PROGRAM PLC_PRG
VAR uMax : UDINT; bDone : BOOL; uTorque : UINT; dStart, dTook : UDINT; END_VAR
IF NOT bDone THEN
  dStart := PacDriveM.Timer1;
  belt.TorqueLimit := 1234;
  uTorque := belt.TorqueLimit;
  dTook := PacDriveM.Timer1 - dStart;
  bDone := TRUE;
END_IF;
END_PROGRAM
"""


@pytest.mark.long
@pytest.mark.manual("PD-028")
def test_parameters_in_a_drive_hold_the_task_for_many_cycles(tmp_path: Path) -> None:
    """The service channel moves two bytes in each cycle of 4 ms."""
    bench = PlcBench(tmp_path, SLOW + task_of("PLC_PRG", 10, 20), "belt", language="en").run(10_000)
    assert bench.value("PLC_PRG.bDone") is True
    assert bench.value("PLC_PRG.uTorque") == 1234
    assert bench.get("belt.TorqueLimit") == 1234
    assert int(bench.value("PLC_PRG.dTook")) > 20
    assert 6317 in bench.codes(), "such a wait is a cause of a cycle time transgression (manual 3256)"


@pytest.mark.manual("PD-028")
def test_error_quit_of_an_axis_holds_the_task_until_it_is_done(tmp_path: Path) -> None:
    text = """
    PROGRAM PLC_PRG
    VAR bDone : BOOL; END_VAR
    IF NOT bDone THEN belt.DiagQuit := TRUE; bDone := TRUE; END_IF;
    END_PROGRAM
    """
    bench = PlcBench(tmp_path, text + task_of("PLC_PRG", 200, 20), "belt", autostart=False).boot()
    bench.do("start").run(0.5)
    assert bench.value("PLC_PRG.bDone") is False
    bench.run(190)
    assert bench.value("PLC_PRG.bDone") is True


@pytest.mark.manual("PD-181", "PD-024")
def test_a_program_moves_a_logic_encoder_and_reads_it_in_each_cycle(tmp_path: Path) -> None:
    text = """
    PROGRAM PLC_PRG
    VAR lrPos : LREAL; END_VAR
    MasterEncoder.Velocity := 250.0;
    lrPos := MasterEncoder.Position;
    END_PROGRAM
    """
    bench = PlcBench(tmp_path, text + task_of("PLC_PRG"), logic_encoders=["MasterEncoder"]).run(1_100)
    assert float(bench.value("PLC_PRG.lrPos")) == pytest.approx(250.0, abs=5)


def test_a_value_that_a_parameter_cannot_have_stops_the_task(tmp_path: Path) -> None:
    text = "PROGRAM PLC_PRG VAR u : UINT := 3; END_VAR\nPacDriveM.CycleTime := u;\nEND_PROGRAM" + task_of("PLC_PRG")
    bench = PlcBench(tmp_path, text).run(150)
    assert (bench.get("DiagCode"), bench.state("T")) == (4196, 6)


# ---- work of the system

BUSY = """
PROGRAM Busy
VAR i : DINT; END_VAR
FOR i := 1 TO 1000000 DO ; END_FOR;
END_PROGRAM
"""


def faces(tmp_path: Path, priority: int, **settings: Any) -> FacesBench:
    """A controller whose only task needs more than its interval of 1 s, at a priority."""
    file = tmp_path / "plc.st"
    file.write_text(BUSY + task_of("Busy", 1_000, priority))
    return FacesBench(program=[str(file)], autostart=True, **settings).boot(200)


@pytest.mark.manual("PD-065", "PD-066")
@pytest.mark.parametrize(("priority", "is_answered"), [(4, False), (5, True), (6, True)])
def test_tcp_ip_is_at_priority_5(tmp_path: Path, priority: int, *, is_answered: bool) -> None:
    """At equal priority it gets every second slice of 250 us."""
    bench = faces(tmp_path, priority)
    assert (bench.ask("03 00 00 00 01") != "") is is_answered


@pytest.mark.long
@pytest.mark.manual("PD-065", "PD-067", "PD-307")
@pytest.mark.parametrize(("priority", "is_updated"), [(3, False), (4, True), (5, True)])
def test_the_io_map_is_updated_at_priority_4(tmp_path: Path, priority: int, *, is_updated: bool) -> None:
    read = {"address": 0, "values": [{"name": "In"}], "every_ms": 10}
    bench = faces(tmp_path, priority, modbus_client={"units": {"io": {"unit": 7, "reads": [read]}}})
    line = bench.outside.link("mb")

    def answer(request: ModbusMessage) -> None:
        if isinstance(request, ModbusRequest):
            line.send(ModbusResponse(7, b"\x03\x02" + len(bench.requests).to_bytes(2), request.exchange))

    line.on_receive(answer, [7])
    bench.set("command", "reset")
    bench.run(1_000)
    bench.set("command", "start")
    bench.run(40)
    before = bench.get("io.In")
    bench.run(60)
    assert (bench.get("io.In") != before) is is_updated
    bench.run(200)
    assert bench.get("io.In") != before, "the cycle of the program has ended"


def test_work_of_the_system_lengthens_the_cycle_of_the_program(tmp_path: Path) -> None:
    bench = faces(tmp_path, 31, load={"tcp_us": 20_000})
    task = bench.max4.firmware.plc.program.scheduler.tasks[0]  # type: ignore[union-attr]  # it is loaded
    busy_ns = bench.max4.firmware.plc.program.scheduler.busy_ns  # type: ignore[union-attr]
    cpu_ns = task.cpu_ns
    assert bench.ask("03 00 00 00 01")
    bench.run(40)
    program = bench.max4.firmware.plc.program
    assert program is not None
    others_ns = program.scheduler.busy_ns - busy_ns - (task.cpu_ns - cpu_ns)
    assert others_ns >= 20 * MS
