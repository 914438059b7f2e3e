"""Register tables as lists that `fieldrig new --registers` reads back, and as a page."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shipped import CONFIGS
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig_devices.begin.register_list import read_list
from fieldrig_devices.export.register_csv import csv_of
from fieldrig_devices.registers.entries import Bit, Register, each_value, number_of
from fieldrig_devices.registers.table import SPACES, Table, access_of, load_table

TABLES = sorted((CONFIGS / "registers").glob("*.yaml"))
KEPT = ("unit", "scale", "offset", "factor_from", "exponent_from", "min", "max", "count")


def facts(table: Table) -> list[Any]:
    """The facts of a table that a list has."""
    found: list[Any] = []
    for space in SPACES:
        for entry in table.entries(space):
            if isinstance(entry, Bit):
                found += [
                    (space, address, name, access_of(space, entry), entry.initial)
                    for name, address in each_value(entry)
                ]
            else:
                found.append((space, *facts_of(table, entry), access_of(space, entry)))
    return sorted(found)


def facts_of(table: Table, entry: Register) -> tuple[Any, ...]:
    initial = None if entry.initial is None else number_of(entry.values, entry.initial)
    orders = (entry.word_order or table.word_order, entry.byte_order or table.byte_order)
    has_order = entry.type != "bool" and not entry.type.startswith("string")
    start = initial or (0 if has_order or entry.type == "bool" else "")
    return (
        entry.address,
        entry.name,
        entry.type,
        orders if has_order else (),
        start,
        *(str(getattr(entry, key)) for key in KEPT),
    )


def read_back(folder: Path, text: str) -> Table:
    file = folder / "list.csv"
    file.write_text(text, encoding="utf-8")
    table = file.with_suffix(".yaml")
    table.write_text(read_list(file).text(file.name), encoding="utf-8")
    return load_table(table)


@pytest.mark.parametrize("file", TABLES, ids=lambda file: file.stem)
def test_a_list_of_a_shipped_table_is_read_back(tmp_path: Path, file: Path) -> None:
    table = load_table(file)
    assert facts(read_back(tmp_path, csv_of(table))) == facts(table)


NAMES = st.from_regex(r"\A[A-Za-z_][A-Za-z0-9_.-]{0,8}\Z")
NUMBER = st.integers(-1000, 1000) | st.floats(-1e6, 1e6, width=32)


@st.composite
def tables(draw: st.DrawFn) -> Table:
    """Holding registers at any addresses, also those that look like numbers such as 40001."""
    places = sorted(draw(st.sets(st.sampled_from([0, 100, 9_960, 10_001, 30_001, 40_001, 40_021, 65_000]), min_size=1)))
    names = draw(st.lists(NAMES, min_size=len(places), max_size=len(places), unique=True))
    registers = []
    for address, name in zip(places, names, strict=True):
        type = draw(st.sampled_from(["u16", "s16", "u32", "s32", "f32", "u64", "f64", "bcd16", "string[7]", "bool"]))
        entry: dict[str, Any] = {"address": address, "name": name, "type": type}
        if type not in ("string[7]", "bool"):
            entry |= draw(
                st.fixed_dictionaries(
                    {},
                    optional={
                        "scale": st.sampled_from([0.1, 10, 0.001]),
                        "offset": st.sampled_from([-40, 2.5]),
                        "word_order": st.sampled_from(["big", "little"]),
                        "byte_order": st.sampled_from(["big", "little"]),
                        "count": st.sampled_from([2, 3]),
                        "unit": st.sampled_from(["V", "%", "m3/h"]),
                        "access": st.sampled_from(["ro", "wo", "rw"]),
                    },
                )
            )
        registers.append(entry | {"about": draw(st.sampled_from(["", "a, b; c", 'the "first"']))})
    return Table.model_validate({"holding_registers": registers})


@settings(max_examples=50)  # each writes and reads three files
@given(tables())
def test_a_list_of_any_table_is_read_back(tmp_path_factory: pytest.TempPathFactory, table: Table) -> None:
    assert facts(read_back(tmp_path_factory.mktemp("list"), csv_of(table))) == facts(table)


def test_the_command_writes_a_list_and_a_page(tmp_path: Path) -> None:
    run, page, folder = CliRunner().invoke, tmp_path / "registers.md", tmp_path / "lists"
    done = run(app, ["export", str(CONFIGS / "feeder.yaml"), "--csv", str(folder), "--markdown", str(page)])
    assert done.output.splitlines() == [str(folder / "feeder-1.csv"), str(folder / "sealer-2.csv"), str(page)]
    assert (folder / "feeder-1.csv").read_text(encoding="utf-8").startswith("address,name,type,space,unit,")
    text = page.read_text(encoding="utf-8")
    assert text.startswith("# Registers of feeder\n")
    assert "\n## feeder, unit 1 at " in text


def test_a_page_says_what_a_list_cannot(tmp_path: Path) -> None:
    (tmp_path / "rig.yaml").write_text(
        "time: virtual\nbuses: {bus: {kind: modbus.virtual}}\n"
        "devices:\n  m: {kind: modbus.device, unit_id: 1, table: t.yaml, links: {modbus: bus}}\n"
    )
    (tmp_path / "t.yaml").write_text(
        "word_order: little\nholding_registers:\n"
        "  - {address: 0, name: mode, values: {0: off, 1: heating}, max: 1, about: the mode}\n"
        "  - {address: 1, name: lamps, bits: [{bit: 0, name: run}, {bit: 4, width: 2, name: level}]}\n"
        "  - {address: 2, name: t, type: s16, scale: 0.1, offset: -40, min: -40, count: 3, unit: degC}\n"
        "fifos: [{address: 10, name: queue, depth: 4}]\n"
        "files: [{number: 3, name: recipe, records: 5, about: 'a | b'}]\n"
    )
    page = tmp_path / "page.md"
    done = CliRunner().invoke(app, ["export", str(tmp_path / "rig.yaml"), "--markdown", str(page)])
    assert done.exit_code == 0, done.output
    lines = page.read_text(encoding="utf-8").splitlines()
    assert "Of several registers the low word comes first." in lines
    assert "| 0 | `mode` | u16 |  |  | at most 1 | rw | the mode; 0 = off, 1 = heating |" in lines
    assert "| 1 | `lamps` | u16 |  |  |  | rw | bit 0: run; bits 4 to 5: level |" in lines
    assert "| 2 to 4 | `t.0` to `t.2` | s16 | degC | 0.1 -40 | at least -40 | rw |  |" in lines
    assert "| 10 | `queue` | 4 |  |" in lines
    assert "| 3 | `recipe` | 5 | rw | a \\| b |" in lines
