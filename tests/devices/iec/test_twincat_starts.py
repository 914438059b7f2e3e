"""Start values and types of public projects of TwinCAT: references, empty lists, constant structures, new pointers."""

import pytest
from iec_program import IecBench, program

from fieldrig_devices.iec.dialect import CODESYS, EPAS_4, Dialect
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.printer import print_unit
from fieldrig_devices.languages.mistakes import CompileError


def ran(text: str, dialect: Dialect = CODESYS) -> IecBench:
    bench = IecBench(text, dialect)
    bench.cycle()
    return bench


def wrong(text: str, dialect: Dialect = CODESYS) -> list[str]:
    with pytest.raises(CompileError) as refused:
        IecBench(text, dialect)
    return [f"{one.what}; {one.expected}" for one in refused.value.mistakes if not one.is_note]


REFERENCE = program(
    "own : WORD := 5; active : REFERENCE TO WORD REF= own; x : WORD;", "active := active + 1; x := own;"
)


def test_a_reference_refers_from_its_declaration_on() -> None:
    assert ran(REFERENCE)["x"] == 6


def test_a_reference_with_its_target_is_printed_as_a_start_value() -> None:
    unit, mistakes = parse(REFERENCE, "a.st", CODESYS)
    assert not mistakes
    assert "active : REFERENCE TO WORD := own;" in print_unit(unit)


BLOCK = "FUNCTION_BLOCK Inner\nVAR_OUTPUT x : INT := 4; END_VAR\nEND_FUNCTION_BLOCK\n"


def test_an_empty_list_changes_no_start_value() -> None:
    assert ran(BLOCK + program("i : Inner := (); x : INT;", "x := i.x;"))["x"] == 4


STATE = """
TYPE State : STRUCT code : DINT; text : STRING; END_STRUCT; END_TYPE
TYPE Alias : State; END_TYPE
VAR_GLOBAL CONSTANT
    FINE : State := (code := 3, text := 'ok');
    EMPTY : State;
END_VAR
VAR_GLOBAL
    present : State := (code := 9);
END_VAR
FUNCTION CodeOf : DINT
VAR_OUTPUT state : Alias := FINE; END_VAR
CodeOf := state.code;
END_FUNCTION
"""


@pytest.mark.parametrize(("start", "code"), [("FINE", 3), ("EMPTY", 0), ("present", 9), ("(code := 7)", 7)])
def test_a_structure_begins_with_another_one(start: str, code: int) -> None:
    assert ran(STATE + program(f"s : Alias := {start}; x : DINT;", "x := s.code;"))["x"] == code


def test_an_output_of_a_function_begins_with_a_constant_structure() -> None:
    assert ran(STATE + program("x : DINT;", "x := CodeOf();"))["x"] == 3


def test_a_start_value_of_another_type_is_refused() -> None:
    text = STATE + program("i : INT; s : State := i;", ";")
    assert wrong(text) == ["i is an INT; State"]
    assert wrong(STATE + program("s : State := FINE;", ";"), EPAS_4)


POINTERS = """
p : POINTER TO POINTER TO INT; q : POINTER TO POINTER TO POINTER TO INT; i : INT := 7; x, y : INT;
"""


def test_new_makes_pointers() -> None:
    body = "p := __NEW(POINTER TO INT, 4); p[2] := ADR(i); x := p[2]^; q := __NEW(POINTER TO POINTER TO INT); q^ := p;"
    bench = ran(program(POINTERS, f"{body} y := q^[2]^ + 1; __DELETE(p); __DELETE(q);"))
    assert (bench["x"], bench["y"]) == (7, 8)


def test_a_pointer_to_a_type_is_no_value() -> None:
    text = "FUNCTION F : INT VAR_INPUT a : INT; END_VAR END_FUNCTION\n" + program("x : INT;", "x := F(POINTER TO INT);")
    assert wrong(text) == ["POINTER TO INT is a type; a value"]


def test_the_number_of_an_address_is_converted() -> None:
    body = "p := ADR(i); d := p; x := TO_UDINT(p) = d AND TO_DWORD(p) = d AND TO_STRING(p) = DWORD_TO_STRING(d);"
    assert ran(program("p : POINTER TO INT; i : INT; d : DWORD; x : BOOL;", body))["x"] is True


def test_values_of_enumerations_without_a_name_belong_to_their_variable() -> None:
    head = "FUNCTION_BLOCK {}\nVAR s : ({}) := NOTHING; END_VAR\nVAR_OUTPUT y : INT; END_VAR\n"
    body = "CASE s OF NOTHING: s := LAST; LAST: y := {}; END_CASE\nIF {} THEN y := y + 10; END_IF\nEND_FUNCTION_BLOCK\n"
    one = head.format("One", "NOTHING, FIRST, LAST") + body.format(2, "s = LAST")
    other = head.format("Other", "FIRST, NOTHING, MORE, LAST") + body.format(3, "LAST = s")
    body = "a(); b(); a(); b(); x := a.y; y := b.y;"
    bench = ran(one + other + program("a : One; b : Other; x, y : INT;", body))
    assert (bench["x"], bench["y"]) == (12, 13)


def test_wide_texts_are_measured_and_copied() -> None:
    body = "n := WLEN2(ADR(a)); x := WSTRNCPY(ADR(b), ADR(a), 8); same := b = a; y := WSTRNCPY(ADR(b), ADR(a), 6);"
    text = program(
        'a : WSTRING := "€uro"; b : WSTRING(9); n : UDINT; x, y, same : BOOL;', body.replace(", 8)", ", 10)")
    )
    bench = ran(text)
    assert (bench["n"], bench["x"], bench["same"], bench["y"], bench["b"]) == (4, True, True, False, "€u")


def test_the_class_of_a_type_is_kept_in_a_variable() -> None:
    text = "FUNCTION ClassOf : INT\nVAR_INPUT v : ANY; END_VAR\nVAR c : __SYSTEM.TYPE_CLASS; END_VAR\n"
    text += "c := v.TypeClass; ClassOf := c;\nEND_FUNCTION\n"
    assert ran(text + program("r : LREAL; x : INT;", "x := ClassOf(r);"))["x"] == 15


def test_the_size_of_a_component_is_asked_of_its_type() -> None:
    types = "TYPE Name : STRUCT n : INT; text : STRING(20); END_STRUCT; END_TYPE\n"
    types += "TYPE Line : STRUCT name : Name; values : ARRAY[1..4] OF DINT; END_STRUCT; END_TYPE\n"
    bench = ran(types + program("x, y : UDINT;", "x := SIZEOF(Line.values); y := SIZEOF(Line.name.text);"))
    assert (bench["x"], bench["y"]) == (16, 21)


TEXTS = """
FUNCTION Changed : INT
VAR_INPUT text : REFERENCE TO STRING; END_VAR
Changed := LEN(text); text := 'new';
END_FUNCTION
"""


def test_a_reference_to_a_text_may_refer_to_a_longer_one() -> None:
    bench = ran(TEXTS + program("long : STRING(255) := 'before'; x : INT;", "x := Changed(long);"))
    assert (bench["x"], bench["long"]) == (6, "new")
    (message,) = wrong(TEXTS + program("short : STRING(10); x : INT;", "x := Changed(short);"))
    assert message.startswith("short is a STRING(10); a variable of type STRING")


EXTENDED = """
TYPE Base : STRUCT a : INT; b : LREAL; END_STRUCT; END_TYPE
TYPE Middle EXTENDS Base : STRUCT c : INT; END_STRUCT; END_TYPE
TYPE Whole EXTENDS Middle : STRUCT d : ARRAY[1..2] OF Base; END_STRUCT; END_TYPE
FUNCTION SumOf : LREAL VAR_INPUT base : Base; END_VAR SumOf := base.a + base.b; END_FUNCTION
"""


def test_a_structure_is_given_for_one_that_it_extends() -> None:
    declared = "w : Whole := (a := 1, b := 2.5, c := 9); m : Middle; list : ARRAY[1..2] OF Base; x : LREAL; y : INT;"
    bench = ran(EXTENDED + program(declared, "m := w; list[2] := w; x := SumOf(w) + SumOf(m) + list[2].b; y := m.c;"))
    assert (bench["x"], bench["y"], bench["list[1].a"]) == (9.5, 9, 0)


def test_a_structure_is_not_given_for_one_that_extends_it() -> None:
    assert wrong(EXTENDED + program("b : Base; m : Middle;", "m := b;")) == ["b is a Base; Middle"]
