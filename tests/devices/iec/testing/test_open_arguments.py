"""Tests in Python beyond plain values: open arrays, ANY, methods of inner instances, outputs of mocks."""

from pathlib import Path
from typing import Any

import pytest

from fieldrig import ArgumentError, program

TEXT = """
TYPE Pair : STRUCT a : INT; b : REAL; END_STRUCT END_TYPE
FUNCTION Largest : INT
VAR_IN_OUT list : ARRAY[*] OF INT; END_VAR
VAR i : DINT; END_VAR
Largest := list[LOWER_BOUND(list, 1)];
FOR i := LOWER_BOUND(list, 1) TO UPPER_BOUND(list, 1) DO
    IF list[i] > Largest THEN Largest := list[i]; END_IF
    list[i] := 0;
END_FOR
END_FUNCTION
FUNCTION Cells : DINT
VAR_IN_OUT grid : ARRAY[*, *] OF Pair; END_VAR
Cells := UPPER_BOUND(grid, 1) * 10 + UPPER_BOUND(grid, 2);
END_FUNCTION
FUNCTION Size : DINT
VAR_INPUT value : ANY; END_VAR
Size := value.diSize;
END_FUNCTION
FUNCTION Read : BOOL
VAR_INPUT channel : INT; END_VAR
VAR_OUTPUT value : INT; pair : Pair; END_VAR
VAR_IN_OUT count : DINT; END_VAR
END_FUNCTION
FUNCTION_BLOCK Base
VAR v : INT := 2; END_VAR
METHOD Add : INT
VAR_INPUT n : INT; END_VAR
v := v + n; Add := v;
END_METHOD
PROPERTY Level : INT
GET
Level := v;
END_GET
SET
v := Level;
END_SET
END_PROPERTY
PROPERTY Fixed : INT
GET
Fixed := 7;
END_GET
END_PROPERTY
END_FUNCTION_BLOCK
FUNCTION_BLOCK Tank EXTENDS Base
END_FUNCTION_BLOCK
FUNCTION_BLOCK Plant
VAR_INPUT what : ANY; END_VAR
VAR_IN_OUT all : ARRAY[*] OF INT; END_VAR
VAR_OUTPUT size, count : DINT; value : INT; pair : Pair; ok : BOOL; END_VAR
VAR one, other : Tank; reads : DINT; END_VAR
size := what.diSize;
count := UPPER_BOUND(all, 1) - LOWER_BOUND(all, 1) + 1;
ok := Read(channel := 3, value => value, pair => pair, count := reads);
END_FUNCTION_BLOCK
"""


@pytest.fixture
def plc(tmp_path: Path) -> Any:
    path = tmp_path / "plant.st"
    path.write_text(TEXT)
    return program(path, dialect="codesys")


def test_an_open_array_has_the_length_of_the_list(plc: Any) -> None:
    largest = plc.function("Largest")
    assert [largest([1, 5, 3]), largest([7]), largest([2] * 40 + [9])] == [5, 7, 9]
    assert largest.outputs == {"list": [0] * 41}
    cells = plc.function("Cells")
    assert cells([[{"a": 1}] * 3] * 2) == 12
    assert cells.outputs["grid"][1][2] == {"a": 1, "b": 0.0}


@pytest.mark.parametrize("value", [5, [], [[1], [2]], ["a"]])
def test_a_value_that_is_no_list_of_its_elements_is_refused(plc: Any, value: Any) -> None:
    with pytest.raises(ArgumentError, match=r"Largest\.list"):
        plc.function("Largest")(value)


@pytest.mark.parametrize("value", [[[{}], []], [{}], [[]]])
def test_lists_in_a_list_are_of_one_length(plc: Any, value: Any) -> None:
    with pytest.raises(ArgumentError, match=r"Cells\.grid"):
        plc.function("Cells")(value)


@pytest.mark.parametrize(("value", "size"), [(True, 1), (5, 4), (2**40, 8), (2**63, 8), (1.5, 8), ("ab", 81)])
def test_an_any_gets_the_type_of_the_value(plc: Any, value: Any, size: int) -> None:
    assert plc.function("Size")(value) == size


def test_a_value_without_a_single_type_is_no_any(plc: Any) -> None:
    with pytest.raises(ArgumentError, match=r"Size\.value cannot be \[1\]"):
        plc.function("Size")([1])


def test_a_block_takes_them_too_and_its_parts_stay_where_they_are(plc: Any) -> None:
    plant = plc.block("Plant")
    inner = plant.one
    inner.v = 40
    assert plant(all=[1, 2, 3]).count == 3
    assert (plant.size, inner.v) == (0, 40)
    assert plant(what=True, all=[1] * 9).count == 9
    assert (plant.size, inner.v, plant.all) == (1, 40, [1] * 9)
    assert plant(what=1.5).size == 8


def test_methods_and_properties_of_an_instance_within_one_are_its_own(plc: Any) -> None:
    plant = plc.block("Plant")
    assert plant.one.Add(4) == 6
    plant.other.Level = 30
    assert (plant.one.Level, plant.other.Level, plant.one.v, plant.other.add(1)) == (6, 30, 6, 31)


def test_a_property_without_set_and_a_method_cannot_be_set(plc: Any) -> None:
    for tank in (plc.block("Tank"), plc.block("Plant").one):
        with pytest.raises(ArgumentError, match="without SET"):
            tank.Fixed = 3
        with pytest.raises(ArgumentError, match="it is a method"):
            tank.Add = 3


def test_a_mock_may_give_the_outputs(plc: Any) -> None:
    def read(channel: int, outputs: Any) -> bool:
        outputs.value = 2 * channel
        outputs.pair = {"a": 5}
        outputs.pair.b = 1.5
        outputs.count += 10
        return True

    plant = plc.block("Plant")
    plc.mock("Read", read)
    plant(all=[1])
    plant()
    assert (plant.value, plant.pair, plant.reads, plant.ok) == (6, {"a": 5, "b": 1.5}, 20, True)


def test_an_argument_given_twice_and_a_number_beyond_a_real_are_refused(plc: Any) -> None:
    with pytest.raises(ArgumentError, match=r"Size\.value is given twice"):
        plc.function("Size")(1, value=2)
    with pytest.raises(ArgumentError, match=r"at most 3\.402823E38"):
        plc.block("Plant").pair = {"b": 1e39}
