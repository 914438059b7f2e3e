"""Each variable of a program is a point by its path, as its page says, for every way in which tools ask for points."""

from pathlib import Path

import pytest

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict
from fieldrig.errors import ControlError
from fieldrig.virtual.rig import Rig

PROGRAM = """
TYPE Recipe : STRUCT length : UDINT := 7; END_STRUCT; END_TYPE
VAR_GLOBAL g_count : UDINT; END_VAR
PROGRAM PLC_PRG
VAR
    count : UINT;
    limit : UINT := 100;
    recipe : Recipe;
    list : ARRAY [1..3] OF INT := [4, 5, 6];
    Move : PTOMoveRelative;
END_VAR
IF count < limit THEN count := count + 1; END_IF
g_count := count;
PTO00();
Move(PTO_REF_IN := PTO00.PTO_REF, Execute := FALSE, Distance := 12);
END_PROGRAM
"""
VALUES = {
    "PLC_PRG.count": 100,
    "plc_prg.COUNT": 100,
    "PLC_PRG.recipe.length": 7,
    "PLC_PRG.list[2]": 5,
    "PLC_PRG.Move.Distance": 12,
    "PLC_PRG.Move.Error": False,
    "g_count": 100,
    "PTO00.Moving": False,
}


@pytest.fixture
def rig(tmp_path: Path) -> Rig:
    (tmp_path / "main.st").write_text(PROGRAM, encoding="utf-8")
    devices = {"scu": {"kind": "hmiscu", "program": str(tmp_path / "main.st"), "channel_0": {"mode": "pto"}}}
    rig = Rig(from_dict({"time": "virtual", "buses": {}, "devices": devices}, folder=tmp_path))
    rig.run_until(2 * S)
    return rig


@pytest.mark.parametrize("name", VALUES)
def test_a_variable_or_pin_is_read_by_its_path(rig: Rig, name: str) -> None:
    assert rig.get(f"scu/{name}") == VALUES[name]


def test_a_variable_that_the_program_only_reads_is_set_by_its_path(rig: Rig) -> None:
    rig.set("scu/PLC_PRG.limit", 150)
    rig.run_for(1 * S)
    assert rig.get("scu/PLC_PRG.count") == 150


@pytest.mark.parametrize("name", ["PLC_PRG.Move.Distance", "PLC_PRG.Move.Error", "g_count"])
def test_what_the_program_drives_is_refused(rig: Rig, name: str) -> None:
    with pytest.raises(ControlError, match=f"the program drives {name}"):
        rig.set(f"scu/{name}", 1)


def test_each_change_of_a_variable_is_told(rig: Rig) -> None:
    seen: list[object] = []
    rig.on_change("scu/PLC_PRG.count", seen.append)
    rig.set("scu/PLC_PRG.limit", 103)
    rig.run_for(100 * MS)
    assert seen[-3:] == [101, 102, 103]


@pytest.mark.parametrize("name", ["PLC_PRG.cuont", "PLC_PRG.list[4]", "PLC_PRG", "PLC_PRG.recipe"])
def test_a_name_without_a_value_is_refused(rig: Rig, name: str) -> None:
    with pytest.raises(ControlError, match="has no value"):
        rig.get(f"scu/{name}")
