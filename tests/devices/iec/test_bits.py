"""BIT: components of a structure that have one bit each (the public description of CODESYS V3)."""

import pytest
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3

FLAGS = """
TYPE Flags : STRUCT b0, b1 : BIT; b2 : BIT := TRUE; b3, b4, b5, b6, b7, b8 : BIT; n : INT; c0 : BIT := TRUE; END_STRUCT;
END_TYPE
TYPE Seen : UNION bits : Flags; bytes : ARRAY[0..4] OF BYTE; END_UNION; END_TYPE
"""


@pytest.fixture
def bench() -> IecBench:
    text = FLAGS + program(
        "f, g : Flags; u : Seen; list : ARRAY[1..2] OF Flags; x : BOOL; size, place : DINT;",
        "size := SIZEOF(f); place := ADR(f.n) - ADR(f); x := f.b2 AND NOT f.b1; f.b8 := TRUE; f.n := -1; g := f; "
        "u.bits.b0 := TRUE; u.bits.b7 := TRUE; u.bits.b2 := FALSE; list[2].b3 := list[2].b2;",
    )
    made = IecBench(text, CODESYS)
    made.cycle()
    return made


def test_eight_have_one_byte(bench: IecBench) -> None:
    assert (bench["size"], bench["place"]) == (5, 2)


def test_each_has_its_own_value(bench: IecBench) -> None:
    assert [bench[f"g.{name}"] for name in ("b0", "b2", "b7", "b8", "n", "c0")] == [False, True, False, True, -1, True]
    assert bench["x"] is True
    assert (bench["list[1].b3"], bench["list[2].b3"]) == (False, True)


def test_the_bytes_show_them(bench: IecBench) -> None:
    assert bench["u.bytes[0]"] == 0x81


def test_a_tool_can_write_one(bench: IecBench) -> None:
    bench["g.b1"] = True
    bench["g.b2"] = False
    assert [bench[f"g.{name}"] for name in ("b0", "b1", "b2", "b3")] == [False, True, False, False]


def test_a_start_value_may_be_given_by_the_variable() -> None:
    text = FLAGS + program("f : Flags := (b0 := TRUE, b2 := FALSE, n := 3);", "")
    bench = IecBench(text, CODESYS)
    assert [bench[f"f.{name}"] for name in ("b0", "b1", "b2", "n", "c0")] == [True, False, False, 3, True]


def test_the_standard_has_none() -> None:
    assert any("the type BIT is not declared" in message for message in refused(FLAGS + program("", ""), EDITION_3))
