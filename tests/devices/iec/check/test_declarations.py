"""The declarations of the manual (digest 2.1, PD-L01 to PD-L09) with their values, and the ones that it forbids."""

import pytest
from iec_check import checked, messages, program, variables

from fieldrig_devices.iec.dialect import EDITION_3
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import Space
from fieldrig_devices.iec.types import ArrayType, EnumType, PointerType, StringType, StructType

INT = Elementary.INT


# ---- strings


@pytest.mark.manual("PD-322")
def test_a_string_has_80_characters_unless_it_says_otherwise() -> None:
    found = variables("s : STRING; str : STRING(35) := 'This is a string'; message : STRING[50];")
    assert [found[name].type for name in found] == [StringType(80), StringType(35), StringType(50)]
    assert found["str"].initial == "This is a string"  # PD-L01


def test_an_alias_is_the_type_behind_it() -> None:
    assert variables("m : message;", "TYPE message : STRING[50]; END_TYPE;")["m"].type == StringType(50)  # PD-L08


def test_a_text_that_is_too_long_is_cut_with_a_note() -> None:
    text = program("s : STRING(3) := 'abcdef';")
    assert messages(text) == []
    assert messages(text, notes=True)[-1].endswith("the text has 6 characters and is cut to 3")
    assert checked(text)[0].pous["plc_prg"].variables["s"].initial == "abc"


# ---- arrays


@pytest.mark.manual("PD-361")
def test_arrays_with_start_values_of_the_manual() -> None:
    found = variables(  # PD-L02
        "arr1 : ARRAY [1..5] OF INT := 1,2,3,4,5;"
        "arr2 : ARRAY [1..2,3..4] OF INT := 1,3(7);"
        "arr3 : ARRAY [1..2,2..3,3..4] OF INT := 2(0),4(4),2,3;"
    )
    assert found["arr1"].initial == [1, 2, 3, 4, 5]
    assert found["arr2"].initial == [[1, 7], [7, 7]]
    assert found["arr3"].initial == [[[0, 0], [4, 4]], [[4, 4], [2, 3]]]
    assert found["arr2"].type == ArrayType(1, 2, ArrayType(3, 4, INT))


@pytest.mark.manual("PD-361")
@pytest.mark.parametrize(
    ("declaration", "expected"),
    [
        (
            "a : ARRAY[1..5] OF INT := 1, 2;",
            "2 start values for 5 elements; a value for every element or for none (PD-361)",
        ),
        ("a : ARRAY[1..2] OF INT := 3(1);", "3 repetitions in an array of 2 elements; 0 to 2"),
        ("a : ARRAY[1..2] OF INT := 1000000000(1);", "1000000000 repetitions in an array of 2 elements; 0 to 2"),
        ("a : ARRAY[5..1] OF INT;", "the array 5..1 is empty"),
        ("a : ARRAY[1..x] OF INT; x : INT;", "x is not declared; a name from a declaration"),
        ("a : ARRAY[1..2] OF INT := 1, 'a';", "'a' is a STRING(1); INT"),
        ("a : ARRAY[1..2] OF INT := 1, 70000;", "70000 does not fit INT; -32768 to 32767"),
    ],
)
def test_arrays_that_are_refused(declaration: str, expected: str) -> None:
    found = messages(program(declaration))
    assert [message.partition(" ")[2] for message in found] == [expected]


def test_a_two_dimensional_element_is_reached_by_two_indices() -> None:
    text = program(
        "CardGame : ARRAY [1..13, 1..4] OF INT; x : INT;", "x := CardGame[9, 2]; x := CardGame[9][2];"
    )  # PD-L03
    assert messages(text) == []


def test_limits_of_arrays_are_constant_expressions() -> None:
    found = variables(
        "a : ARRAY[0..last - 1] OF INT;", "VAR_GLOBAL CONSTANT last : INT := half * 2; half : INT := 4; END_VAR"
    )
    assert found["a"].type == ArrayType(0, 7, INT)


def test_start_values_of_the_manual() -> None:
    found = variables(  # PD-L09
        "a : INT := 13; b : STRING := 'this is a string'; c : REAL := 1.1;"
        "s : myStruct := (state := TRUE, inputValue := 2.5);"
        "d : ARRAY[1..10] OF INT := 1, 2, 2(4), 5, 6, 7, 8, 9,10;",
        "TYPE myStruct : STRUCT state : BOOL; inputValue : REAL; END_STRUCT END_TYPE",
    )
    assert found["a"].initial == 13
    assert found["b"].initial == "this is a string"
    assert found["c"].initial == 1.10000002384185791015625  # 1.1 in single precision, as IEEE 754 has it
    assert found["s"].initial == {"state": True, "inputvalue": 2.5}
    assert found["d"].initial == [1, 2, 4, 4, 5, 6, 7, 8, 9, 10]


# ---- pointers


@pytest.mark.manual("PD-358")
def test_a_pointer_is_declared_filled_and_followed() -> None:
    text = program(  # PD-L04
        "pt : POINTER TO INT; var_int1 : INT := 5; var_int2 : INT; d : DWORD;",
        "pt := ADR(var_int1); var_int2 := pt^; pt := ADR(pt^) + SIZEOF(INT); d := pt; pt^ := 3;",
    )
    assert messages(text) == []
    assert checked(text)[0].pous["plc_prg"].variables["pt"].type == PointerType(INT)


@pytest.mark.manual("PD-358")
def test_a_bit_has_no_address() -> None:
    text = program("b AT %MX5.0 : BOOL; x : INT; d : DWORD;", "d := ADR(b); d := ADR(x.3); d := ADR(%MW5);")
    assert messages(text) == [
        "3:10 b has no address of its own; a variable",
        "3:24 x.3 has no address of its own; a variable",
    ]


def test_a_structure_may_point_to_itself_but_not_contain_itself() -> None:
    assert messages("TYPE N : STRUCT next : POINTER TO N; END_STRUCT END_TYPE") == []
    assert messages("TYPE A : STRUCT b : B; END_STRUCT END_TYPE TYPE B : STRUCT a : A; END_STRUCT END_TYPE") == [
        "1:6 A contains itself; a type of limited size"
    ]
    assert messages("TYPE C : D; END_TYPE TYPE D : C; END_TYPE") == ["1:31 the type C is defined by itself; a type"]


def test_a_function_block_does_not_contain_itself() -> None:
    first = "FUNCTION_BLOCK A VAR b : B; END_VAR ; END_FUNCTION_BLOCK"
    second = "FUNCTION_BLOCK B VAR a : A; END_VAR ; END_FUNCTION_BLOCK"
    assert messages(first, second) == ["1:1 A contains itself; a type of limited size"]


# ---- enumerations

TRAFFIC = "TYPE TrafficLights : (red, yellow, green := 10); END_TYPE"


@pytest.mark.manual("PD-359")
def test_an_enumeration_counts_from_0_and_may_be_used_like_an_int() -> None:
    text = program(
        "t : TrafficLights; i : INT;", "t := 0; FOR i := red TO green DO i := i + 1; END_FOR; i := t; t := i;", TRAFFIC
    )
    assert messages(text) == []  # PD-L05
    found = checked(text)[0].pous["plc_prg"].variables["t"].type
    assert isinstance(found, EnumType)
    assert found.values == {"red": 0, "yellow": 1, "green": 10}


@pytest.mark.manual("PD-359")
def test_the_same_enumeration_value_must_not_be_used_twice() -> None:
    text = f"{TRAFFIC}\nTYPE Color : (blue, white, red); END_TYPE"  # PD-L06
    assert messages(text) == [
        (
            "2:28 the name red is used already, in 1.st, line 1; "
            "names of enumeration values occur once in the project (PD-359)"
        )
    ]


@pytest.mark.manual("PD-359")
def test_enumeration_values_are_known_in_the_whole_project_even_if_declared_locally() -> None:
    first = "FUNCTION_BLOCK A VAR e : (up, down); END_VAR ; END_FUNCTION_BLOCK"
    assert messages(first, program("i : INT;", "i := down;")) == []


@pytest.mark.manual("PD-359")
def test_enumeration_values_ascend() -> None:
    assert messages("TYPE E : (first := 3, second := 3, third := 1); END_TYPE") == [
        "1:23 second is 3 after 3; ascending numbers (PD-359)",
        "1:36 third is 1 after 3; ascending numbers (PD-359)",
    ]


def test_a_number_that_is_no_value_of_the_enumeration_is_refused() -> None:
    assert messages(program("t : TrafficLights;", "t := 5;", TRAFFIC)) == [
        "3:6 5 is no value of TrafficLights; red (0), yellow (1), green (10)"
    ]


# ---- structures


@pytest.mark.manual("PD-360")
def test_a_structure_of_the_manual() -> None:
    text = (  # PD-L07; `End` is only a name here
        "TYPE Polygonzug: STRUCT Start:ARRAY [1..2] OF INT; Point1:ARRAY [1..2] OF INT; Point2:ARRAY [1..2] OF INT; "
        "Point3:ARRAY [1..2] OF INT; Point4:ARRAY [1..2] OF INT; End:ARRAY [1..2] OF INT; END_STRUCT END_TYPE"
    )
    found = checked(text, program("p : Polygonzug;", "p.End[2] := p.Start[1];"))[0].types["polygonzug"]
    assert isinstance(found, StructType)
    assert [(field.name, field.offset) for field in found.fields.values()] == [
        ("Start", 0), ("Point1", 4), ("Point2", 8), ("Point3", 12), ("Point4", 16), ("End", 20)
    ]  # fmt: skip
    assert found.size == 24


@pytest.mark.manual("PD-360")
def test_structures_nest_and_have_no_addresses() -> None:
    nested = (
        "TYPE I : STRUCT v : INT := 7; END_STRUCT END_TYPE TYPE O : STRUCT i : ARRAY[1..2] OF I; END_STRUCT END_TYPE"
    )
    assert messages(nested, program("o : O;", "o.i[2].v := 3;")) == []
    assert messages("TYPE S : STRUCT w AT %MW3 : INT; END_STRUCT END_TYPE") == [
        "1:17 w in a structure has an address; no AT in a structure (PD-360)"
    ]


def test_start_values_of_nested_structures_and_instances() -> None:
    found = variables(
        "a : ARRAY[1..2] OF S := (v := 1), (v := 2); t : TON := (PT := T#3s); u : ARRAY[1..3] OF small;",
        "TYPE S : STRUCT v : INT := 7; w : small; END_STRUCT END_TYPE TYPE small : INT(5..9) := 6; END_TYPE",
    )
    assert found["a"].initial == [{"v": 1}, {"v": 2}]
    assert found["t"].initial == {"pt": 3000}
    assert found["u"].initial == [6, 6, 6]
    kind = found["a"].type
    assert isinstance(kind, ArrayType)
    assert isinstance(kind.element, StructType)
    assert [field.initial for field in kind.element.fields.values()] == [7, 6]


def test_a_subrange_holds_only_its_values() -> None:
    assert messages(program("d : INT(0..10) := 11;", "d := 12; d := -1; d := 10;")) == [
        "1:40 11 is outside the subrange; 0 to 10",
        "3:6 12 is outside the subrange; 0 to 10",
        "3:15 -1 is outside the subrange; 0 to 10",
    ]


# ---- names


@pytest.mark.manual("PD-350")
def test_names_have_32_significant_characters_and_no_case() -> None:
    long = "a" * 32
    text = program(f"{long}x : INT; Counter : INT;", f"{long}y := 3; COUNTER := counter;")
    assert messages(text) == []
    assert messages(program(f"{long}x : INT; {long}y : INT;")) == [
        f"1:63 {long}y is declared in line 1 already; another name, or one declaration (PD-350)"
    ]


@pytest.mark.manual("PD-357")
def test_names_of_pous_are_unique_in_the_project() -> None:
    first, second = "FUNCTION A : INT\nA := 1;\nEND_FUNCTION", "\nFUNCTION_BLOCK a\n;\nEND_FUNCTION_BLOCK"
    assert messages(first, second) == [
        "2:1 a is declared in 1.st, line 1 already; a name that is unique in the project (PD-357)"
    ]


def test_a_pou_of_the_project_replaces_one_of_a_library() -> None:
    text = "FUNCTION_BLOCK TON VAR_INPUT mine : BOOL; END_VAR ; END_FUNCTION_BLOCK"
    assert messages(text, program("t : TON;", "t(mine := TRUE);")) == []


def test_a_local_name_hides_a_global_one() -> None:
    assert messages("VAR_GLOBAL x : DINT; END_VAR", program("x : INT; y : INT;", "y := x;")) == []


# ---- variables


@pytest.mark.manual("PD-351")
def test_the_kinds_of_variables_and_their_attributes() -> None:
    text = """
VAR_GLOBAL RETAIN g : INT := 3; END_VAR
FUNCTION_BLOCK B
VAR_INPUT i : INT; END_VAR VAR_OUTPUT q : INT; END_VAR VAR_IN_OUT r : INT; END_VAR VAR_EXTERNAL g : INT; END_VAR
VAR_TEMP t : INT; END_VAR VAR CONSTANT c : INT := 4; END_VAR VAR RETAIN k : INT; END_VAR VAR w AT %QW3 : INT; END_VAR
t := i + c; r := t; g := r; q := w; k := q;
END_FUNCTION_BLOCK"""
    found, mistakes = checked(text)
    assert [mistake.what for mistake in mistakes if not mistake.is_note] == []
    variables = found.pous["b"].variables
    assert "g" not in variables  # it is the global variable
    assert found.globals["g"].is_retain
    assert variables["k"].is_retain
    assert variables["c"].is_constant
    assert variables["r"].is_reference
    assert [variables[name].space for name in ("i", "q", "r", "t", "k")] == [
        Space.INSTANCE, Space.INSTANCE, Space.INSTANCE, Space.FRAME, Space.INSTANCE
    ]  # fmt: skip


@pytest.mark.manual("PD-351")
@pytest.mark.parametrize(
    ("block", "expected"),
    [
        (
            "VAR_INPUT i : INT; END_VAR",
            "3:1 i is a VAR_INPUT and cannot be changed within its POU; a variable that may be written here",
        ),
        ("VAR CONSTANT i : INT := 1; END_VAR", "3:1 i is a constant; a variable that may be written here"),
        (
            "VAR_GLOBAL i : INT; END_VAR",
            "1:18 VAR_GLOBAL in a FUNCTION_BLOCK; VAR_GLOBAL in a file of its own or in a program",
        ),
        ("VAR_EXTERNAL i : INT; END_VAR", "1:31 there is no global variable i; the name of a VAR_GLOBAL"),
    ],
)
def test_variables_are_written_only_where_their_kind_allows_it(block: str, expected: str) -> None:
    assert messages(f"FUNCTION_BLOCK B {block}\n\ni := 3;\nEND_FUNCTION_BLOCK")[0] == expected


@pytest.mark.manual("PD-351")
def test_an_external_variable_has_the_type_of_the_global_one() -> None:
    text = "FUNCTION_BLOCK B VAR_EXTERNAL g : INT; END_VAR ; END_FUNCTION_BLOCK"
    assert messages("VAR_GLOBAL g : DINT; END_VAR", text) == [
        "1:31 the VAR_EXTERNAL g is an INT; DINT, as the global variable"
    ]


@pytest.mark.manual("PD-354")
def test_a_function_keeps_nothing_between_calls() -> None:
    text = "FUNCTION F : INT VAR t : TON; END_VAR VAR RETAIN z : INT; END_VAR\nF := 1;\nEND_FUNCTION"
    assert messages(text) == [
        (
            "1:22 the instance t of TON in a function; "
            "VAR_IN_OUT for an instance; a function keeps nothing between calls (PD-354)"
        ),
        "1:39 RETAIN in a function; a function keeps nothing between calls (PD-354)",
    ]


@pytest.mark.manual("PD-356")
def test_a_program_has_no_instances() -> None:
    found, _ = checked(program("x : INT;"))
    assert found.pous["plc_prg"].instance is found.globals["plc_prg"]
    assert messages(program("p : PLC_PRG;")) == ["1:26 PLC_PRG is a PROGRAM, not a type"]


def test_a_constant_that_is_defined_by_itself_has_one_message() -> None:
    assert messages("VAR_GLOBAL CONSTANT a : INT := b; b : INT := a; END_VAR") == [
        "1:32 a is defined by itself; a constant"
    ]


def test_long_types_exist_in_edition_3_only() -> None:
    assert messages(program("a : LINT;")) == ["1:26 LINT is not supported by the controller"]
    assert messages(program("a : LINT;"), dialect=EDITION_3) == []
