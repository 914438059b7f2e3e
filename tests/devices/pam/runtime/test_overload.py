"""Programs that need more than a basic cycle has room for: they are delayed (manual lines 3131 to 3135), and go on."""

import pytest
from pam_bench import PamBench, sequence, started

from fieldrig_devices.pam.runtime.item import RoutineRef
from fieldrig_devices.pam.runtime.processor import Limits

LONG = "LOOP w <- w + 1; END_LOOP w = 20000; n <- n + 1; w <- 0;"
EVENT = "ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS ON_EVENT SBI_a ACTION {} END_ACTION END_ACTIONS "
STATE = "ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS ON_STATE SBI_a ACTION {} END_ACTION END_ACTIONS "
ROUTINES = "ROUTINES RGR_a; ROUTINE RTN_a; {} END_ROUTINE END_ROUTINES "
CONNECTED = ROUTINES + "COMPARATOR CMP_a; REFERENCE = 1; ROUTINE = RTN_a; END "
PLACES = {
    "sequence": sequence(LONG),
    "sequence that starts itself": sequence("w <- w + 1; IF w < 9000 THEN XEQ_SEQUENCE SEQ_a; END_IF n <- n + 1;"),
    "sequence of power-on": sequence("", power_on=LONG),
    "routine that a sequence calls": ROUTINES.format(LONG) + sequence("CALL RTN_a;"),
    "action of an event": EVENT.format(LONG),
    "action of a state": STATE.format(LONG),
    "routine that an action calls": ROUTINES.format(LONG) + EVENT.format("CALL RTN_a;"),
    "power-on of routines": "ROUTINES RGR_a; POWERON " + LONG + " END_POWERON END_ROUTINES",
    "power-on of actions": "ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS POWERON " + LONG + " END_POWERON END_ACTIONS",
}


@pytest.mark.manual("PAMS-104", "PAML-321")
@pytest.mark.parametrize("programs", PLACES.values(), ids=PLACES)
def test_long_programs_take_several_cycles(programs: str) -> None:
    bench = PamBench(programs)
    bench.run(2)
    bench["SBI_a"] = True
    bench.run()
    assert bench["n"] == 0
    bench["SBI_a"] = False
    bench.run(20)
    assert (bench["n"], bench.errors) == (1, [])


@pytest.mark.manual("PAML-321")
def test_a_loop_without_end_leaves_time_for_other_tasks() -> None:
    other = sequence("LOOP at <- at + 1; WAIT_TIME 1; END_LOOP SBI_b;").replace("TSK_a", "TSK_b")
    bench = PamBench(sequence("LOOP n <- n + 1; END_LOOP SBI_c;") + other)
    bench.run()
    bench["SBI_a"] = True
    bench.run(11)
    assert bench.errors == []
    assert bench["at"] == 11
    bench["SBI_c"] = True
    bench.run(2)
    before = bench["n"]
    bench.run(3)
    assert bench["n"] == before


@pytest.mark.parametrize("statements", [1, 2, 3, 7, 100])
def test_results_do_not_depend_on_the_room_in_a_cycle(statements: int) -> None:
    programs = sequence("LOOP w <- w + 1; IF w % 3 = 0 THEN n <- n + w; END_IF END_LOOP w = 30; at <- 1;")
    bench = PamBench(programs, limits=Limits(statements))
    bench.run(3)
    bench["SBI_a"] = True
    for _ in range(300):
        bench.run()
    assert (bench["w"], bench["n"], bench["at"], bench.errors) == (30, 165, 1, [])


@pytest.mark.manual("PAML-274")
def test_routines_come_first_in_the_next_cycle() -> None:
    bench = PamBench(
        CONNECTED.format("LOOP w <- w + 1; END_LOOP w >= 250; at <- n;") + sequence("n <- 7;"), limits=Limits(100)
    )
    bench.run(2)
    bench["SBI_a"] = True
    bench.objects.on_cycle.append(lambda: bench.runtime.start_routine(RoutineRef("RTN_a", ())))
    bench.run()
    bench.objects.on_cycle.clear()
    bench.run(20)
    assert (bench["w"], bench["at"], bench["n"], bench.errors) == (250, 0, 7, [])


def test_an_event_during_its_long_action_counts_once_afterwards() -> None:
    bench = PamBench(EVENT.format("n <- n + 1; w <- 0; LOOP w <- w + 1; END_LOOP w = 250;"), limits=Limits(50))
    bench.run(2)
    for _ in range(4):
        bench["SBI_a"] = True
        bench["SBI_a"] = False
        bench.run()
    bench.run(60)
    assert (bench["n"], bench["w"], bench.errors) == (2, 250, [])


def test_a_lasting_overload_by_routines_is_told_once_and_does_not_grow() -> None:
    bench = PamBench(CONNECTED.format("n <- n + 1;"), limits=Limits(2))
    bench.run(2)

    def start() -> None:
        for _ in range(40):
            bench.runtime.start_routine(RoutineRef("RTN_a", ()))

    bench.objects.on_cycle.append(start)
    bench.run(100)
    assert bench.errors == ["07..E023"]
    assert not bench.runtime.is_stopped
    bench.objects.on_cycle.clear()
    count = bench["n"]
    bench.run(3_000)
    assert isinstance(count, int)
    assert bench["n"] == count + 1_023  # one of the 1,024 has run in the last cycle


def test_an_overrun_can_be_fatal() -> None:
    bench = PamBench(sequence("LOOP n <- 1; END_LOOP SBI_b;"), limits=Limits(is_overrun_fatal=True))
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    assert bench.errors == ["02..F060"]
    assert "do not come to rest" in bench.messages[-1][2]
    bench.run(5)
    assert bench.runtime.is_stopped


@pytest.mark.long
def test_the_loop_of_20000_ends() -> None:
    bench = started("LOOP w <- w + 1; END_LOOP w = 20000;")
    bench.run(5)
    assert (bench["w"], bench.errors) == (20_000, [])
