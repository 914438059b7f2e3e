"""Properties of function blocks: reading and writing one runs the code of its GET and SET."""

import pytest
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect

TANKS = """
FUNCTION_BLOCK Tank
VAR level : REAL; limit : INT := 500; writes : INT; END_VAR
PROPERTY PUBLIC Height : INT
GET
    Height := REAL_TO_INT(level * 1000.0);
END_GET
SET
VAR checked : INT; END_VAR
    checked := MIN(Height, limit);
    level := checked / 1000.0;
    writes := writes + 1;
END_SET
END_PROPERTY
PROPERTY Full : BOOL
GET
    Full := Height >= limit;
END_GET
END_PROPERTY
METHOD Fill : BOOL
VAR_INPUT more : INT; END_VAR
    Height := Height + more;
    THIS^.Height := THIS^.Height + 1;
    Fill := Full;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Slow_Tank EXTENDS Tank
PROPERTY Full : BOOL
GET
    Full := SUPER^.Full AND writes > 2;
END_GET
END_PROPERTY
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR one : Tank; others : ARRAY[1..2] OF Slow_Tank; n : INT; filled, slow : BOOL; END_VAR
one.Height := 100;
n := one.Height + 5;
filled := one.Fill(600);
others[2].Height := 600;
slow := others[2].Full;
END_PROGRAM
"""


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("n", (105, 105, 105)),
        ("one.level", (0.5, 0.5, 0.5)),
        ("one.writes", (3, 6, 9)),
        ("filled", (True, True, True)),
        ("others[2].writes", (1, 2, 3)),
        ("slow", (False, False, True)),
        ("others[1].writes", (0, 0, 0)),
    ],
)
def test_accesses_run_the_code_of_the_property(name: str, values: tuple[object, ...]) -> None:
    bench = IecBench(TANKS, EDITION_3)
    seen = []
    for _ in values:
        bench.cycle()
        seen.append(bench[name])
    assert tuple(seen) == values


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("one.Full := TRUE;", "the property one.Full has no SET"),
        ("n := one.Limit;", "the property one.Limit has no GET"),
        ("one.Limit := 'x';", "'x' is a STRING(1); expected INT"),
        ("n := one.None;", "Tank has no variable None"),
        ("m := one.Height;", "m is not declared"),
        ("wrong.Full := 1;", "wrong is not declared"),
    ],
)
def test_what_a_property_does_not_allow(body: str, expected: str) -> None:
    text = """
    FUNCTION_BLOCK Tank
    VAR level : INT; END_VAR
    PROPERTY Full : BOOL GET Full := level > 5; END_GET END_PROPERTY
    PROPERTY Limit : INT SET level := Limit; END_SET END_PROPERTY
    PROPERTY Height : INT GET END_GET SET END_SET END_PROPERTY
    END_FUNCTION_BLOCK
    """
    found = refused(f"{text} PROGRAM PLC_PRG VAR one : Tank; n : INT; END_VAR {body} END_PROGRAM", CODESYS)
    assert len([message for message in found if "note" not in message]) == 1
    assert any(expected in message for message in found), found


def test_a_property_needs_an_accessor_and_a_block() -> None:
    empty = "FUNCTION_BLOCK A PROPERTY P : INT\nEND_PROPERTY END_FUNCTION_BLOCK"
    assert any("P cannot be read or written" in message for message in refused(empty, EDITION_3))
    alone = "PROPERTY P : INT GET P := 1; END_GET END_PROPERTY"
    assert any("the property P belongs to no POU" in message for message in refused(alone, EDITION_3))
    assert any("PROPERTY" in message for message in refused(TANKS, EPAS_4))


@pytest.mark.parametrize("dialect", [EDITION_3, CODESYS])
def test_a_property_of_an_interface_without_accessors_can_be_read(dialect: Dialect) -> None:
    text = """
        INTERFACE IDevice
        PROPERTY Number : INT
        END_PROPERTY
        END_INTERFACE
        FUNCTION_BLOCK Drive IMPLEMENTS IDevice
        PROPERTY Number : INT GET Number := 7; END_GET END_PROPERTY
        END_FUNCTION_BLOCK
    """
    variables = "drive : Drive; device : IDevice; n : INT;"
    bench = IecBench(text + program(variables, "device := drive; n := device.Number;"), dialect)
    bench.cycle()
    assert bench["n"] == 7
    found = refused(text + program(variables, "device := drive; device.Number := 3;"), dialect)
    assert any("Number" in message for message in found), found
    found = refused(text.replace("GET Number := 7; END_GET", "SET ; END_SET") + program("", ""), dialect)
    assert any("Number" in message for message in found), found


def test_a_property_of_what_the_own_property_of_an_interface_gives() -> None:
    text = """
    INTERFACE IKind PROPERTY Title : STRING GET END_GET END_PROPERTY END_INTERFACE
    FUNCTION_BLOCK Bool_ IMPLEMENTS IKind
    PROPERTY Title : STRING GET Title := 'BOOL'; END_GET END_PROPERTY
    END_FUNCTION_BLOCK
    FUNCTION_BLOCK Items
    VAR kind : Bool_; END_VAR
    PROPERTY Kind_ : IKind GET Kind_ := kind; END_GET END_PROPERTY
    METHOD Name : STRING Name := CONCAT('OF ', Kind_.Title); END_METHOD
    END_FUNCTION_BLOCK
    """
    bench = IecBench(text + program("items : Items; s : STRING;", "s := items.Name();"), CODESYS)
    bench.cycle()
    assert bench["s"] == "OF BOOL"
