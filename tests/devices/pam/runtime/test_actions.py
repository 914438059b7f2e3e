"""Actions, routines, boolean equations, variables, and the start of an application (sections 2.11 to 2.13)."""

import pytest
from pam_bench import PamBench, sequence, started

from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.pam.runtime.item import RoutineRef

ACTIONS = "ACTIONS ACT_a; SPECS {specs} CYCLES = {cycles}; END_SPECS {body} END_ACTIONS\n"


def acting(body: str, *, cycles: int = 1, specs: str = "", more: str = "") -> PamBench:
    bench = PamBench(ACTIONS.format(specs=specs, cycles=cycles, body=body) + more)
    bench.run()
    return bench


# ---- actions


@pytest.mark.manual("PAML-010", "PAML-260", "PAML-261")
def test_an_action_on_an_event_runs_once_each_time() -> None:
    bench = acting("ON_EVENT SBI_a + SBI_b ACTION n <- n + 1; END_ACTION")
    for name, value, expected in [
        ("SBI_a", True, 1), ("SBI_b", True, 1), ("SBI_a", False, 1), ("SBI_b", False, 1), ("SBI_b", True, 2),
    ]:  # fmt: skip
        bench[name] = value
        bench.run(3)
        assert bench["n"] == expected


@pytest.mark.manual("PAML-262", "PAML-263")
def test_an_action_on_a_state_repeats_in_its_cycles() -> None:
    bench = acting("ON_STATE SBI_a ACTION n <- n + 1; END_ACTION", cycles=5)
    bench.run(10)
    bench["SBI_a"] = True
    assert bench.trace("n", 14) == {15: 1, 20: 2, 25: 3}
    bench["SBI_a"] = False
    bench.run(20)
    assert bench["n"] == 3


@pytest.mark.manual("PAML-263")
def test_cycles_are_the_longest_delay_of_an_event() -> None:
    bench = acting("ON_EVENT SBI_a ACTION n <- 1; END_ACTION", cycles=5)
    bench["SBI_a"] = True
    bench["SBI_a"] = False
    assert bench.trace("n", 10) == {5: 1}


@pytest.mark.manual("PAML-265")
def test_actions_with_several_items() -> None:
    bench = acting("ON_EVENT we[i] > 2 ACTION we[i] <- we[i] * 10; n <- n + 1; END_ACTION", specs="NUMBER = 3;")
    bench["we"] = [1, 3, 5]
    bench.run(3)
    assert (bench["we"], bench["n"]) == ([1, 30, 50], 2)


@pytest.mark.manual("PAML-009", "PAML-264", "PAML-275", "PAML-298")
def test_programs_start_when_all_power_on_parts_have_finished() -> None:
    programs = (
        "ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS ON_STATE !SBI_c ACTION n <- n + 1; END_ACTION"
        " POWERON; at <- at * 10 + 1; f <- set; END_POWERON END_ACTIONS\n"
        "ROUTINES RGR_a; ROUTINE RTN_a; w <- 1; END_ROUTINE POWERON at <- at * 10 + 2; END_POWERON END_ROUTINES\n"
        "TASK TSK_a; SPECS CYCLES = 1; END_SPECS EVENTS ON_EVENT f XEQ_SEQUENCE SEQ_a; END_EVENTS SEQUENCE SEQ_a;"
        " w <- 7; END_SEQUENCE POWERON at <- at * 10 + 3; WAIT_TIME 20; at <- at * 10 + 4; END_POWERON END_TASK\n"
    )
    bench = PamBench(programs)
    bench.run(10)
    assert (bench["at"], bench["n"], bench["w"], bench.runtime.is_working) == (123, 0, 0, False)
    bench.run(12)
    assert (bench["at"], bench["n"], bench["w"], bench.runtime.is_working) == (1234, 1, 7, True)
    assert [code for code, _, _ in bench.messages] == ["07..M016", "07..M018", "07..M017"]


# ---- routines


ROUTINES = """
ROUTINES RGR_a;
  ROUTINE RTN_Send WITH a, b, c; f <- set; x <- a * 2; n <- b; cf <- c; END_ROUTINE
  ROUTINE RTN_Twice WITH a; CALL RTN_Send WITH a, w + 1, a > 3; n <- n + 1; END_ROUTINE
  ROUTINE RTN_Count; w <- w + 1; END_ROUTINE
END_ROUTINES
"""


@pytest.mark.manual("PAML-270", "PAML-271")
def test_calls_of_routines() -> None:
    bench = PamBench(ROUTINES + sequence("w <- 6; CALL RTN_Twice WITH w / 4.0; at <- 1; CALL RTN_Count;"))
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    assert [bench[name] for name in ("x", "n", "cf", "at", "w", "f")] == [3.0, 8, False, 1, 7, True]


@pytest.mark.manual("PAML-270")
def test_arguments_are_values() -> None:
    bench = PamBench(ROUTINES + sequence("CALL RTN_Send WITH n, n + 1, 1; CALL RTN_Twice WITH n;"))
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    assert [bench[name] for name in ("x", "n", "cf")] == [2.0, 2, False]


@pytest.mark.manual("PAML-273", "PAML-276")
def test_a_connected_routine_runs_before_the_programs_of_its_cycle() -> None:
    header_block = "COMPARATOR CMP_a; REFERENCE = 1; ROUTINE = RTN_Send WITH 5, 3, 1; END\n"
    programs = ROUTINES + header_block + sequence("n <- n * 10; CMP_a:ROUTINE <- RTN_Twice WITH r + 1;")
    bench = PamBench(programs)
    bench.run()
    bench["SBI_a"] = True
    bench.objects.on_cycle.append(lambda: bench.runtime.start_routine(RoutineRef("RTN_Send", (5, 3, 1))))
    bench.run()
    assert (bench["n"], bench["x"]) == (30, 10.0)
    assert bench.item("CMP_a").parameters["ROUTINE"] == RoutineRef("RTN_Twice", (1.0,))
    bench.objects.on_cycle[0] = lambda: bench.runtime.start_routine(RoutineRef("", ()))
    bench.run()
    assert bench["n"] == 30


@pytest.mark.manual("PAML-274", "PAML-301")
def test_a_connected_routine_that_comes_later_runs_at_the_end_of_a_loop() -> None:
    bench = PamBench(
        ROUTINES
        + "COMPARATOR CMP_a; REFERENCE = 1; ROUTINE = RTN_Count; END\n"
        + sequence("LOOP n <- n + 1; CMP_a:REFERENCE <- n; CMP_a:REFERENCE <- n; at <- w; END_LOOP n = 3;")
    )
    item, count = bench.item("CMP_a"), []

    def set_parameter(name: str, value: object) -> None:
        count.append(value)
        bench.runtime.start_routine(RoutineRef("RTN_Count"))

    item.set_parameter = set_parameter  # type: ignore[method-assign]
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    assert (count, bench["w"], bench["at"]) == ([1, 1, 2, 2, 3, 3], 6, 4)


# ---- boolean equations


@pytest.mark.manual("PAML-240", "PAML-242", "PAML-243", "PAML-244", "PAML-247")
def test_an_equation_follows_its_operands() -> None:
    bench = PamBench(
        "BOOLEAN BOL_a; EQUATION (SBI_a + f) * !cf * (AXI_Each[all+] ? error) ; END_BOOLEAN"
        " BOOLEAN BOL_b; EQUATION = !BOL_a * (AXI_Each[i] ? speed >= 2)[all*]; END_BOOLEAN"
    )
    bench.run()
    assert (bench["BOL_a"], bench["BOL_b"]) == (False, False)
    bench["f"] = True
    bench.item("AXI_Each", 1).answer("error", value=True)
    for number in (0, 1):
        bench.item("AXI_Each", number).answers["speed"] = 2.5
    bench.run()
    assert (bench["BOL_a"], bench["BOL_b"]) == (True, False)
    bench["cf"] = True
    bench.run()
    assert (bench["BOL_a"], bench["BOL_b"]) == (False, True)


@pytest.mark.manual("PAML-241")
def test_a_linked_output_follows_every_change() -> None:
    bench = PamBench(
        "BOOLEAN BOL_a; LINKED_OUTPUT = SBO_a; EQUATION = !SBI_a; END_BOOLEAN"
        " BOOLEAN BOL_e[i]; LINKED_OUTPUT = SBO_Each; EQUATION = fe[i]; END_BOOLEAN"
    )
    found = [bench["SBO_a"]]
    for value in (True, False):
        bench["SBI_a"] = value
        bench.run()
        found.append(bench["SBO_a"])
    assert found == [True, False, True]
    bench["fe"] = [False, True]
    bench.run()
    assert [item.value() for item in bench.objects.items["SBO_Each"]] == [False, True]
    assert bench.messages[0][0] == "07..M015"


@pytest.mark.manual("PAML-245", "PAML-246")
def test_equations_with_several_items() -> None:
    bench = PamBench(
        "BOOLEAN BOL_e[i]; EQUATION = fe[i] * !SBI_a; END_BOOLEAN BOOLEAN BOL_Any; EQUATION = BOL_e[all+]; END_BOOLEAN"
        " BOOLEAN BOL_All; EQUATION = (BOL_e[i] * fe[i])[all*]; END_BOOLEAN"
    )
    for each, expected in [([True, False], (True, False)), ([True, True], (True, True)), ([False] * 2, (False, False))]:
        bench["fe"] = each
        bench.run()
        assert (bench["BOL_e"], bench["BOL_Any"], bench["BOL_All"]) == (each, *expected)


# ---- variables and objects


@pytest.mark.manual("PAML-220", "PAML-221", "PAML-224")
def test_variables_of_each_class() -> None:
    bench = started("f <- set; g <- invert; fe[all] <- set; we[all] <- 7; cf <- invert; fe[all] <- invert; h <- reset;")
    assert [bench[name] for name in ("f", "g", "h", "cf", "fe", "we")] == [
        True, True, False, True, [False, False], [7, 7, 7],
    ]  # fmt: skip


@pytest.mark.manual("PAML-310", "PAML-311", "PAML-312", "PAML-313", "PAML-314")
def test_access_to_objects() -> None:
    bench = started(
        "AXI_Each[all] <- absolute_move(w + 2.5); AXI_Each[all]:ACCELERATION <- 3; SDO_a <- 5.9; PAO_a <- 5.9;"
        " SBO_a <- 1; f <- SBO_a; w <- SDO_a + 1; SBO_a <- invert; r <- PAO_a;"
    )
    assert bench.objects.orders == [
        "AXI_Each[1] <- absolute_move(2.5)", "AXI_Each[2] <- absolute_move(2.5)", "AXI_Each[1]:ACCELERATION <- 3",
        "AXI_Each[2]:ACCELERATION <- 3", "SDO_a <- 5", "PAO_a <- 5.9", "SBO_a <- True", "SBO_a <- invert",
    ]  # fmt: skip
    assert [bench[name] for name in ("f", "w", "r", "SBO_a")] == [True, 6, 5.9, False]


# ---- limits


@pytest.mark.manual("PAML-272", "PAML-260")
@pytest.mark.parametrize(
    "statement",
    [
        "WAIT_TIME 1;",
        "CONDITION f;",
        "EXCEPTION f ABORT_SEQUENCE;",
        "XEQ_TASK TSK_a SEQUENCE SEQ_a;",
        "XEQ_SEQUENCE SEQ_a;",
    ],
)
def test_what_routines_and_actions_must_not_do(statement: str) -> None:
    for programs in (
        f"ROUTINES RGR_a; ROUTINE RTN_a; {statement} END_ROUTINE END_ROUTINES",
        ACTIONS.format(specs="", cycles=1, body=f"ON_EVENT f ACTION {statement} END_ACTION"),
    ):
        with pytest.raises(CompileError):
            PamBench(programs + sequence(""))


@pytest.mark.manual("PAML-294")
@pytest.mark.parametrize(
    "programs",
    [
        "BOOLEAN BOL_a; EQUATION = ((we[i] > 1) * fe[i])[all+]; END_BOOLEAN",
        ACTIONS.format(specs="NUMBER = 3;", cycles=1, body="ON_EVENT fe[i] ACTION n <- 1; END_ACTION"),
        (
            "TASK TSK_b; SPECS NUMBER = 2; CYCLES = 1; END_SPECS SEQUENCE SEQ_b[i]; END_SEQUENCE END_TASK"
            " TASK TSK_c; SPECS NUMBER = 3; CYCLES = 1; END_SPECS SEQUENCE SEQ_c[i]; XEQ_TASK TSK_b SEQUENCE SEQ_b[i];"
            " END_SEQUENCE END_TASK"
        ),
    ],
)
def test_what_is_used_together_has_enough_items(programs: str) -> None:
    with pytest.raises(CompileError, match=r"has 2 items, but .* has 3"):
        PamBench(programs)


def test_an_error_of_an_object_is_not_one_of_the_program() -> None:
    bench = PamBench(sequence("SBO_a <- set;"))

    def do(function: str, arguments: object) -> None:
        raise ValueError(function)

    bench.item("SBO_a").do = do  # type: ignore[method-assign]
    bench.restart()
    bench.run()
    bench["SBI_a"] = True
    with pytest.raises(ValueError, match="set"):
        bench.run()


@pytest.mark.manual("PAML-301")
def test_tasks_take_turns_at_the_ends_of_loops() -> None:
    statements = "LOOP w <- w + 1; n <- n * 10 + {}; END_LOOP w >= 6;"
    bench = PamBench(sequence(statements.format(1)) + sequence(statements.format(2)).replace("TSK_a", "TSK_b"))
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    assert bench["n"] == 1212121


def test_a_single_equation_drives_all_items_of_an_output() -> None:
    bench = PamBench("BOOLEAN BOL_a; LINKED_OUTPUT = SBO_Each; EQUATION = SBI_a; END_BOOLEAN")
    bench["SBI_a"] = True
    bench.run()
    assert [item.value() for item in bench.objects.items["SBO_Each"]] == [True, True]
