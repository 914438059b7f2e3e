"""`modbus.device`: named bits and numbers, and scales that are values of other registers."""

from pathlib import Path

import pytest
from full_store import FullStore
from register_bench import Bench

from fieldrig.errors import ConfigError
from fieldrig_bus.wires import Signal
from fieldrig_devices.registers.table import load_table

DRIVE = """
holding_registers:
  - address: 0
    name: command
    bits:
      - {bit: 0, name: enable, wire: drive.enable}
      - {bit: 4, width: 3, name: mode, wire: drive.mode, values: {0: off, 1: speed, 2: torque}}
  - {address: 1, name: level, values: {0: user, 7: service}, initial: service}
  - {address: 2, name: ratio, initial: 40}
  - {address: 3, name: power_limit, unit: W, type: u32, factor_from: ratio, initial: 8000}
input_registers:
  - address: 0
    name: status
    type: u32
    word_order: little
    bits: [{bit: 0, name: ready, wire: drive.ready}, {bit: 31, name: fault}]
  - {address: 2, name: w, type: s16, unit: W, scale: 0.5, exponent_from: w_sf, initial: 12350}
  - {address: 3, name: w_sf, type: s16, initial: 1}
"""


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path, DRIVE)


def test_named_bits_are_points_and_wires(bench: Bench) -> None:
    bench.wires.take()
    assert bench.ask("06 0000 0011") == "0600000011"
    assert bench.wires.take() == [Signal("drive.enable", True), Signal("drive.mode", 1)]
    assert (bench.point("command"), bench.point("command.enable"), bench.point("command.mode")) == (0x11, True, "speed")
    bench.set("command.mode", "torque")
    assert bench.ask("03 0000 0001") == "03020021"
    assert Signal("drive.mode", 2) in bench.wires.take()
    bench.set("command.enable", False)
    bench.set("command.mode", 5)
    assert bench.ask("03 0000 0001") == "03020050"
    assert bench.point("command.mode") == 5


def test_a_wire_sets_a_bit_and_leaves_the_others(bench: Bench) -> None:
    bench.set("status.fault", True)
    bench.wires.deliver(Signal("drive.ready", True))
    assert bench.ask("04 0000 0002") == "040400018000"
    assert bench.device.points()["status.ready"].write is None


def test_a_name_stands_for_its_number(bench: Bench) -> None:
    assert bench.point("level") == "service"
    assert bench.ask("03 0001 0001") == "03020007"
    bench.set("level", "user")
    assert bench.ask("03 0001 0001") == "03020000"
    bench.ask("06 0001 0005")
    assert bench.point("level") == 5
    with pytest.raises(ValueError, match="expected user or service, got 'servise'"):
        bench.set("level", "servise")


def test_a_factor_stands_in_another_register(bench: Bench) -> None:
    assert bench.ask("03 0003 0002") == "0304000000c8"  # 8000 W / 40
    bench.ask("06 0002 0014")
    assert bench.point("power_limit") == 4000  # the registers keep what they hold
    bench.set("power_limit", 100)
    assert bench.ask("03 0003 0002") == "030400000005"
    bench.ask("06 0002 0000")
    bench.set("power_limit", 100)
    assert bench.point("power_limit") == 0


def test_a_start_value_may_fit_by_its_factor_only(tmp_path: Path) -> None:
    table = """
holding_registers:
  - {address: 0, name: power, factor_from: ratio, initial: 131070}
  - {address: 1, name: ratio, initial: 2}
"""
    assert Bench(tmp_path, table).ask("03 0000 0001") == "0302ffff"


def test_an_exponent_stands_in_another_register(bench: Bench) -> None:
    """In SunSpec's models, W_SF is the power of ten of W; 8000h stands for "not implemented"."""
    assert bench.ask("04 0002 0002") == "040409a60001"  # 12350 W = 2470 * 0.5 * 10
    bench.set("w_sf", -2)
    assert bench.point("w") == 12.35
    bench.set("w_sf", -32768)
    assert bench.point("w") == 1235


def test_a_bit_of_a_retained_register_that_cannot_be_stored_keeps_its_value(tmp_path: Path) -> None:
    table = "holding_registers: [{address: 0, name: options, retained: true, bits: [{bit: 3, name: beeps}]}]"
    store = FullStore()
    bench = Bench(tmp_path, table, store)
    store.is_full = True
    with pytest.raises(ValueError, match="cannot be stored"):
        bench.set("options.beeps", True)
    assert bench.ask("03 0000 0001") == "03020000"
    store.is_full = False
    bench.set("options.beeps", True)
    assert Bench(tmp_path, table, store).point("options") == 8


def test_the_exception_status_may_have_named_bits(tmp_path: Path) -> None:
    bench = Bench(tmp_path, DRIVE, exception_status=["status.fault", "command.enable"])
    bench.set("command.enable", True)
    assert bench.ask("07") == "0702"


@pytest.mark.parametrize(
    "entry",
    [
        "{name: a, bits: [{bit: 16, name: b}]}",
        "{name: a, bits: [{bit: 2, width: 3, name: b}, {bit: 4, name: c}]}",
        "{name: a, bits: [{bit: 2, name: b}, {bit: 4, name: b}]}",
        "{name: a, type: s16, bits: [{bit: 2, name: b}]}",
        "{name: a, scale: 2, bits: [{bit: 2, name: b}]}",
        "{name: a, max: 2, bits: [{bit: 2, name: b}]}",
        "{name: a, bits: [{bit: 2, name: b, values: {0: x}}]}",
        "{name: a, bits: [{bit: 2, width: 2, name: b, values: {4: x}}]}",
        "{name: a, values: {65536: x}}",
        "{name: a, values: {1: x, 2: x}}",
        "{name: a, values: {1: x}, initial: y}",
        "{name: a, type: f32, values: {1: x}}",
        "{name: a, factor_from: nothing}",
        "{name: a, factor_from: a}",
        "{name: a, factor_from: other, exponent_from: other}",
        "{name: a, factor_from: other, bits: [{bit: 2, name: b}]}",
        "{name: a, factor_from: other, initial: 131072}",
    ],
)
def test_what_is_wrong_is_told_with_its_line(tmp_path: Path, entry: str) -> None:
    lines = ["holding_registers:", "  - {address: 9, name: other, initial: 2}", f"  - {{address: 0, {entry[1:]}"]
    (tmp_path / "t.yaml").write_text("\n".join(lines))
    with pytest.raises(ConfigError) as wrong:
        load_table(tmp_path / "t.yaml")
    assert [mistake.line for mistake in wrong.value.mistakes] == [3]
