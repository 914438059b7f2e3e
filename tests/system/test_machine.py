"""The line of configs/machine.yaml in virtual time: three rigs joined, and what ties them together."""

from pathlib import Path

import pytest

from fieldrig.clock import S
from fieldrig.config.rig_file import load
from fieldrig.config.yaml_source import read
from fieldrig.pytest_plugin import RigMaker
from fieldrig.virtual.rig import Rig

pytestmark = pytest.mark.system

CONFIGS = Path(__file__).parents[2] / "configs"
MACHINE = "configs/machine.yaml"
PARTS = ("lab.yaml", "arp-cell.yaml", "ring.yaml")
DRIVES = ("infeed", "film", "jaw", "outfeed")


def number(rig: Rig, device: str, key: str) -> float:
    value = rig.get(device, key)
    assert not isinstance(value, str)
    return value


def film_runs(rig: Rig) -> int:
    """The panel's input of the tower's lamp."""
    return int(number(rig, "panel", "6000:01")) >> 5 & 1


@pytest.mark.parametrize("part", PARTS)
def test_every_device_of_a_part_is_in_it_and_as_it_is_there_but_for_what_the_file_says(part: str) -> None:
    machine, alone = load(CONFIGS / "machine.yaml"), load(CONFIGS / part)
    changed = read((CONFIGS / "machine.yaml").read_text(encoding="utf-8"), "").data["devices"]
    for name, device in alone.devices.items():
        joined = machine.devices[name]
        assert joined.kind == device.kind
        if name not in changed:
            assert (joined.settings, joined.links, joined.process) == (device.settings, device.links, device.process)


def test_film_runs_glue_rises_and_the_wrapper_follows(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(MACHINE)
    rig.run_until(5 * S)
    assert (rig.get("max4", "ring.state"), rig.get("max4", "DiagCode")) == ("up", 0)
    assert film_runs(rig) == 0
    level = number(rig, "tank", "level")
    rig.set("drive", "speed_set", 100)
    rig.set("drive", "run", True)
    rig.set("line", "F33", True)
    for name in DRIVES:
        rig.set("max4", f"{name}.ControllerEnable", True)
    rig.run_until(15 * S)
    assert rig.get("line", "V20") == 3
    assert [rig.get(name, "axis_state") for name in DRIVES] == [3, 3, 3, 3]
    assert film_runs(rig) == 1
    before, turned = number(rig, "max4", "FilmEncoder.Position"), number(rig, "nip", "encoder")
    rig.run_until(16 * S)
    assert number(rig, "max4", "FilmEncoder.Position") > before
    assert number(rig, "nip", "encoder") > turned
    assert number(rig, "tank", "level") > level + 0.03  # 1 l/s on 0.25 m2


def test_emergency_stop_of_the_panel_stops_cards_and_drives(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(MACHINE)
    rig.run_until(5 * S)
    rig.set("line", "F33", True)
    rig.set("max4", "film.ControllerEnable", True)
    rig.run_until(12 * S)
    assert (rig.get("line", "V20"), rig.get("film", "axis_state")) == (3, 3)
    rig.set("panel", "6200:01", 0)
    rig.run_until(20 * S)
    assert abs(number(rig, "nip", "speed")) < 0.01
    assert rig.get("film", "axis_state") != 3
    assert rig.get("max4", "film.AxisState") == 0
