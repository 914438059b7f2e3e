"""Conditions of the compiler: expectations from the public description of CODESYS V3's pragmas."""

from dataclasses import replace

import pytest

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, Dialect
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.languages.mistakes import Mistake


def compiled(body: str, dialect: Dialect = CODESYS) -> tuple[list[str], list[Mistake]]:
    """Return the names that are assigned to in a body, and the mistakes."""
    unit, mistakes = parse(f"PROGRAM p\nVAR a, b, c, d : INT; END_VAR\n{body}\nEND_PROGRAM", "p.st", dialect)
    names = [one.target.text for one in tree.walk(unit) if isinstance(one, tree.Assign)]  # type: ignore[union-attr]
    return names, mistakes


@pytest.mark.parametrize(
    ("condition", "holds"),
    [
        ("defined (x)", True),
        ("defined(X)", True),
        ("defined (y)", False),
        ("NOT defined (y)", True),
        ("defined (x) AND defined (y)", False),
        ("defined (x) OR defined (y)", True),
        ("NOT (defined (x) AND NOT defined (y))", False),
        ("defined (y) AND defined (y) OR defined (x)", True),
        ("hasvalue (x, '7')", True),
        ("hasvalue (x, '8')", False),
        ("hasvalue (y, '')", False),
        ("project_defined (y)", False),
        ("defined (IsLittleEndian)", True),
        ("defined (IsSimulationMode)", False),
    ],
)
def test_conditions(condition: str, holds: bool) -> None:
    names, mistakes = compiled(f"{{define x '7'}}\n{{IF {condition}}}\na := 1;\n{{ELSE}}\nb := 2;\n{{END_IF}}")
    assert names == (["a"] if holds else ["b"])
    assert mistakes == []


def test_the_first_branch_that_holds_is_compiled() -> None:
    body = "{define y}{IF defined (x)} a := 1; {ELSIF defined (y)} b := 1; {ELSIF defined (y)} c := 1; "
    body += "{ELSE} d := 1; {END_IF}"
    assert compiled(body) == (["b"], [])


def test_conditions_within_conditions() -> None:
    body = "{define x}{IF defined (x)} {IF defined (y)} a := 1; {ELSE} b := 1; {END_IF} c := 1; "
    body += "{ELSE} {IF defined (x)} d := 1; {END_IF} {END_IF}"
    assert compiled(body) == (["b", "c"], [])


def test_undefine() -> None:
    assert compiled("{define x}{undefine x}{IF defined (x)} a := 1; {END_IF} b := 1;") == (["b"], [])


def test_a_define_that_is_not_compiled_defines_nothing() -> None:
    assert compiled("{IF defined (x)} {define y} {END_IF} {IF defined (y)} a := 1; {END_IF}") == ([], [])


def test_what_is_not_compiled_may_be_anything() -> None:
    names, mistakes = compiled("{IF defined (x)} this is ( no code ' at all\n{END_IF} a := 1;")
    assert (names, mistakes) == (["a"], [])


def test_comments_and_texts_contain_no_conditions() -> None:
    body = "(* {IF defined (x)} (* *) *) a := 1; // {IF defined (x)}\n/* {IF defined (x)} */ s := '{IF defined (x)}';"
    assert compiled(body) == (["a", "s"], [])


def test_lines_and_columns_stay() -> None:
    _, mistakes = compiled("{IF defined (x)}\na := 1;\n{ELSE}\n   b := := 2;\n{END_IF}")
    assert [(one.line, one.column) for one in mistakes] == [(6, 9)]


@pytest.mark.parametrize(
    ("body", "line", "column", "what"),
    [
        ("a := 1;\n  {IF defined (x)}\nb := 1;", 4, 3, "{IF} is not closed"),
        ("{END_IF}", 3, 1, "{END_IF} has no {IF}"),
        ("{ELSE}{END_IF}", 3, 1, "{ELSE} has no {IF}"),
        ("{IF defined (x)}{ELSE}{ELSE}{END_IF}", 3, 23, "{ELSE} has no {IF}"),
        ("{IF x = 1}{END_IF}", 3, 1, "the condition x = 1 cannot be read"),
        ("{IF defined (x}{END_IF}", 3, 1, "the condition defined (x cannot be read"),
        ("{IF}{END_IF}", 3, 1, "the condition of {IF} cannot be read"),
        ("{define 7}", 3, 1, "{define 7} has no name"),
        ("{error 'not for this controller'}", 3, 1, "not for this controller"),
    ],
)
def test_mistakes(body: str, line: int, column: int, what: str) -> None:
    mistakes = compiled(body)[1]
    assert (line, column, what) in [(one.line, one.column, one.what) for one in mistakes if not one.is_note]


def test_messages_of_a_program() -> None:
    names, mistakes = compiled("{IF defined (x)} {error 'never'} {END_IF} {warning 'old'} {info 'known'} a := 1;")
    assert names == ["a"]
    assert [(one.what, one.is_note) for one in mistakes] == [("old", True), ("known", True)]


def test_conditions_about_the_project_are_noted() -> None:
    names, mistakes = compiled("{IF defined (pou: Pump)} a := 1; {ELSE} b := 1; {END_IF} c := 1;")
    assert names == ["a", "b", "c"]
    assert [one.is_note for one in mistakes] == [True]


def test_deep_conditions_and_open_ones_end() -> None:
    compiled("{IF defined (x)}" * 2_000)
    compiled("{IF " + "NOT (" * 5_000 + "}")
    compiled("{IF " * 2_000)


def test_other_dialects_have_pragmas_only() -> None:
    assert compiled("{IF defined (x)} a := 1; {END_IF}", EDITION_3)[0] == ["a"]
    assert compiled("{IF defined (x)} a := 1; {END_IF}", replace(CODESYS, has_conditional_code=False))[0] == ["a"]
