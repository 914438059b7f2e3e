"""Programs of random statements with random inputs run, and a dead sequence leaves nothing behind."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pam_bench import PamBench

from fieldrig.coverage.collecting import collecting
from fieldrig.testing import plain_forms
from fieldrig_devices.pam.runtime.lower.formulas import CHANGES as ON_CHANGES
from fieldrig_devices.pam.runtime.sequence import SequenceState

STATEMENTS = (
    "AXI_Each[i] <- run(1);",
    "fe[i] <- SBI_a + SBI_b;",
    "fe[i] <- invert;",
    "fe[all] <- reset;",
    "CONDITION fe[i] * (AXI_Each[i] ? ready) TIMEOUT w;",
    "CONDITION x > 2 TIMEOUT 4;",
    "CONDITION DUPL_START;",
    "LOOP w <- w + 1; WAIT_TIME 2; END_LOOP w > 5;",
    "w <- 0;",
    "x <- AXI_Each[i]:TRAVEL_SPEED * 2;",
    "IF (fe[i] * SBI_b)[all+] THEN XEQ_SEQUENCE SEQ_b[i] END_IF",
    "IF fe[i] * (AXI_Each[i] ? ready) + !SBI_c * (w > 2) THEN x <- x + 1; END_IF",
    "n <- AXI_Each[i] ? status;",
    "CALL RTN_a WITH w, w > 3; CALL RTN_a WITH 1.5, TIMEOUT;",
    "CASE CONDITION SBI_b XEQ_SEQUENCE SEQ_b[i]; TIMEOUT 5 XEQ_SEQUENCE SEQ_b[i]; END_CASE",
    "EXCEPTION f TIMEOUT 3 ABORT_SEQUENCE;",
    "EXCEPTION SBI_b TIMEOUT 30 SEQUENCE SEQ_b[i];",
    "EXCEPTION SBI_c ENTRY again;",
    "EXCEPTION g XEQ_TASK TSK_b SEQUENCE SEQ_b WAIT;",
    "XEQ_TASK TSK_b SEQUENCE SEQ_b WAIT;",
    "REMOVE_EXCEPTION;",
    "f <- set;",
    "g <- invert;",
    "WAIT_TIME 3;",
)
PROGRAM = """
ROUTINES RGR_a; ROUTINE RTN_a WITH a, b; x <- a / 2.0; g <- b; END_ROUTINE END_ROUTINES
TASK TSK_b; SPECS CYCLES = 1; END_SPECS SEQUENCE SEQ_b; WAIT_TIME 3; END_SEQUENCE END_TASK
TASK TSK_a; SPECS NODES_GROUP = NGR_Both; DUPL = 1; CYCLES = {cycles}; END_SPECS
EVENTS ON_EVENT fe[i] XEQ_SEQUENCE SEQ_a[i]; ON_EVENT SBI_a XEQ_SEQUENCE SEQ_b[i]; END_EVENTS
SEQUENCE SEQ_a[i]; {before} EXCEPTION_ENTRY again; {after} END_SEQUENCE
SEQUENCE SEQ_b[i]; WAIT_TIME 2; END_SEQUENCE
END_TASK
ACTIONS ACT_a; SPECS CYCLES = 2; END_SPECS ON_EVENT SBI_a * g ACTION f <- reset; END_ACTION
ON_STATE f ACTION n <- 1; END_ACTION END_ACTIONS
"""
EQUATIONS = """
BOOLEAN BOL_a; LINKED_OUTPUT = SBO_a; EQUATION = (SBI_a + f) * !g; END_BOOLEAN
BOOLEAN BOL_e[i]; LINKED_OUTPUT = SBO_Each; EQUATION = fe[i] * (AXI_Each[i] ? ready) * !BOL_a; END_BOOLEAN
"""
SOME = st.lists(st.sampled_from(STATEMENTS), max_size=8).map("\n".join)
CHANGES = st.lists(st.sampled_from(["SBI_a", "SBI_b", "SBI_c", "f", "fe", ""]), max_size=60)


def apply(bench: PamBench, change: str) -> None:
    if change == "fe":
        bench["fe"] = [True, False]
        bench["fe"] = [False, True]
    elif change:
        bench[change] = not bench[change]


@pytest.mark.long
@settings(max_examples=40)
@given(cycles=st.integers(1, 3), before=SOME, after=SOME, changes=CHANGES)
def test_any_program_runs(cycles: int, before: str, after: str, changes: list[str]) -> None:
    bench = PamBench(PROGRAM.format(cycles=cycles, before=before, after=after))
    at_rest = bench.runtime.watches.size
    for change in changes:
        apply(bench, change)
        bench.run()
    assert set(bench.errors) <= {"03..E033"}
    for task in bench.runtime.tasks:
        task.end()
        assert task.state is SequenceState.DEAD
    assert bench.runtime.watches.size == at_rest


def trace(program: str, changes: list[str]) -> list[str]:
    """Return all variables, outputs and messages after each cycle."""
    bench = PamBench(program)
    shown = []
    for change in changes:
        apply(bench, change)
        bench.run()
        items = [item.value() for name in ("SBO_a", "SBO_Each") for item in bench.objects.items[name]]
        states = [task.state for task in bench.runtime.tasks]
        shown.append(repr((bench.runtime.cells, items, states, bench.messages)))
    return shown


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(cycles=st.integers(1, 3), before=SOME, after=SOME, changes=CHANGES)
def test_a_program_that_is_served_on_changes_does_what_one_does_that_is_served_always(
    cycles: int, before: str, after: str, changes: list[str]
) -> None:
    program = PROGRAM.format(cycles=cycles, before=before, after=after) + EQUATIONS
    with plain_forms(ON_CHANGES.name):
        plain = trace(program, changes)
    assert trace(program, changes) == plain


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(cycles=st.integers(1, 3), before=SOME, after=SOME, changes=CHANGES)
def test_a_program_with_marks_of_coverage_does_what_one_without_does(
    cycles: int, before: str, after: str, changes: list[str]
) -> None:
    program = PROGRAM.format(cycles=cycles, before=before, after=after) + EQUATIONS
    plain = trace(program, changes)
    with collecting(is_detailed=True):
        assert trace(program, changes) == plain
