"""Tasks and sequences: their states, and the statements that wait, exact to the basic cycle (sections 2.14 to 2.16)."""

import pytest
from pam_bench import OBJECTS, PamBench, sequence, started

from fieldrig_devices.pam.runtime.item import Pending
from fieldrig_devices.pam.runtime.sequence import SequenceState

TWO = "TASK TSK_b; SPECS CYCLES = {cycles}; END_SPECS SEQUENCE SEQ_b; {body} END_SEQUENCE END_TASK\n"


def with_other(statements: str, body: str, *, cycles: int = 1) -> PamBench:
    """A bench with a second task, whose sequence the first one starts."""
    bench = PamBench(sequence(statements) + TWO.format(body=body, cycles=cycles))
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    return bench


# ---- events and states


@pytest.mark.manual("PAML-009", "PAML-293", "PAML-292", "PAML-290")
def test_an_event_starts_a_sequence_and_one_that_comes_too_early_is_lost() -> None:
    bench = PamBench(
        "TASK TSK_a; SPECS CYCLES = 1; END_SPECS EVENTS ON_EVENT SBI_a XEQ_SEQUENCE SEQ_a; ON_EVENT SBI_b XEQ_SEQUENCE"
        " SEQ_b; END_EVENTS SEQUENCE SEQ_a; n <- n + 1; WAIT_TIME 10; END_SEQUENCE SEQUENCE SEQ_b; w <- 1;"
        " END_SEQUENCE END_TASK"
    )
    bench.run()
    (task,) = bench.runtime.tasks
    assert task.state is SequenceState.DEAD
    bench["SBI_a"] = True
    bench.run()
    assert (bench["n"], task.state) == (1, SequenceState.SUSPENDED)
    bench["SBI_b"] = True  # while SEQ_a is alive
    bench.run(20)
    assert (bench["w"], task.state) == (0, SequenceState.DEAD)
    bench["SBI_b"] = False
    bench.run()
    bench["SBI_b"] = True
    bench.run()
    assert (bench["n"], bench["w"]) == (1, 1)


@pytest.mark.manual("PAML-296", "PAML-302")
@pytest.mark.parametrize("word", ["CYCLES", "PERIOD"])
def test_a_task_reacts_in_its_cycles(word: str) -> None:
    bench = PamBench(sequence("at <- at + 1; WAIT_TIME 1; at <- at + 1;", cycles=10).replace("CYCLES", word))
    bench.run(12)
    bench["SBI_a"] = True
    assert bench.trace("at", 30) == {20: 1, 30: 2}


@pytest.mark.manual("PAML-008", "PAML-291", "PAML-299")
def test_tasks_run_side_by_side() -> None:
    other = sequence("CONDITION f; w <- 2;").replace("TSK_a", "TSK_b")
    bench = PamBench(sequence("WAIT_TIME 5; f <- set; WAIT_TIME 5; n <- 1;") + other)
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    assert [task.state for task in bench.runtime.tasks] == [SequenceState.SUSPENDED] * 2
    assert bench.trace("w", 6) == {7: 2}
    assert bench.trace("n", 6) == {12: 1}


@pytest.mark.manual("PAML-012", "PAML-355")
@pytest.mark.parametrize(("thirds", "cycles"), [(3, 100), (6, 50), (1, 300), (4, 75)])
def test_wait_time_is_exact_to_the_cycle(thirds: int, cycles: int) -> None:
    header = OBJECTS.replace("BASIC_PAM_CYCLE = 3", f"BASIC_PAM_CYCLE = {thirds}")
    bench = PamBench(sequence("at <- 1; WAIT_TIME 100; at <- 2; WAIT_TIME n; at <- 3;"), header=header)
    bench.run()
    bench["SBI_a"] = True
    assert bench.trace("at", 1) == {2: 1}
    assert bench.trace("at", cycles) == {2 + cycles: 3}


# ---- conditions


@pytest.mark.manual("PAML-009", "PAML-350", "PAML-352")
def test_a_condition_that_holds_takes_no_time_and_one_that_does_not_waits() -> None:
    bench = started("at <- 1; CONDITION SBI_a; at <- 2; CONDITION SBI_b; at <- 3;")
    assert bench["at"] == 2
    bench.run(1000)
    assert bench["at"] == 2
    bench["SBI_b"] = True
    assert bench.trace("at", 2) == {1003: 3}


@pytest.mark.manual("PAML-009", "PAML-350")
def test_a_change_that_leaves_a_condition_false_does_not_end_its_wait() -> None:
    bench = started("at <- 1; CONDITION SBI_b * SBI_c; at <- 2;")
    seen = []
    for name in ("SBI_c", "SBI_b"):
        bench[name] = True
        bench.run(10)
        seen.append(bench["at"])
    assert seen == [1, 2]


@pytest.mark.manual("PAML-351", "PAML-320")
@pytest.mark.parametrize(("comes", "expected"), [(None, 2), (3, 1)])
def test_timeout_of_a_condition(comes: int | None, expected: int) -> None:
    bench = started("CONDITION SBI_b TIMEOUT 5000; IF TIMEOUT THEN at <- 2; ELSE at <- 1; END_IF")
    if comes is not None:
        bench.run(comes)
        bench["SBI_b"] = True
        assert bench.trace("at", 2) == {6: expected}
    else:
        assert bench.trace("at", 5001) == {5002: expected}


@pytest.mark.manual("PAML-351")
def test_the_next_condition_clears_the_indicator() -> None:
    bench = started("CONDITION SBI_b TIMEOUT 1; f <- TIMEOUT; CONDITION SBI_a; g <- TIMEOUT;")
    bench.run(5)
    assert (bench["f"], bench["g"]) == (True, False)


@pytest.mark.manual("PAML-353")
@pytest.mark.parametrize(
    ("statement", "code"),
    [
        ("CONDITION SBI_b TIMEOUT n - 1;", "03..E032"),
        ("CASE CONDITION SBI_b XEQ_SEQUENCE SEQ_a; TIMEOUT n - 1 XEQ_SEQUENCE SEQ_a; END_CASE", "03..E032"),
        ("EXCEPTION SBI_b TIMEOUT n - 1 ABORT_SEQUENCE;", "03..E031"),
    ],
)
def test_a_negative_time_out_is_an_error(statement: str, code: str) -> None:
    bench = started(f"{statement} at <- 1;")
    bench.run(3)
    assert (bench.errors, bench["at"], bench.runtime.tasks[0].is_alive) == ([code], 0, False)


@pytest.mark.manual("PAML-225", "PAML-226")
def test_a_condition_on_a_common_variable_is_polled_in_the_cycles_of_its_task() -> None:
    other = TWO.format(cycles=10, body="CONDITION n >= 3; at <- 1;")
    bench = PamBench(sequence("XEQ_TASK TSK_b SEQUENCE SEQ_b; LOOP n <- n + 1; WAIT_TIME 1; END_LOOP n >= 20;") + other)
    bench.run(4)
    bench["SBI_a"] = True
    assert bench.trace("at", 30) == {10: 1}


@pytest.mark.manual("PAML-225")
def test_common_variables_cause_no_events() -> None:
    bench = PamBench(
        "ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS ON_EVENT f ACTION n <- n + 1; END_ACTION END_ACTIONS\n"
        + sequence("f <- set; f <- reset; cf <- set; cf <- reset;")
        + "TASK TSK_c; SPECS CYCLES = 1; END_SPECS EVENTS ON_EVENT cf XEQ_SEQUENCE SEQ_c; END_EVENTS"
        " SEQUENCE SEQ_c; w <- 1; END_SEQUENCE END_TASK"
    )
    bench.run()
    bench["SBI_a"] = True
    bench.run(3)
    assert (bench["n"], bench["w"]) == (1, 0)  # the short pulse of an INTERNAL variable is not missed


@pytest.mark.manual("PAML-225")
@pytest.mark.parametrize("other", ["", " * !f"])
def test_a_common_variable_that_stays_true_causes_no_event(other: str) -> None:
    """Manual line 2644: an event comes from what else is in the expression."""
    bench = PamBench(
        f"ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS ON_EVENT cf{other} ACTION n <- n + 1; END_ACTION END_ACTIONS\n"
        + sequence(f"f <- set; EXCEPTION cf{other} ABORT_SEQUENCE; cf <- set; WAIT_TIME 50; w <- 1; f <- reset;")
    )
    bench.run()
    bench["SBI_a"] = True
    bench.run(100)
    assert (bench["n"], bench["w"]) == (1 if other else 0, 1)


# ---- CASE


CASE = """
at <- 1;
CASE
  CONDITION f XEQ_SEQUENCE SEQ_1; CONDITION g XEQ_SEQUENCE SEQ_2; CONDITION SBI_b XEQ_SEQUENCE SEQ_3;
  TIMEOUT 500 XEQ_SEQUENCE SEQ_4;
END_CASE
at <- 99;
"""
CHOICES = "".join(f"SEQUENCE SEQ_{number}; n <- {number}; END_SEQUENCE\n" for number in range(1, 5))


@pytest.mark.manual("PAML-356")
def test_case_takes_the_first_condition_in_the_order_of_the_text() -> None:
    bench = started(CASE, more=CHOICES)
    bench.run(10)
    bench["g"] = bench["f"] = True
    bench.run()
    assert (bench["n"], bench["at"], bench.runtime.tasks[0].is_alive) == (1, 1, False)
    bench = started("g <- set; SBO_a <- set;" + CASE, more=CHOICES)
    assert bench["n"] == 2


@pytest.mark.manual("PAML-357")
def test_case_with_a_time_out() -> None:
    bench = started(CASE, more=CHOICES)
    assert bench.trace("n", 600) == {502: 4}
    assert bench["at"] == 1


# ---- loops, and starting other sequences


@pytest.mark.manual("PAML-321")
def test_a_loop_runs_at_least_once() -> None:
    bench = started("LOOP n <- n + 1; END_LOOP SBI_a; LOOP w <- w + 1; WAIT_TIME 10; END_LOOP w = 3;")
    assert bench["n"] == 1
    assert bench.trace("w", 40) == {12: 2, 22: 3}


@pytest.mark.manual("PAML-322")
def test_xeq_sequence_aborts_the_present_one() -> None:
    more = "SEQUENCE SEQ_b; n <- n + 10; END_SEQUENCE\n"
    bench = started("IF SBI_b THEN XEQ_SEQUENCE SEQ_b END_IF n <- n + 1;", more=more)
    found = [bench["n"]]
    bench["SBI_b"], bench["SBI_a"] = True, False
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    assert [*found, bench["n"]] == [1, 11]


@pytest.mark.manual("PAML-323")
def test_xeq_task_goes_on_in_parallel() -> None:
    bench = with_other("XEQ_TASK TSK_b SEQUENCE SEQ_b; at <- 1;", "WAIT_TIME 5; w <- 1;")
    assert (bench["at"], bench["w"]) == (1, 0)
    assert bench.trace("w", 10) == {7: 1}


@pytest.mark.manual("PAML-324")
def test_xeq_task_wait() -> None:
    bench = with_other("XEQ_TASK TSK_b SEQUENCE SEQ_b WAIT; at <- 1;", "WAIT_TIME 5; w <- 1;")
    assert bench.runtime.tasks[0].state is SequenceState.SUSPENDED
    bench.run(4)
    assert (bench["at"], bench["w"]) == (0, 0)
    bench.run(2)
    assert (bench["at"], bench["w"]) == (1, 1)


@pytest.mark.manual("PAML-325")
def test_xeq_task_abort() -> None:
    bench = with_other("XEQ_TASK TSK_b SEQUENCE SEQ_b ABORT; at <- 1;", "WAIT_TIME 5; w <- 1;")
    assert [task.is_alive for task in bench.runtime.tasks] == [False, True]
    bench.run(10)
    assert (bench["at"], bench["w"]) == (0, 1)


@pytest.mark.manual("PAML-326")
def test_a_busy_task_stops_the_one_that_starts_it() -> None:
    bench = with_other("XEQ_TASK TSK_b SEQUENCE SEQ_b; XEQ_TASK TSK_b SEQUENCE SEQ_b; at <- 1;", "WAIT_TIME 5; w <- 1;")
    assert (bench.errors, bench["at"]) == (["03..E033"], 0)
    assert [task.is_alive for task in bench.runtime.tasks] == [False, True]
    bench.run(10)
    assert (bench["w"], bench.runtime.is_stopped) == (1, False)


# ---- duplicates


@pytest.mark.manual("PAML-295", "PAML-297", "PAML-354")
def test_dupl_start_lets_only_so_many_items_through() -> None:
    bench = PamBench(
        "INTERNAL FLAG_VAR go; NUMBER = 20; END INTERNAL FLAG_VAR halt; NUMBER = 20; END COMMON WORD_VAR in;"
        " COMMON WORD_VAR most; COMMON WORD_VAR done;\n"
        "TASK TSK_a; SPECS NUMBER = 20; DUPL = 10; CYCLES = 1; END_SPECS"
        " EVENTS ON_EVENT go[i] XEQ_SEQUENCE SEQ_a[i]; END_EVENTS SEQUENCE SEQ_a[i]; EXCEPTION halt[i] ABORT_SEQUENCE;"
        " CONDITION DUPL_START; in <- in + 1; IF in > most THEN most <- in; END_IF WAIT_TIME 10; in <- in - 1;"
        " done <- done + 1; END_SEQUENCE END_TASK"
    )
    bench.run()
    bench["go"] = [True] * 20
    bench.run()
    assert bench["in"] == 10
    bench["halt"] = [False] * 19 + [True]  # aborts an item in front of the gate
    bench.run(30)
    assert (bench["most"], bench["done"], bench["in"]) == (10, 19, 0)


@pytest.mark.manual("PAML-294", "PAML-004")
def test_each_item_of_a_multiple_task_has_its_own_sequence() -> None:
    bench = PamBench(
        "TASK TSK_a; SPECS NODES_GROUP = NGR_Both; CYCLES = 1; END_SPECS"
        " EVENTS ON_EVENT fe[i] XEQ_SEQUENCE SEQ_a[i]; END_EVENTS"
        " SEQUENCE SEQ_a[i]; SBO_Each[i] <- set; AXI_Each[i] <- run(2 * 3); END_SEQUENCE END_TASK"
    )
    bench.run()
    bench["fe"] = [False, True]
    bench.run()
    assert [item.value() for item in bench.objects.items["SBO_Each"]] == [False, True]
    assert bench.objects.orders == ["SBO_Each[2] <- set", "AXI_Each[2] <- run(6)"]


@pytest.mark.manual("PAML-002")
def test_two_drilling_machines_behave_alike_with_their_own_drills() -> None:
    bench = PamBench(
        "TASK TSK_Drill; SPECS NODES_GROUP = NGR_Both; CYCLES = 1; END_SPECS"
        " EVENTS ON_EVENT fe[i] XEQ_SEQUENCE SEQ_Drill[i]; END_EVENTS"
        " SEQUENCE SEQ_Drill[i]; AXI_Each[i] <- relative_move(depth[i]); END_SEQUENCE END_TASK",
        header=OBJECTS + "COMMON WORD_VAR depth; NODES_GROUP = NGR_Both; END\n",
    )
    bench["depth"] = [40, 65]
    bench.run()
    bench["fe"] = [True, True]
    bench.run()
    assert bench.objects.orders == ["AXI_Each[1] <- relative_move(40)", "AXI_Each[2] <- relative_move(65)"]


@pytest.mark.manual("PAML-005", "PAML-006", "PAML-007")
def test_components_that_are_missing_are_left_out() -> None:
    text = (
        "BOOLEAN BOL_All; EQUATION = fe[all*]; END_BOOLEAN BOOLEAN BOL_Any; EQUATION = (fe[i] * !SBI_b)[all+];"
        " END_BOOLEAN TASK TSK_a; SPECS NODES_GROUP = NGR_Both; CYCLES = 1; END_SPECS EVENTS ON_EVENT fe[i]"
        " XEQ_SEQUENCE SEQ_a[i]; END_EVENTS SEQUENCE SEQ_a[i]; n <- n + 1; AXI_Each[all] <- stop; END_SEQUENCE END_TASK"
    )
    whole, part = PamBench(text), PamBench(text, missing=1)
    for bench in (whole, part):
        bench.run()
        bench["fe"] = [True, False]
        bench.run()
    assert (whole["BOL_All"], whole["BOL_Any"], whole.objects.orders) == (
        False,
        True,
        ["AXI_Each[1] <- stop", "AXI_Each[2] <- stop"],
    )
    assert (part["BOL_All"], part["BOL_Any"], part.objects.orders) == (True, True, ["AXI_Each[1] <- stop"])
    part["fe"] = [False, True]
    part.run()
    assert (part["BOL_All"], part["BOL_Any"], part["n"], len(part.runtime.tasks)) == (False, False, 1, 1)


# ---- answers from the ring


@pytest.mark.manual("PAML-144", "PAML-145", "PAML-148")
@pytest.mark.parametrize("asked", ["ENC_One[all+]", "ENC_One"])
def test_an_encoder_without_sampler_suspends_the_sequence(asked: str) -> None:
    header = OBJECTS.replace("NODE NOD_Io", "NODE NOD_x; ADDRESS = 3; TYPE = ST1; END NODE NOD_Io")
    header = header.replace("ENC_One; NODE = NOD_Each", "ENC_One; NODE = NOD_x")
    if asked != "ENC_One":
        asked = "ENC_One ? speed"
    bench = PamBench(sequence(f"x <- 2 * {asked} + 1; at <- 1;"), header=header)
    answer = Pending()
    for function in ("value", "speed"):
        bench.item("ENC_One").answers[function] = answer
    bench.run()
    bench["SBI_a"] = True
    bench.run(6)
    assert (bench["at"], bench.runtime.tasks[0].state) == (0, SequenceState.SUSPENDED)
    answer.value = 21.5
    bench.run()
    assert (bench["x"], bench["at"]) == (44.0, 1)


def test_a_condition_asks_over_the_ring_again_and_again() -> None:
    motor = (
        "BINARY_OUTPUT SBO_i; NODE = NOD_Io; ADDRESS = 205; ACTIVE = HIGH; END"
        " BINARY_OUTPUT SBO_d; NODE = NOD_Io; ADDRESS = 206; ACTIVE = HIGH; END"
        " COUNTER_INPUT CNT_m; NODE = NOD_Io; ADDRESS = 105; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END"
        " DC_MOTOR DCM_m; INC = SBO_i; DEC = SBO_d; ZERO = SBI_c; ENCODER = CNT_m; TIMEOUT = 5; BRAKING = 1; END\n"
    )
    bench = PamBench(motor + sequence("CONDITION DCM_m ? position > 100; at <- 1;"))
    asked: list[Pending] = []

    def ask(function: str, arguments: object) -> Pending:
        asked.append(Pending())
        return asked[-1]

    bench.item("DCM_m").ask = ask  # type: ignore[method-assign]
    bench.restart()
    bench.run()
    bench["SBI_a"] = True
    for position in (50, 100, 101):
        bench.run(6)
        assert (bench["at"], len(asked)) == (0, {50: 1, 100: 2, 101: 3}[position])
        asked[-1].value = position
    bench.run(2)
    assert bench["at"] == 1


@pytest.mark.manual("PAML-266")
def test_an_action_does_not_wait_for_an_answer() -> None:
    header = OBJECTS.replace("NODE NOD_Io", "NODE NOD_x; ADDRESS = 3; TYPE = ST1; END NODE NOD_Io")
    header = header.replace("ENC_One; NODE = NOD_Each", "ENC_One; NODE = NOD_x")
    bench = PamBench(
        "ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS ON_EVENT f ACTION x <- ENC_One; n <- 1; END_ACTION END_ACTIONS",
        header=header,
    )
    bench.item("ENC_One").answers["value"] = Pending()
    bench.run()
    bench["f"] = True
    bench.run()
    assert (bench["n"], bench.errors) == (1, ["07..E021"])


def test_sequences_that_wait_cost_nothing() -> None:
    """No program is served in a cycle in which nothing that it waits for has changed."""
    bench = started("LOOP CONDITION f; f <- reset; WAIT_TIME 1000; END_LOOP g;")
    bench.run(5)
    served: list[int] = []
    task = bench.runtime.tasks[0]
    serve = task.serve

    def counted() -> None:
        served.append(bench.runtime.cycle_number)
        serve()

    task.serve = counted  # type: ignore[method-assign]
    bench["SBI_b"] = True  # nothing waits for it
    bench.run(100)
    assert served == []
    bench["f"] = True
    bench.run(1500)
    assert served == [108, 1108]


@pytest.mark.manual("PAML-224")
def test_one_item_is_used_with_and_without_an_index() -> None:
    statements = "one <- 5; n <- one; one[all] <- 6; at <- one;"
    bench = PamBench("INTERNAL WORD_VAR one; NUMBER = 1; END\n" + sequence(statements, specs="NUMBER = 1;"))
    bench["SBI_a"] = True
    bench.run()
    bench["SBI_a"] = False
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    assert (bench["n"], bench["at"]) == (5, 6)
