"""`modbus.device`: registers and bits that live by themselves."""

from pathlib import Path

import pytest
from register_bench import Bench

from fieldrig import MS, S
from fieldrig.errors import ConfigError
from fieldrig_devices.registers.table import load_table

METER = """
discrete_inputs:
  - {address: 0, name: pulse, source: {kind: square, period_ms: 1000, high_percent: 10}}
holding_registers:
  - {address: 0, name: limit, initial: 7}
  - {address: 1, name: seconds, type: u32, source: {kind: uptime}}
input_registers:
  - {address: 0, name: voltage, scale: 0.1, unit: V, source: {kind: sine, low: 225, high: 235, period_ms: 4000}}
  - {address: 1, name: energy, type: u32, word_order: little, source: {kind: counter, per_s: 1000, first: 65530}}
  - {address: 3, name: hot, type: bool, source: {kind: ramp, first: 0, last: 1, period_ms: 1000, repeats: false}}
  - {address: 4, name: too_much, max: 10, source: {kind: constant, value: 1.0e+9}}
  - {address: 5, name: flow, type: s16, source: {kind: random_walk, low: -99, high: 99, step: 9}, count: 2}
"""


def test_each_read_shows_the_present_values(tmp_path: Path) -> None:
    bench = Bench(tmp_path, METER)
    assert bench.ask("04 0000 0005") == "040a 08fc fffa0000 0000 ffff".replace(" ", "")  # 230.0 V, 65530 Wh
    bench.clock.advance_to(1 * S)
    assert bench.ask("04 0000 0005") == "040a 092e 03e20001 0001 ffff".replace(" ", "")  # 235.0 V, 66530 Wh
    assert bench.ask("03 0000 0003") == "0306000700000001"
    assert [bench.point(key) for key in ("voltage", "energy", "seconds", "hot")] == [235, 66530, 1, True]


def test_a_bit_follows_a_square_at_its_instants(tmp_path: Path) -> None:
    bench = Bench(tmp_path, METER)
    seen = []
    for now_ms in (0, 99, 100, 999, 1000):
        bench.clock.advance_to(now_ms * MS)
        seen.append(bench.ask("02 0000 0001"))
    assert seen == ["020101", "020101", "020100", "020100", "020101"]


def test_two_random_walks_go_their_own_ways_and_the_same_each_time(tmp_path: Path) -> None:
    ways = []
    for _ in range(2):
        bench = Bench(tmp_path, METER)
        bench.clock.advance_to(60 * S)
        ways.append((bench.point("flow.0"), bench.point("flow.1")))
    assert ways[0] == ways[1]
    assert ways[0][0] != ways[0][1]


SCALED = """
holding_registers:
  - {address: 0, name: power, type: u16, factor_from: per_count, source: {kind: constant, value: 600}}
  - {address: 1, name: per_count, initial: 10}
  - {address: 2, name: current, type: s16, exponent_from: power_of_ten, source: {kind: constant, value: 12.5}}
  - {address: 3, name: power_of_ten, type: s16, source: {kind: counter, per_s: -1}}
"""


def test_a_value_that_lives_stays_itself_when_the_register_of_its_factor_changes(tmp_path: Path) -> None:
    bench = Bench(tmp_path, SCALED)
    assert bench.ask("03 0000 0001") == "0302003c"  # 60 * 10
    assert bench.ask("06 0001 0064") == "0600010064"
    assert bench.ask("03 0000 0001") == "03020006"  # 6 * 100
    assert bench.point("power") == 600
    bench.clock.advance_to(1 * S)
    assert bench.ask("03 0002 0002") == "0304007dffff"  # 125 * 10^-1, and the factor lives too


def test_nobody_can_write_a_value_that_lives(tmp_path: Path) -> None:
    bench = Bench(tmp_path, METER)
    assert bench.ask("06 0001 0005") == "8602"
    assert bench.device.points()["seconds"].write is None
    assert bench.ask("06 0000 0005") == "0600000005"


def test_uptime_begins_again_at_power_on(tmp_path: Path) -> None:
    bench = Bench(tmp_path, METER)
    bench.clock.advance_to(5 * S)
    bench.device.start()
    bench.clock.advance_to(7 * S)
    assert bench.point("seconds") == 2


def test_a_mistake_in_a_source_is_told_for_its_kind_only(tmp_path: Path) -> None:
    (tmp_path / "t.yaml").write_text(
        """
coils: [{address: 0, name: a, source: {kind: sine, low: 1, high: 2}}]
input_registers: [{address: 1, name: b, source: {kind: counter, per_sec: 1, per_s: 1}}]
"""
    )
    with pytest.raises(ConfigError) as wrong:
        load_table(tmp_path / "t.yaml")
    told = [mistake.remedy for mistake in wrong.value.mistakes]
    assert told == ["expected a number from 0.001 to 1000000000000.0 (time of one oscillation)", "did you mean per_s?"]


@pytest.mark.parametrize(
    "entry",
    [
        "{address: 0, name: a, wire: w, source: {kind: uptime}}",
        "{address: 0, name: a, initial: 1, source: {kind: uptime}}",
        "{address: 0, name: a, retained: true, source: {kind: uptime}}",
        "{address: 0, name: a, access: wo, source: {kind: uptime}}",
        '{address: 0, name: a, type: "string[4]", source: {kind: uptime}}',
        "{address: 0, name: a, source: {kind: sine, low: 1, high: 2}}",
        "{address: 0, name: a, source: {kind: sinus, low: 1, high: 2, period_ms: 5}}",
        "{address: 0, name: a, source: {kind: replay, file: none.csv, column: b}}",
        "{address: 0, name: a, source: {low: 1, high: 2}}",
    ],
)
def test_what_does_not_go_with_a_source_is_told_with_its_line(tmp_path: Path, entry: str) -> None:
    (tmp_path / "t.yaml").write_text(f"holding_registers:\n  - {entry}\n")
    with pytest.raises(ConfigError) as wrong:
        load_table(tmp_path / "t.yaml")
    assert [mistake.line for mistake in wrong.value.mistakes] == [2]
