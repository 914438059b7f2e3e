"""Mistakes: each is reported once, at its place, with what was expected, and nothing follows from it."""

import pytest

from fieldrig_devices.iec.dialect import EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.parser import parse, parse_body
from fieldrig_devices.iec.tokens import KEYWORDS

# A body of ST, and the messages about it as `line:column what; expected`.
STATEMENTS = [
    ("x = 5;", ["1:3 got =; :="]),
    ("x == 5;", ["1:3 got =; :="]),
    ("x : = 5;", ["1:3 got : =; :="]),
    ("x += 1;", ["1:3 got +=; :="]),
    ("x := 5\ny := 3;", ["1:7 ; is missing behind 5"]),
    ("x := 5 y := 3;", ["1:7 ; is missing behind 5"]),
    ("RETURN\nx := 1;", ["1:7 ; is missing behind RETURN"]),
    ("IF a THEN x := 1 ELSE x := 2 END_IF;", ["1:17 ; is missing behind 1", "1:29 ; is missing behind 2"]),
    ("IF a := 5 THEN b := 1; END_IF;", ["1:6 got := in a condition; ="]),
    ("IF a = 5 b := 1; END_IF;", ["1:9 THEN is missing behind 5"]),
    ("WHILE a\n b := 1;\nEND_WHILE;", ["1:8 DO is missing behind a"]),
    ("FOR i := 1 TO 5\n x := 1;\nEND_FOR;", ["1:16 DO is missing behind 5"]),
    ("FOR i = 1 TO 5 DO x := 1; END_FOR;", ["1:7 got =; :="]),
    ("IF a == 5 && b != 3 THEN ; END_IF;", ["1:6 got ==; =", "1:11 got &&; AND", "1:16 got !=; <>"]),
    ("IF a THEN\n b := 1;\nENDIF;\nc = 2;", ["3:1 got ENDIF; END_IF", "4:3 got =; :="]),  # X12
    ("IF a THEN ; END IF;", ["1:13 got END IF; END_IF"]),
    ("IF a THEN ; ELSEIF b THEN ; END_IF;", ["1:13 got ELSEIF; ELSIF"]),  # X12
    ("x := 1;\nIF a THEN\n b := 1;", ["3:9 got the end of the text; END_IF for the IF in line 2"]),
    (
        "WHILE x DO\n IF a THEN ;\nEND_WHILE;\ny = 3;",
        ["3:1 got END_WHILE; END_IF for the IF in line 2", "4:3 got =; :="],
    ),
    ("END_WHILE; x = 1;", ["1:1 got END_WHILE, but no WHILE is open here; WHILE in front of it", "1:14 got =; :="]),
    ("REPEAT x := 1; END_REPEAT;", ["1:16 got END_REPEAT; UNTIL condition for the REPEAT in line 1"]),
    ("CASE x OF\n y := 3;\n1: z := 4;\nEND_CASE;", ["2:2 got y; a value with a colon, such as 1:"]),
    ("x := (a + b;\ny := 3;", ["1:12 ) for the ( in line 1, column 6 is missing behind b"]),
    ("x := a + b);", ["1:11 got ); ;"]),
    ("x[3 := 5;", ["1:5 got :=; ] for the [ in line 1, column 2"]),
    ("x := ;\ny := ;", ["1:6 got ;; a variable, a constant or a call", "2:6 got ;; a variable, a constant or a call"]),
    ("x := 7,4;", ["1:7 got ,; ;"]),
    ("a b := 5;", ["1:3 got b; := or a call"]),
    ("f(a b);", ["1:5 got b; , or ) in the arguments"]),
    ("t(IN := a\nIF x THEN ; END_IF", ["2:1 got IF; ) for the ( in line 1, column 2"]),
    ("x := 'abc;\ny = 3;", ["1:6 the string is not closed; ' at its end, in the same line", "2:3 got =; :="]),
    ('x := "abc";', ["1:6 got \"abc\"; a string in single quotes: 'abc'"]),
    ("x := 3; (* never\ny = 3;", ["1:9 the comment is not closed; *) at its end"]),
    ("IF a THEN\n(* never\nEND_IF;", ["2:1 the comment is not closed; *) at its end"]),
    ("x := 3 // why\n;y = 2;", ["1:8 // does not begin a comment; (* ... *)", "2:4 got =; :="]),
    ("k\u00e4se := 3;", ["1:1 the name k\u00e4se has letters that are not allowed; A to Z, digits and underscores"]),
    ("a__b := 3;", ["1:1 the name a__b has several underscores in a row; single underscores"]),
    ("x := 3axis;", ["1:6 3axis is neither a number nor a name; a name that begins with a letter or an underscore"]),
    ("x := a AND THEN b;", ["1:12 got THEN; a variable, a constant or a call"]),
    ("x := a ? b;", ["1:8 got ?; a character that has a meaning in the language", "1:10 got b; ;"]),
    ("x := 2 ** 3;", ["1:8 the operator ** is not supported; EXPT(base, exponent)"]),
    ("x := a AND_THEN b;", ["1:8 the operator AND_THEN is not supported; AND"]),
    ("CONTINUE;", ["1:1 CONTINUE is not supported; IF around the rest of the loop"]),
    ("JMP there;", ["1:1 JMP is not allowed in Structured Text; another statement"]),
    ("there: x := 1;", ["1:6 there: is a label, which Structured Text does not have; :="]),
    ("x S= y;", ["1:3 got S=; :="]),
]
HINTS = [
    ("x = 5;", "An assignment is written with :=."),
    ("IF a := 5 THEN ; END_IF;", "A comparison is written with =, an assignment with :=."),
    ("x := 7,4;", "A decimal fraction is written with a point: 7.4."),
    ("x := 15ms;", "A time is written T#15ms."),
    ("IF a THEN ; ENDIF", "The keyword is END_IF."),
    ("IF a THEN ; ELSEIF b THEN ; END_IF;", "The keyword is ELSIF."),
    ("a b := 5;", "A name has no blank in it: a_b."),
    ("x := a + b);", "There is one closing bracket more than opening ones."),
    ("x += 1;", "Write x := x + ... for x += ..."),
    ("x := 2 ** 3;", "Write EXPT(2, 3) for 2**3."),
    ("a__b := 3;", "Write a_b."),
    ("x := 'a$q';", "A dollar sign in a text is written $$."),
]
DECLARATIONS = [
    ("x : INT := 5;\nVAR_END", ["4:1 got VAR_END; END_VAR"]),  # X12
    ("x : INT\ny : INT;\nEND_VAR", ["3:8 ; is missing behind INT"]),
    ("Intermediate result : BOOL;\nEND_VAR", ["3:1 the name Intermediate result has a blank in it; one word"]),  # L10
    ("x : INT;", ["4:1 got x; END_VAR for the VAR in line 2"]),
    ("x INT;\nEND_VAR", ["3:2 : is missing behind x"]),
    ("x : INT = 5;\nEND_VAR", ["3:9 got =; :="]),  # X15
    ("if : BOOL; y = 5 : INT;\nEND_VAR", ["3:1 got if; the name of a variable", "3:14 got =; : and a type"]),
    ("INT : BOOL;\nEND_VAR", ["3:1 INT is the name of a type; another name for the variable"]),
    (
        "3a : INT;\nEND_VAR",
        ["3:1 3a is neither a number nor a name; a name that begins with a letter or an underscore"],
    ),
    ("x : REAL := 7,4;\nEND_VAR", ["3:14 got ,; ; behind the start value of a REAL"]),
    ("x : ARRAY[1-5] OF INT;\nEND_VAR", ["3:14 got ]; .."]),
    ("x : ARRAY(1..3) OF INT;\nEND_VAR", ["3:10 got (; ["]),
    ("x : ARRAY[1..3] INT;\nEND_VAR", ["3:17 got INT; OF"]),
    ("x : STRING(3;\nEND_VAR", ["3:13 ) for the ( in line 3, column 11 is missing behind 3"]),
    ("x AT 5 : INT;\nEND_VAR", ["3:6 got 5; an address such as %QX1.0"]),
]
UNITS = [
    ("PROGRAM p\nx := 1;\n", ["3:1 got the end of the text; END_PROGRAM for PROGRAM p in line 1"]),
    (
        "PROGRAM p\nIF x THEN ;\nEND_PROGRAM\nPROGRAM q x := ; END_PROGRAM",
        [
            "3:1 got END_PROGRAM; END_IF for the IF in line 2",
            "4:16 got ;; a variable, a constant or a call",
        ],
    ),
    (
        "FUNCTION f : INT\nf := 1;\nEND_FUNCTION_BLOCK\nPROGRAM q END_PROGRAM",
        ["3:1 got END_FUNCTION_BLOCK at the end of FUNCTION f; END_FUNCTION"],
    ),
    (
        "x := 5;\nPROGRAM q END_PROGRAM",
        ["1:1 got x; PROGRAM, FUNCTION_BLOCK, FUNCTION, TYPE, VAR_GLOBAL or CONFIGURATION"],
    ),
    ("PROGRAM p EXTENDS q\nEND_PROGRAM", ["1:11 got EXTENDS; VAR_INPUT or another declaration"]),
    ("FUNCTION_BLOCK b : INT\nEND_FUNCTION_BLOCK", ["1:20 a FUNCTION_BLOCK has no result; VAR_OUTPUT"]),
    ("TYPE c : REFERENCE TO INT; END_TYPE", ["1:10 got REFERENCE; a type"]),
    ("TYPE b : STRUCT x : INT; END_TYPE", ["1:26 got END_TYPE; END_STRUCT for the STRUCT in line 1"]),
    ("ACTION a: x := 1; END_ACTION", ["1:1 the action a belongs to no POU; a POU in front of it"]),
    (
        "CONFIGURATION c\nTASK u(CYCLE := 3);\nTASK v;\nEND_CONFIGURATION",
        ["2:8 got CYCLE; INTERVAL, PRIORITY or SINGLE", "3:7 got ;; ("],
    ),
    (
        """PROGRAM p
INITIAL_STEP a: run(Q); END_STEP
STEP b: run(L); END_STEP
TRANSITION FROM a b := TRUE; END_TRANSITION
END_PROGRAM""",
        [
            "2:21 got Q; a qualifier: N, R, S, L, D, P, SD, DS, SL, P0 or P1",
            "3:14 , and a time is missing behind L",
            "4:19 got b; TO",
        ],
    ),
]
IL = [
    ("LD x\nST y;\nADD 2", ["2:5 got ;; the end of the line"]),
    ("LD x\nADD 2 3\nST y", ["2:7 got 3; the end of the line"]),
    ("LD x\ny := 5\nST y", ["2:3 got :=; an operand"]),
    ("LD x\n)", ["2:1 got ); an operator of IL"]),
    ("LD x\nMUL ( 3\nADD 4\nST z", ["4:5 ) for the ( in line 2, column 5 is missing behind z"]),
]


def messages(text: str, dialect: Dialect = EPAS_4, language: str = "") -> list[str]:
    if language:
        _, mistakes = parse_body(text, "test.st", language, dialect)
    else:
        _, mistakes = parse(text, "test.st", dialect)
    assert all(mistake.file == "test.st" for mistake in mistakes)
    return [
        f"{mistake.line}:{mistake.column} {mistake.what}" + (f"; {mistake.expected}" if mistake.expected else "")
        for mistake in mistakes
    ]


@pytest.mark.parametrize(("text", "expected"), STATEMENTS)
def test_a_mistake_in_a_statement_is_reported_once(text: str, expected: list[str]) -> None:
    assert messages(text, language="ST") == expected


@pytest.mark.parametrize(("text", "expected"), DECLARATIONS)
def test_a_mistake_in_a_declaration_is_reported_once(text: str, expected: list[str]) -> None:
    assert messages(f"PROGRAM p\nVAR\n{text}\nx := 1;\nEND_PROGRAM") == expected


@pytest.mark.parametrize(("text", "expected"), UNITS)
def test_a_mistake_in_a_file_is_reported_once(text: str, expected: list[str]) -> None:
    assert messages(text) == expected


@pytest.mark.parametrize(("text", "expected"), IL)
def test_a_mistake_in_instruction_list_is_reported_once(text: str, expected: list[str]) -> None:
    found = messages(text, language="IL")
    assert found == expected


@pytest.mark.parametrize(("text", "hint"), HINTS)
def test_a_mistake_has_a_hint(text: str, hint: str) -> None:
    _, mistakes = parse_body(text, "test.st", "ST")
    assert hint in [mistake.hint for mistake in mistakes]


def test_the_indentation_shows_which_end_is_missing() -> None:
    text = "IF a THEN\n    IF b THEN\n        x := 1;\n    IF c THEN\n        x := 2;\n    END_IF;\nEND_IF;\ny := 3;"
    _, (mistake,) = parse_body(text, "test.st", "ST")
    assert (mistake.line, mistake.expected) == (8, "END_IF for the IF in line 1")
    assert mistake.hint == "IF in line 2 may lack its END_IF: see the indentation of line 7."


def test_what_edition_3_allows_is_no_mistake() -> None:
    text = (
        "x := 2 ** 3; // power\nWHILE a AND_THEN b DO CONTINUE; END_WHILE;\nthere: JMP there; x S= y; (* a (* b *) *)"
    )
    assert messages(text, EDITION_3, "ST") == []
    assert messages("Reset;", EDITION_3, "ST") == ["1:6 () is missing behind Reset"]
    assert messages("Reset;", EPAS_4, "ST") == []


@pytest.mark.manual("PD-362")
def test_comments_do_not_nest() -> None:
    assert messages("(* a (* b *) c *) x = 1;", language="ST") == [
        "1:6 a comment begins inside a comment; *) first",
        "1:21 got =; :=",
    ]
    assert messages("(* a (* b *) x := 1;", language="ST") == []


@pytest.mark.manual("PD-350")
@pytest.mark.parametrize("name", ["_ConveyerBelt", "x", "A_BCD", "VAR1", "Task", "Step", "with", "LD", "S", "R1"])
def test_names_have_letters_digits_and_single_underscores(name: str) -> None:
    assert messages(f"VAR_GLOBAL {name} : INT; END_VAR") == []


@pytest.mark.manual("PD-350")
@pytest.mark.parametrize("name", ["__x", "a__b", "1a", "a b", "\u00fcber", "a-b", "IF", "end_if", "Var", "int", "TIME"])
def test_other_names_are_refused(name: str) -> None:
    assert len(messages(f"VAR_GLOBAL {name} : INT; END_VAR")) == 1


def test_first_lines_of_bodies_alone_are_counted_from_where_they_stand() -> None:
    _, mistakes = parse_body("x := 1;\ny = 2;", "a.TcPOU", "ST", first_line=40)
    assert [(mistake.line, mistake.column) for mistake in mistakes] == [(41, 3)]


HEAD = "PROGRAM p\nVAR\n"


@pytest.mark.parametrize(
    "text",
    [
        HEAD + "{attribute 'link' := '\n pv: A:B\n io: i\n'}\n x : BOOL;\nEND_VAR\nx := TRUE;\nEND_PROGRAM",
        HEAD + "t : TON;\nEND_VAR\nt(IN := TRUE, PT := T#1s,\n);\nEND_PROGRAM",
    ],
)
def test_what_todays_tools_write_is_read(text: str) -> None:
    assert messages(text, EDITION_3) == []


def test_a_line_number_counts_the_lines_of_a_pragma() -> None:
    assert messages(HEAD + "{a\n\n}\nx : BOOL;\nEND_VAR\nx = 1;\nEND_PROGRAM") == ["8:3 got =; :="]


def test_a_comma_behind_the_last_argument_is_refused_by_epas() -> None:
    assert messages("a(b := 1,);", language="ST") == ["1:9 got , behind the last argument; )"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("TYPE e : (a, b) REAL; END_TYPE", ["1:17 got REAL behind an enumeration; ;"]),
        (HEAD + "b : Block(n := 1);\nEND_VAR\nEND_PROGRAM", ["3:10 got (; ; or :="]),
    ],
)
def test_what_only_todays_tools_have_is_refused_once(text: str, expected: list[str]) -> None:
    assert messages(text, EDITION_3) == expected


def test_what_the_controller_does_not_have_is_skipped_to_its_end() -> None:
    text = (
        "FUNCTION_BLOCK f\nx := 1;\nPROPERTY PUBLIC m : BOOL\nVAR a : INT; END_VAR\na := 1;\nEND_PROPERTY\n"
        "y = 2;\nEND_FUNCTION_BLOCK"
    )
    assert messages(text) == ["3:1 a PROPERTY is not supported; a statement", "7:3 got =; :="]
    assert messages("FUNCTION_BLOCK PUBLIC f\nEND_FUNCTION_BLOCK") == [
        "1:16 got PUBLIC; the name of the FUNCTION_BLOCK"
    ]


@pytest.mark.parametrize("behind", ["b : STRUCT m : INT; END_STRUCT;", "b : ARRAY[1..2] OF INT;", "b, c : INT := 3;"])
def test_a_keyword_as_the_name_of_a_variable_is_one_mistake(behind: str) -> None:
    for word in KEYWORDS - {"AT"}:
        if not word.startswith("END_"):
            for front in ("", "a : INT; "):
                _, mistakes = parse(
                    f"PROGRAM p\nVAR\n {front}{word} : BYTE := 200; {behind}\nEND_VAR\nEND_PROGRAM\n", "p.st"
                )
                assert len(mistakes) == 1, (word, mistakes)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x ← 5;", "got ←; expected :="),
        ("x := 5 – y;", "got –; expected -"),
        ("x := 5 × y ÷ 2;", "got ×; expected *"),
        ("b := x ≠ 5;", "got ≠; expected <>"),
        ("b := x ≤ 5;", "got ≤; expected <="),
        ("x := 5；", "got ；; expected ;"),
        ("f（x）;", "got （; expected ("),
        ("b := x => 5;", "The sign for greater or equal is >=."),
        ("b := x >< 5;", "The sign for unequal is <>"),
        ("x := x << 2;", "bits are moved by SHL and SHR"),
        ("x := .5;", "A number has a digit in front of its point: 0.5."),
        ("GOTO there;", "loops, IF and CASE instead of jumps"),
        ("LET x := 5;", "An assignment is x := 5; without a word in front."),
        ("MOVE x TO y;", "An assignment is x := y; or x := MOVE(y);"),
        ("CALL timer;", "A call is the name of the instance with brackets"),
        ("INT z;", "A variable is declared between VAR and END_VAR: z : INT;"),
        ("int z := 5;", "A variable is declared between VAR and END_VAR: z : INT;"),
        ("FOR i := 1 TO 5 STEP 2 DO ; END_FOR;", "The step of a FOR is behind BY."),
    ],
)
def test_a_habit_of_other_languages_and_of_word_processors_is_told_the_right_form(text: str, said: str) -> None:
    _, found = parse_body(text, "test.st", "ST", EDITION_3)
    assert said in str(found[0])
    assert {mistake.line for mistake in found} == {1}
