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
        (valve(OPEN).replace("place : INT", "place : INT; any : I_Valve"), "I_Valve is an interface, of which there"),
        ("INTERFACE I_Valve\nMETHOD Open\nEND_METHOD", "END_INTERFACE"),
    ],
)
def test_what_is_missing_or_differs_is_named(text: str, expected: str) -> None:
    found = refused(text, EDITION_3)
    assert any(expected in message for message in found), found


def test_the_controller_has_none() -> None:
    assert any("INTERFACE is not supported" in message for message in refused(INTERFACES, EPAS_4))
