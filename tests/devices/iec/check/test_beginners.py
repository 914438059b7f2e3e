"""Mistakes of a beginner who knows another language: one message for each, with the words of ST as its hint."""

import re

import pytest
from iec_check import program

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile

NAMES = "i, n : INT; b : BOOL; s : STRING; r : REAL; a : ARRAY[1..3] OF INT; t : TON;"
FUNCTION = (
    "TYPE Colour : (red, green); END_TYPE\n"
    "FUNCTION Add2 : INT VAR_INPUT x, y : INT; END_VAR Add2 := x + y; END_FUNCTION\n"
)

# Statement, and its only message: column, what is wrong, what was expected, hint.
STATEMENTS = [
    ("i++;", "2 got +; := or a call | Write x := x + 1 for x++."),
    ("i--;", "2 got -; := or a call | Write x := x - 1 for x--."),
    ("++i;", "1 got +; a statement | Write x := x + 1 for ++x."),
    ("n := i++;", "9 got ;; a variable, a constant or a call | Write x := x + 1 in a line of its own for x++."),
    ("n := i--;", "9 got ;; a variable, a constant or a call | Write x := x - 1 in a line of its own for x--."),
    (
        "IF i++ > 3 THEN n := 1; END_IF;",
        "8 got >; a variable, a constant or a call | Write x := x + 1 in a line of its own for x++.",
    ),
    ('b := "on";', "6 got \"on\"; a string in single quotes: 'on' | "),
    ("s := 'on;", "6 the string is not closed; ' at its end, in the same line | "),
    ("t(IN = TRUE);", "3 IN = TRUE is a comparison; IN := TRUE | A value is passed with :=."),
    ("i := Add2(x = 1, y := 2);", "11 x = 1 is a comparison; x := 1 | A value is passed with :=."),
    (
        "a(3) := n;",
        (
            "1 a value is assigned to a call; a variable in front of := "
            "| An element of an array is a[...], in square brackets."
        ),
    ),
    ("i := 0xFF;", "6 got 0xFF; 16#FF | The number is written 16#FF."),
    ("i := 0b1_01 + n;", "6 got 0b1_01; 2#1_01 | The number is written 2#1_01."),
    ("i := 0o17;", "6 got 0o17; 8#17 | The number is written 8#17."),
    ("CASE i OF 0FFh: n := 1; END_CASE;", "11 got 0FFh; 16#0FF | The number is written 16#0FF."),
    ("i := $1F;", "6 got $1F; 16#1F | The number is written 16#1F."),
    ("i := 1 / 0;", "8 this is a division by zero; a divisor other than 0 | "),
    (
        "FOR i := 0 TO 32767 DO n := 1; FOR n := 0 TO 3 DO EXIT; END_FOR; END_FOR;",
        (
            "15 the loop never ends, as i is an INT and wraps around at -32768 and 32767; "
            "an end that i can pass, or EXIT in the loop | use a larger type for the variable"
        ),
    ),
    (
        "FOR i := 3 TO -32768 BY -1 DO n := 1; END_FOR;",
        (
            "15 the loop never ends, as i is an INT and wraps around at -32768 and 32767; "
            "an end that i can pass, or EXIT in the loop | use a larger type for the variable"
        ),
    ),
    ("i := 5u;", "6 5u is neither a number nor a name; a name that begins with a letter or an underscore | "),
    ("i := n % 3;", "8 got %; MOD | The remainder of a division is a MOD b."),
    ("i := n%3;", "7 got %; MOD | The remainder of a division is a MOD b."),
    ("b := !b;", "6 got !; NOT | The operator is NOT."),
    ("i := %X3;", "6 %X3 is not an address; %I, %Q or %M, a size X, B, W or D, and numbers, such as %QX1.0 | "),
    ("r := 1,64e9;", "7 got ,; ; | A decimal fraction is written with a point: 1.64e9."),
    (
        "RETURN i + n;",
        "8 got i; ; | The result of a function is assigned to its name in front of it: Name := value; RETURN;",
    ),
    (
        "for (i = 0; i < 10; i++)\n n := 1;\nEND_FOR",
        "5 got (; the variable of the loop | Write FOR i := 0 TO 9 DO ...; END_FOR;",
    ),
    (
        "FOR (i := 0 TO 3) DO n := 1; END_FOR",
        "5 got (; the variable of the loop | Write FOR i := 0 TO 9 DO ...; END_FOR;",
    ),
    (
        "switch (i) { case 1: n := 2; break; }",
        "1 got switch; CASE | Write CASE x OF 1: ...; 2: ...; ELSE ...; END_CASE;",
    ),
    (
        "CASE i OF case 1: n := 2; END_CASE;",
        "11 got case; 1: | A branch of CASE begins with its value only.",
    ),
    (
        "CASE i OF 1: n := 2; case 2: n := 3; END_CASE;",
        "22 got case; 2: | A branch of CASE begins with its value only.",
    ),
    (
        "CASE i OF 1: n := 2; default: n := 3; END_CASE;",
        "22 default is not declared;  | the last branch of CASE begins with ELSE",
    ),
    ("i := INT;", "6 INT is a type; a value | x : INT; declares a variable of it"),
    ("i := n + int;", "10 int is a type; a value | x : int; declares a variable of it"),
    ("INT := i;", "1 INT is a type; a value | x : INT; declares a variable of it"),
    ("i := INT[3];", "6 INT is a type; a value | x : INT; declares a variable of it"),
    ("IF i > LREAL THEN n := 1; END_IF;", "8 LREAL is a type; a value | x : LREAL; declares a variable of it"),
    ("s := STRING;", "6 STRING is a type; a value | x : STRING; declares a variable of it"),
    ("i := Colour;", "6 Colour is a type; a value | x : Colour; declares a variable of it"),
    ("i := a[BYTE];", "8 BYTE is a type; a value | x : BYTE; declares a variable of it"),
    ("i := t.PT + TIME;", "13 TIME is a type; a value | x : TIME; declares a variable of it"),
    ("INT(3);", "1 INT is a type; an instance, program, action or function | x : INT; declares a variable of it"),
    (
        "i := DINT(n);",
        "6 DINT is a type; a function | DINT#... gives a number its type, and ..._TO_DINT(...) converts a value",
    ),
    ("i := Colour(3);", "6 Colour is a type; a function | "),
    ("r := ABS;", "6 ABS is a FUNCTION; a value | ABS(...) calls it"),
    ("r := r + sqrt;", "10 sqrt is a FUNCTION; a value | sqrt(...) calls it"),
    ("i := REAL_TO_INT;", "6 REAL_TO_INT is a FUNCTION; a value | REAL_TO_INT(...) calls it"),
    ("i := t;", "6 t is a TON; INT | "),
    ("i := TON;", "6 TON is a FUNCTION_BLOCK; a value | declare x : TON;"),
    ("i := PLC_PRG;", "6 PLC_PRG is a PROGRAM; a value | PLC_PRG.x is its variable x"),
    ("i := INT#;", "6 the number is missing; digits | "),
]
TYPES = [("boolean", "BOOL"), ("Integer", "INT"), ("float", "REAL"), ("double", "LREAL"), ("Int32", "DINT")]


def messages(text: str) -> list[str]:
    with pytest.raises(CompileError) as refused:
        compile_project([SourceFile("a.st", text)], StandaloneHost(VirtualClock()))
    return [
        f"{found.column} {found.what}; {found.expected} | {found.hint}"
        for found in refused.value.mistakes
        if not found.is_note
    ]


@pytest.mark.parametrize(("statement", "expected"), STATEMENTS)
def test_a_statement_of_another_language_has_one_message(statement: str, expected: str) -> None:
    assert messages(FUNCTION + program(NAMES, "\n" + statement)) == [expected]


def test_a_switch_is_read_as_a_case() -> None:
    body = "switch (i)\n case 1: n := 2;\n case 2: nn := 3;\nEND_CASE"
    first, *branches, last = messages(program(NAMES, body))
    assert first.partition(" ")[2] == "got switch; CASE | Write CASE x OF 1: ...; 2: ...; ELSE ...; END_CASE;"
    assert [one.partition(" ")[2].partition(";")[0] for one in branches] == ["got case", "got case"]
    assert last.startswith("10 nn is not declared")


@pytest.mark.parametrize(
    ("call", "number"),
    [
        ("MUX(2, n, 7)", 2),
        ("MUX(-1, n, 7)", -1),
        ("MUX(K := 3, IN0 := 1, IN1 := 2, IN2 := n)", 3),
        ("MUX(1, n, 7)", None),
        ("MUX(n, 1, 7)", None),
    ],
)
def test_a_constant_number_of_mux_without_an_input_is_noted(call: str, number: int | None) -> None:
    made = compile_project([SourceFile("a.st", program(NAMES, f"i := {call};"))], StandaloneHost(VirtualClock()))
    notes = [note.what for note in made.notes if "MUX" in note.what]
    wanted = [f"MUX has no input with the number {number}, so it selects the last one"]
    assert notes == (wanted if number is not None else [])


@pytest.mark.parametrize(
    ("kind", "loop", "is_noted"),
    [
        ("BYTE", "0 TO 254 BY 2", True),
        ("BYTE", "0 TO 253 BY 3", False),  # wraps around twice, and comes to 254
        ("BYTE", "1 TO 254 BY 2", False),
        ("USINT", "5 TO 251 BY 10", False),  # comes to 255
        ("USINT", "9 TO 8 BY 2", False),  # no pass
        ("INT", "-32768 TO 32766 BY 10000", True),
        ("SINT", "99 TO -127 BY -4", True),
        ("UINT", "9 TO 1 BY -2", True),
        ("UINT", "9 TO 2 BY -2", False),
    ],
)
def test_a_counter_that_steps_over_its_end_is_noted(kind: str, loop: str, is_noted: bool) -> None:
    text = f"PROGRAM PLC_PRG\nVAR\nx : {kind}; n : INT;\nEND_VAR\nFOR x := {loop} DO n := 1; END_FOR;\nEND_PROGRAM\n"
    made = compile_project([SourceFile("a.st", text)], StandaloneHost(VirtualClock()))
    assert any("the loop never ends unless its body changes x" in note.what for note in made.notes) is is_noted
    ends = _ends(kind, loop)
    assert ends is not is_noted


def _ends(kind: str, loop: str) -> bool:
    """Count as the controller does, for as many steps as the type has values."""
    first, last, step = (int(part) for part in re.findall(r"-?\d+", loop))
    low, values = {"BYTE": (0, 2**8), "USINT": (0, 2**8), "SINT": (-(2**7), 2**8), "UINT": (0, 2**16)}.get(
        kind, (-(2**15), 2**16)
    )
    counted = ((first + number * step - low) % values + low for number in range(values + 1))
    return any(value > last if step > 0 else value < last for value in counted)


@pytest.mark.parametrize(("name", "meant"), TYPES)
def test_a_type_of_another_language_has_the_one_that_is_meant_as_its_hint(name: str, meant: str) -> None:
    text = f"PROGRAM PLC_PRG\nVAR\nx : {name};\nEND_VAR\nEND_PROGRAM\n"
    assert messages(text) == [f"5 the type {name} is not declared;  | the type is called {meant}"]


def test_an_object_of_the_controller_is_known_with_its_rig_file_only() -> None:
    (found,) = messages(program(NAMES, "\ni := PacDriveM.Timer1;"))
    assert found.startswith("6 PacDriveM is not declared;  | it is the MAx-4: ")
    assert "--rig" in found


def test_a_minus_in_a_name() -> None:
    text = "PROGRAM PLC_PRG\nVAR\npump-on : BOOL;\nEND_VAR\nEND_PROGRAM\n"
    assert messages(text) == ["5 got -; : and a type | A name has letters, digits and underscores only."]


def test_else_if_in_two_words() -> None:
    body = "IF i = 1 THEN\n n := 1;\nELSE IF i = 2 THEN\n n := 2;\nEND_IF\n"
    (found,) = messages(program(NAMES, body))
    assert "END_IF for the IF in line" in found
    assert found.endswith("begins an IF with an END_IF of its own. Write ELSIF.")


def test_an_instruction_without_a_blank_is_il() -> None:
    """The manual prints LD2#1001_0011 (line 2218) and STVar1."""
    first, *_ = messages(program("Var1 : BYTE;", "\nLD2#1001_0011\nNOT\nST Var1\n"))
    assert (
        first == "1 got LD2#1001_0011; an operator of IL, such as LD, ST or AND | Write LD 2#1001_0011, with a blank."
    )


@pytest.mark.parametrize(
    ("declaration", "message"),
    [
        (
            "z : INT[5];",
            "got INT[; ARRAY[1..5] OF INT | The limits of an array are in front of the type of its elements.",
        ),
        (
            "z : REAL[0..3] := 1;",
            "got REAL[; ARRAY[1..10] OF REAL | The limits of an array are in front of the type of its elements.",
        ),
        ("z[5] : INT;", "got [; : and a type | An array is declared name : ARRAY[1..10] OF INT."),
    ],
)
def test_an_array_as_in_other_languages_has_one_message(declaration: str, message: str) -> None:
    (found,) = messages(program(declaration, "; (* nothing *)"))
    assert found.partition(" ")[2] == message


@pytest.mark.parametrize(
    "loop",
    [
        "FOR i := 0 TO 32766 DO n := 1; END_FOR;",
        "FOR i := 0 TO 32767 DO IF b THEN EXIT; END_IF; END_FOR;",
        "FOR i := 0 TO 32767 DO CASE n OF 1: RETURN; END_CASE; END_FOR;",
        "FOR i := 0 TO n DO n := 1; END_FOR;",
    ],
)
def test_a_loop_that_can_end_has_no_message(loop: str) -> None:
    compile_project([SourceFile("a.st", program(NAMES, loop))], StandaloneHost(VirtualClock()))


@pytest.mark.parametrize("body", ["IF b THEN { i := 1; } END_IF;", "FOR i := 0 TO 3 DO {\n n := 1;\n} END_FOR;"])
def test_statements_in_braces_get_a_note(body: str) -> None:
    found = compile_project([SourceFile("a.st", program(NAMES, body))], StandaloneHost(VirtualClock()))
    assert "the text in braces is a pragma, and its statements do not run" in [note.what for note in found.notes]


def test_c_code_of_matiec_does_not_run_and_gets_a_note() -> None:
    body = "i := 1;\n{{\n  if (x) { y = GetFbVar(i, .body); }\n}}\nb := i = 1;"
    found = compile_project([SourceFile("a.st", program(NAMES, body))], StandaloneHost(VirtualClock()))
    assert "the text between {{ and }} is C code of MatIEC, and does not run" in [note.what for note in found.notes]


@pytest.mark.parametrize("pragma", ["{attribute 'text' := 'a; b'}", "{native code}", "{flag on}"])
def test_a_pragma_gets_no_note(pragma: str) -> None:
    text = program(NAMES, f"{pragma} i := 1;")
    found = compile_project([SourceFile("a.st", text)], StandaloneHost(VirtualClock()))
    assert not [note for note in found.notes if "braces" in note.what]


@pytest.mark.parametrize(
    ("loop", "is_noted"),
    [
        ("WHILE TRUE DO n := 1; END_WHILE;", True),
        ("WHILE (1 = 1) DO ; END_WHILE;", True),
        ("REPEAT n := 1; UNTIL FALSE END_REPEAT;", True),
        ("WHILE NOT FALSE DO WHILE b DO EXIT; END_WHILE; END_WHILE;", True),
        ("WHILE TRUE DO IF b THEN EXIT; END_IF; END_WHILE;", False),
        ("REPEAT FOR i := 0 TO 3 DO RETURN; END_FOR; UNTIL FALSE END_REPEAT;", False),
        ("WHILE FALSE DO n := 1; END_WHILE;", False),
        ("REPEAT n := 1; UNTIL TRUE END_REPEAT;", False),
        ("WHILE b DO n := 1; END_WHILE;", False),
    ],
)
def test_a_loop_with_a_constant_condition_gets_a_note(loop: str, is_noted: bool) -> None:
    found = compile_project([SourceFile("a.st", program(NAMES, loop))], StandaloneHost(VirtualClock()))
    assert ("the loop never ends" in [note.what for note in found.notes]) is is_noted


@pytest.mark.parametrize(
    "loop", ["WHILE n > DO n := 1; END_WHILE;", "WHILE DO n := 1; END_WHILE;", "FOR i := TO 3 DO n := 1; END_FOR;"]
)
def test_a_loop_whose_condition_cannot_be_read_gets_no_note_as_well(loop: str) -> None:
    with pytest.raises(CompileError) as refusal:
        compile_project([SourceFile("a.st", program(NAMES, loop))], StandaloneHost(VirtualClock()))
    assert "the loop never ends" not in [mistake.what for mistake in refusal.value.mistakes]


@pytest.mark.parametrize("text", ["", "\n\n", "(* only a comment *)\n"])
def test_a_file_with_nothing_in_it_gets_a_note(text: str) -> None:
    files = [SourceFile("a.st", program(NAMES, "i := 1;")), SourceFile("b.st", text)]
    found = compile_project(files, StandaloneHost(VirtualClock()))
    assert [note.file for note in found.notes if note.what == "there is nothing in this file"] == ["b.st"]
