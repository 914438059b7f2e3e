"""The changes of each construct; each makes another program, and nothing but the change."""

from pathlib import Path

import pytest

from fieldrig_devices.iec.dialect import DIALECTS
from fieldrig_devices.iec.imports import read_source
from fieldrig_devices.iec.mutation.changes import MOST_SHOWN, Made, changes_of
from fieldrig_devices.iec.printer import print_unit
from fieldrig_devices.iec.tree import Unit

PROGRAMS = sorted((Path(__file__).parents[1] / "programs").glob("*.st"))[::8]
HEAD = "PROGRAM P\nVAR a, b, c : BOOL; i : INT; t : TIME; s : STRING; block : TON; END_VAR\n"


def read(text: str, name: str = "p.st") -> Unit:
    unit, mistakes = read_source(name, text, DIALECTS["codesys"])
    assert mistakes == []
    return unit


def offered(body: str) -> list[tuple[str, str, str]]:
    unit = read(f"{HEAD}{body}\nEND_PROGRAM\n")
    return [(made.change.kind.value, made.change.before, made.change.after) for made in changes_of(unit)]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("IF i > 3 THEN ; END_IF", [("compare", "i > 3", "i >= 3"), ("compare", "i > 3", "i <= 3")]),
        ("IF i >= 3 THEN ; END_IF", [("compare", "i >= 3", "i > 3"), ("compare", "i >= 3", "i < 3")]),
        ("IF i = 3 THEN ; END_IF", [("compare", "i = 3", "i <> 3")]),
        ("a := b AND c;", [("logic", "b AND c", "b OR c"), ("contact", "b", "NOT b"), ("contact", "c", "NOT c")]),
        ("a := NOT b;", [("contact", "NOT b", "b")]),
        ("IF a THEN ; END_IF", [("contact", "a", "NOT a")]),
        ("WHILE a DO EXIT; END_WHILE", [("contact", "a", "NOT a"), ("statement", "EXIT;", "")]),
        ("i := i * 2;", [("arithmetic", "i * 2", "i / 2"), ("constant", "2", "3")]),
        ("a := FALSE;", [("reset", "a := FALSE;", ""), ("constant", "FALSE", "TRUE")]),
        ("i := 0;", [("reset", "i := 0;", ""), ("constant", "0", "1")]),
        ("t := T#1s;", [("statement", "t := T#1s;", ""), ("constant", "T#1s", "T#2s")]),
        ("s := 'on';", [("constant", "'on'", "''")]),
        ("block(IN := a, PT := t);", [("statement", "block(IN := a, PT := t);", "")]),
        ("CASE i OF 1: a := b; END_CASE", [("statement", "a := b;", "")]),
    ],
)
def test_each_construct_has_its_changes(body: str, expected: list[tuple[str, str, str]]) -> None:
    assert [one for one in offered(body) if one in expected] == expected
    assert len(offered(body)) <= len(expected) + 1, "and the assignment itself at most"


def test_labels_types_and_times_of_tasks_stay() -> None:
    types = "TYPE Row : ARRAY[0..9] OF INT(0..7); Mode : (IDLE := 3, RUN := 4); END_TYPE\n"
    tasks = (
        "CONFIGURATION C TASK Fast(INTERVAL := T#10ms, PRIORITY := 3); PROGRAM P1 WITH Fast : P; END_CONFIGURATION\n"
    )
    unit = read(f"{types}{HEAD}CASE i OF 1, 5..7: ; END_CASE\nEND_PROGRAM\n{tasks}")
    assert list(changes_of(unit)) == []


def test_a_chart_fires_at_once_or_never_and_lacks_actions() -> None:
    chart = (
        "INITIAL_STEP Begin: Light(N); Horn(S); END_STEP\nSTEP Done: END_STEP\n"
        "TRANSITION FROM Begin TO Done := a; END_TRANSITION\nTRANSITION FROM Done TO Begin := TRUE; END_TRANSITION\n"
        "ACTION Light: b := TRUE; END_ACTION\nACTION Horn: c := TRUE; END_ACTION"
    )
    found = offered(chart)
    assert ("transition", "a", "TRUE") in found
    assert ("transition", "a", "FALSE") in found
    assert ("action", "Begin: Light(N)", "") in found
    assert ("action", "Begin: Horn(S)", "") in found
    assert found.count(("transition", "TRUE", "FALSE")) == 1


def test_lines_of_a_list_change() -> None:
    unit = read("FUNCTION F : BOOL\nVAR_INPUT a, b : BOOL; END_VAR\nLD a\nAND b\nST F\nEND_FUNCTION\n", "f.il")
    found = [(str(one.change.kind), one.change.before, one.change.after) for one in changes_of(unit)]
    assert found == [
        ("contact", "LD a", "LDN a"),
        ("logic", "AND b", "OR b"),
        ("contact", "AND b", "ANDN b"),
        ("contact", "ST F", "STN F"),
        ("statement", "ST F", ""),
    ]


def test_a_change_is_at_its_place() -> None:
    unit = read(f"{HEAD}IF a THEN\n  i := i + 1;\nEND_IF\nEND_PROGRAM\n")
    places = {(one.change.before, one.change.line, one.change.column) for one in changes_of(unit)}
    assert places == {("a", 3, 1), ("i := i + 1;", 4, 3), ("i + 1", 4, 10), ("1", 4, 12)}
    assert {one.change.pou for one in changes_of(unit)} == {"P"}


def test_a_long_text_is_cut_in_its_middle() -> None:
    chain = " AND ".join(["a"] * 200)
    assert max(len(text) for _, *texts in offered(f"a := {chain};") for text in texts) <= MOST_SHOWN


@pytest.mark.parametrize("file", PROGRAMS, ids=lambda file: file.stem)
def test_each_change_makes_another_program_and_leaves_the_given_one(file: Path) -> None:
    unit, _ = read_source(file.name, file.read_text(encoding="utf-8"), DIALECTS["codesys"])
    text = print_unit(unit)
    made: list[Made] = list(changes_of(unit))
    for one in made[:: max(1, len(made) // 20)]:
        assert print_unit(one.made_in(unit)) != text, one.change
        assert print_unit(unit) == text
