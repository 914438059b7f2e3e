"""No text makes the parser raise, and none takes it long: random texts, damaged programs, and deep nesting."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.iec.dialect import EDITION_3, EPAS_4
from fieldrig_devices.iec.parser import parse, parse_body, parse_declarations
from fieldrig_devices.iec.printer import print_unit
from fieldrig_devices.iec.tokens import END, tokens

PROGRAM = """
TYPE Colour : (red, yellow := 3, green); END_TYPE
TYPE Form : STRUCT a : ARRAY[1..3, 2..4] OF INT := 1, 2(7); s : STRING(20) := 'a$'b$0D'; END_STRUCT END_TYPE
FUNCTION_BLOCK Counter
VAR_INPUT RETAIN iMode : INT; (* 0 = reset *) END_VAR
VAR p AT %MW3 : POINTER TO INT; t : TIME := T#1m30s; d : DATE := D#1998-12-07; END_VAR
IF iMode = 0 AND NOT (p^ > 16#FF) THEN
    x[3, i + 1].y := -5.5E-3 * 2 MOD 3;
ELSIF a XOR b THEN
    CASE i OF 1, 3..5: Start(IN := TRUE, Q => q); red: EXIT; ELSE ; END_CASE;
ELSE
    FOR i := 1 TO 10 BY 2 DO WHILE a DO REPEAT UNTIL b END_REPEAT; END_WHILE; END_FOR;
END_IF;
END_FUNCTION_BLOCK
PROGRAM il
loop: LD a
    ADD ( 2
    MUL 3 )
    ST b
    JMPCN loop
    CAL c(x := 1,
        y := 2)
END_PROGRAM
PROGRAM chart
INITIAL_STEP s: run(SD, T#5s); END_STEP
STEP f: ENTRY a := 1; END_ENTRY ACTIVE LD 1
 ST a
 END_ACTIVE END_STEP
TRANSITION t (PRIORITY := 3) FROM (s, f) TO s := a > 3; END_TRANSITION
ACTION run: b := 2; END_ACTION
END_PROGRAM
CONFIGURATION c VAR_GLOBAL g : INT; END_VAR RESOURCE r ON PLC
TASK t(INTERVAL := T#10ms, PRIORITY := 30); PROGRAM p WITH t : Counter; END_RESOURCE END_CONFIGURATION
VAR_CONFIG chart.s AT %QX0.0 : BOOL; END_VAR
"""
WORDS = sorted(
    {*PROGRAM.split(), "(*", "*)", "'", "//", '"', "{native}", "%", "$", "#", "..", "^", "16#", "T#", "\x00"}
)
DIALECTS = pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3], ids=lambda dialect: dialect.name)


def read(text: str, dialect: object = EPAS_4) -> None:
    """Parse a text in every way, and print what came out of it."""
    unit, _ = parse(text, "any.st", dialect)  # type: ignore[arg-type]
    print_unit(unit)
    for language in ("", "ST", "IL", "SFC"):
        parse_body(text, "any.st", language, dialect)  # type: ignore[arg-type]
    parse_declarations(text, "any.st", dialect)  # type: ignore[arg-type]


@DIALECTS
def test_the_program_that_is_damaged_below_has_no_mistakes(dialect: object) -> None:
    assert parse(PROGRAM, "any.st", dialect)[1] == []  # type: ignore[arg-type]


@pytest.mark.long
@settings(deadline=None)
@given(st.text(max_size=200))
def test_any_text_is_read(text: str) -> None:
    read(text)


@settings(deadline=None)
@given(st.lists(st.sampled_from(WORDS), max_size=40).map(" ".join), st.sampled_from([EPAS_4, EDITION_3]))
def test_any_words_are_read(text: str, dialect: object) -> None:
    read(text, dialect)


@pytest.mark.long
@settings(deadline=None)
@given(st.integers(0, len(PROGRAM)), st.integers(0, 30), st.sampled_from(["", *WORDS]))
def test_a_damaged_program_is_read(start: int, length: int, inserted: str) -> None:
    read(f"{PROGRAM[:start]}{inserted}{PROGRAM[start + length :]}")


@pytest.mark.parametrize(
    ("head", "part", "tail"),
    [
        ("x := ", "(", ";"),
        ("x := ", "NOT ", "a;"),
        ("x := ", "- ", "a;"),
        ("x := a", "[a", ";"),
        ("x := a", ".b", ";"),
        ("x := ", "f(", ";"),
        ("x := a", "^", ";"),
        ("", "IF a THEN ", ""),
        ("", "CASE a OF 1: ", ""),
        ("", "WHILE a DO ", ""),
        ("LD a\n", "ADD (\n", ""),
    ],
)
def test_deep_nesting_ends_in_one_message(head: str, part: str, tail: str) -> None:
    body, mistakes = parse_body(f"{head}{part * 5_000}{tail}", "deep.st", "")
    assert [mistake.expected[:7] for mistake in mistakes] == ["at most"]
    assert body is not None


@pytest.mark.long
@pytest.mark.parametrize("part", ["ARRAY[1..2] OF ", "POINTER TO ", "STRUCT a : "])
def test_deep_types_end_in_one_message(part: str) -> None:
    _, mistakes = parse(f"TYPE t : {part * 5_000} INT; END_TYPE", "deep.st")
    assert [mistake.expected[:7] for mistake in mistakes] == ["at most"]


@pytest.mark.parametrize("part", ["[", "2(", "(a := "])
def test_deep_start_values_end_in_one_message(part: str) -> None:
    _, mistakes = parse(f"VAR_GLOBAL a : t := {part * 5_000}; END_VAR", "deep.st")
    assert [mistake.expected[:7] for mistake in mistakes] == ["at most"]


MANY = 300_000  # quadratic work at this size takes longer than a test may


@pytest.mark.long
@pytest.mark.parametrize(
    "text",
    [
        " " * MANY,
        f"x := 'a{' ' * MANY}b",
        f"x := 'a{')' * MANY}b",
        f"x := 'a{chr(13) * MANY}b",
        "{" * MANY,
        "{{ " * (MANY // 3),
        "{{}} " * (MANY // 5),
        "(*) " * (MANY // 4),
        "'" * (MANY + 1),
    ],
    ids=[
        "blanks",
        "blanks in a string",
        "brackets in a string",
        "returns in a string",
        "braces",
        "double braces",
        "closed double braces",
        "comments",
        "quotes",
    ],
)
def test_a_text_is_split_in_one_pass(text: str) -> None:
    assert tokens(text, "any.st", EPAS_4).kinds[-1] == END


@pytest.mark.parametrize("number", ["1e5000", f"1.{'9' * 500}"], ids=["exponent", "digits"])
def test_a_number_that_is_too_large_is_a_message(number: str) -> None:
    _, mistakes = parse(f"PROGRAM p VAR r : REAL; END_VAR r := {number}; END_PROGRAM", "any.st")
    assert [found.what for found in mistakes] == ["the number is too large"]
