"""Expressions with their precedence, and what the parser says about wrong programs."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pam_programs import HEADER, MACHINE, in_sequence, mistakes_of

from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.formatter import formatted
from fieldrig_devices.pam.language.items import Task
from fieldrig_devices.pam.language.parser import parse
from fieldrig_devices.pam.language.tokens import split
from fieldrig_devices.pam.language.tree import Assign, Binary, Expression, Inquiry, Number, Reference, Unary, Word


def value_of(text: str) -> Expression:
    program, _ = parse(in_sequence(f"CRV_Size <- {text};"), "x")
    task = program.items[-1]
    assert isinstance(task, Task)
    statement = task.sequences[0].body[0]
    assert isinstance(statement, Assign)
    return statement.value


def shape(expression: Expression) -> str:
    """An expression with all its parentheses."""
    match expression:
        case Binary(operator=operator, left=left, right=right):
            return f"({shape(left)} {operator} {shape(right)})"
        case Unary(operator=operator, operand=operand):
            return f"({operator}{shape(operand)})"
        case Inquiry(subject=subject, function=function):
            return f"({shape(subject)} ? {function})"
        case Number(spelling=spelling):
            return spelling
        case Reference(name=name, index=index):
            return f"{name}[{index}]" if index else name
        case Word(name=name):
            return name
        case _:
            return type(expression).__name__


@pytest.mark.manual("PAMS-008")
@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("x * z ^ y", "((x * z) ^ y)"),  # manual lines 6657 to 6661
        ("2 * x + 23 ? cos", "((2 * x) + (23 ? cos))"),  # manual lines 6569 to 6573
        ("!X ? ready", "((!X) ? ready)"),
        ("!(X ? ready)", "(!(X ? ready))"),
        ("A ? error_code = K", "((A ? error_code) = K)"),  # manual line 7701
        ("a - b - c", "((a - b) - c)"),
        ("a + b > c = d", "(((a + b) > c) = d)"),
        ("d <> c >= a + b * e", "(d <> (c >= (a + (b * e))))"),
        ("a < b > c", "((a < b) > c)"),
        ("a = b <> c", "((a = b) <> c)"),
        ("-3 + +2.5", "((-3) + (+2.5))"),
        ("Pi / 2", "(PI / 2)"),
        ("a[all*] * b[i]", "(a[all*] * b[i])"),
    ],
)
def test_precedence(text: str, meaning: str) -> None:
    assert shape(value_of(text)) == meaning


@pytest.mark.parametrize(
    ("text", "place", "said"),
    [
        (
            "NODE NOD_a; ADRESS = 1; TYPE = ST1; END",
            (2, 13),
            "got ADRESS; expected a parameter of NODE: NUMBER",
        ),
        ("NODE NOD_a; ADDRESS = 1 TYPE = ST1; END", (2, 24), "; is missing behind 1"),
        ("NODE NOD_a; ADDRESS = 1; ADDRESS = 2; TYPE = ST1; END", (2, 26), "ADDRESS appears twice"),
        ("NODE CASE; END", (2, 6), "CASE is a reserved word"),
        ("SEQUENCE SEQ_a; END_SEQUENCE", (2, 1), "got SEQUENCE; expected the kind of an object"),
        ("INTERNAL BIT_VAR a;", (2, 10), "got BIT_VAR; expected FLAG_VAR, WORD_VAR or REAL_VAR"),
        ("VME DUALPORT END_DUALPORT", (2, 14), "expected SPECS"),
    ],
)
def test_wrong_items(text: str, place: tuple[int, int], said: str) -> None:
    found = mistakes_of(HEADER + text)[0]
    assert (found.line, found.column) == place
    assert said in str(found)


def test_every_statement_says_its_own_mistake() -> None:
    wrong = "AXI_Belt stop;\nIFV_Go <- ;\nWAIT_TIME 5;\nCONDITION TIMEOUT TIMEOUT 5 6;\nLOOP END_LOOP"
    found = mistakes_of(in_sequence(wrong))
    first = in_sequence("").splitlines().index("SEQUENCE SEQ_Test;") + 2
    assert [mistake.line - first for mistake in found] == [0, 1, 3, 4]


def test_a_semicolon_that_listings_leave_out_is_worth_a_note() -> None:
    program, found = checked(in_sequence("IF IFV_Go THEN XEQ_SEQUENCE SEQ_Other END_IF REMOVE_EXCEPTION"), "x")
    assert program.items
    assert [(mistake.is_note, mistake.what) for mistake in found] == [(True, "a semicolon is missing")] * 2


@pytest.mark.parametrize(
    "text", ["(" * 500, "IF IFV_Go THEN " * 500, "CRV_Size <- " + "-" * 500, "CRV_Size <- 1" + " + 1" * 5000 + ";"]
)
def test_depth_is_limited(text: str) -> None:
    assert mistakes_of(in_sequence(text))


MORE_WORDS = "TASK SEQUENCE END_TASK IF LOOP CASE <- << ? [i] [all] ( ) : ; #set"
WORDS = st.sampled_from([*MACHINE.split(), *MORE_WORDS.split()])


@given(st.lists(WORDS, max_size=60).map(" ".join) | st.text(max_size=100))
def test_damaged_programs_are_refused_with_a_place(text: str) -> None:
    for mistake in checked(HEADER + text, "x")[1]:
        assert mistake.line >= 1
        assert mistake.column >= 1


@given(st.lists(WORDS | st.sampled_from(["\n", "// a\n", "\n\n", "/* b */"]), max_size=60).map(" ".join))
def test_formatting_keeps_the_tokens_and_is_stable(text: str) -> None:
    once = formatted(HEADER + text)
    assert formatted(once) == once
    before, after = parse(HEADER + text, "x")[0], parse(once, "x")[0]
    assert before.items == after.items
    comments = [[comment for _, comment in split(source, "x").comments] for source in (HEADER + text, once)]
    assert comments[0] == comments[1]
