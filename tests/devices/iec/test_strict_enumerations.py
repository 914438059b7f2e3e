"""Attributes of enumerations, 'strict' and 'qualified_only': expectations from what CODESYS and TwinCAT say of them."""

from dataclasses import replace

import pytest
from iec_program import IecBench, refused

from fieldrig_devices.iec.dialect import CODESYS

TYPES = """
{attribute 'qualified_only'}
{attribute 'strict'}
TYPE Colour : (red := 1, green, blue := 7); END_TYPE
TYPE Loose : (one := 1, two); END_TYPE
FUNCTION Next_ : Colour
VAR_INPUT c : Colour; END_VAR
Next_ := Colour.blue;
END_FUNCTION
"""


def text(body: str, start: str = "") -> str:
    return (
        f"{TYPES}PROGRAM PLC_PRG\nVAR c, d : Colour{start}; l : Loose; n : INT; b : BOOL; END_VAR\n{body}\nEND_PROGRAM"
    )


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("c := 3;", "3 is no value of Colour"),
        ("c := -1;", "-1 is no value of Colour"),
        ("c := n;", "n is no value of Colour, which is strict"),
        ("c := n + 1;", "n + 1 is no value of Colour, which is strict"),
        ("c := l;", "l is a Loose"),
        ("c := Loose.one;", "Loose.one is a Loose"),
        ("c := c + 1;", "+ with a value of Colour, which is strict"),
        ("n := Colour.red * 2;", "* with a value of Colour, which is strict"),
        ("n := 5 - c;", "- with a value of Colour, which is strict"),
        ("c := Next_(4);", "4 is no value of Colour"),
        ("c := Next_(c := n);", "n is no value of Colour, which is strict"),
    ],
)
def test_numbers_are_refused(body: str, said: str) -> None:
    assert said in "\n".join(refused(text(body), CODESYS))


def test_a_start_value_is_one_of_the_values() -> None:
    assert "5 is no value of Colour" in "\n".join(refused(text(";", " := 5"), CODESYS))


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("c := Colour.green; n := c;", 2),
        ("c := Next_(Colour.red); n := TO_INT(c);", 7),
        ("n := TO_INT(Colour.blue) + 1;", 8),
        ("c := Colour.blue; IF c = Colour.blue AND c > Colour.red THEN n := 3; END_IF", 3),
        ("c := Colour.blue; CASE c OF Colour.red: n := 1; Colour.blue: n := 4; END_CASE", 4),
        ("c := Colour.blue; d := c; n := d;", 7),
        ("c := SEL(TRUE, Colour.red, Colour.green); n := c;", 2),
        ("l := 2; n := l + 1;", 3),
        ("c := 7; n := c;", 7),
        ("c := Next_(2); n := c;", 7),
    ],
)
def test_values_are_taken(body: str, expected: int) -> None:
    bench = IecBench(text(body, " := Colour.red"), CODESYS)
    bench.cycle()
    assert bench["n"] == expected


def test_the_other_dialects_read_no_attribute() -> None:
    bench = IecBench(text("c := 2; n := c + 1;"), replace(CODESYS, has_enumeration_attributes=False))
    bench.cycle()
    assert bench["n"] == 3


@pytest.mark.parametrize("body", ["c := red;", "IF c = green THEN n := 1; END_IF", "CASE c OF blue: n := 1; END_CASE"])
def test_values_are_known_behind_the_name_alone(body: str) -> None:
    assert "is not declared" in "\n".join(refused(text(body), CODESYS))


def test_values_of_the_same_name_are_those_of_their_types() -> None:
    other = "{attribute 'qualified_only'} TYPE Light : (red := 5, green); END_TYPE\n"
    bench = IecBench(other + text("c := Colour.red; n := TO_INT(c) * 10 + Light.red;"), CODESYS)
    bench.cycle()
    assert bench["n"] == 15
