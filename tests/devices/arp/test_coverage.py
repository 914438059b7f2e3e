"""The coverage of small programs of a card, worked out by hand, and that marks change nothing else."""

from contextlib import nullcontext
from pathlib import Path

import pytest
from arp_card import ArpBench
from covered import Missed, coverage, missed
from hypothesis import given, settings
from hypothesis import strategies as st

import fieldrig
from fieldrig.clock import MS
from fieldrig.coverage.collecting import collecting
from fieldrig.coverage.places import Kind
from fieldrig_devices.languages.writer import Build

HAND = [
    # text from line 2 on, statements, branches, missed
    ("V1 == 1\nV2 == 2", (2, 2), (0, 0), []),
    ("IF V1 = 0, V2 == 1\nV3 == 1", (2, 2), (1, 2), [(2, "no IF")]),
    ("IF V1 = 1, V2 == 1\nV3 == 1", (2, 2), (1, 2), [(2, "IF")]),
    ("IF V1 = 0, GOTO OUT\nV2 == 1\nOUT: V3 == 1", (2, 3), (1, 2), [(2, "no IF"), (3, "")]),
    ("IF V1 = 1, GOTO OUT\nV2 == 1\nOUT: V3 == 1", (3, 3), (1, 2), [(2, "IF")]),
    ("GOTO OUT\nV2 == 1\nOUT: V3 == 1", (2, 3), (0, 0), [(3, "")]),
    ("IF V1 = 0, WAIT 1\nV2 == 1", (1, 2), (1, 2), [(2, "no IF"), (3, "")]),
    ("V3 == 1\nWAIT 1\nV2 == 1", (2, 3), (0, 0), [(4, "")]),
    ("AGAIN: V1 += 1\nIF V1 < 3, GOTO AGAIN\nV2 == 1", (3, 3), (2, 2), []),
    ("IF F1 = ON, SET O101\nRES O102", (2, 2), (1, 2), [(2, "IF")]),
    ("V1 == 200\nIF V[V1] = V[V2], V3 == 1", (2, 2), (1, 2), [(3, "no IF")]),
]


@pytest.mark.parametrize(("text", "statements", "branches", "open_places"), HAND)
def test_statements_and_branches(
    text: str, statements: tuple[int, int], branches: tuple[int, int], open_places: Missed
) -> None:
    with coverage() as seen:
        ArpBench(text).run(3)
        part = seen()
    assert part.count(Kind.STATEMENT) == statements
    assert part.count(Kind.BRANCH) == branches
    assert missed(part) == open_places


def test_routines_and_interrupts_have_their_own_rows() -> None:
    text = "BEG MAIN\nIF V1 = 0, CALL USED\nEND\nBEG USED\nV2 == 1\nEND\nBEG UNUSED\nV2 == 2\nEND"
    with coverage() as seen:
        ArpBench(text).run(3)
        found = {(place.pou, place.line): has_run for place, has_run in seen().places if place.kind is Kind.STATEMENT}
    assert found == {("MAIN", 2): True, ("USED", 5): True, ("UNUSED", 8): False}


@pytest.mark.long
def test_the_program_of_a_whole_card_has_its_file_in_the_report(tmp_path: Path) -> None:
    file = tmp_path / "small.I01"
    file.write_text("BEG MAIN\nAGAIN: IF F1 = ON, V1 == 2\nWAIT 0.01\nGOTO AGAIN\nEND\n")
    with coverage() as seen:
        plc = fieldrig.program(file)
        plc.advance(50 * MS)
        before = missed(seen())
        plc["F1"] = True
        plc.advance(50 * MS)
        part = seen()
    assert (before, missed(part)) == ([(2, "IF")], [])
    assert {place.file for place, _ in part.places} == {str(file)}


LINES = st.sampled_from(
    (
        "V1 += 1",
        "V2 == V1 * 2",
        "IF V1 > 3, GOTO L1",
        "IF V1 < V2, GOTO L2",
        "IF V2 > 4, V1 == 0",
        "IF F1 = ON, CALL SUB",
        "IF V1 > 2, WAIT 0.002",
        "CALL SUB",
        "WAIT 0.003",
        "GOTO L2",
        "SET F1",
        "RES F1",
        "PAC 1, V1",
        "V[V1] == 5",
    )
)
SUITES = st.lists(LINES, max_size=12)


def played(first: list[str], second: list[str], third: list[str]) -> str:
    lines = [*first, "L1: V3 += 1", *second, "L2: V4 += 1", *third]
    bench = ArpBench("\n".join(["BEG MAIN", *lines, "END", "BEG SUB", "V5 += 1", "IF V5 > 6, V5 == 0", "END"]))
    shown = []
    for budget in (7, 20, 1, 3, 50):
        bench.run(2, budget)
        card, program = bench.card, bench.program
        shown.append(repr((card.V[:9], card.F[1], card.asked, card.warnings, program.state, program.place)))
    return "\n".join(shown)


@settings(deadline=None, max_examples=40)
@given(SUITES, SUITES, SUITES)
def test_any_program_does_the_same_with_marks(first: list[str], second: list[str], third: list[str]) -> None:
    plain = played(first, second, third)
    with collecting():
        assert played(first, second, third) == plain


def test_the_code_has_no_marks_unless_coverage_is_wanted() -> None:
    for context, number in ((nullcontext(), 0), (collecting(), 3)):
        with context:
            source = ArpBench("V1 == 1\nIF V1 = 1, V2 == 1\nWAIT 1\nV3 == 1").program.code.source(Build.FAST)
        assert source.count("hit[") == number
