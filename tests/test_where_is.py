"""The page "Where is …" leads to files and names that exist."""

import ast
import re
from collections.abc import Iterator

import pytest
from doc_pages import ROOT, page_named

PAGE = page_named("where-is.md")
LINE = re.compile(r"\| (?P<question>[^|]+\?) \| `(?P<file>[^`]+)` \| (?:`(?P<name>[^`]+)`)? ?\|")


def rows() -> list[tuple[str, str, str | None]]:
    return [
        (row["question"], row["file"], row["name"]) for row in map(LINE.fullmatch, PAGE.read_text().split("\n")) if row
    ]


def names_in(tree: ast.Module) -> Iterator[str]:
    """Yield the functions, classes and constants of a module, and `Class.method` and `Class.attribute`."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
        if isinstance(node, ast.ClassDef):
            yield from (f"{node.name}.{name}" for name in names_in(ast.Module(node.body, [])))
        elif isinstance(node, ast.Assign):
            yield from (target.id for target in node.targets if isinstance(target, ast.Name))
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            yield node.target.id


@pytest.mark.long
@pytest.mark.parametrize(("question", "file", "name"), rows())
def test_the_page_leads_to_what_exists(question: str, file: str, name: str | None) -> None:
    path = ROOT / file
    assert path.is_file(), question
    if name is not None:
        assert name in set(names_in(ast.parse(path.read_text()))), question


def test_every_row_of_the_page_is_read_and_answers_another_question() -> None:
    questions = [question for question, _, _ in rows()]
    assert len(questions) == len(set(questions)) >= 40
    assert len(questions) == sum(
        line.startswith("| ") for line in PAGE.read_text().split("\n")
    ) - PAGE.read_text().count("| question |")
