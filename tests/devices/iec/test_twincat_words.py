"""Small constructs of TwinCAT's sources: words, names, and values, each with a program that stopped at it."""

import pytest
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EPAS_4, Dialect
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile


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


def test_the_size_of_a_block_and_of_a_type_of_a_library() -> None:
    text = "FUNCTION_BLOCK Lamp VAR a : DINT; b : INT; END_VAR END_FUNCTION_BLOCK\n" + program(
        "x, y : UDINT;", "x := SIZEOF(Lamp); y := SIZEOF(Tc2_System.T_MaxString);"
    )
    bench = ran(text)
    assert (bench["x"], bench["y"]) == (6, 256)


def test_this_is_a_pointer_to_the_instance() -> None:
    text = """
    VAR_GLOBAL exits : INT; END_VAR
    FUNCTION_BLOCK Node
    VAR n : INT := 3; END_VAR
    METHOD Own : POINTER TO Node Own := THIS; END_METHOD
    METHOD Gone __DELETE(THIS); END_METHOD
    METHOD FB_exit : BOOL VAR_INPUT bInCopyCode : BOOL; END_VAR exits := exits + n; END_METHOD
    END_FUNCTION_BLOCK
    """ + program(
        "a : Node; p : POINTER TO Node; isSame : BOOL; x : INT;",
        "p := a.Own(); isSame := p = ADR(a); x := a.Own()^.n; p := __NEW(Node); p^.Gone();",
    )
    bench = ran(text)
    assert (bench["isSame"], bench["x"], bench["exits"]) == (True, 3, 3)


def test_an_instance_on_the_stack_may_be_handed_out_by_its_own_code() -> None:
    text = """
    INTERFACE I_Node METHOD Value : INT END_METHOD END_INTERFACE
    FUNCTION_BLOCK Node IMPLEMENTS I_Node
    VAR n : INT; END_VAR
    METHOD FB_init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; k : INT; END_VAR n := k; END_METHOD
    METHOD Value : INT Value := n; END_METHOD
    METHOD Own : I_Node Own := THIS^; END_METHOD
    END_FUNCTION_BLOCK
    FUNCTION Through : INT VAR_INPUT i : I_Node; END_VAR Through := i.Value(); END_FUNCTION
    FUNCTION Local : INT VAR before : LREAL; a : Node(5); END_VAR Local := Through(a.Own()); END_FUNCTION
    """ + program("x : INT;", "x := Local();")
    assert ran(text)["x"] == 5


def test_a_character_of_windows_has_one_byte() -> None:
    bench = ran(program("s : STRING := '€5'; n : INT; b : BYTE;", "n := LEN(s); b := s[0];"))
    assert (bench["n"], bench["b"]) == (2, 0x80)


def test_sel_computes_only_what_it_chooses() -> None:
    text = program(
        "a : ARRAY[0..2] OF INT := [5, 6, 7]; i, x, y : INT;",
        "x := SEL(i > 0, 3, a[i - 1]); i := 2; y := SEL(i > 0, a[i + 5], a[i - 1]);",
    )
    bench = ran(text)
    assert (bench["x"], bench["y"]) == (3, 6)


def test_the_result_of_a_call_is_not_lost_among_the_other_arguments() -> None:
    text = """
    TYPE Pair : STRUCT a, b, c : INT; END_STRUCT; END_TYPE
    VAR_GLOBAL seen : STRING; END_VAR
    FUNCTION Text : STRING VAR_INPUT n : INT; END_VAR Text := INT_TO_STRING(n); END_FUNCTION
    FUNCTION Made : Pair VAR_INPUT n : INT; END_VAR Made.a := n; Made.b := 2 * n; Made.c := 3 * n; END_FUNCTION
    FUNCTION Say VAR_INPUT n : INT; t : STRING; END_VAR seen := CONCAT(t, INT_TO_STRING(n)); END_FUNCTION
    FUNCTION Sum : INT VAR_INPUT n : INT; p : Pair; END_VAR Sum := n + p.a + p.b + p.c; END_FUNCTION
    """ + program("x : INT;", "Say(4, Text(77)); x := Sum(100, Made(1));")
    bench = ran(text)
    assert (bench["seen"], bench["x"]) == ("774", 106)


OBJECT = """<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1"><POU Name="PLC_PRG" Id="{0}">
<Declaration><![CDATA[PROGRAM PLC_PRG
VAR Configuration : INT; END_VAR]]></Declaration>
<Implementation><ST><![CDATA[Configuration := 4;]]></ST></Implementation>
<Method Name="Drawn" Id="{1}"><Declaration><![CDATA[METHOD Drawn]]></Declaration>
<Implementation>BODY</Implementation></Method>
</POU></TcPlcObject>
"""
EMPTY_CFC = (
    '<CFC><XmlArchive><Data><o><o n="Items" t="CFCItemList"><l2 n="InnerList"/></o></o></Data></XmlArchive></CFC>'
)
EMPTY_LD = (
    '<NWL><XmlArchive><Data><o><l2 n="NetworkList"><o><l2 n="NetworkItems"/></o></l2></o></Data></XmlArchive></NWL>'
)


@pytest.mark.parametrize("body", [EMPTY_CFC, EMPTY_LD])
def test_an_empty_drawing_and_a_keyword_of_others_as_a_name(body: str) -> None:
    bench = IecBench(OBJECT.replace("BODY", body), CODESYS, name="PLC_PRG.TcPOU")
    bench.cycle()
    assert bench["Configuration"] == 4


def test_a_drawing_with_something_in_it_is_refused() -> None:
    full = EMPTY_CFC.replace('<l2 n="InnerList"/>', '<l2 n="InnerList"><o t="CFCItem"/></l2>')
    with pytest.raises(CompileError, match="The body is in CFC"):
        IecBench(OBJECT.replace("BODY", full), CODESYS, name="PLC_PRG.TcPOU")


def test_a_name_behind_that_of_a_library_is_no_variable_of_the_program() -> None:
    text = "FUNCTION Twice : INT VAR_INPUT x : INT; END_VAR Twice := 2 * x; END_FUNCTION\n"
    body = "len := Tc2_Standard.LEN('abc'); twice := Lib.Twice(len);"
    bench = IecBench(text + program("len, twice : INT;", body), CODESYS)
    bench.cycle()
    assert (bench["len"], bench["twice"]) == (3, 6)


ALIKE = """
FUNCTION Next : BOOL VAR_IN_OUT value : {wanted}; END_VAR value := value + 1; Next := TRUE; END_FUNCTION
"""


@pytest.mark.parametrize(
    ("wanted", "given"), [("WORD", "UINT"), ("UINT", "WORD"), ("BYTE", "USINT"), ("LWORD", "ULINT")]
)
def test_an_unsigned_integer_is_passed_for_a_bit_string_of_its_size(wanted: str, given: str) -> None:
    text = ALIKE.format(wanted=wanted)
    bench = IecBench(text + program(f"x : {given} := 7; b : BOOL;", "b := Next(x);"), CODESYS)
    bench.cycle()
    assert bench["x"] == 8


@pytest.mark.parametrize(
    ("wanted", "given", "dialect"),
    [("WORD", "INT", CODESYS), ("WORD", "UDINT", CODESYS), ("INT", "UINT", CODESYS), ("WORD", "UINT", EPAS_4)],
)
def test_no_other_number_is_passed_for_a_bit_string(wanted: str, given: str, dialect: Dialect) -> None:
    text = ALIKE.format(wanted=wanted) + program(f"x : {given}; b : BOOL;", "b := Next(x);")
    expected = f"a variable of type {wanted} for the VAR_IN_OUT value"
    assert any(expected in message for message in refused(text, dialect))


CODES = "TYPE Code : (none := 0, unknown := 65535); END_TYPE\n"


def test_a_number_of_an_enumeration_may_need_the_sign_bit() -> None:
    body = "c := Code.unknown; n := c; is_same := c = Code.unknown;"
    bench = IecBench(CODES + program("c : Code; n : INT; is_same : BOOL;", body), CODESYS)
    bench.cycle()
    assert (bench["n"], bench["is_same"]) == (-1, True)


@pytest.mark.parametrize(("number", "dialect"), [("65536", CODESYS), ("65535", EPAS_4)])
def test_a_larger_number_of_an_enumeration_is_refused(number: str, dialect: Dialect) -> None:
    text = CODES.replace("65535", number) + program("c : Code;", "c := unknown;")
    assert f"{number} does not fit INT" in refused(text, dialect)[0]


def test_a_bit_is_named_by_a_constant() -> None:
    declared = "VAR CONSTANT ready : INT := 3; END_VAR VAR w : WORD; is_ready : BOOL; END_VAR"
    text = f"PROGRAM PLC_PRG {declared} w.ready := TRUE; is_ready := w.ready; END_PROGRAM"
    bench = ran(text)
    assert (bench["w"], bench["is_ready"]) == (8, True)


def test_a_bit_beyond_its_word_and_a_variable_are_no_bits() -> None:
    declared = "VAR CONSTANT ready : INT := 16; END_VAR VAR w : WORD; n : INT; END_VAR"
    found = refused(f"PROGRAM PLC_PRG {declared} w.ready := TRUE; w.n := TRUE; END_PROGRAM", CODESYS)
    assert any("WORD has no bit 16" in one for one in found)
    assert any("w is a WORD and has no components" in one for one in found)


def test_the_number_of_equal_start_values_may_have_the_name_of_its_list() -> None:
    declared = "<Declaration><![CDATA[VAR_GLOBAL CONSTANT most : INT := 3; END_VAR]]></Declaration>"
    listed = f'<TcPlcObject Version="1.1.0.1"><GVL Name="Limits" Id="{{0}}">{declared}</GVL></TcPlcObject>'
    main = program("a : ARRAY[1..3] OF INT := [Limits.most(7)]; x : INT;", "x := a[3];")
    bench = IecBench(main, CODESYS, others=[SourceFile("Limits.TcGVL", listed)])
    bench.cycle()
    assert bench["x"] == 7


def test_a_variable_is_described_by_varinfo() -> None:
    text = "TYPE Info : __SYSTEM.VAR_INFO; END_TYPE\n"
    text += (
        "FUNCTION_BLOCK Part VAR n : DINT; END_VAR VAR_OUTPUT i : Info; END_VAR i := __VARINFO(n); END_FUNCTION_BLOCK\n"
    )
    declared = "part : Part; list : ARRAY[1..2, 0..2] OF INT; i : Info; ok : ARRAY[1..3] OF BOOL;"
    body = """
    part();
    ok[1] := part.i.Symbol = 'n' AND part.i.TypeName = 'DINT' AND part.i.BitSize = 32;
    i := __VARINFO(list);
    ok[2] := i.Symbol = 'list' AND i.NumElements = 6 AND i.ElemBitSize = 16 AND i.BitSize = 96;
    ok[3] := i.TypeClass = __SYSTEM.TYPE_CLASS.TYPE_ARRAY AND i.BaseTypeClass = __SYSTEM.TYPE_CLASS.TYPE_INT;
    """
    bench = ran(text + program(declared, body))
    assert [bench[f"ok[{number}]"] for number in (1, 2, 3)] == [True] * 3


@pytest.mark.parametrize(
    ("call", "expected"),
    [("__VARINFO()", "one variable"), ("__VARINFO(n, n)", "one variable"), ("__VARINFO(gone)", "gone is not declared")],
)
def test_varinfo_needs_a_variable(call: str, expected: str) -> None:
    found = refused(program("n : INT; i : __SYSTEM.VAR_INFO;", f"i := {call};"), CODESYS)
    assert any(expected in one for one in found)


def test_varinfo_without_a_variable_for_it_is_refused() -> None:
    found = refused(program("n : INT; b : BOOL;", "b := __VARINFO(n).BitSize = 16;"), CODESYS)
    assert any("expected a variable of type __SYSTEM.VAR_INFO" in one for one in found)


def test_classes_of_events_have_their_numbers() -> None:
    """Tc2_System: TCEVENTCLASS_NONE is 0, TCEVENTCLASS_PARAMERROR 8."""
    body = "first := E_TcEventClass.TCEVENTCLASS_NONE; last := TCEVENTCLASS_PARAMERROR; n := last;"
    bench = ran(program("first, last : E_TcEventClass; n : UINT;", body))
    assert (bench["first"], bench["n"]) == (0, 8)
