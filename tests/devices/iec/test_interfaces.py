"""Interfaces: a function block has what those that it implements ask for."""

import pytest
from iec_program import IecBench, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect

INTERFACES = """
INTERFACE I_Valve EXTENDS I_Part
METHOD Open : BOOL
VAR_INPUT amount : INT; END_VAR
END_METHOD
END_INTERFACE
INTERFACE I_Part
PROPERTY Place : INT GET END_GET END_PROPERTY
END_INTERFACE
"""
PART = """
FUNCTION_BLOCK ABSTRACT Part IMPLEMENTS I_Part
VAR present : INT; END_VAR
PROPERTY Place : INT GET Place := present; END_GET END_PROPERTY
END_FUNCTION_BLOCK
"""
OPEN = """
METHOD Open : BOOL
VAR_INPUT amount : INT; END_VAR
present := present + amount;
Open := TRUE;
END_METHOD
"""
MAIN = """
PROGRAM PLC_PRG
VAR one : Valve; place : INT; END_VAR
IF one.Open(4) THEN place := one.Place; END_IF;
END_PROGRAM
"""


def valve(methods: str, head: str = "EXTENDS Part IMPLEMENTS I_Valve, I_Part") -> str:
    return f"{INTERFACES}{PART}FUNCTION_BLOCK FINAL Valve {head}\n{methods} END_FUNCTION_BLOCK {MAIN}"


@pytest.mark.parametrize("dialect", [EDITION_3, CODESYS])
def test_a_block_that_has_everything_runs(dialect: Dialect) -> None:
    bench = IecBench(valve(OPEN), dialect)
    bench.cycle()
    assert bench["place"] == 4


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (valve(OPEN, "IMPLEMENTS I_Valve"), "Valve has no property Place with GET; expected all of I_Part"),
        (valve(OPEN.replace("amount : INT", "amount : DINT")), "the method Open of Valve differs from that of I_Valve"),
        (valve(OPEN.replace("Open : BOOL", "Open : INT")), "the method Open of Valve differs"),
        (valve(OPEN.replace("amount", "size")), "the method Open of Valve differs"),
        (valve("", "EXTENDS Part IMPLEMENTS I_Valve"), "Valve has no method Open"),
        (valve(OPEN, "EXTENDS Part IMPLEMENTS I_Valves"), "the interface I_Valves is not declared"),
        (valve(OPEN).replace("place : INT", "place : INT; any : I_Valve := 1"), "the number 1 is no I_Valve"),
        ("INTERFACE I_Valve\nMETHOD Open\nEND_METHOD", "END_INTERFACE"),
    ],
)
def test_what_is_missing_or_differs_is_named(text: str, expected: str) -> None:
    found = refused(text, EDITION_3)
    assert any(expected in message for message in found), found


def test_the_controller_has_none() -> None:
    assert any("INTERFACE is not supported" in message for message in refused(INTERFACES, EPAS_4))


USED = """
INTERFACE I_Lamp METHOD Light END_METHOD END_INTERFACE
FUNCTION_BLOCK Lamp IMPLEMENTS I_Lamp METHOD Light END_METHOD END_FUNCTION_BLOCK
FUNCTION_BLOCK Bulb EXTENDS Lamp VAR n : INT; END_VAR METHOD Light n := n + 1; END_METHOD END_FUNCTION_BLOCK
FUNCTION_BLOCK Stone END_FUNCTION_BLOCK
FUNCTION Lit : BOOL VAR_IN_OUT it : Bulb; END_VAR Lit := TRUE; END_FUNCTION
"""


@pytest.mark.parametrize("dialect", [EDITION_3, CODESYS])
@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("it := stone;", "stone is a Stone; expected an instance of a block that implements I_Lamp"),
        ("it := valve;", "valve is an I_Valve; expected an instance of a block that implements I_Lamp"),
        ("it := 5;", "the number 5 is no I_Lamp"),
        ("it := text;", "text is a STRING; expected I_Lamp"),
        ("bulb := it;", "it is an I_Lamp; expected Bulb"),
        ("it^.Light();", "it is an I_Lamp; expected a pointer in front of ^"),
        ("it.Dark();", "I_Lamp has no method or property Dark; expected light"),
        ("it();", "it is an I_Lamp and cannot be called"),
        ("isLit := Lit(lamp);", "lamp is a Lamp; expected a variable of type Bulb"),
    ],
)
def test_what_a_variable_of_an_interface_cannot_be(dialect: Dialect, body: str, expected: str) -> None:
    variables = "it : I_Lamp; valve : I_Valve; stone : Stone; lamp : Lamp; bulb : Bulb; text : STRING; isLit : BOOL;"
    found = refused(f"{USED}{INTERFACES}PROGRAM PLC_PRG VAR {variables} END_VAR {body} END_PROGRAM", dialect)
    assert any(expected in message for message in found), found


def test_the_word_of_a_block_is_not_shown() -> None:
    bench = IecBench(
        f"{USED}PROGRAM PLC_PRG VAR bulb : Bulb; it : I_Lamp; END_VAR it := bulb; it.Light(); END_PROGRAM", CODESYS
    )
    bench.cycle()
    assert [path for path in bench.values() if "bulb" in path] == ["PLC_PRG.bulb.n"]
    assert bench["bulb.n"] == 1


def test_an_instance_keeps_its_block_in_an_online_change() -> None:
    text = f"{USED}PROGRAM PLC_PRG VAR bulb : Bulb; it : I_Lamp; END_VAR it := bulb; it.Light(); END_PROGRAM"
    bench = IecBench(text, CODESYS)
    bench.cycle()
    more = "FUNCTION_BLOCK Also IMPLEMENTS I_Lamp METHOD Light END_METHOD END_FUNCTION_BLOCK"
    bench.runtime.change(bench.compile(f"{more}{text}", bench.compiled))
    bench.cycle()
    assert bench["bulb.n"] == 2
