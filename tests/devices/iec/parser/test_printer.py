"""A tree that is printed and parsed again is the same tree, and printing it again gives the same text."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from iec_trees import EXPRESSIONS, INITIALS, STATEMENTS, UNITS

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import CODESYS, DIALECTS, EDITION_3
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.printer import print_unit

_COMMENT = re.compile(r"\(\*.*?\*\)", re.DOTALL)


def assert_survives(unit: tree.Unit) -> None:
    text = print_unit(unit)
    again, mistakes = parse(text, unit.file, replace(EDITION_3, has_chained_assignments=True))
    assert mistakes == []
    assert again == unit
    assert print_unit(again) == text


def unit_of(*statements: tree.AnyStatement, blocks: tuple[tree.Variables, ...] = ()) -> tree.Unit:
    pou = tree.Pou(tree.PouKind.PROGRAM, "p", None, blocks, tree.StBody(statements))
    return tree.Unit("random.st", (pou,))


@pytest.mark.long
@settings(deadline=None)
@given(EXPRESSIONS)
def test_a_printed_expression_is_parsed_to_the_same_tree(expression: tree.Expression) -> None:
    assert_survives(unit_of(tree.Assign(tree.Name("x"), expression)))


@pytest.mark.long
@settings(deadline=None, max_examples=50)
@given(STATEMENTS)
def test_a_printed_statement_is_parsed_to_the_same_tree(statement: tree.AnyStatement) -> None:
    assert_survives(unit_of(tree.Empty(), statement))


@pytest.mark.long
@settings(deadline=None, max_examples=50)
@given(INITIALS)
def test_a_printed_start_value_is_parsed_to_the_same_tree(initial: tree.Initial) -> None:
    variable = tree.Variable("x", tree.NamedType("Form"), initial)
    assert_survives(unit_of(blocks=(tree.Variables(tree.Section.LOCAL, (variable,)),)))


@pytest.mark.long
@settings(deadline=None, max_examples=15)
@given(UNITS)
def test_a_printed_file_is_parsed_to_the_same_tree(unit: tree.Unit) -> None:
    assert_survives(unit)
    assert sorted(_COMMENT.findall(print_unit(unit))) == sorted(comments_of(unit))


def comments_of(node: object) -> list[str]:
    """All comments in a tree."""
    if isinstance(node, tuple):
        return [found for part in node for found in comments_of(part)]
    if not hasattr(node, "__dataclass_fields__"):
        return []
    found = [*getattr(node, "comments", ()), *getattr(node, "after", ())]
    found += [remark for remark in [getattr(node, "remark", "")] if remark]
    for name in node.__dataclass_fields__:
        if name not in ("comments", "after", "remark"):
            found += comments_of(getattr(node, name))
    return found


def test_a_comment_in_front_of_an_action_stays_there() -> None:
    declared = "PROGRAM a\nVAR\n    x : INT;\nEND_VAR\n\n    LD x\n\n"
    text = f"{declared}(* what Reset does *)\nACTION Reset:\nEND_ACTION\nEND_PROGRAM\n"
    unit, mistakes = parse(text, "a.st")
    assert mistakes == []
    (program,) = unit.declarations
    assert isinstance(program, tree.Pou)
    assert program.actions[0].comments == ("(* what Reset does *)",)
    assert_survives(unit)


@pytest.mark.parametrize("name", ["R", "s", "Ret", "S.x", "R[1]", "Cal^", "Reset"])
def test_a_variable_with_the_name_of_an_operator_stays_a_variable(name: str) -> None:
    """Once, `OR ( R` was written for it, which is the operator R."""
    unit, mistakes = parse(
        f"PROGRAM p\n    LD a\n    OR (\n        LD {name}\n        NOT\n    )\nEND_PROGRAM\n", "a.st"
    )
    assert mistakes == []
    assert_survives(unit)


ENDS = """\
FUNCTION_BLOCK f
METHOD m
(* in m *)
END_METHOD (* behind m *)
END_FUNCTION_BLOCK (* behind f *)

PROGRAM a
b := 1; /* one */
END_PROGRAM // behind a
"""


def test_comments_at_the_ends_of_units_and_methods_stay_once() -> None:
    unit, mistakes = parse(ENDS, "a.st", EDITION_3)
    assert mistakes == []
    printed = print_unit(unit)
    assert [printed.count(f"{what} *)") for what in ("in m", "behind m", "behind f")] == [1, 1, 1]
    assert printed.endswith("b := 1; /* one */\nEND_PROGRAM // behind a\n")
    assert print_unit(parse(printed, "a.st", EDITION_3)[0]) == printed


@pytest.mark.parametrize("section", ["entry", "active", "exit"])
def test_a_section_of_a_step_may_begin_with_an_empty_statement(section: str) -> None:
    step = tree.Step("a", True, (), None, None, None)
    setattr(step, section, tree.StBody((tree.Empty(),)))
    assert_survives(tree.Unit("a.st", (tree.Pou(tree.PouKind.PROGRAM, "p", None, (), tree.SfcBody((step,), ())),)))


PROGRAMS = sorted((Path(__file__).parents[1] / "programs").glob("*.st"))


@pytest.mark.parametrize("file", PROGRAMS, ids=lambda file: file.stem)
def test_a_small_program_is_the_same_behind_the_formatter(file: Path) -> None:
    text = file.read_text(encoding="ascii")
    head = re.match(r"\(\* dialects: ([\w-]+)", text)
    assert head is not None
    unit, mistakes = parse(text, "a.st", DIALECTS[head[1]])
    printed = print_unit(unit)
    assert parse(printed, "a.st", DIALECTS[head[1]]) == (unit, mistakes)
    assert print_unit(parse(printed, "a.st", DIALECTS[head[1]])[0]) == printed


@pytest.mark.parametrize("file", PROGRAMS[::6], ids=lambda file: file.stem)
def test_a_comment_between_any_two_words_survives(file: Path) -> None:
    text = re.sub(r"\(\*.*?\*\)", "", file.read_text(encoding="ascii"))
    for found in re.finditer(r"(?<=[\s;,()])(?=\S)|$", text):
        unit, mistakes = parse(f"{text[: found.start()]} (*here*) {text[found.start() :]}", "a.st", EDITION_3)
        if not mistakes:  # within an instruction of a list there is none
            assert print_unit(unit).count("(*here*)") == 1, text[: found.start()]


def test_a_test_of_trust_keeps_its_words() -> None:
    text = "TEST_PROGRAM CountsUp\nASSERT_TRUE(TRUE);\nEND_TEST_PROGRAM\n"
    unit, mistakes = parse(text, "counts.st", EDITION_3)
    assert not mistakes
    assert print_unit(unit) == text


def test_assignments_within_expressions_survive() -> None:
    body = (
        "IF a := b = 3 THEN c := (d := (e := 4) + 1) * 2; END_IF F((a := b), n := (c := 5)); WHILE x := y DO END_WHILE"
    )
    unit, mistakes = parse(f"PROGRAM p {body} END_PROGRAM", "expressions.st", CODESYS)
    assert mistakes == []
    text = print_unit(unit)
    assert "IF (a := b = 3) THEN" in text
    assert "c := (d := (e := 4) + 1) * 2;" in text
    assert parse(text, unit.file, CODESYS) == (unit, [])
