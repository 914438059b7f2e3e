"""A name in a rig file that nothing has is a doubt if something has a name that is nearly the same."""

import shutil
from pathlib import Path

import pytest
from doc_pages import ROOT
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.cli.rigfile import look_at
from fieldrig.config.near_names import near_names
from fieldrig.config.rig_file import load
from fieldrig.config.yaml_source import Source
from fieldrig.text.nearest import is_numbered, is_slip

CONFIGS = sorted((ROOT / "configs").glob("*.yaml"))

RIG = """\
time: virtual
buses:
  wires:
    kind: wires.virtual
    alarms:
      tank.high: {when: true, text: the tank is full}
devices:
  tank:
    {kind: plant.tank, area_m2: 1, height_m: 2, outlet_area_m2: 0.001, pump_flow_m3_per_s: 0.1, links: {wires: wires}}
  other:
    {kind: plant.tank, area_m2: 1, height_m: 2, outlet_area_m2: 0.001, pump_flow_m3_per_s: 0.1, outlet_wire: tank.level,
     links: {wires: wires}}
"""


def doubts_of(folder: Path, text: str, *overrides: str) -> list[tuple[str, str, str]]:
    """Return key, mistake and remedy of each doubt about this rig."""
    file = folder / "rig.yaml"
    file.write_text(text)
    config, mistakes, doubts = look_at(file, overrides)
    assert config is not None, mistakes
    assert all(doubt.line for doubt in doubts)
    return [(doubt.key, doubt.what, doubt.remedy) for doubt in doubts]


def test_a_file_that_can_be_read_only_once_has_no_doubts() -> None:
    config = load(ROOT / "configs" / "smart-io.yaml")
    assert near_names(Source(), config.buses, config.devices) == []


@pytest.mark.long
@pytest.mark.parametrize("file", CONFIGS, ids=lambda file: file.stem)
def test_the_examples_give_no_alarm(file: Path) -> None:
    assert look_at(file, ())[2] == []


@pytest.mark.parametrize(
    ("fault", "key", "remedy"),
    [
        ("{what: stuck, wire: tank.levl}", "wire", "did you mean tank.level?"),
        ("{what: swapped, wire: tank.level, other: tank.hgih}", "other", "did you mean tank.high?"),
    ],
)
def test_a_wire_in_a_fault(tmp_path: Path, fault: str, key: str, remedy: str) -> None:
    text = RIG.replace("    alarms:", f"    faults: [{fault}]\n    alarms:")
    ((at, what, said),) = doubts_of(tmp_path, text)
    assert (at, said) == (f"buses.wires.faults[0].{key}", remedy)
    assert what.startswith("nothing on wires drives ")


@pytest.mark.parametrize("wire", ["tank.level", "valve", "tank.outlet_of_mine"])
def test_another_wire_in_a_fault_may_be_driven_from_outside(tmp_path: Path, wire: str) -> None:
    text = RIG.replace("    alarms:", f"    faults: [{{what: stuck, wire: {wire}}}]\n    alarms:")
    assert doubts_of(tmp_path, text) == []


@pytest.mark.parametrize(
    ("wrong", "right", "key"),
    [
        ("outlet_wire: tank.leevl", "tank.level", "devices.other.outlet_wire"),  # a reader, two letters swapped
        ("outlet_wire: tank.levl", "tank.level", "devices.other.outlet_wire"),  # one is missing
        ("outlet_wire: Tank.Level", "tank.level", "devices.other.outlet_wire"),
        ("outlet_wire: tank_level", "tank.level", "devices.other.outlet_wire"),
        ("outlet_wire: tnk.leve", "tank.level", "devices.other.outlet_wire"),
    ],
)
def test_a_wire_that_a_device_reads(tmp_path: Path, wrong: str, right: str, key: str) -> None:
    ((at, what, remedy),) = doubts_of(tmp_path, RIG.replace("outlet_wire: tank.level", wrong))
    assert at == key
    assert what == f"nothing on wires drives {wrong.partition(': ')[2]}"
    assert remedy.startswith(f"did you mean {right}")


def test_a_wire_that_a_device_drives(tmp_path: Path) -> None:
    """The reader has the name that is its own by default, so the mistake is at the other end."""
    text = RIG.replace("height_m: 2,", "height_m: 2, level_wire: other.outelt,", 1)
    text = text.replace(", outlet_wire: tank.level", "")
    doubts = doubts_of(tmp_path, text)
    remedy = "did you mean other.outlet, which other reads?"
    assert doubts == [("devices.tank.level_wire", "nothing on wires reads other.outelt", remedy)]


def test_a_wire_of_an_alarm(tmp_path: Path) -> None:
    doubts = doubts_of(tmp_path, RIG.replace("tank.high:", "tank.hihg:"))
    what = "nothing on wires has the wire tank.hihg"
    assert doubts == [("buses.wires.alarms.tank.hihg", what, "did you mean tank.high?")]


@pytest.mark.parametrize("wire", ["panel.button", "tank.start", "tank.inlet"])
def test_a_wire_that_is_driven_by_hand_is_none(tmp_path: Path, wire: str) -> None:
    assert doubts_of(tmp_path, RIG.replace("outlet_wire: tank.level", f"outlet_wire: {wire}")) == []


def test_names_that_count_are_two(tmp_path: Path) -> None:
    text = RIG.replace("  other:", "  tank2:").replace("outlet_wire: tank.level", "outlet_wire: tank3.level")
    third = text[text.index("  tank2:") :].replace("tank2:", "meter:").replace("tank3.level", "tank2.level")
    assert doubts_of(tmp_path, text + third) == []


@pytest.mark.parametrize(("name", "wrong"), [("http", "htpt"), ("ftp", "fpt")])
def test_a_service_that_no_device_has(tmp_path: Path, name: str, wrong: str) -> None:
    for part in ("ring.yaml", "teleservice.yaml", "eds", "plates", "programs", "registers"):
        source = ROOT / "configs" / part
        (shutil.copytree if source.is_dir() else shutil.copy)(source, tmp_path / part)
    file = tmp_path / "teleservice.yaml"
    file.write_text(file.read_text().replace(f" {name}: 127", f" {wrong}: 127").replace(f"{{{name}:", f"{{{wrong}:"))
    doubts = [(doubt.key, doubt.remedy) for doubt in look_at(file, ())[2]]
    assert doubts == [(f"buses.lan.listen.{wrong}", f"did you mean {name}?")]


def test_the_first_of_several_parts_that_has_another_process(tmp_path: Path) -> None:
    text = RIG.replace("time: virtual", "time: real").replace("wires.virtual", "wires.hub\n    process: plnats")
    found = doubts_of(tmp_path, text.replace("links", "process: plants, links"))
    assert found == [("buses.wires.process", "nothing else is in the process plnats", "did you mean plants?")]


@pytest.mark.parametrize(
    ("process", "doubts"),
    [
        ("plnats", [("devices.other.process", "nothing else is in the process plnats", "did you mean plants?")]),
        ("plants", []),
        ("plants2", []),
        ("tank", []),
        ("elsewhere", []),
    ],
)
def test_a_process_of_one_part_alone(tmp_path: Path, process: str, doubts: list[tuple[str, str, str]]) -> None:
    text = RIG.replace("time: virtual", "time: real").replace("wires.virtual", "wires.hub\n    process: plants")
    found = doubts_of(tmp_path, text.replace("outlet_wire", f"process: {process}, outlet_wire"))
    assert found == doubts


@given(st.text("ab1.", min_size=4, max_size=10), st.text("ab1.", min_size=4, max_size=10))
def test_whether_a_name_is_mistyped_does_not_depend_on_the_order(one: str, other: str) -> None:
    assert is_slip(one, other) == is_slip(other, one)
    assert is_numbered(one, other) == is_numbered(other, one)
    assert not is_slip(one, one)
