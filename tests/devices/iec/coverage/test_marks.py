"""The coverage of small programs, worked out by hand for each kind of statement."""

import pytest
from covered import coverage, missed
from iec_program import IecBench

from fieldrig.coverage.places import Kind
from fieldrig.coverage.summary import Part
from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, Dialect


def covered(text: str, cycles: int = 1, dialect: Dialect = EDITION_3) -> Part:
    """Run the program PLC_PRG, whose clock goes on by 100 ms in each cycle; return all places."""
    with coverage() as seen:
        bench = IecBench(text, dialect)
        for number in range(cycles):
            bench.host.ms = 100 * number
            bench.cycle()
        return seen()


def body(statements: str) -> str:
    """Return a program whose statements begin in line 2."""
    return f"PROGRAM PLC_PRG VAR a, b, i : INT; x : BOOL; e : (Red, Green, Blue); END_VAR\n{statements}\nEND_PROGRAM"


HAND = [
    # text, cycles, statements, branches, missed
    ("a := 1; b := 2;", 1, (2, 2), (0, 0), []),
    (";;", 1, (0, 0), (0, 0), []),
    ("IF a = 0 THEN\nb := 1;\nEND_IF", 1, (2, 2), (1, 2), [(2, "no ELSE")]),
    ("IF a = 1 THEN\nb := 1;\nEND_IF", 1, (1, 2), (1, 2), [(2, "IF"), (3, "")]),
    ("IF a = 1 THEN\nb := 1;\nELSE\nb := 2;\nEND_IF", 1, (2, 3), (1, 2), [(2, "IF"), (3, "")]),
    ("IF a = 1 THEN\nb := 1;\nEND_IF\na := 1;", 2, (3, 3), (2, 2), []),
    (
        "IF a = 1 THEN b := 1;\nELSIF a = 0 THEN b := 2;\nELSIF a = 2 THEN b := 3;\nELSE b := 4;\nEND_IF",
        1,
        (2, 5),
        (1, 4),
        [(2, ""), (2, "ELSE"), (2, "IF"), (4, ""), (4, "ELSIF 2"), (5, "")],
    ),
    (
        "IF a = 1 THEN b := 1;\nELSIF a = 2 THEN b := 2;\nEND_IF",
        1,
        (1, 3),
        (1, 3),
        [(2, ""), (2, "IF"), (3, ""), (3, "ELSIF 1")],
    ),
    ("IF a = 1 THEN\n;\nELSE IF a = 0 THEN\nb := 1;\nEND_IF END_IF", 1, (3, 3), (2, 4), [(2, "IF"), (4, "no ELSE")]),
    (
        "CASE a OF\n0: b := 1;\n1, 3..5: b := 2;\nEND_CASE",
        1,
        (2, 3),
        (1, 3),
        [(2, "no ELSE"), (4, ""), (4, "CASE 1, 3..5")],
    ),
    ("CASE a OF\n1: b := 1;\nELSE\nb := 2;\nEND_CASE", 1, (2, 3), (1, 2), [(3, ""), (3, "CASE 1")]),
    (
        "CASE e OF\nRed: e := Green;\nGreen: ;\nBlue: b := 2;\nEND_CASE",
        2,
        (2, 3),
        (2, 4),
        [(2, "no ELSE"), (5, ""), (5, "CASE Blue")],
    ),
    (
        "CASE a OF\n" + "".join(f"{n}: b := {n};\n" for n in range(8)) + "ELSE b := 9;\nEND_CASE\na := a + 1;",
        7,
        (9, 11),
        (7, 9),
        [(2, "ELSE"), (10, ""), (10, "CASE 7"), (11, "")],
    ),
    ("FOR i := 1 TO 3 DO\nb := i;\nEND_FOR", 1, (2, 2), (1, 2), [(2, "body skipped")]),
    ("FOR i := 1 TO a DO\nb := i;\nEND_FOR", 1, (1, 2), (1, 2), [(2, "body"), (3, "")]),
    ("FOR i := 1 TO a DO\nb := i;\nEND_FOR\na := 2;", 2, (3, 3), (2, 2), []),
    ("FOR i := 1 TO 3 DO\nIF i = 2 THEN EXIT; END_IF\nb := i;\nEND_FOR", 1, (4, 4), (3, 4), [(2, "body skipped")]),
    ("FOR i := 1 TO 3 DO\nCONTINUE;\nb := i;\nEND_FOR", 1, (2, 3), (1, 2), [(2, "body skipped"), (4, "")]),
    ("WHILE a < 2 DO\na := a + 1;\nEND_WHILE", 1, (2, 2), (1, 2), [(2, "body skipped")]),
    ("WHILE a < 2 DO\na := a + 1;\nEND_WHILE", 2, (2, 2), (2, 2), []),
    ("WHILE a < 2 DO\na := a + 1;\nCONTINUE;\nb := 1;\nEND_WHILE", 1, (3, 4), (1, 2), [(2, "body skipped"), (5, "")]),
    ("REPEAT\na := a + 1;\nEXIT;\nb := 1;\nUNTIL a > 3 END_REPEAT", 1, (3, 4), (0, 0), [(5, "")]),
    ("a := 1;\nRETURN;\nb := 1;", 1, (2, 3), (0, 0), [(4, "")]),
    ("IF x THEN\nRETURN;\nEND_IF\nb := 1;", 1, (2, 3), (1, 2), [(2, "IF"), (3, "")]),
    ("IF NOT x THEN\nRETURN;\nEND_IF\nb := 1;", 1, (2, 3), (1, 2), [(2, "no ELSE"), (5, "")]),
    (
        "IF x THEN IF a = 0 THEN b := 1; END_IF\nELSE\nb := 2; END_IF",
        1,
        (2, 4),
        (1, 4),
        [(2, ""), (2, ""), (2, "IF"), (2, "IF"), (2, "no ELSE")],
    ),
]


@pytest.mark.parametrize(("statements", "cycles", "counted", "branches", "expected"), HAND)
def test_coverage_is_what_was_worked_out_by_hand(
    statements: str,
    cycles: int,
    counted: tuple[int, int],
    branches: tuple[int, int],
    expected: list[tuple[int, str]],
) -> None:
    part = covered(body(statements), cycles)
    assert missed(part) == expected
    assert (part.count(Kind.STATEMENT), part.count(Kind.BRANCH)) == (counted, branches)


@pytest.mark.parametrize(
    "statements",
    [
        "IF a = 1 THEN b := 1;\n" + "".join(f"ELSIF a = {n} THEN b := 1;\n" for n in range(2, 1_500)) + "END_IF",
        "IF a = 0 THEN\n" * 14 + "b := 1;\n" + "END_IF\n" * 14,
        "IF a = 1 THEN b := 1; ELSE\n" * 14 + "b := 2;\n" + "END_IF\n" * 14,
    ],
    ids=["many ELSIF", "deep THEN", "deep ELSE"],
)
def test_long_and_deep_choices_are_covered(statements: str) -> None:
    part = covered(body(statements))
    assert part.count(Kind.BRANCH).run in (1, 14)


CHART = """\
PROGRAM PLC_PRG
VAR go, never : BOOL; n : INT; END_VAR
INITIAL_STEP Wait : END_STEP
TRANSITION FROM Wait TO Work := go; END_TRANSITION
TRANSITION lost FROM Wait TO Idle := never; END_TRANSITION
STEP Work : Count(N); END_STEP
STEP Idle : END_STEP
TRANSITION FROM Work TO Wait := never; END_TRANSITION
ACTION Count : n := n + 1; go := FALSE; END_ACTION
END_PROGRAM
"""


def places_of(part: Part, kind: Kind) -> dict[str, tuple[int, bool]]:
    return {place.what: (place.line, has_run) for place, has_run in part.places if place.kind is kind}


def test_a_chart_has_its_steps_transitions_and_actions_and_nothing_that_the_compiler_adds() -> None:
    part = covered(CHART.replace("go, never", "go : BOOL := TRUE; never"), cycles=3)
    assert places_of(part, Kind.STEP) == {"Wait": (3, True), "Work": (6, True), "Idle": (7, False)}
    assert places_of(part, Kind.TRANSITION) == {
        "Wait to Work": (4, True),
        "lost": (5, False),
        "Work to Wait": (8, False),
    }
    assert part.count(Kind.STATEMENT) == (2, 2)
    assert part.count(Kind.BRANCH) == (0, 0)
    assert {place.pou for place, _ in part.places} == {"PLC_PRG", "PLC_PRG.Count"}
    assert places_of(covered(CHART, cycles=3), Kind.STEP)["Work"] == (6, False)


def test_lines_of_instruction_list_behind_a_jump_have_not_run() -> None:
    part = covered(
        "PROGRAM PLC_PRG\nVAR a, b : INT; END_VAR\nLD 1\nST a\nJMP over\nLD 2\nST b\nover:\nLD 3\nST b\nEND_PROGRAM"
    )
    assert part.lines() == {4: True, 5: True, 7: False, 10: True}


BLOCKS = """\
FUNCTION_BLOCK Base
VAR n : INT; END_VAR
METHOD Both : INT
n := n + 1;
END_METHOD
METHOD Never : INT
n := 0;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Derived EXTENDS Base
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR d : Derived; r : INT; END_VAR
r := d.Both();
END_PROGRAM
"""


def test_a_method_that_is_inherited_is_one_place_and_its_callers_cover_it() -> None:
    part = covered(BLOCKS, dialect=CODESYS)
    assert {place.pou: has_run for place, has_run in part.places} == {
        "Base.Both": True,
        "Base.Never": False,
        "PLC_PRG": True,
    }


def test_what_the_compiler_adds_to_a_statement_is_not_counted() -> None:
    variables = "VAR x : ARRAY[0..1] OF INT; t : TON; s : STRING; END_VAR"
    statements = "t(IN := TRUE, PT := T#1s);\ns := CONCAT(s, 'a');\nx[LEN(s)] := 1;"
    part = covered(f"PROGRAM PLC_PRG {variables}\n{statements}\nEND_PROGRAM")
    assert part.lines() == {2: True, 3: True, 4: True}
    assert part.count() == (3, 3)
