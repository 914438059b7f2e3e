"""Each face shows the same values, and refuses writes to what a program drives."""

from pathlib import Path
from typing import Any

import pytest
from hmiscu_device_bench import PTO, DeviceBench
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.hmiscu.fast_outputs import _wrapped

PROGRAM = """
VAR_GLOBAL g_bLamp : BOOL; END_VAR
PROGRAM PLC_PRG
VAR
    bLamp AT %QX0.1 : BOOL;
    bPanel AT %QX8.2 : BOOL;
END_VAR
PWM00(F_Enable := TRUE, Frequency := 1500, Duty := 30);
bLamp := TRUE;
bPanel := g_bLamp;
END_PROGRAM
"""
VARIABLES = """
VAR_GLOBAL
    g_uiShown, g_uiSet, g_uiCount, g_uiWanted : UINT;
    g_bBusy, g_bStart : BOOL;
END_VAR
PROGRAM PLC_PRG
VAR
    Edge : R_TRIG;
    Move : PTOMoveVelocity;
    bHot AT %IX0.3 : BOOL;
    uiLocal : UINT;
END_VAR
Edge(CLK := g_bStart);
Move(PTO_REF_IN := PTO00.PTO_REF, Execute := Edge.Q, Velocity := 5000);
g_bBusy := Edge.Q;
g_bStart := FALSE;                    (* a command, which the program takes back *)
g_uiShown := g_uiSet;
g_uiCount := g_uiCount + 1;
IF bHot THEN g_uiWanted := 7; END_IF;
uiLocal := g_uiSet;
END_PROGRAM
"""
DRIVEN = ["g_uiShown", "g_bBusy", "PLC_PRG.uiLocal", "PLC_PRG.Move.Velocity", "PLC_PRG.Move.Execute", "PLC_PRG.bHot"]
DRIVEN += ["plc_prg.move.Busy", "PLC_PRG.Edge.Q", "PLC_PRG.Edge.CLK"]
FREE = ["g_uiSet", "g_uiCount", "g_uiWanted", "g_bStart", "PLC_PRG.Move.Acceleration", "PLC_PRG.Edge.M"]
TABLE = """
about: variables
coils:
  - {address: 0, name: g_bBusy}
  - {address: 1, name: g_bStart}
holding_registers:
  - {address: 0, name: g_uiShown, type: u16}
  - {address: 1, name: g_uiSet, type: u16}
  - {address: 2, name: PLC_PRG.Move.Velocity, type: u32}
  - {address: 4, name: PLC_PRG.Move.Acceleration, type: u32}
"""
OBJECTS = {
    "2001:03": "PLC_PRG.Move.Velocity",
    "2001:04": "g_uiShown",
    "2001:05": "g_uiSet",
    "6200:01.0": "g_bBusy",
    "6200:01.1": "g_bStart",
}
FREQUENCY, DUTY, EN_ENABLE = "05", "06", "01"
REFUSED = "22000008"
"""0800 0022h, the present device state, in the order of the bytes on the bus."""


def sdo(bench: DeviceBench, request: str) -> str:
    bench.can.take()
    bench.can.deliver(CanFrame(0x605, bytes.fromhex(request)))
    (frame,) = [frame for frame in bench.can.take() if frame.identifier == 0x585]
    return frame.data.hex()


@pytest.fixture
def bench(tmp_path: Path) -> DeviceBench:
    found = DeviceBench(tmp_path, PROGRAM, channel_0={"mode": "pwm"}, can_slave={"node_id": 5})
    found.run(100)
    return found


@pytest.mark.long
def test_canopen_shows_the_pins_that_a_program_drives(bench: DeviceBench) -> None:
    assert sdo(bench, f"40 07 20 {FREQUENCY} 00 00 00 00") == "43072005" + "dc050000"
    assert sdo(bench, f"40 07 20 {DUTY} 00 00 00 00") == "4f072006" + "1e000000"
    assert (bench.get("PWM00.Frequency"), bench.get("PWM00.Duty")) == (1_500, 30)


@pytest.mark.long
def test_each_face_refuses_what_the_program_drives(bench: DeviceBench) -> None:
    assert sdo(bench, f"2f 07 20 {DUTY} 32 00 00 00") == "80072006" + REFUSED
    assert sdo(bench, "2f 00 62 01 00 00 00 00") == "80006201" + REFUSED  # DQ1
    assert sdo(bench, "2f 00 62 03 04 00 00 00") == "80006203" + REFUSED  # lamp 3
    assert bench.ask("05 0041 0000") == "8504"  # DQ1
    assert bench.ask("05 0052 ff00") == "8504"  # lamp 3
    assert bench.ask("05 0011 0000") == "8504"  # PWM00.F_Enable
    assert bench.ask("05 0053 ff00") == "050053ff00"  # lamp 4, which the program leaves alone
    for name in ("PWM00.Duty", "pwm00.frequency", "DQ1", "panel.lamp3"):
        with pytest.raises(ValueError, match=r"the program drives"):
            bench.set(name, 0)
    bench.run(50)
    assert (bench.get("PWM00.Duty"), bench.get("DQ1")) == (30, True)


@pytest.fixture
def with_variables(tmp_path: Path) -> DeviceBench:
    table = tmp_path / "table.yaml"
    table.write_text(TABLE)
    faces: dict[str, Any] = {
        "modbus": {"turnaround_ms": 0, "table": table},
        "can_slave": {"node_id": 5, "points": OBJECTS},
    }
    found = DeviceBench(tmp_path, VARIABLES, channel_0=PTO, **faces)
    found.run(100)
    return found


@pytest.mark.long
def test_each_face_refuses_variables_and_pins_that_the_next_cycle_overwrites(with_variables: DeviceBench) -> None:
    bench = with_variables
    for name in DRIVEN:
        with pytest.raises(ValueError, match=r"the program drives"):
            bench.set(name, 1)
    for key in ("2001 03", "2001 04"):
        index, sub = key.split()
        assert sdo(bench, f"23 {index[2:]} {index[:2]} {sub} 01 00 00 00") == f"80{index[2:]}{index[:2]}{sub}" + REFUSED
    assert sdo(bench, "2f 00 62 01 01 00 00 00") == "80006201" + REFUSED
    assert bench.ask("05 0000 ff00") == "8504"
    assert bench.ask("06 0000 0001") == "8604"
    assert bench.ask("10 0002 0002 04 0001 0000") == "9004"


@pytest.mark.long
def test_each_face_takes_commands_set_points_and_counters(with_variables: DeviceBench) -> None:
    bench = with_variables
    for name in FREE:
        bench.set(name, 1)
    assert sdo(bench, "23 01 20 05 2a 00 00 00").startswith("60")
    bench.run(20)
    assert (bench.get("g_uiShown"), sdo(bench, "40 01 20 04 00 00 00 00")) == (42, "430120042a000000")
    assert bench.ask("06 0001 0007") == "0600010007"
    assert bench.ask("10 0004 0002 04 0000 0009") == "1000040002"
    bench.run(20)
    assert (bench.ask("03 0000 0001"), bench.get("PLC_PRG.uiLocal")) == ("03020007", 7)
    assert bench.get("PLC_PRG.Move.Acceleration") == 9
    assert sdo(bench, "2f 00 62 01 02 00 00 00").startswith("60")
    assert bench.get("g_bStart") is True
    bench.run(20)
    assert bench.get("g_bStart") is False


@pytest.mark.long
def test_what_the_program_leaves_alone_takes_values_of_each_face(bench: DeviceBench) -> None:
    assert sdo(bench, f"2f 07 20 {EN_ENABLE} 01 00 00 00") == "6007200100000000"
    assert bench.get("PWM00.EN_Enable") is True
    bench.set("PWM00.EN_Enable", False)
    assert sdo(bench, f"40 07 20 {EN_ENABLE} 00 00 00 00") == "4f07200100000000"
    bench.can.deliver(CanFrame(0x000, b"\x01\x05"))
    bench.can.deliver(CanFrame(0x205, bytes.fromhex("05 00 00")))  # DQ0 and DQ2, and DQ1 stays the program's
    bench.run(50)
    assert [bench.get(f"DQ{number}") for number in range(4)] == [True, True, True, False]
    assert sdo(bench, "40 00 62 01 00 00 00 00") == "4f00620107000000"


@pytest.mark.long
def test_a_pin_that_another_face_has_set_can_be_set_back_by_canopen() -> None:
    bench = DeviceBench(channel_0=PTO, can_slave={"node_id": 5})
    assert sdo(bench, "23 01 20 03 10 27 00 00").startswith("60")
    bench.set("MoveRelative.Velocity", 7)
    assert sdo(bench, "40 01 20 03 00 00 00 00") == "4301200307000000"
    assert sdo(bench, "23 01 20 03 10 27 00 00").startswith("60")
    assert bench.get("MoveRelative.Velocity") == 10_000


@given(st.integers(-(2**40), 2**40))
def test_a_position_beyond_32_bits_goes_on_at_the_other_end(position: int) -> None:
    shown = _wrapped(position)
    assert -(2**31) <= shown < 2**31
    assert (shown - position) % 2**32 == 0
