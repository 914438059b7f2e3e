"""A register table over points: scales, limits, access, and what is refused with its key."""

from pathlib import Path
from typing import Any

import pytest

from fieldrig.device import Point, Value
from fieldrig_bus.modbus.errors import ModbusError
from fieldrig_devices.registers.live_table import LiveUnit, live_unit, wrong_entries
from fieldrig_devices.registers.table import Table, load_table

TABLE = """
word_order: little
coils:
  - {address: 0, name: run}
discrete_inputs:
  - {address: 3, name: ready}
holding_registers:
  - {address: 10, name: speed, type: u16, unit: "%", scale: 0.1, max: 100}
  - {address: 11, name: length, type: u32}
  - {address: 13, name: force, type: bool}
input_registers:
  - {address: 0, name: level, type: f32}
"""


class Bench:
    """Points that keep their values, and the unit over them."""

    def __init__(self, folder: Path, table: str = TABLE) -> None:
        self.values: dict[str, Value] = {
            "run": False,
            "ready": True,
            "speed": 12.3,
            "length": 0x1_0002,
            "force": False,
            "level": 1.0,
        }
        path = folder / "table.yaml"
        path.write_text(table)
        self.table: Table = load_table(path)
        self.unit: LiveUnit = live_unit(self.table, self.find)

    def find(self, name: str) -> Point | None:
        if name not in self.values:
            return None
        is_input = name in ("ready", "level")
        return Point(lambda: self.values[name], None if is_input else lambda value: self.put(name, value))

    def put(self, name: str, value: Value) -> None:
        if name == "length" and value == 7:
            raise ValueError("expected another length")
        self.values[name] = value


def test_a_client_reads_the_points_as_they_are(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    assert bench.unit.discrete_inputs.read(3, 1) == b"\x01"
    assert bench.unit.holding_registers.read(10, 4) == bytes.fromhex("007b 0002 0001 0000")
    assert bench.unit.input_registers.read(0, 2) == bytes.fromhex("0000 3f80")
    bench.values |= {"ready": False, "speed": 50.0, "force": True}
    assert bench.unit.discrete_inputs.read(3, 1) == b"\x00"
    assert bench.unit.holding_registers.read(10, 4) == bytes.fromhex("01f4 0002 0001 0001")


def test_a_client_writes_the_points(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    bench.unit.coils.write(0, 1, b"\x01")
    bench.unit.holding_registers.write(10, bytes.fromhex("03e8 ffff 0000 0001"))
    assert bench.values == {
        "run": True, "ready": True, "speed": 100.0, "length": 0xFFFF, "force": True, "level": 1.0,
    }  # fmt: skip


@pytest.mark.parametrize(("address", "data", "code"), [(10, "03e9", 4), (11, "0007 0000", 4), (14, "0000", 2)])
def test_a_value_that_is_refused_is_an_exception(tmp_path: Path, address: int, data: str, code: int) -> None:
    bench = Bench(tmp_path)
    before = dict(bench.values)
    with pytest.raises(ModbusError) as refused:
        bench.unit.holding_registers.write(address, bytes.fromhex(data))
    assert (refused.value.code, bench.values) == (code, before)


WRONG: list[tuple[str, tuple[Any, ...]]] = [
    ("coils: [{address: 0, name: missing}]", ("coils", 0, "name")),
    ("coils: [{address: 0, name: ready}]", ("coils", 0, "access")),
    ("coils: [{address: 0, name: run, wire: x}]", ("coils", 0, "wire")),
    ("coils: [{address: 0, name: run, count: 2}]", ("coils", 0, "count")),
    ("holding_registers: [{address: 0, name: speed, retained: true}]", ("holding_registers", 0, "retained")),
    ("holding_registers: [{address: 0, name: speed, initial: 1}]", ("holding_registers", 0, "initial")),
    ("fifos: [{address: 0, name: events}]", ("fifos",)),
]


@pytest.mark.parametrize(("text", "key"), WRONG)
def test_an_entry_without_a_point_and_a_key_without_a_meaning_are_refused(
    tmp_path: Path, text: str, key: tuple[Any, ...]
) -> None:
    bench = Bench(tmp_path)
    path = tmp_path / "wrong.yaml"
    path.write_text(text)
    assert key in [wrong.path for wrong in wrong_entries(load_table(path), bench.find)]


def test_a_good_table_has_no_wrong_entries(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    assert list(wrong_entries(bench.table, bench.find)) == []
