"""Messages to the engineer: one for each mistake, at its place, with what was expected."""

import pytest
from iec_check import checked, hints, messages, program

SAMPLES = """
FUNCTION F : INT VAR_INPUT a : INT; b : INT := 3; END_VAR F := a + b; END_FUNCTION
FUNCTION_BLOCK Lamp
VAR_INPUT iOn : INT; END_VAR VAR_OUTPUT xLit : BOOL; END_VAR VAR_IN_OUT iCount : INT; END_VAR VAR iOwn : INT; END_VAR
ACTION Reset : iOwn := 0; END_ACTION
END_FUNCTION_BLOCK
"""

NAMES = [
    ("cuter := 3; cuter := 4;", ["3:1 cuter is not declared"]),  # once in each body
    (
        "x := qqqq + zzzz;",
        ["3:6 qqqq is not declared; a name from a declaration", "3:13 zzzz is not declared; a name from a declaration"],
    ),
    ("Foo(3);", ["3:1 Foo is not declared; an instance, program, action or function"]),
    ("x := Foo(3);", ["3:6 the function Foo is not declared; a declared or standard function"]),
    ("x := Lamp;", ["3:6 Lamp is a FUNCTION_BLOCK; a value"]),
    ("x := F;", ["3:6 F is a FUNCTION; a value"]),
    ("F := 3;", ["3:1 F is a FUNCTION; a variable that may be written here"]),
    ("x := l.iOwn;", ["3:7 iOwn is a VAR of Lamp and not known outside; an input or output of the instance"]),
    ("l.xLit := TRUE;", ["3:2 l.xLit is an output and only its block writes it; a variable that may be written here"]),
    ("x := l.iOm;", ["3:7 Lamp has no variable iOm; an input or output"]),
    ("x := l();", ["3:6 l is not a function; a function"]),
    ("x := x.foo;", ["3:7 x is an INT and has no components; a structure, an instance or an object"]),
    ("x := x[3];", ["3:7 x is an INT, not an array; an array"]),
    ("x := x^;", ["3:7 x is an INT; a pointer in front of ^"]),
    ("x(3);", ["3:1 x is an INT and cannot be called; an instance, program or function"]),
    ("n := 4;", ["3:1 n is a constant; a variable that may be written here"]),
    ("l := l;", ["3:6 l is an instance of Lamp and cannot be copied; a variable without a function block"]),
]

TYPES = [
    ("x := y;", ["3:6 y is a DINT; INT"]),
    ("x := 70000;", ["3:6 70000 does not fit INT; -32768 to 32767"]),
    ("x := 1.5;", ["3:6 the number 1.5 is no INT; INT"]),
    ("b := 2;", ["3:6 the number 2 is no BOOL; BOOL"]),
    ("x := 'abc';", ["3:6 'abc' is a STRING(3); INT"]),
    ("r := b;", ["3:6 b is a BOOL; REAL"]),
    ("b := x = 1 AND x;", ["3:12 AND between BOOL and INT; two BOOL or two bit strings"]),
    ("r := r MOD r;", ["3:8 MOD between REAL and REAL; two integers"]),  # X11
    ("b := 20 > 30 > 40;", ["3:14 > between BOOL and the number 40; two values of the same type"]),  # PD-L34
    ("t := t + 5;", ["3:8 + between TIME and the number 5; two values of the same type"]),
    ("t := -t;", ["3:6 a minus sign in front of a TIME; a number"]),
    ("s := s + s;", ["3:8 + between STRING and STRING; two numbers"]),
    ("x := a;", ["3:6 a is an ARRAY[1..5] OF INT; INT"]),
    ("x := a[1, 2];", ["3:7 the array a has 1 dimension; 1 index"]),
    ("x := a[6];", ["3:8 the index 6 is outside the array; 1 to 5"]),
    ("x := a[r];", ["3:8 the index is a REAL; an integer"]),
    ("b := x.16;", ["3:7 INT has no bit 16; 0 to 15"]),
    ("b := s.1;", ["3:7 s is a STRING and has no bits; an integer or bit string"]),
    ("r := 1E40;", ["3:6 1E40 does not fit REAL; at most 3.4E38"]),
    ("IF x THEN ; END_IF", ["3:4 the condition x is an INT; a BOOL"]),
    ("WHILE r DO ; END_WHILE", ["3:7 the condition r is a REAL; a BOOL"]),
    ("x := SQRT(b);", ["3:6 SQRT with BOOL; one number"]),
    ("x := MAX(b, 3);", ["3:6 MAX with BOOL, the number 3; at least two values of the same kind"]),
]

CALLS = [
    ("x := F();", ["3:6 the argument a is missing in the call of F; values for a, b"]),
    ("x := F(1, 2, 3);", ["3:14 too many arguments for F; 2 arguments"]),
    ("x := F(a := 1, c := 2);", ["3:16 F has no input c; a, b"]),
    ("x := F(a := 1, a := 2);", ["3:16 the argument a is given twice; one value for each input"]),
    ("x := F(y);", ["3:8 y is a DINT; INT"]),
    ("l(1, iCount := x);", ["3:3 Lamp is called with an argument without a name; iOn := 1"]),  # PD-366
    ("l(iOn := 1);", ["3:1 the argument iCount is missing in the call of Lamp; values for iOn, iCount"]),
    ("l(iOn := 1, iCount := 3);", ["3:23 3 is passed to the VAR_IN_OUT iCount; a variable"]),
    ("l(iOn := 1, iCount := n);", ["3:23 n is passed to the VAR_IN_OUT iCount; a variable"]),
    ("l(iCount := y);", ["3:13 y is a DINT; a variable of type INT for the VAR_IN_OUT iCount"]),
    ("l(iCount := x, xLit => x);", ["3:24 xLit is a BOOL; INT"]),
    ("l(iCount := x, xLit := b);", ["3:16 xLit is an output of Lamp; xLit => target"]),
    ("l(iCount := x, xLitt => b);", ["3:16 Lamp has no output xLitt; xLit"]),
    ("Lamp(iCount := x);", ["3:1 Lamp is a function block, not an instance; an instance"]),
    ("ABS(3);", ["3:1 the result of ABS is not used; a function in an expression"]),
    ("x := l.Reset;", ["3:7 Lamp.Reset is an action; a value"]),
]

STATEMENTS = [
    ("EXIT;", ["3:1 EXIT outside a loop; a place in FOR, WHILE or REPEAT"]),
    ("FOR r := 1 TO 2 DO ; END_FOR", ["3:5 r is a REAL; an integer variable behind FOR"]),
    ("FOR x := 1 TO y DO ; END_FOR", ["3:15 y is a DINT; INT"]),
    ("FOR x := 1 TO 2 BY 0 DO ; END_FOR", ["3:20 the step is 0 and the loop never ends; a step that is not 0"]),
    ("CASE r OF 1: ; END_CASE", ["3:6 r is a REAL; an integer behind CASE"]),
    ("CASE x OF y: ; END_CASE", ["3:11 y is not constant; a value that is known at compile time"]),
    ("CASE x OF 7..6: ; END_CASE", ["3:11 the range 7..6 is empty; the lower value first"]),
    ("CASE x OF 70000: ; END_CASE", ["3:11 70000 does not fit INT; -32768 to 32767"]),
]

VARIABLES = (
    "x : INT; y : DINT; r : REAL; b : BOOL; t : TIME; s : STRING; a : ARRAY[1..5] OF INT; l : Lamp; cutter : INT; "
    "END_VAR VAR CONSTANT n : INT := 5;"
)


@pytest.mark.parametrize(("statements", "expected"), [*NAMES, *TYPES, *CALLS, *STATEMENTS])
def test_each_mistake_has_one_message_at_its_place(statements: str, expected: list[str]) -> None:
    assert messages(SAMPLES, program(VARIABLES, statements)) == expected


HINTS = [
    ("x := y;", "use DINT_TO_INT(y) if cutting is meant"),
    ("x := r;", "use REAL_TO_INT(r), which rounds, or TRUNC"),
    ("r := b;", "use BOOL_TO_REAL(b)"),
    ("cuter := 3;", "the closest known name is cutter"),
    ("x := l.iOm;", "the closest known name is iOn"),
    ("l(iCount := x, iOnn := 3);", "the closest known name is iOn"),
    ("x := LIMITT(1, x, 3);", "the closest known name is LIMIT"),
    ("b := 20 > 30 > 40;", "write 20 > 30 AND 30 > 40"),
    ("t := 300;", "write T#300ms for milliseconds"),
    ("IF x THEN ; END_IF", "write x <> 0"),
    ("s := s + s;", "CONCAT(a, b) joins strings"),
    ("x := l();", "call l(...); as a statement first, and read l.Q afterwards"),
    ("x := Axis_10;", "Axis_10.logAdr is its logical address"),
]


@pytest.mark.parametrize(("statements", "hint"), HINTS)
def test_a_hint_says_what_to_write_instead(statements: str, hint: str) -> None:
    assert hints(SAMPLES, program(VARIABLES, statements)) == [hint]


def test_all_mistakes_of_all_files_are_reported_in_their_order() -> None:
    first = "FUNCTION A : INT\nA := u;\nEND_FUNCTION"
    second = program("x : BOOL;", "x := A(); x := 4;\nx := v;")
    found = [(mistake.file, mistake.line) for mistake in checked(first, second)[1] if not mistake.is_note]
    assert found == [("1.st", 2), ("2.st", 3), ("2.st", 3), ("2.st", 4)]


def test_an_unknown_type_has_no_follow_on_mistakes() -> None:
    text = program("f : Nix; a : ARRAY[1..3] OF Nix;", "f := 3; f.x := a[2] + 1; f(IN := 3); a[9] := f;")
    assert messages(text) == ["1:26 the type Nix is not declared; a type", "1:50 the type Nix is not declared; a type"]


def test_a_repeated_case_label_is_only_a_note() -> None:
    text = program("x : INT;", "CASE x OF 1..5: ; 3: ; 4..9: ; END_CASE")
    assert messages(text) == []
    assert [found[4:20] for found in messages(text, notes=True)[1:]] == [" the label 3 occ", " the label 4..9 "]


def test_a_function_that_calls_itself_is_only_noted() -> None:
    text = "FUNCTION G : INT VAR_INPUT n : INT; END_VAR\nIF n > 0 THEN G := G(n - 1); END_IF\nEND_FUNCTION"
    assert messages(text, notes=True) == ["2:20 G calls itself"]


def test_a_circle_of_two_functions_is_noted_once() -> None:
    first = "FUNCTION A : INT\nA := B();\nEND_FUNCTION"
    second = "FUNCTION B : INT\nB := A();\nEND_FUNCTION"
    assert len(messages(first, second, notes=True)) == 1
