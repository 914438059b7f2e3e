"""The Modbus server: the map of section 13 of the digest, tables over variables, and what is refused."""

from pathlib import Path
from typing import Any

import pytest
from hmiscu_device_bench import PTO, DeviceBench

from fieldrig.errors import ConfigError
from fieldrig_devices.hmiscu.faces.modbus import BLOCKS
from fieldrig_devices.registers.table import load_table

ON = "020101"
"""The response for one discrete input that is on."""


@pytest.fixture
def bench() -> DeviceBench:
    bench = DeviceBench(channel_0=PTO)
    bench.run(105)
    return bench


@pytest.mark.long
def test_a_master_moves_the_axis_by_registers_and_coils_alone(bench: DeviceBench) -> None:
    # 20000 Hz, 40000 pulses, 1000 ms, 500 ms: each DWORD with its low word first
    assert bench.ask("10 0000 0008 10 4e20 0000 9c40 0000 03e8 0000 01f4 0000") == "1000000008"
    assert bench.ask("05 0002 ff00") == "050002ff00"
    bench.run(10)
    assert bench.ask("02 0009 0001") == ON  # Busy
    bench.run(1_500)
    assert bench.ask("04 0000 0002") == "04044e200000"  # Frequency
    assert bench.ask("02 0028 0001") == ON  # level of the direction
    bench.run(1_500)
    assert bench.ask("02 0008 0005") == "020101"  # Done alone
    assert bench.ask("04 0000 0004") == "0408000000009c400000"
    assert bench.ask("04 0014 0001") == "04020000"  # Standstill


def test_a_value_out_of_range_is_accepted_and_judged_by_the_block(bench: DeviceBench) -> None:
    assert bench.ask("10 0000 0002 04 ffff 0000") == "1000000002"  # 65535 Hz
    assert bench.ask("05 0002 ff00") == "050002ff00"
    bench.run(20)
    assert bench.ask("02 000c 0001") == ON  # Error
    assert bench.ask("04 0008 0001") == "04020003"  # PTO_INVALID_PARAMETER
    assert bench.ask("04 0014 0001") == "04020004"  # ErrorStop


def test_a_dword_acts_when_its_last_register_is_written(bench: DeviceBench) -> None:
    bench.ask("06 0000 4e20")
    assert bench.get("MoveRelative.Velocity") == 0
    bench.ask("06 0001 0000")
    assert bench.get("MoveRelative.Velocity") == 20_000


@pytest.mark.parametrize("pdu", ["04 0032 0001", "03 001e 0002", "01 0010 0004", "02 0020 0003"])
def test_what_the_configuration_does_not_have_does_not_exist(bench: DeviceBench, pdu: str) -> None:
    assert bench.ask(pdu) == f"{0x80 | int(pdu[:2], 16):02x}02"


def test_terminals_and_panel_are_in_the_map(bench: DeviceBench) -> None:
    bench.wire("drive.ready", True)
    assert bench.ask("02 0042 0001") == ON  # DI2
    assert bench.ask("05 0040 ff00") == "050040ff00"  # DQ0
    bench.run(10)
    assert bench.level("lamp") is True
    assert bench.ask("10 0064 0014 28" + b"READY".ljust(40, b"\0").hex()) == "1000640014"
    assert bench.get("panel.line1") == "READY"


# Digest section 13, an entry or more of each group.
MAP = [
    ("coils", 0, "PTO00.ResetError"), ("coils", 7, "GetDiag.Execute"), ("coils", 19, "PWM00.F_Sync"),
    ("coils", 20, "PWM01.EN_Enable"), ("discrete_inputs", 2, "PTO00.Stopping"),
    ("discrete_inputs", 11, "MoveRelative.CommandAborted"), ("discrete_inputs", 16, "MoveVelocity.InVelocity"),
    ("discrete_inputs", 26, "Stop.Error"), ("discrete_inputs", 34, "PWM00.Error"),
    ("discrete_inputs", 36, "PWM01.InFrequency"), ("discrete_inputs", 40, "PTO00.DirectionLevel"),
    ("holding_registers", 8, "MoveRelative.Direction"), ("holding_registers", 16, "MoveVelocity.Direction"),
    ("holding_registers", 18, "Stop.Deceleration"), ("holding_registers", 22, "SetParam.Param_Value"),
    ("holding_registers", 32, "PWM00.Duty"), ("holding_registers", 36, "PWM01.Duty"),
    ("input_registers", 4, "GetDiag.PTODiag"), ("input_registers", 6, "GetParam.ParamValue"),
    ("input_registers", 12, "SetParam.ErrID"), ("input_registers", 15, "PWM01.ErrID"),
    ("input_registers", 20, "PTO00.State"),
]  # fmt: skip


@pytest.mark.parametrize(("space", "address", "name"), MAP)
def test_the_map_is_the_proposal_of_the_digest(space: str, address: int, name: str) -> None:
    entries = {entry.address: entry.name for entry in load_table(BLOCKS).entries(space)}
    assert entries[address] == name


RECIPE = """
VAR_GLOBAL
    g_udiLength : UDINT := 5;
    g_rSetPoint : REAL;
    g_bStart : BOOL;
    g_sName : STRING(8) := 'A4';
END_VAR
PROGRAM PLC_PRG
END_PROGRAM
"""
TABLE = """
holding_registers:
  - {address: 0, name: g_udiLength, type: u32, min: 1, max: 100000}
  - {address: 2, name: g_rSetPoint, type: s16, scale: 0.1}
  - {address: 3, name: g_sName, type: "string[8]"}
coils: [{address: 0, name: g_bstart}]
"""


def recipes(folder: Path, table: str = TABLE, **modbus: Any) -> DeviceBench:
    path = folder / "recipe.yaml"
    path.write_text(table)
    return DeviceBench(folder, RECIPE, modbus={"turnaround_ms": 0, "table": str(path), **modbus})


def test_a_table_shows_variables_of_the_program(tmp_path: Path) -> None:
    bench = recipes(tmp_path)
    assert bench.ask("03 0000 0007") == "030e" + "00000005" + "0000" + b"A4".ljust(8, b"\0").hex()
    assert bench.ask("10 0000 0003 06 0000 1388 ff9c") == "1000000003"
    assert bench.ask("05 0000 ff00") == "050000ff00"
    assert (bench.get("g_udiLength"), bench.get("g_rSetPoint"), bench.get("g_bStart")) == (5_000, -10.0, True)


@pytest.mark.parametrize(("refusal", "code"), [("server_failure", "04"), ("illegal_value", "03")])
def test_a_value_beyond_the_limits_of_the_table_is_an_exception(tmp_path: Path, refusal: str, code: str) -> None:
    bench = recipes(tmp_path, refusal=refusal)
    assert bench.ask("10 0000 0002 04 0000 0000") == f"90{code}"
    assert bench.get("g_udiLength") == 5


def test_a_name_that_no_point_has_is_refused_with_its_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"recipe\.yaml:2: .*g_rWrong") as refused:
        recipes(tmp_path, "coils:\n  - {address: 0, name: g_rWrong}\n")
    assert len(refused.value.mistakes) == 1
