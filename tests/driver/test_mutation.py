"""The mutation of the rows: which places it takes, which tests it runs, and what its page says."""

import random
from collections import Counter
from pathlib import Path

import pytest
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator
from tests.mutation.__main__ import Copy, lines_by_row, running, running_of_others
from tests.mutation.page import page
from tests.mutation.places import Mutant, Verdict, changes_of, chosen

MODULE = """\
def limited(value: int | None, limit: int) -> int | str:
    log.debug("%d", value + 1)
    assert limit > 0
    count: int | None = 3
    if value > limit:
        raise Refused(0x06090031, f"more than {limit + 1}")
    return value

class Thing:
    def __repr__(self) -> str:
        return "a" * 5
"""


def mutant(row: str, line: int = 1) -> Mutant:
    return Mutant(row, "devices/one.py", line, "core/AddNot", 0, "if it:")


def test_only_what_a_row_can_be_about_is_changed() -> None:
    found = {(change.line, change.operator.partition("/")[2]) for change in changes_of(MODULE)}
    assert found == {
        (4, "NumberReplacer"),
        (5, "AddNot"),
        (5, "ReplaceComparisonOperator_Gt_GtE"),
        (5, "ReplaceComparisonOperator_Gt_LtE"),
        (6, "NumberReplacer"),
    }


def test_occurrences_are_counted_as_cosmic_ray_does() -> None:
    changed = {
        str(mutate_code(MODULE, get_operator(item.operator)(), item.occurrence))
        for item in changes_of(MODULE)
        if item.line == 6
    }
    lines = {text.splitlines()[5] for text in changed}
    assert len(lines) == len(changed) == 2
    assert all("Refused(" in line and "0x06090031" not in line and "{limit + 1}" in line for line in lines)


def test_a_place_of_the_row_alone_is_taken_sooner(tmp_path: Path) -> None:
    (tmp_path / "one.py").write_text("if a:\n    b = 1\nif c:\n    d = 2\n")
    lines = {"A-001": {"one.py": {1, 3}}} | {f"A-{number:03}": {"one.py": {1}} for number in range(2, 12)}
    taken = Counter(
        item.line for seed in range(100) for item in chosen("A-001", lines, 1, random.Random(seed), tmp_path)
    )
    assert taken[3] > 90


def test_each_place_is_taken_once_and_a_row_without_places_gets_none(tmp_path: Path) -> None:
    (tmp_path / "one.py").write_text("a = b\nif c:\n    d = 2\n")
    lines = {"A-001": {"one.py": {1, 2, 3}}, "A-002": {"one.py": {1}}}
    taken = list(chosen("A-001", lines, 5, random.Random(1), tmp_path))
    assert sorted(item.line for item in taken) == [2, 3]
    assert {item.source for item in taken} == {"if c:", "d = 2"}
    assert list(chosen("A-002", lines, 5, random.Random(1), tmp_path)) == []


def test_the_tests_of_a_row_that_run_the_place_are_run() -> None:
    tests = {"A-001": ["t.py::one", "t.py::two"], "A-002": ["t.py::two"]}
    recorded = {"t.py::one": {"devices/one.py": [1]}, "t.py::two": {"devices/one.py": [2], "devices/two.py": [1]}}
    assert lines_by_row(tests, recorded) == {
        "A-001": {"devices/one.py": {1, 2}, "devices/two.py": {1}},
        "A-002": {"devices/one.py": {2}, "devices/two.py": {1}},
    }
    assert running(mutant("A-001", 1), tests, recorded) == ["t.py::one"]


def test_the_tests_of_other_rows_that_run_the_place_are_those_that_are_not_the_row_s_own() -> None:
    tests = {
        "A-001": ["t.py::one", "t.py::both"],
        "A-002": ["t.py::both", "t.py::wide", "t.py::narrow", "t.py::elsewhere"],
        "B-001": ["t.py::narrow"],
    }
    recorded = {
        "t.py::one": {"devices/one.py": [1]},
        "t.py::both": {"devices/one.py": [1]},
        "t.py::wide": {"devices/one.py": [1, 2], "devices/two.py": [1]},
        "t.py::narrow": {"devices/one.py": [1, 2]},
        "t.py::elsewhere": {"devices/one.py": [2], "devices/two.py": [1]},
    }
    assert running_of_others(mutant("A-001", 1), tests, recorded) == ["t.py::narrow", "t.py::wide"]
    assert running_of_others(mutant("A-002", 2), tests, recorded) == []


def test_the_page_says_that_its_score_is_of_a_sample_and_of_which_commit() -> None:
    mutants = [mutant("ARP-001", 1), mutant("ARP-001", 2), mutant("ARP-002", 3), mutant("PD-001", 4)]
    verdicts = [Verdict.KILLED, Verdict.SURVIVED, Verdict.ELSEWHERE, Verdict.SURVIVED]
    text = page("abc1234", "word", 244, list(zip(mutants, verdicts, strict=True)))
    assert "that of a sample: 4 mutants of 3 of the 244 rows" in " ".join(text.split())
    assert "with seed `word`, at commit abc1234" in " ".join(text.split())
    assert "| ARP | 3 | 1 | 1 | 1 | 67% |\n| PD | 1 | 0 | 0 | 1 | 0% |" in text
    survivors, elsewhere = text.partition("## Survivors")[2].split("## Killed by another row's tests")
    assert "- ARP-001: `devices/one.py:2`, AddNot\n- PD-001: `devices/one.py:4`, AddNot\n" in survivors
    assert survivors.count("- ") == 2
    assert elsewhere.endswith("\n\n- ARP-002: `devices/one.py:3`, AddNot\n")
    assert elsewhere.count("- ") == 1


@pytest.mark.parametrize(
    ("own", "other", "at_import", "verdict"),
    [
        (0, 1, "", Verdict.KILLED),
        (1, 0, "", Verdict.ELSEWHERE),
        (1, 1, "", Verdict.SURVIVED),
        (1, None, "", Verdict.SURVIVED),
        (1, None, "assert not one.is_high(0)\n", Verdict.KILLED),
    ],
)
@pytest.mark.long
def test_a_mutant_is_made_in_the_copy_which_is_as_before_afterwards(
    own: int, other: int | None, at_import: str, verdict: Verdict, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "tree" / "devices").mkdir(parents=True)
    (tmp_path / "tree" / "tests").mkdir()
    code = "def is_high(value):\n    return value > 0\n"
    (tmp_path / "tree" / "devices" / "one.py").write_text(code)
    (tmp_path / "tree" / "pyproject.toml").write_text("[tool.pytest.ini_options]\nmarkers = ['manual']\n")
    (tmp_path / "tree" / "tests" / "test_one.py").write_text(
        f"import one, pytest\n{at_import}"
        "@pytest.mark.manual\n@pytest.mark.parametrize('value', [0, 1])\n"
        "def test_one(value):\n    assert one.is_high(value) is (value > 0)\n"
    )
    monkeypatch.setattr("tests.mutation.__main__.ROOT", tmp_path / "tree")
    monkeypatch.setattr("tests.mutation.__main__.COPIED", ("devices", "tests", "pyproject.toml"))
    copy = Copy(tmp_path / "copy")
    change = next(item for item in changes_of(code) if item.operator.endswith("Gt_GtE"))
    of_row = Mutant("A-001", "devices/one.py", 2, change.operator, change.occurrence, "return value > 0")
    others = [] if other is None else [f"tests/test_one.py::test_one[{other}]"]
    assert copy.judge(of_row, [f"tests/test_one.py::test_one[{own}]"], others) is verdict
    for folder in ("tree", "copy"):
        assert (tmp_path / folder / "devices" / "one.py").read_text() == code
