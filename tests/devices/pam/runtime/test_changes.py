"""Programs that wait for pipes and axes: what is looked at on changes shows what is looked at in every cycle."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pam_pipelines import MACHINE
from pam_whole import WholePam

from fieldrig.testing import plain_forms
from fieldrig_devices.pam.objects.pipes import SLEEP
from fieldrig_devices.pam.runtime.lower.formulas import CHANGES

PROGRAM = """
BINARY_OUTPUT SBO_A; NODE = NOD_Desk; ADDRESS = 201; ACTIVE = HIGH; END
ZERO_POSITIONER ZEP_B; OBJECT = AXI_B; SENSOR = SBI_Mark; COARSE_SPEED = 10; COARSE_EDGE = RISING;
  COARSE_MOVE = 0.1; END
INTERNAL FLAG_VAR IFV_Go; INTERNAL FLAG_VAR IFV_Mark; INTERNAL WORD_VAR IWV_N; INTERNAL WORD_VAR IWV_Edges;
INTERNAL REAL_VAR IRV_X;
BOOLEAN BOL_Ready; EQUATION = (TMP_A ? ready) * (PHA_A ? ready) * !(COR_A ? triggered); END_BOOLEAN
TASK TSK_A; SPECS CYCLES = {cycles}; END_SPECS
  EVENTS ON_EVENT IFV_Go XEQ_SEQUENCE SEQ_A; END_EVENTS
  SEQUENCE SEQ_A; {first} {statements} IWV_N <- 99; END_SEQUENCE
  POWERON IFV_Go <- set; END_POWERON
END_TASK
TASK TSK_B; SPECS CYCLES = 1; END_SPECS
  EVENTS ON_EVENT IFV_Go XEQ_SEQUENCE SEQ_B; END_EVENTS
  SEQUENCE SEQ_B; {others} END_SEQUENCE
END_TASK
ACTIONS ACT_Edges; SPECS CYCLES = 1; END_SPECS {edges} END_ACTIONS
"""
READY = ("TMP_A", "TMP_B", "PMP_A", "AMP_A", "COR_A", "PHA_A", "CMP_A", "CNV_Sink", "CNV_Set", "AXI_A", "AXS_BC")
FLAGS = (
    *(f"{name} ? ready" for name in READY),
    "COR_A ? triggered",
    "MUL_A ? execute",
    "AXI_A ? pipe_motionless",
    "AXS_BC ? pipe_motionless",
    "AXI_A ? error",
    "BOL_Ready",
    "ZEP_B ? ready",
    "SBO_A",
    "AXI_B ? ready",
    "SBI_Mark",
)
EDGES = " ".join(
    f"ON_EVENT {flag} ACTION IWV_Edges <- IWV_Edges + {2**number}; END_ACTION" for number, flag in enumerate(FLAGS[:12])
)
NUMBERS = ("0.0", "1.0", "7.0", "10.0", "30.0", "90.0", "-3.0", "0.1")
ACTS = (
    *(
        f"{name} <- {function}({number});"
        for name in ("TMP_A", "TMP_B", "PMP_A")
        for function in ("absolute_move", "relative_move", "run")
        for number in NUMBERS
    ),
    *(f"AMP_A:GAIN <- {number};" for number in NUMBERS),
    *(f"PHA_A:PHASE <- {number};" for number in NUMBERS),
    *(f"CMP_A:REFERENCE <- {number};" for number in NUMBERS),
    *(f"COR_A <- trigger({number});" for number in NUMBERS),
    "COR_A <- start_correction;",
    "COR_A <- trigger_off;",
    "PHA_A <- stop;",
    "PHA_A <- start;",
    "MUL_A <- learn;",
    "MUL_A <- execute;",
    "AXI_A <- power_on;",
    "AXI_A <- stop;",
    "AXS_BC <- power_on;",
    "AXS_BC <- stop;",
    "AXI_A <- relative_move(7.0);",
    "AXI_B <- power_on;",
    "AXI_B <- absolute_move(0.3);",
    "ZEP_B <- start;",
    "ZEP_B <- stop;",
    "SBO_A <- invert;",
    "CNV_Set <- deactivate;",
    "CNV_Axis <- deactivate;",
    "WAIT_TIME 5;",
    "WAIT_TIME 40;",
    "IWV_N <- IWV_N + 1;",
    "IRV_X <- AMP_A ? value;",
)
PIPES = (
    "CNV_Sink << COR_A << AMP_A << TMP_A;",
    "CNV_Axis << PHA_A << CMP_A << TMP_B;",
    "CNV_Set << AMP_B << DIS_A << TMP_A;",
    "CNV_Set << MUL_A << CAM_A << PMP_A;",
    "CNV_Speed << DER_A << AMP_A << TMP_A;",
    "CNV_Other << COR_B << SAM_A;",
)
waits = st.builds(
    "CONDITION {}({}) TIMEOUT 60; IWV_N <- IWV_N + 1;".format, st.sampled_from(["", "!"]), st.sampled_from(FLAGS)
)
statements = st.lists(
    st.one_of(st.sampled_from(ACTS), st.sampled_from(ACTS), waits, waits, st.sampled_from(PIPES)), max_size=14
).map("\n".join)


def trace(program: str, marks: list[int]) -> list[str]:
    """Return all variables, orders and messages after each cycle of a run with events of an input."""
    pam = WholePam(program, (1, 2, 3))
    shown, seen, level = [], 0, 0
    for cycles in [5, *marks]:
        level = 1 - level
        pam.change(17, 1, level)
        for _ in range(cycles):
            pam.run()
            sent, seen = pam.port.sent[seen:], len(pam.port.sent)
            shown.append(repr((pam.runtime.cells, sent, pam.messages, pam.volts)))
    return shown


def program_of(cycles: int, first: list[str], statements: str, others: str) -> str:
    return MACHINE + PROGRAM.format(
        cycles=cycles, first=" ".join(first), statements=statements, others=others, edges=EDGES
    )


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(
    st.integers(1, 3), st.lists(st.sampled_from(PIPES), max_size=3), statements, statements,
    st.lists(st.integers(1, 120), max_size=5),
)  # fmt: skip
def test_programs_that_wait_for_pipes_do_the_same_in_both_forms(
    cycles: int, first: list[str], statements: str, others: str, marks: list[int]
) -> None:
    program = program_of(cycles, first, statements, others)
    with plain_forms(SLEEP.name, CHANGES.name):
        plain = trace(program, marks)
    assert trace(program, marks) == plain


@pytest.mark.parametrize(
    "command", ["TMP_A <- run(0.1);", "TMP_A <- absolute_move(0.000001);", "TMP_A <- relative_move(0.0);"]
)
def test_a_command_that_takes_less_than_a_period_is_seen_to_end(command: str) -> None:
    pam = WholePam(
        program_of(1, [PIPES[0]], f"WAIT_TIME 50; {command} CONDITION TMP_A ? ready; IWV_N <- 1;", ""), (1, 2, 3)
    )
    pam.run(100)
    assert pam["IWV_N"] == 99


def test_a_converter_whose_pipe_is_made_again_becomes_ready_again() -> None:
    """It is so with the first value of the new pipe (PAML-485)."""
    pam = WholePam(program_of(1, [PIPES[0]], f"WAIT_TIME 50; {PIPES[0]}", ""), (1, 2, 3))
    pam.run(100)
    assert pam["IWV_Edges"] == 2 * 2 ** READY.index("CNV_Sink")
