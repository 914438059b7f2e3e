"""Arrays, structures and instances as Python sees them: what is assigned to a part goes to the program."""

import copy
from pathlib import Path
from typing import Any

import pytest

from fieldrig import MS, ArgumentError, RigError, program

TEXT = """
TYPE Pair : STRUCT a : INT; b : ARRAY[1..2] OF REAL; END_STRUCT; END_TYPE
FUNCTION_BLOCK Valve
VAR_INPUT open : BOOL; END_VAR
VAR_OUTPUT isOpen : BOOL; END_VAR
VAR_INPUT limits : Pair; END_VAR
isOpen := open;
END_FUNCTION_BLOCK
FUNCTION_BLOCK Plant
VAR list : ARRAY[0..3] OF INT; grid : ARRAY[0..1, 1..2] OF INT; END_VAR
VAR pair : Pair; valves : ARRAY[1..2] OF Valve; sum : INT; END_VAR
VAR i : INT; END_VAR
sum := 0;
FOR i := 0 TO 3 DO sum := sum + list[i]; END_FOR;
valves[1](); valves[2]();
END_FUNCTION_BLOCK
FUNCTION_BLOCK Other
END_FUNCTION_BLOCK
PROGRAM Main
VAR plant : Plant; END_VAR
plant();
END_PROGRAM
"""


@pytest.fixture
def plc(tmp_path: Path) -> Any:
    (tmp_path / "plant.st").write_text(TEXT)
    return program(tmp_path / "plant.st")


def test_elements_of_arrays_are_assigned_to(plc: Any) -> None:
    plant = plc.block("Plant")
    plant.list[2] = 5
    plant.list[-1] = 1
    plant.list[0:2] = [10, 20]
    plant.grid[1][0] = 7
    assert plant().sum == 36
    assert plant.list == [10, 20, 5, 1]
    assert plant.grid == [[0, 0], [7, 0]]


def test_components_are_keys_and_attributes(plc: Any) -> None:
    plant = plc.block("Plant")
    plant.pair.a = 4
    plant.pair["B"][1] = 1.5
    plant.pair.update(a=5)
    assert plant.pair == {"a": 5, "b": [0.0, 1.5]}
    assert (plant.pair.A, plant.pair["A"]) == (5, 5)
    plc["Main.plant.pair"]["a"] = 9
    plc["Main.plant"].list[1] = 3
    assert (plc["Main.plant.pair.a"], plc["Main.plant.list[1]"]) == (9, 3)


def test_instances_in_arrays_have_variables(plc: Any) -> None:
    plant = plc.block("Plant")
    plant.valves[1].open = True
    plant.valves[0].limits.b[0] = 2.0
    plant()
    assert [valve.isOpen for valve in plant.valves] == [False, True]
    assert plant.valves[0]["limits"] == {"a": 0, "b": [2.0, 0.0]}


def test_a_list_that_was_read_keeps_its_values(plc: Any) -> None:
    plant = plc.block("Plant")
    before = plant.list
    plant.list[0] = 1
    assert (before, plant.list[0]) == ([0, 0, 0, 0], 1)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda plant: plant.list.append(1), "always has 4 elements"),
        (lambda plant: plant.list.__setitem__(slice(0, 2), [1]), "always has 4 elements"),
        (lambda plant: plant.list.__setitem__(0, "x"), "cannot be 'x'"),
        (lambda plant: plant.pair.pop("a"), "always has a, b"),
        (lambda plant: plant.pair.__setitem__("c", 1), "has no c"),
        (lambda plant: plant.pair.__setitem__("a", 70_000), "cannot be 70000"),
    ],
)
def test_what_an_array_or_a_structure_cannot_be_is_refused(plc: Any, wrong: Any, said: str) -> None:
    plant = plc.block("Plant")
    with pytest.raises(ArgumentError, match=said):
        wrong(plant)
    assert (plant.list, plant.pair) == ([0, 0, 0, 0], {"a": 0, "b": [0.0, 0.0]})


def test_an_unknown_component_has_the_nearest_name(plc: Any) -> None:
    with pytest.raises(AttributeError, match=r"did you mean open\?"):
        assert plc.block("Plant").valves[0].opn


def test_an_index_outside_is_refused(plc: Any) -> None:
    with pytest.raises(IndexError):
        plc.block("Plant").list[4] = 1


def test_what_was_read_before_the_program_was_compiled_again_is_read_again(plc: Any) -> None:
    plant = plc.block("Plant")
    before = plant.list
    plc.block("Other")
    with pytest.raises(RigError, match="read it again"):
        before[0] = 1


def test_copies_are_plain(plc: Any) -> None:
    plant = plc.block("Plant")
    for one in (copy.copy(plant.pair), copy.deepcopy(plant.pair)):
        one["c"] = 1
    copy.deepcopy(plant.list).append(5)
    assert plant.pair == {"a": 0, "b": [0.0, 0.0]}


def test_a_program_has_the_name_of_its_instance_as_well(tmp_path: Path) -> None:
    cell = "CONFIGURATION Cell RESOURCE R ON PLC TASK Fast(INTERVAL := T#10ms, PRIORITY := 1);"
    cell += " PROGRAM Line1 WITH Fast : Main;"
    (tmp_path / "plant.st").write_text(f"{TEXT}\n{cell} END_RESOURCE END_CONFIGURATION")
    plc = program(tmp_path / "plant.st")
    plc["Line1.plant.list[0]"] = 4
    plc.start()
    plc.advance(20 * MS)
    assert (plc["line1.plant.sum"], plc["Main.plant.sum"]) == (4, 4)
