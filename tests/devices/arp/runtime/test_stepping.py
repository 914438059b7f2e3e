"""Steps of a program from one source line to another, into, over and out of subprograms."""

from arp_card import ArpBench

from fieldrig_devices.arp.runtime.program import Place, ProgramState
from fieldrig_devices.languages.debugging.debuggee import Step

PROGRAM = """\
BEG MAIN
LOOP:
V1 += 1
CALL SUB
V3 += 1
GOTO LOOP
END
BEG SUB
V2 += 1
WAIT 0.01
V4 += 1
END"""
START, CALL, AFTER_CALL = 3, 4, 5
IN_SUB, WAIT, BEHIND_WAIT = 9, 10, 11


def paused_at(line: int) -> ArpBench:
    bench = ArpBench(PROGRAM)
    bench.program.break_at({line})
    bench.run(30)
    assert (bench.program.state, bench.program.place.line) == (ProgramState.PAUSED, line)
    return bench


def step(bench: ArpBench, kind: Step) -> tuple[Place, int]:
    """Step, and return the place that was reached and the time that it took in ms."""
    stops: list[Place] = []
    bench.program.on_stop = lambda: stops.append(bench.program.place)
    bench.program.step_to(kind)
    for ms in range(30):
        if stops:
            assert bench.program.state is ProgramState.PAUSED
            return stops[0], ms - 1
        bench.run(1)
    raise AssertionError("the step has not ended")


def test_a_step_into_a_subprogram_stops_at_its_first_line() -> None:
    assert step(paused_at(CALL), Step.INTO) == (Place("SUB", IN_SUB), 0)


def test_a_step_over_a_call_takes_the_time_of_its_waits() -> None:
    bench = paused_at(CALL)
    assert step(bench, Step.OVER) == (Place("MAIN", AFTER_CALL), 10)
    assert (bench.card.V[2], bench.card.V[4]) == (1_000, 1_000)


def test_a_step_out_ends_behind_the_call() -> None:
    assert step(paused_at(IN_SUB), Step.OUT) == (Place("MAIN", AFTER_CALL), 10)


def test_a_step_over_a_line_without_a_call_is_one_line() -> None:
    bench = paused_at(START)
    assert step(bench, Step.OVER) == (Place("MAIN", CALL), 0)
    assert step(paused_at(WAIT), Step.OVER) == (Place("SUB", BEHIND_WAIT), 0)  # its time passes afterwards


def test_a_breakpoint_ends_a_step_over_a_call() -> None:
    bench = paused_at(CALL)
    bench.program.break_at({CALL, BEHIND_WAIT})
    assert step(bench, Step.OVER) == (Place("SUB", BEHIND_WAIT), 0)


def test_going_on_forgets_a_step() -> None:
    bench = paused_at(IN_SUB)
    bench.program.break_at(set())
    bench.program.step_to(Step.OUT)
    bench.program.pause()
    bench.program.go_on()
    bench.run(100)
    assert bench.program.state is ProgramState.RUNNING
