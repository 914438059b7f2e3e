"""NAMESPACE, USING and ?= of edition 3 (results: programs/namespaces.st)."""

import pytest
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.printer import print_unit

MAIN = program("", "")
SHAPES = """
INTERFACE IShape METHOD Area : INT END_METHOD END_INTERFACE
INTERFACE INamed METHOD Name : STRING END_METHOD END_INTERFACE
CLASS Cube IMPLEMENTS IShape METHOD PUBLIC Area : INT Area := 4; END_METHOD END_CLASS
"""


@pytest.mark.parametrize(
    ("dialect", "text", "expected"),
    [
        (
            EDITION_3,
            "NAMESPACE A\nFUNCTION F : INT F := 1; END_FUNCTION\n",
            "END_NAMESPACE for the NAMESPACE in line 1",
        ),
        (EDITION_3, "END_NAMESPACE\n", "got END_NAMESPACE; expected PROGRAM"),
        (EDITION_3, "NAMESPACE 3\nEND_NAMESPACE\n", "got 3; expected the name of the namespace"),
        (EDITION_3, "USING A\n", "; is missing behind A"),
        (
            EDITION_3,
            "NAMESPACE A CLASS C END_CLASS END_NAMESPACE NAMESPACE B CLASS C END_CLASS END_NAMESPACE\n",
            "C is declared in main.st, line 1 already",
        ),
        (CODESYS, "NAMESPACE A\nEND_NAMESPACE\n", "Namespaces need the dialect edition-3."),
        (EPAS_4, "NAMESPACE A\nEND_NAMESPACE\n", "NAMESPACE is not supported."),
    ],
)
def test_a_wrong_namespace_is_refused(dialect: Dialect, text: str, expected: str) -> None:
    found = refused(text + MAIN, dialect)
    assert any(expected in message for message in found), found


def test_a_mistake_in_a_namespace_leaves_its_end_alone() -> None:
    found = [one for one in refused("NAMESPACE A\nnix\nEND_NAMESPACE\n" + MAIN, EDITION_3) if "note:" not in one]
    assert len(found) == 1, found


@pytest.mark.parametrize(
    ("dialect", "declarations", "body", "expected"),
    [
        (EDITION_3, "i : IShape; n : INT;", "i ?= n;", "n is an INT; expected a variable of an interface"),
        (EDITION_3, "i : IShape; n : INT;", "n ?= i;", "n is an INT; expected a variable of an interface"),
        (EDITION_3, "i : IShape;", "i ?= 3;", "expected a variable"),
        (EDITION_3, "i : IShape;", "i ?= nix;", "nix is not declared"),
        (CODESYS, "n : INT;", "n ?= 3;", "Here a ?= b is __QUERYINTERFACE(b, a)."),
        (EPAS_4, "n : INT;", "n ?= 3;", "got ?=; expected :="),
    ],
)
def test_a_wrong_attempt_is_refused(dialect: Dialect, declarations: str, body: str, expected: str) -> None:
    found = refused((SHAPES if dialect is EDITION_3 else "") + program(declarations, body), dialect)
    assert any(expected in message for message in found), found


def test_an_attempt_from_nothing_refers_to_nothing() -> None:
    body = "shape := cube; named ?= shape; was := named = NULL; shape := NULL; other ?= shape; is_null := other = NULL"
    variables = "cube : Cube; shape, other : IShape; named : INamed; was, is_null : BOOL;"
    bench = IecBench(SHAPES + program(variables, f"{body};"), EDITION_3)
    bench.cycle()
    assert bench.thread.fault is None
    assert (bench["was"], bench["is_null"]) == (True, True)


def test_an_attempt_keeps_its_sign_in_print() -> None:
    text = print_unit(parse(program("a, b : IShape;", "a ?= b;"), "a.st", EDITION_3)[0])
    assert "a ?= b;" in text
    assert print_unit(parse(text, "a.st", EDITION_3)[0]) == text


@pytest.mark.parametrize("dialect", [EDITION_3, CODESYS])
@pytest.mark.parametrize("is_first", [True, False])
def test_a_global_variable_may_have_the_name_of_its_type(dialect: Dialect, is_first: bool) -> None:
    types = """
        TYPE Level : STRUCT top : INT := 3; END_STRUCT; Colour : (red, green); END_TYPE
        FUNCTION_BLOCK Tank VAR_INPUT a : INT; END_VAR VAR_OUTPUT b : INT; END_VAR b := a + 1; END_FUNCTION_BLOCK
    """
    variables = "VAR_GLOBAL Tank : Tank; level : Level; colour : Colour := Colour#green; END_VAR "
    body = "Tank(a := Level.top); n := Tank.b; is_green := Colour = Colour#green; other(a := 8); m := other.b;"
    main = program("n, m : INT; other : Tank; is_green : BOOL;", body)
    bench = IecBench((variables + types if is_first else types + variables) + main, dialect)
    bench.cycle()
    assert (bench["n"], bench["m"], bench["is_green"]) == (4, 9, True)


def test_a_global_variable_has_no_name_of_another_variable_or_function() -> None:
    double = "VAR_GLOBAL a : INT; a : BOOL; END_VAR "
    assert any("a is declared in main.st" in one for one in refused(double + MAIN, EDITION_3))
    function = "FUNCTION F : INT F := 1; END_FUNCTION VAR_GLOBAL F : INT; END_VAR "
    assert any("F is declared in main.st" in one for one in refused(function + MAIN, CODESYS))
    block = "FUNCTION_BLOCK Tank END_FUNCTION_BLOCK VAR_GLOBAL Tank : Tank; END_VAR "
    assert any("Tank is declared in main.st" in one for one in refused(block + MAIN, EPAS_4))
