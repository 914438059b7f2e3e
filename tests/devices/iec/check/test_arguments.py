"""Arguments that are passed by their address: to a VAR_IN_OUT, a VAR_IN_OUT CONSTANT or an ARRAY[*]."""

import pytest
from iec_check import messages
from iec_check import program as configured
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect

TYPES = """TYPE Colour : (red, green, blue); END_TYPE
TYPE Pair : STRUCT a, b : INT; r : ARRAY[0..2] OF INT; END_STRUCT END_TYPE
VAR_GLOBAL CONSTANT fixed : Pair := (a := 1); END_VAR
FUNCTION Both : Pair
Both.a := 4;
END_FUNCTION
FUNCTION Inc : INT
VAR_IN_OUT n : INT; END_VAR
n := n + 1;
Inc := n;
END_FUNCTION
FUNCTION Paint : INT
VAR_IN_OUT c : Colour; END_VAR
Paint := 1;
END_FUNCTION
FUNCTION Length : INT
VAR_IN_OUT s : STRING(4); END_VAR
Length := LEN(s);
END_FUNCTION
"""
CONSTANT = """FUNCTION Kept : INT
VAR_IN_OUT CONSTANT n : INT; END_VAR
Kept := n;
END_FUNCTION
FUNCTION KeptPair : INT
VAR_IN_OUT CONSTANT p : Pair; END_VAR
KeptPair := p.a;
END_FUNCTION
FUNCTION KeptText : INT
VAR_IN_OUT CONSTANT s : STRING(4); END_VAR
KeptText := LEN(s);
END_FUNCTION
FUNCTION_BLOCK Limits
VAR_INPUT CONSTANT given : INT := 5; END_VAR
VAR CONSTANT most : INT := 9; all : ARRAY[0..1] OF INT; END_VAR
END_FUNCTION_BLOCK
FUNCTION OfInput : INT
VAR_INPUT p : Pair; END_VAR
OfInput := Inc(p.b) + Inc(p.r[1]);
END_FUNCTION
TYPE Either : UNION a : INT; pair : Pair; END_UNION END_TYPE
FUNCTION One : Either
One.a := 4;
END_FUNCTION
FUNCTION Long : DINT
Long := 1;
END_FUNCTION
TYPE Hidden : STRUCT wide : DINT; END_STRUCT END_TYPE
"""
VARIABLES = """x, y : INT; wide : DINT; pair : Pair; wides : ARRAY[0..1] OF DINT; c : Colour; w AT %MD4 : DWORD;
s3 : STRING(3); s4 : STRING(4); s5 : STRING(5);"""
MORE = " p : POINTER TO DINT; limits : Limits; hidden : Hidden; ws : WSTRING(4);"


def calling(call: str, dialect: Dialect) -> str:
    is_codesys = dialect is CODESYS  # the only one with VAR_IN_OUT CONSTANT
    types, variables = (TYPES + CONSTANT, VARIABLES + MORE) if is_codesys else (TYPES, VARIABLES)
    return types + program(variables, f"x := {call};")


def said(call: str, dialect: Dialect) -> list[str]:
    """Return all messages about a call, without notes."""
    found = [message.partition("\n")[0].split(": ", 1)[1] for message in refused(calling(call, dialect), dialect)]
    return [message for message in found if not message.startswith("note")]


def result(call: str, dialect: Dialect) -> object:
    bench = IecBench(calling(call, dialect), dialect)
    bench.cycle()
    return bench["x"]


@pytest.mark.manual("PD-352")
@pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3, CODESYS])
@pytest.mark.parametrize(
    ("call", "expected"),
    [
        ("Inc(-y)", "-y is passed to the VAR_IN_OUT n; expected a variable"),
        ("Inc(Both().a)", "Both(...).a is passed to the VAR_IN_OUT n; expected a variable"),
        ("Inc(Both().r[1])", "Both(...).r[1] is passed to the VAR_IN_OUT n; expected a variable"),
        ("Inc(fixed.a)", "fixed.a is a constant and n may be changed; expected a variable that may be written"),
        ("Inc(fixed.r[1])", "fixed.r[1] is a constant and n may be changed; expected a variable that may be written"),
        ("Length(s3)", "s3 is a STRING(3); expected a variable of type STRING(4) for the VAR_IN_OUT s"),
        ("Paint(y)", "y is an INT; expected a variable of type Colour for the VAR_IN_OUT c"),
    ],
)
def test_what_is_refused_has_one_message(call: str, expected: str, dialect: Dialect) -> None:
    assert said(call, dialect) == [expected]


def test_an_enumeration_is_no_integer_in_edition_3() -> None:
    assert said("Inc(c)", EDITION_3) == ["c is a Colour; expected a variable of type INT for the VAR_IN_OUT n"]


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        ("Kept(wide)", "wide is a DINT; expected a variable of type INT for the VAR_IN_OUT n"),
        ("Kept(wides[1])", "wides[1] is a DINT; expected a variable of type INT for the VAR_IN_OUT n"),
        ("Kept(p^)", "p^ is a DINT; expected a variable of type INT for the VAR_IN_OUT n"),
        ("Kept(y.3)", "y.3 is a bit and has no address for the VAR_IN_OUT n; expected a variable without AT (PD-352)"),
        ("Kept(%MD4)", "%MD4 is a DWORD; expected a variable of type INT for the VAR_IN_OUT n"),
        ("Kept(Inc(y))", "Inc(...) is passed to the VAR_IN_OUT n; expected a variable"),
        ("Kept(Long())", "Long(...) is passed to the VAR_IN_OUT n; expected a variable"),
        ("Kept(Both().a)", "Both(...).a is passed to the VAR_IN_OUT n; expected a variable"),
        ("Inc(One().pair.b)", "One(...).pair.b is passed to the VAR_IN_OUT n; expected a variable"),
        ("KeptPair(3)", "3 is passed to the VAR_IN_OUT p; expected a variable"),
        ("KeptText(ws)", "ws is a WSTRING(4); expected a variable of type STRING(4) for the VAR_IN_OUT s"),
        ("Kept(pair)", "pair is a Pair; expected a variable of type INT for the VAR_IN_OUT n"),
        ("Kept(hidden.wide)", "hidden.wide is a DINT; expected a variable of type INT for the VAR_IN_OUT n"),
        ("Inc(limits.most)", "limits.most is passed to the VAR_IN_OUT n; expected a variable"),
        (
            "Inc(limits.all[1])",
            "limits.all[1] is a constant and n may be changed; expected a variable that may be written",
        ),
    ],
)
def test_what_is_refused_for_a_constant_reference_has_one_message(call: str, expected: str) -> None:
    assert said(call, CODESYS) == [expected]


@pytest.mark.parametrize(
    ("call", "dialects", "expected"),
    [
        ("Inc(pair.b)", [EPAS_4, EDITION_3, CODESYS], 1),
        ("Inc(pair.r[2])", [EPAS_4, EDITION_3, CODESYS], 1),
        ("Length(s4)", [EPAS_4, EDITION_3, CODESYS], 0),
        ("Length(s5)", [EPAS_4, EDITION_3, CODESYS], 0),
        ("Paint(c)", [EPAS_4, EDITION_3, CODESYS], 1),
        ("Inc(c)", [EPAS_4, CODESYS], 1),
        ("Kept(limits.most)", [CODESYS], 9),
        ("Inc(limits.given)", [CODESYS], 6),
        ("KeptPair(fixed)", [CODESYS], 1),
        ("OfInput(pair)", [CODESYS], 2),
        ("KeptText(s3)", [CODESYS], 0),
        ("KeptText('seven')", [CODESYS], 5),
    ],
)
def test_what_fits_is_passed(call: str, dialects: list[Dialect], expected: int) -> None:
    assert [result(call, dialect) for dialect in dialects] == [expected] * len(dialects)


@pytest.mark.parametrize(("limits", "index"), [("*", "1"), ("*, *", "1, 1")])
def test_an_element_of_an_open_input_is_not_changed(limits: str, index: str) -> None:
    text = f"""{TYPES}FUNCTION First : INT
VAR_INPUT a : ARRAY[{limits}] OF INT; END_VAR
First := Inc(a[{index}]);
END_FUNCTION
{program("", "")}"""
    expected = f"a[{index}] is a part of the VAR_INPUT, of which there is no copy, and n may be changed"
    assert any(expected in message for message in refused(text, EDITION_3))


def test_an_array_that_is_passed_by_its_address_is_never_left_out() -> None:
    """A call with names may leave other inputs out in edition 3."""
    text = """FUNCTION First : INT
VAR_INPUT a : ARRAY[*] OF INT; b, c : INT; END_VAR
First := a[1] + b;
END_FUNCTION
"""
    found = refused(text + program("n : INT;", "n := First(b := 1);"), EDITION_3)
    assert any("the argument a is missing in the call of First" in message for message in found), found


def test_an_object_of_the_configuration_is_never_left_out() -> None:
    text = "FUNCTION State : INT VAR_INPUT axis : MC_4; a, b : INT; END_VAR State := a; END_FUNCTION"
    assert messages(text, configured("n : INT;", "n := State(a := 1);"), dialect=EDITION_3) == [
        "3:6 the argument axis is missing in the call of State; values for axis, a, b"
    ]
