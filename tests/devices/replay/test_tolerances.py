"""The words of users for objects, registers and identifiers."""

import pytest

from fieldrig.errors import UsageError
from fieldrig.traces.parts import Part
from fieldrig_devices.replay.tolerances import Tolerances, value_tolerances

POSITION = Part("6064h", "Position actual value", 1000, "1000")
VENDOR = Part("1018h:01", "Vendor-ID", 7, "7")


@pytest.mark.parametrize(
    "word",
    ["6064h", "0x6064", "6064", "6064:00", "6064H", "axis/6064h", "axis/0x6064", "node 3 (axis)/6064h", "position*"],
)
def test_an_object_is_left_out_however_it_is_spelled(word: str) -> None:
    assert Tolerances(leave_out=[word]).is_left_out("node 3 (axis)", POSITION.key, POSITION.name)


@pytest.mark.parametrize("word", ["6065h", "belt/6064h", "6064:01", "185"])
def test_other_objects_are_not(word: str) -> None:
    assert not Tolerances(leave_out=[word]).is_left_out("node 3 (axis)", POSITION.key, POSITION.name)


@pytest.mark.parametrize("word", ["1018:01", "1018h:01", "0x1018:01", "vendor-id"])
def test_a_sub_index_is_spelled_with_a_colon(word: str) -> None:
    assert Tolerances(leave_out=[word]).is_left_out("io", VENDOR.key, VENDOR.name)


@pytest.mark.parametrize("word", ["185", "0x185", "185h"])
def test_an_identifier_is_left_out(word: str) -> None:
    assert Tolerances(leave_out=[word]).is_left_out("io", "185", "TPDO 1")


@pytest.mark.parametrize(("words", "differs"), [(["6064h=3"], False), (["0x6064=2.9"], True), (["axis/6064=3"], False)])
def test_a_value_may_differ_by_its_tolerance(words: list[str], differs: bool) -> None:
    other = POSITION._replace(value=1003, text="1003")
    tolerances = Tolerances(values=value_tolerances(words))
    assert bool(list(tolerances.differences("node 3 (axis)", [POSITION], [other]))) == differs


def test_a_value_that_is_missing_is_in_no_tolerance() -> None:
    assert list(Tolerances(values={"6064h": 1e9}).differences("axis", [POSITION], []))


@pytest.mark.parametrize("word", ["6064h", "=3", "6064h=", "6064h=-1", "6064h=nan", "6064h=much"])
def test_a_tolerance_without_a_number_is_refused(word: str) -> None:
    with pytest.raises(UsageError, match="is not a tolerance"):
        value_tolerances([word])
