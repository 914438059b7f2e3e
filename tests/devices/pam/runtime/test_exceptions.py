"""Exceptions of sequences in all their forms (section 2.17)."""

import pytest
from pam_bench import PamBench, sequence, started

from fieldrig_devices.pam.runtime.sequence import SequenceState

OTHER = "SEQUENCE SEQ_x; n <- n + 1; IF TIMEOUT THEN w <- 1; END_IF END_SEQUENCE\n"


def pulse(bench: PamBench, name: str) -> None:
    """A short event, which is gone before the next basic cycle."""
    bench[name] = True
    bench[name] = False


@pytest.mark.manual("PAML-009", "PAML-370", "PAML-371", "PAML-375")
def test_exception_with_a_sequence() -> None:
    bench = started("EXCEPTION SBI_b TIMEOUT 1000 SEQUENCE SEQ_x; WAIT_TIME 500; at <- 1;", more=OTHER)
    bench.run(10)
    bench["SBI_b"] = True
    bench.run()
    assert (bench["n"], bench["w"], bench["at"]) == (1, 0, 0)
    bench.run(600)
    assert (bench["n"], bench["at"], bench.runtime.tasks[0].is_alive) == (1, 0, False)
    bench["SBI_b"] = False
    bench["SBI_b"] = True  # not armed any more
    bench.run()
    assert bench["n"] == 1


@pytest.mark.manual("PAML-378", "PAML-380")
def test_the_time_out_is_a_second_event() -> None:
    bench = started("EXCEPTION SBI_b TIMEOUT 1000 SEQUENCE SEQ_x; CONDITION SBI_c; at <- 1;", more=OTHER)
    assert bench.trace("n", 1100) == {1002: 1}
    assert (bench["w"], bench["at"]) == (1, 0)


@pytest.mark.manual("PAML-373")
def test_an_event_that_is_true_already_fires_at_once() -> None:
    bench = started("at <- 1; EXCEPTION SBI_a SEQUENCE SEQ_x; at <- 2;", more=OTHER)
    assert (bench["at"], bench["n"]) == (1, 1)


@pytest.mark.manual("PAML-372")
def test_a_new_exception_replaces_the_present_one() -> None:
    statements = "EXCEPTION SBI_b SEQUENCE SEQ_x; EXCEPTION SBI_c ABORT_SEQUENCE; WAIT_TIME 100; at <- 1;"
    bench = started(statements, more=OTHER)
    pulse(bench, "SBI_b")
    bench.run(2)
    assert (bench["n"], bench.runtime.tasks[0].is_alive) == (0, True)
    pulse(bench, "SBI_c")
    bench.run(2)
    assert (bench["n"], bench["at"], bench.runtime.tasks[0].is_alive) == (0, 0, False)


@pytest.mark.manual("PAML-372")
def test_an_exception_can_be_removed() -> None:
    bench = started("EXCEPTION SBI_b ABORT_SEQUENCE; WAIT_TIME 10; REMOVE_EXCEPTION WAIT_TIME 10; at <- 1;")
    bench.run(12)
    bench["SBI_b"] = True
    bench.run(10)
    assert bench["at"] == 1


@pytest.mark.manual("PAML-374")
def test_the_exception_comes_before_the_condition() -> None:
    bench = started("EXCEPTION SBI_b SEQUENCE SEQ_x; CONDITION SBI_b; at <- 1;", more=OTHER)
    bench["SBI_b"] = True
    bench.run(3)
    assert (bench["n"], bench["at"]) == (1, 0)


@pytest.mark.manual("PAML-376")
def test_a_short_event_is_remembered_and_wakes_the_sequence() -> None:
    bench = started("EXCEPTION SBI_b SEQUENCE SEQ_x; WAIT_TIME 500; at <- 1;", cycles=10, more=OTHER)
    bench.run(2)
    pulse(bench, "SBI_b")
    assert bench.trace("n", 20) == {20: 1}


@pytest.mark.manual("PAML-377")
def test_the_present_statement_is_completed_first() -> None:
    bench = started("EXCEPTION f * g SEQUENCE SEQ_x; f <- set; g <- set; at <- 1;", more=OTHER)
    assert (bench["f"], bench["g"], bench["n"], bench["at"]) == (True, True, 1, 0)


@pytest.mark.manual("PAML-381", "PAML-382")
def test_exception_with_an_entry() -> None:
    statements = (
        "EXCEPTION SBI_b ENTRY out; WAIT_TIME 10; at <- 1; EXCEPTION_ENTRY out; n <- n + 1; WAIT_TIME 10; w <- 1;"
    )
    bench = started(statements)
    bench.run(25)
    assert (bench["at"], bench["n"], bench["w"]) == (1, 1, 1)  # without the event it is passed
    bench = started(statements)
    bench["SBI_b"] = True
    bench.run()
    assert (bench["at"], bench["n"]) == (0, 1)
    bench.run(5)  # the event is still true, and does not fire again
    assert bench["n"] == 1
    bench["SBI_b"] = False
    bench["SBI_b"] = True  # again, behind the entry
    assert bench.trace("n", 3) == {9: 2}
    assert bench.trace("w", 12) == {19: 1}


EXECUTED = (
    "TASK TSK_x; SPECS CYCLES = 1; END_SPECS SEQUENCE SEQ_x; n <- 1; WAIT_TIME 20; n <- 2; END_SEQUENCE END_TASK\n"
)


def with_task(mode: str) -> PamBench:
    body = f"EXCEPTION SBI_b TIMEOUT 1000 XEQ_TASK TSK_x SEQUENCE SEQ_x {mode}; WAIT_TIME 10; at <- 1;"
    bench = PamBench(sequence(body) + EXECUTED)
    bench.run()
    bench["SBI_a"] = True
    bench.run(3)
    bench["SBI_b"] = True
    bench.run()
    assert bench["n"] == 1
    return bench


@pytest.mark.manual("PAML-370")
@pytest.mark.parametrize(("mode", "at"), [("", {12: 1}), ("WAIT", {26: 1}), ("ABORT", {})])
def test_exception_with_a_task(mode: str, at: dict[int, object]) -> None:
    bench = with_task(mode)
    expected = {"": SequenceState.SUSPENDED, "WAIT": SequenceState.SUSPENDED, "ABORT": SequenceState.DEAD}[mode]
    assert bench.runtime.tasks[0].state is expected
    assert bench.trace("at", 40) == at
    assert bench["n"] == 2


@pytest.mark.manual("PAML-383")
def test_an_exception_for_a_busy_task_is_an_error() -> None:
    first = sequence("EXCEPTION SBI_b XEQ_TASK TSK_x SEQUENCE SEQ_x; WAIT_TIME 100; at <- 1;")
    second = sequence("EXCEPTION SBI_c XEQ_TASK TSK_x SEQUENCE SEQ_x; WAIT_TIME 100; w <- 1;").replace("TSK_a", "TSK_c")
    bench = PamBench(first + second + EXECUTED)
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    bench["SBI_b"] = True
    bench.run()
    bench["SBI_c"] = True
    bench.run()
    assert (bench.errors, [task.is_alive for task in bench.runtime.tasks]) == (["03..E033"], [True, False, True])
    bench.run(200)
    assert (bench["at"], bench["w"], bench["n"]) == (1, 0, 2)


# ---- the example of the manual, lines 4343 to 4365

EXAMPLE = """
EXCEPTION SBI_b TIMEOUT 1000 ENTRY exit;
n <- n * 10 + 1; {first}
EXCEPTION SBI_c TIMEOUT ABORT_SEQUENCE;
n <- n * 10 + 2; {second}
EXCEPTION_ENTRY exit;
IF TIMEOUT THEN n <- n * 10 + 3; ELSE n <- n * 10 + 4; END_IF
"""


def example(first: str = "WAIT_TIME 400;", second: str = "WAIT_TIME 400;") -> PamBench:
    return started(EXAMPLE.format(first=first, second=second))


@pytest.mark.manual("PAML-379")
@pytest.mark.parametrize(
    ("event", "after_ms", "first", "second", "outcome"),
    [
        ("", 0, 400, 400, 124),
        ("SBI_b", 200, 400, 400, 14),  # Stop before line L3
        ("SBI_b", 600, 400, 400, 124),  # Stop after L3 is no exception
        ("", 0, 2000, 400, 13),  # 1000 ms before L3
        ("", 0, 400, 2000, 12),  # 1000 ms after L3: aborted
        ("SBI_c", 200, 400, 400, 124),  # Emergency before L3, and gone
        ("SBI_c", 600, 400, 400, 12),  # Emergency after L3: aborted
    ],
)
def test_outcomes_of_the_example(event: str, after_ms: int, first: int, second: int, outcome: int) -> None:
    bench = example(f"WAIT_TIME {first};", f"WAIT_TIME {second};")
    if event:
        bench.run(after_ms)
        pulse(bench, event)
    bench.run(2500)
    assert (bench["n"], bench.runtime.tasks[0].is_alive) == (outcome, False)


@pytest.mark.manual("PAML-379")
def test_the_rest_of_the_time_is_taken_over() -> None:
    bench = started("EXCEPTION SBI_b TIMEOUT 100 ABORT_SEQUENCE; WAIT_TIME 80; EXCEPTION SBI_c TIMEOUT SEQUENCE SEQ_x;"
                    " WAIT_TIME 1000;", more=OTHER)  # fmt: skip
    assert bench.trace("n", 200) == {102: 1}
    assert bench["w"] == 1
