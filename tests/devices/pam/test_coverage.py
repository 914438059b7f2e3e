"""The coverage of small applications, worked out by hand."""

from pathlib import Path

import pytest
from covered import coverage, missed
from pam_bench import OBJECTS, PamBench

import fieldrig
from fieldrig.clock import MS
from fieldrig.coverage.collecting import collecting
from fieldrig.coverage.places import DETAILS, Kind
from fieldrig.coverage.reports.table import said
from fieldrig.coverage.summary import Coverage

TASK = "TASK TSK_a; SPECS CYCLES = 1; END_SPECS EVENTS ON_EVENT SBI_b XEQ_SEQUENCE SEQ_a; END_EVENTS\nSEQUENCE SEQ_a;\n"
END = "\nEND_SEQUENCE\nSEQUENCE SEQ_b;\nn <- 9;\nEND_SEQUENCE\nEND_TASK\n"
HAND = [
    # statements from the first line on, statements, branches, missed
    ("n <- 1; x <- 2;", (2, 3), (0, 0), ["n <- 9;"]),
    ("IF w = 0 THEN\nn <- 1;\nEND_IF", (2, 3), (1, 2), ["no ELSE", "n <- 9;"]),
    ("IF w = 1 THEN\nn <- 1;\nELSE\nn <- 2;\nEND_IF", (2, 4), (1, 2), ["IF", "n <- 1;", "n <- 9;"]),
    ("WAIT_TIME 3;\nn <- 1;", (2, 3), (0, 0), ["n <- 9;"]),
    ("WAIT_TIME 900;\nn <- 1;", (1, 3), (0, 0), ["n <- 1;", "n <- 9;"]),
    ("CONDITION SBI_a;\nn <- 1;", (1, 3), (0, 0), ["n <- 1;", "n <- 9;"]),
    ("CONDITION SBI_a TIMEOUT 6;\nn <- 1;", (2, 3), (1, 2), ["no TIMEOUT", "n <- 9;"]),
    ("CONDITION !SBI_a TIMEOUT 6;\nn <- 1;", (2, 3), (1, 2), ["TIMEOUT", "n <- 9;"]),
    ("LOOP\nn <- n + 1;\nEND_LOOP n > 3;", (2, 3), (0, 0), ["n <- 9;"]),
    ("XEQ_SEQUENCE SEQ_b;", (2, 2), (0, 0), []),
    (
        "CASE\nCONDITION SBI_a XEQ_SEQUENCE SEQ_a;\nCONDITION !SBI_a XEQ_SEQUENCE SEQ_b;\nEND_CASE",
        (2, 2),
        (1, 2),
        ["CASE 1"],
    ),
    (
        "CASE\nCONDITION SBI_a XEQ_SEQUENCE SEQ_a;\nTIMEOUT 5 XEQ_SEQUENCE SEQ_b;\nEND_CASE",
        (2, 2),
        (1, 2),
        ["CASE 1"],
    ),
    ("EXCEPTION !SBI_a ENTRY late;\nn <- 1;\nEXCEPTION_ENTRY late;\nn <- 2;", (3, 5), (0, 0), ["n <- 1;", "n <- 9;"]),
]


@pytest.mark.parametrize(("text", "statements", "branches", "names"), HAND)
def test_statements_and_branches(
    text: str, statements: tuple[int, int], branches: tuple[int, int], names: list[str]
) -> None:
    programs = TASK + text + END
    with coverage() as seen:
        bench = PamBench(programs)
        bench.run()
        bench["SBI_b"] = True
        bench.run(8)
        part = seen()
    lines = (OBJECTS + programs).splitlines()
    assert part.count(Kind.STATEMENT) == statements
    assert part.count(Kind.BRANCH) == branches
    assert sorted(what or lines[line - 1] for line, what in missed(part)) == sorted(names)


def test_actions_routines_and_sequences_have_their_own_rows() -> None:
    programs = (
        "ROUTINES RGR_a; ROUTINE RTN_a WITH a; n <- a; END_ROUTINE END_ROUTINES\n"
        "ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS ON_EVENT SBI_b ACTION CALL RTN_a WITH 5; END_ACTION\n"
        "ON_EVENT SBI_a ACTION n <- 1; END_ACTION END_ACTIONS\n"
    )
    with coverage() as seen:
        bench = PamBench(programs)
        bench.run()
        bench["SBI_b"] = True
        bench.run(3)
        found = {place.pou: has_run for place, has_run in seen().places}
    assert found == {"RTN_a": True, "ACT_a.1": True, "ACT_a.2": False}


def test_included_files_have_their_paths_in_the_report(tmp_path: Path) -> None:
    main, part = tmp_path / "main.pam", tmp_path / "part.inc"
    main.write_text(OBJECTS + '#include "PART.INC"\n')
    part.write_text(TASK + "IF w = 1 THEN n <- 1; END_IF" + END)
    with coverage() as seen:
        plc = fieldrig.program(main)
        plc.start()
        plc.advance(50 * MS)
        plc["SBI_b"] = True
        plc.advance(50 * MS)
        found = seen()
        assert missed(found) == [(3, ""), (3, "IF"), (6, "")]
        assert {place.file for place, _ in found.places} == {str(part)}


def test_the_code_has_no_marks_unless_coverage_is_wanted() -> None:
    programs = TASK + "IF w = 0 THEN n <- 1; END_IF" + END
    assert not PamBench(programs).program.code.marked.hits
    with collecting():
        assert len(PamBench(programs).program.code.marked.hits) == 4


DECISIONS = [
    # condition, values of w and f, conditions that were not, or did not decide
    ("(w > 1) * f", [(2, True), (0, True), (2, False)], []),
    ("(w > 1) * f", [(2, True), (0, True)], ["f FALSE", "f FALSE decides"]),
    ("!((w > 1) + f)", [(0, False), (2, False), (0, True)], []),
    ("f", [(0, False)], []),
    ("(w + w) > 1", [(0, False)], []),
]


@pytest.mark.parametrize(("condition", "values", "names"), DECISIONS)
def test_conditions_of_decisions(condition: str, values: list[tuple[int, bool]], names: list[str]) -> None:
    with collecting(is_detailed=True) as collected:
        bench = PamBench(TASK + f"IF {condition} THEN n <- 1; END_IF" + END)
        for w, f in values:
            bench["w"], bench["f"], bench["SBI_b"] = w, f, False
            bench.run(3)
            bench["SBI_b"] = True
            bench.run(3)
        places = Coverage(collected.news()).total.places
    assert sorted(said(place) for place, has_run in places if not has_run and place.kind in DETAILS) == names


WAITS = [
    # condition, values of w and f one after the other, conditions that were not, or did not decide
    ("(w > 1) * f", [(0, True), (2, False), (2, True)], []),
    ("(w > 1) * f", [(0, False), (2, True)], ["f FALSE decides", "w > 1 FALSE decides"]),
    ("!((w > 1) + f)", [(2, False), (0, True), (0, False)], []),
    ("f", [(0, False), (0, True)], []),
]


@pytest.mark.parametrize("statement", ["CONDITION {}; n <- 1;", "CASE CONDITION {} XEQ_SEQUENCE SEQ_b; END_CASE"])
@pytest.mark.parametrize(("condition", "values", "names"), WAITS)
def test_conditions_that_a_sequence_waits_for(
    statement: str, condition: str, values: list[tuple[int, bool]], names: list[str]
) -> None:
    with collecting(is_detailed=True) as collected:
        bench = PamBench(TASK + statement.format(condition) + END)
        bench["w"], bench["f"] = values[0]
        bench["SBI_b"] = True
        bench.run(3)
        for w, f in values[1:]:
            # Both change in one instant, so that no combination between them is seen.
            bench["w"], bench["f"] = w, f
            bench.run(3)
        places = Coverage(collected.news()).total.places
    assert bench["n"] in (1, 9)
    assert sorted(said(place) for place, has_run in places if not has_run and place.kind in DETAILS) == names
