"""Register tables: every mistake of a file at once, with its line."""

from pathlib import Path

import pytest

from fieldrig.errors import ConfigError
from fieldrig_devices.registers.table import load_table

RIGHT = """
word_order: little
coils: [{address: 0, name: run, wire: pump.run}]
input_registers:
  - {address: 0, name: level, type: f32, unit: m, wire: tank.level}
  - {address: 2, name: text, type: "string[5]", initial: abc}
"""


def mistakes(tmp_path: Path, text: str) -> list[str]:
    file = tmp_path / "table.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError) as wrong:
        load_table(file)
    return [f"{mistake.line}: {mistake.key}: {mistake.what}" for mistake in wrong.value.mistakes]


def test_a_right_table_is_read(tmp_path: Path) -> None:
    file = tmp_path / "table.yaml"
    file.write_text(RIGHT)
    table = load_table(file)
    assert table.word_order == "little"
    assert [entry.words for entry in table.input_registers] == [2, 3]


def test_every_mistake_is_told_at_once(tmp_path: Path) -> None:
    found = mistakes(
        tmp_path,
        """
holding_registers:
  - {address: 70000, name: a}
  - {address: 1, name: "b c"}
  - {address: 2, name: d, type: u17}
  - {address: 3, name: e, scale: 0}
  - {address: 4, name: f, colour: red}
  - {address: 5, name: g, min: 3, max: 2}
  - {address: 6, name: h, initial: 70000}
  - {address: 7, name: i, type: bool, scale: 2}
  - {address: 8, name: j, direction: to_wire}
  - {address: 65535, name: k, type: u32}
  - {address: 9, name: l, max: 5, initial: 6}
""",
    )
    assert [line.split(":")[0] for line in found] == [str(line) for line in range(3, 14)]


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("name: tank, count: 3", "name: tank.1"),
        ("name: tank.1", "name: tank, count: 3"),
        ("name: tank, count: 3", "name: tank, count: 2"),
    ],
)
def test_a_name_that_a_count_makes_is_a_name(tmp_path: Path, first: str, second: str) -> None:
    found = mistakes(tmp_path, f"holding_registers:\n  - {{address: 0, {first}}}\n  - {{address: 9, {second}}}\n")
    assert [line.partition(" is already")[0].partition("name: ")[2] for line in found] in (["tank.1"], ["tank"])


def test_conflicts_between_entries_are_told(tmp_path: Path) -> None:
    found = mistakes(
        tmp_path,
        """
coils:
  - {address: 0, name: run, wire: pump.run, count: 1}
  - {address: 1, name: run}
discrete_inputs:
  - {address: 0, name: running, access: rw}
holding_registers:
  - {address: 0, name: wide, type: u64}
  - {address: 3, name: inside}
  - {address: 10, name: speed, wire: pump.run}
  - {address: 11, name: fixed, access: ro, wire: x, direction: to_wire}
fifos:
  - {address: 7, name: q1}
  - {address: 7, name: q2}
""",
    )
    assert found == [
        "4: coils[1].name: run is already used at coils[0]",
        "6: discrete_inputs[0].access: a client cannot write discrete inputs",
        "9: holding_registers[1].address: address 3 is in use by wide",
        "10: holding_registers[2].wire: pump.run is already used at coils[0]",
        "11: holding_registers[3].direction: no client can write it, so it cannot drive a wire",
        "14: fifos[1].address: 7 is already used at fifos[0]",
    ]


@pytest.mark.parametrize(
    "text", ["[", "- 1", "3", "coils: 3", "coils: [3]", "\x00", "coils: [{address: 0, name: yes, initial: 1}]"]
)
def test_what_is_no_table_is_refused(tmp_path: Path, text: str) -> None:
    assert mistakes(tmp_path, text)


@pytest.mark.parametrize("key", [-1, 0, 1])
def test_a_number_in_the_place_of_a_key_is_refused(tmp_path: Path, key: int) -> None:
    path = tmp_path / "table.yaml"
    path.write_text(f"holding_registers: [{{address: 0, name: a, {key}: 1}}]\nfifos: {{{key}: 1}}\n")
    with pytest.raises(ConfigError):
        load_table(path)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError):
        load_table(tmp_path / "none.yaml")
