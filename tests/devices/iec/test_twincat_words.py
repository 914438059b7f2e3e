"""Small constructs of TwinCAT's sources: words, names, and values, each with a program that stopped at it."""

import pytest
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import CODESYS, Dialect


def ran(text: str, dialect: Dialect = CODESYS) -> IecBench:
    bench = IecBench(text, dialect)
    bench.cycle()
    return bench


@pytest.mark.parametrize(
    ("text", "name", "expected"),
    [
        ("TYPE INTERNAL Level : INT; END_TYPE\n" + program("x : Level;", "x := 4;"), "x", 4),
        (
            "TYPE PUBLIC Pair : STRUCT a : INT; END_STRUCT; END_TYPE\n" + program("x : Pair;", "x.a := 4;"),
            "x.a",
            4,
        ),
        (program("x : LWORD;", "x := 16#7f_ff__ff;"), "x", 0x7FFFFF),
        (program("x : DINT;", "x := __SYSTEM.TYPE_CLASS.TYPE_LREAL;"), "x", 15),
        (program("x : LTIME := LTIME#200000d;", ""), "x", 200_000 * 86_400_000_000_000),
        (program("x : ULINT;", "x := LTIME_TO_ULINT(LTIME#213503d23h34m33s709ms551us615ns);"), "x", 2**64 - 1),
        (program("x : LTIME; a : TIME := T#2s;", "x := a * 3;"), "x", 6_000_000_000),
        (program("x : STRING;", "x := LTIME_TO_STRING(LTIME#1m30s5us);"), "x", "LTIME#1m30s5us"),
    ],
)
def test_a_small_construct_has_its_value(text: str, name: str, expected: object) -> None:
    assert ran(text)[name] == expected


ACCESSOR = """
FUNCTION_BLOCK Tank
VAR kept : INT := 7; END_VAR
PROPERTY Level : INT
GET {get}
VAR half : INT; END_VAR
half := kept / 2; Level := half * 2; END_GET
SET PRIVATE
kept := Level; END_SET
END_PROPERTY
METHOD Fill Level := 9; END_METHOD
END_FUNCTION_BLOCK
"""


@pytest.mark.parametrize("word", ["", "PUBLIC", "INTERNAL"])
def test_an_accessor_may_have_an_access_word(word: str) -> None:
    bench = ran(
        ACCESSOR.replace("{get}", word) + program("t : Tank; x, y : INT;", "x := t.Level; t.Fill(); y := t.Level;")
    )
    assert (bench["x"], bench["y"]) == (6, 8)


ENUMERATION = """
TYPE Mode : (AUTO, MANUAL, TEST, Lamp); END_TYPE
FUNCTION TEST : INT VAR_INPUT a : INT; END_VAR TEST := a + 1; END_FUNCTION
FUNCTION_BLOCK Lamp VAR n : INT := 3; END_VAR END_FUNCTION_BLOCK
FUNCTION_BLOCK MANUAL VAR n : INT := 5; END_VAR END_FUNCTION_BLOCK
"""


def test_a_value_of_an_enumeration_may_have_the_name_of_a_pou() -> None:
    text = ENUMERATION + program(
        "m : Mode := TEST; k : Mode; l : Lamp; o : MANUAL; x, y, z : INT;",
        """
        x := TEST(4);
        k := Mode.MANUAL;
        CASE m OF MANUAL: y := 1; TEST: y := 2; Lamp: y := 3; END_CASE
        z := l.n + o.n;
        """,
    )
    bench = ran(text)
    assert [bench[name] for name in ("x", "k", "y", "z")] == [5, 1, 2, 8]


def test_a_reference_may_be_a_result() -> None:
    text = """
    FUNCTION_BLOCK Store
    VAR held : INT := 4; END_VAR
    METHOD Found : REFERENCE TO INT VAR_INPUT n : INT; END_VAR
    IF n = 1 THEN Found REF= held; END_IF
    END_METHOD
    PROPERTY First : REFERENCE TO INT GET First REF= held; END_GET END_PROPERTY
    END_FUNCTION_BLOCK
    """ + program(
        "s : Store; a, b, c : BOOL; r : REFERENCE TO INT; x : INT;",
        "a := __ISVALIDREF(s.Found(1)); b := __ISVALIDREF(s.Found(2)); c := __ISVALIDREF(s.First);"
        "r REF= s.Found(1); r := 9; x := s.First;",
    )
    bench = ran(text)
    assert [bench[name] for name in "abcx"] == [True, False, True, 9]


def test_a_reference_input_may_get_nothing() -> None:
    text = (
        "FUNCTION Has : BOOL VAR_INPUT r : REFERENCE TO INT; END_VAR Has := __ISVALIDREF(r); END_FUNCTION\n"
        + program("i : INT; a, b : BOOL;", "a := Has(0); b := Has(i);")
    )
    bench = ran(text)
    assert (bench["a"], bench["b"]) == (False, True)


def test_a_constant_argument_is_handed_on_through_an_interface() -> None:
    text = """
    INTERFACE I_Sum METHOD Sum : INT VAR_IN_OUT CONSTANT a : INT; END_VAR END_METHOD END_INTERFACE
    FUNCTION_BLOCK Adder IMPLEMENTS I_Sum
    METHOD Sum : INT VAR_IN_OUT CONSTANT a : INT; END_VAR Sum := a + 1; END_METHOD
    END_FUNCTION_BLOCK
    FUNCTION Summed : INT VAR_IN_OUT CONSTANT a : INT; END_VAR VAR_INPUT s : I_Sum; END_VAR
    Summed := s.Sum(a);
    END_FUNCTION
    """ + program("d : Adder; x : INT;", "x := Summed(4, d);")
    assert ran(text)["x"] == 5
