"""The user's program as a whole: waits, calls, holds, slices, breakpoints."""

import pytest
from arp_card import ArpBench

from fieldrig.clock import MS
from fieldrig_devices.arp.runtime.program import Place, ProgramState
from fieldrig_devices.arp.runtime.slices import Costs, Slices


@pytest.mark.manual("ARP-107")
def test_wait_pauses_the_program_for_its_time() -> None:
    bench = ArpBench("SET O101\nWAIT 0.25\nSET O102")
    bench.run(250)
    assert (bench.card.O[101], bench.card.O[102]) == (1, 0)
    assert bench.run(1).card.O[102] == 1


@pytest.mark.manual("ARP-107")
@pytest.mark.parametrize("time", ["0", "100.001", "-1"])
def test_a_wait_out_of_range_is_w03_and_does_not_wait(time: str) -> None:
    bench = ArpBench(f"WAIT {time} + 0 * V1\nSET O101").run()
    assert (bench.card.warnings, bench.card.O[101]) == ([203], 1)


@pytest.mark.manual("ARP-107")
def test_the_shortest_and_the_longest_wait() -> None:
    assert ArpBench("WAIT 0.001\nSET O101").run(2).card.O[101] == 1
    bench = ArpBench("WAIT 100\nSET O101").run(100_000)
    assert bench.card.O[101] == 0
    assert bench.run(1).card.O[101] == 1


RECURSIVE = """\
BEG MAIN
V2 == 0
CALL DOWN
SET O101
END
BEG DOWN
V2 += 1
IF V2 < V1, CALL DOWN
V3 += 1
END"""


@pytest.mark.manual("ARP-084")
def test_ten_levels_of_calls_return_one_by_one() -> None:
    bench = ArpBench(RECURSIVE)
    bench.card.V[1] = 10_000
    bench.run(10)
    assert (bench.card.V[2], bench.card.V[3], bench.card.O[101]) == (10_000, 10_000, 1)
    assert bench.card.error_codes == []


@pytest.mark.manual("ARP-084")
@pytest.mark.parametrize("budget", [1, 2, 3, 1_000])
def test_the_eleventh_level_stops_the_program_with_e12(budget: int) -> None:
    bench = ArpBench(RECURSIVE)
    bench.card.V[1] = 11_000
    bench.run(100, budget)
    assert bench.program.state is ProgramState.FAILED
    assert bench.card.error_codes == [112]
    assert (bench.card.V[2], bench.card.V[3]) == (10_000, 0)
    assert len(bench.program.calls) == 10


@pytest.mark.manual("ARP-098")
@pytest.mark.parametrize(
    ("move", "flag", "asked"),
    [
        ("PAC 1, 5", 263, ("PAC", 1, 5_000)),
        ("PRC 2, -5", 295, ("PRC", 2, -5_000)),
        ("PVC 1, 50", 263, ("PVC", 1, 50_000)),
        ("PST 2, 1, V10", 263, ("PST", 2, 1, 10)),
    ],
)
def test_a_busy_axis_holds_the_program_on_the_line(move: str, flag: int, asked: tuple[object, ...]) -> None:
    bench = ArpBench(f"IF F1 = HI, {move}\nSET O101")
    bench.card.F[1] = bench.card.F[flag] = 1
    bench.run(3)
    assert (bench.card.asked, bench.card.O[101], bench.program.place) == ([], 0, Place("MAIN", 2))
    bench.card.F[1] = 0  # the line has begun: its condition is not evaluated again
    bench.card.F[flag] = 0
    bench.run()
    assert (bench.card.asked, bench.card.O[101]) == ([asked], 1)


def test_the_other_axis_does_not_hold() -> None:
    bench = ArpBench("PAC 1, 5\nPAC 2, 5")
    bench.card.F[263] = 1
    assert bench.run(2).card.asked == []
    bench.card.F[263], bench.card.F[295] = 0, 1
    assert bench.run(2).card.asked == [("PAC", 1, 5_000)]


def test_stop_never_holds() -> None:
    bench = ArpBench("STOP 1")
    bench.card.F[263] = 1
    assert bench.run().card.asked == [("STOP", 1)]


def test_a_program_that_never_ends_gives_way_every_slice() -> None:
    bench = ArpBench("LOOP:\nV1 += 0.001\nGOTO LOOP")
    for count in range(1, 50):
        assert bench.run(1, budget=20).card.V[1] == count * 10


def test_end_of_the_main_program_stops_events_too_and_leaves_outputs() -> None:
    bench = ArpBench("BEG M\nON1 F1 & F2 IRQ\nSET O101\nEND\nBEGA IRQ\nSET O102\nENDA").run()
    assert bench.program.state is ProgramState.ENDED
    bench.card.F[1] = bench.card.F[2] = 1
    bench.run(3)
    assert (bench.card.O[101], bench.card.O[102]) == (1, 0)


def test_start_begins_at_the_first_instruction_with_nothing_armed() -> None:
    bench = ArpBench("BEG M\nV1 += 1\nIF V1 = 1, ON1 F1 & F2 IRQ\nWAIT 100\nEND\nBEGA IRQ\nV2 += 1\nRES F2\nENDA")
    bench.run(5)
    bench.program.reset()
    assert bench.program.state is ProgramState.HELD
    bench.card.F[1] = bench.card.F[2] = 1
    bench.run(5)
    assert (bench.card.V[1], bench.card.V[2]) == (2_000, 0)


# ---- debugging

COUNTING = """\
LOOP:
V1 += 1
CALL SUB
V3 += 1
GOTO LOOP
END
BEG SUB
V2 += 1
END"""
DEBUGGED = f"BEG MAIN\n{COUNTING}"


def test_breakpoints_stop_in_front_of_their_lines() -> None:
    bench = ArpBench(DEBUGGED)
    assert bench.program.break_at({5, 9, 1000}) == {5, 9}
    bench.run(3)
    assert bench.program.state is ProgramState.PAUSED
    assert (bench.program.place, bench.program.calls) == (Place("SUB", 9), [Place("MAIN", 5)])
    assert (bench.card.V[1], bench.card.V[2]) == (1_000, 0)
    bench.program.go_on()
    bench.run(3)
    assert (bench.program.place, bench.card.V[2], bench.card.V[3]) == (Place("MAIN", 5), 1_000, 0)
    bench.program.break_at(set())
    bench.program.go_on()
    assert bench.run(3, budget=12).card.V[1] > 4_000


def test_single_steps_go_into_subprograms_and_back() -> None:
    bench = ArpBench(DEBUGGED)
    bench.program.start()
    bench.program.pause()
    assert bench.run(5).card.V[1] == 0
    places = []
    for _ in range(7):
        places.append(bench.program.place)
        bench.program.step()
    assert [place.line for place in places] == [3, 4, 9, 10, 5, 6, 3]
    bench.program.go_on()
    bench.run(1, budget=5)
    assert bench.card.V[1:4] == [2_000, 2_000, 2_000]


def test_a_step_does_not_shorten_a_wait() -> None:
    bench = ArpBench("WAIT 0.01\nSET O101")
    bench.program.start()
    bench.program.pause()
    for _ in range(5):
        bench.program.step()
    assert bench.card.O[101] == 0
    bench.card.time_ns += 10 * MS
    bench.program.step()
    assert bench.card.O[101] == 1


# ---- slices


def instructions_in(costs: Costs, control_ms: int, scheduler_ms: int, total_ms: int) -> int:
    slices = Slices(costs, control_ms * MS, scheduler_ms * MS)
    given: list[int] = []

    def run(budget: int) -> int:
        given.append(budget)
        return 0

    for _ in range(total_ms // control_ms):
        slices.give(run)
    return sum(given)


def test_the_program_gets_what_the_control_loop_and_the_scheduler_leave() -> None:
    costs = Costs(instruction_us=50, control_us=300, scheduler_us=1_000)
    assert instructions_in(costs, 2, 20, 1_000) == 500 * (2_000 - 300 - 100) // 50


def test_a_longer_control_period_speeds_the_program_up() -> None:
    speeds = [instructions_in(Costs(), period, 20, 1_000) for period in (1, 2, 4, 5, 10)]
    assert speeds == sorted(set(speeds))


def test_a_longer_scheduler_period_speeds_the_program_up() -> None:
    speeds = [instructions_in(Costs(), 2, period, 1_000) for period in (10, 20, 50, 100)]
    assert speeds == sorted(set(speeds))


def test_what_a_slice_ran_over_is_paid_off_in_the_next_ones() -> None:
    slices = Slices(Costs(instruction_us=50, control_us=0, scheduler_us=0), 1 * MS, 20 * MS)
    asked: list[int] = []

    def run(budget: int) -> int:
        asked.append(budget)
        return -25 if len(asked) == 1 else 0

    for _ in range(4):
        slices.give(run)
    assert asked == [20, 15, 20]  # the second slice was paid off completely, and a quarter of the third


def test_a_program_that_waits_saves_up_no_time() -> None:
    slices = Slices(Costs(instruction_us=50, control_us=0, scheduler_us=0), 1 * MS, 20 * MS)
    asked: list[int] = []

    def run(budget: int) -> int:
        asked.append(budget)
        return budget

    for _ in range(5):
        slices.give(run)
    assert asked == [20] * 5
