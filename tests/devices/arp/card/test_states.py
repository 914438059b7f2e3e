"""The states of a card: every pair of state and event, and the behaviour in each state (digest 10.1, 10.2)."""

from collections.abc import Callable

import pytest
from arp_bench import CardBench

from fieldrig_devices.arp import card_errors as codes
from fieldrig_devices.arp.card.states import NEXT_STATE, Event, States
from fieldrig_devices.arp.card_access import CardState
from fieldrig_devices.arp.runtime.program import ProgramState

INIT, RESET_ENABLE, RESET_COMMAND = CardState.INIT, CardState.RESET_ENABLE, CardState.RESET_COMMAND
RUN, STOPPED, BLOCKED = CardState.RUN, CardState.STOPPED, CardState.BLOCKED

LOOP = "SET O101\nDAC 1, 5\nLOOP:\nV1 += 1\nGOTO LOOP"
AXES = {"axis1": {4: 1, 7: 1000, 8: 10_000}, "axis2": {4: 1}}

# Digest 10.1 in another layout: rows are states, columns are events; a dot is "nothing changes".
TABLE = """
                 OPENED         CLOSED   RESET           STARTED   STOPPED   ENDED     FAILED
INIT             RESET_ENABLE   RUN      .               .         .         .         BLOCKED
RESET_ENABLE     .              RUN      .               .         .         .         BLOCKED
RESET_COMMAND    RESET_ENABLE   .        .               RUN       .         .         BLOCKED
RUN              RESET_ENABLE   .        RESET_COMMAND   .         STOPPED   STOPPED   BLOCKED
STOPPED          RESET_ENABLE   .        RESET_COMMAND   RUN       .         .         BLOCKED
BLOCKED          RESET_ENABLE   RUN      RESET_COMMAND   .         .         .         .
"""
_HEAD, *_ROWS = [line.split() for line in TABLE.strip().splitlines()]
CELLS = [(row[0], event, after) for row in _ROWS for event, after in zip(_HEAD, row[1:], strict=True)]


@pytest.mark.parametrize(("before", "event", "after"), CELLS)
def test_each_event_leads_where_the_digest_says(before: str, event: str, after: str) -> None:
    seen: list[tuple[CardState, CardState]] = []
    states = States(lambda old, new: seen.append((old, new)))
    states.state = CardState[before]
    is_change = after != "."
    assert states.handle(Event[event]) is is_change
    assert states.state is (CardState[after] if is_change else CardState[before])
    assert seen == ([(CardState[before], CardState[after])] if is_change else [])


def test_the_table_has_nothing_else() -> None:
    assert len(NEXT_STATE) == sum(after != "." for _, _, after in CELLS)


# ---- ways into each state on a whole card


def running(program: str = LOOP) -> CardBench:
    return CardBench(program, AXES).run_for(100)


def disabled() -> CardBench:
    return running().drive("I108", False).run_for(10)


def at_reset() -> CardBench:
    bench = running()
    bench.access.reset()
    return bench


def stopped() -> CardBench:
    bench = running()
    assert bench.access.stop_program()
    return bench


def without_program() -> CardBench:
    return CardBench().run_for(20)


WAYS: dict[CardState, Callable[[], CardBench]] = {
    RUN: running,
    RESET_ENABLE: disabled,
    RESET_COMMAND: at_reset,
    STOPPED: stopped,
    BLOCKED: without_program,
}


@pytest.mark.parametrize("state", WAYS)
def test_each_state_can_be_reached_and_left_by_enable(state: CardState) -> None:
    bench = WAYS[state]()
    assert bench.state is state
    bench.drive("I108", False).run_for(10)
    assert (bench.state, bench.error) == (RESET_ENABLE, codes.RESET)
    bench.drive("I108", True).run_for(10)
    assert bench.state is (BLOCKED if state is BLOCKED else RUN)  # still without a program


@pytest.mark.manual("ARP-041", "ARP-122")
@pytest.mark.parametrize("state", [RESET_ENABLE, RESET_COMMAND, BLOCKED])
def test_a_card_that_is_held_has_its_outputs_at_0(state: CardState) -> None:
    bench = running()
    assert (bench.last_sent("O101"), bench.last_sent("dac1")) == (True, 5.0)
    for number in (102, 132, 201, 232, 301, 332):
        assert bench.access.set_output(number, 1)
    if state is BLOCKED:
        bench.access.errors.fail(codes.STACK)
    elif state is RESET_ENABLE:
        bench.drive("I108", False)
    else:
        bench.access.reset()
    bench.run_for(11)
    assert bench.state is state
    assert (bench.last_sent("O101"), bench.last_sent("dac1")) == (False, 0.0)
    assert not any(bench.access.O)
    assert not bench.access.set_output(101, 1)


@pytest.mark.manual("ARP-041")
def test_a_card_without_enable_holds_its_program_at_the_first_instruction() -> None:
    bench = disabled()
    count = bench.variable(1)
    bench.run_for(100)
    assert bench.variable(1) == count
    assert bench.access.program is not None
    assert bench.access.program.state is ProgramState.HELD
    assert bench.line == 2  # the line after BEG


@pytest.mark.manual("ARP-043", "ARP-049")
def test_closing_enable_clears_errors_and_restores_the_initial_state() -> None:
    bench = running("IF V2 = 1, LOOP\nV1 == 1 / V2\n@PAR1[7] == 55\nSET F1\nSET O110\nPST 1, 2, V10\nLOOP:\nGOTO LOOP")
    assert (bench.error, bench.warning) == (codes.PARAMETERS, 201)
    bench.put_variable(2, 1)
    bench.drive("I108", False).run_for(10)
    assert bench.warning == 201  # opening alone clears nothing
    bench.drive("I108", True).run_for(10)
    assert (bench.state, bench.error, bench.warning) == (RUN, 0, 0)
    assert bench.access.parameters.ram[1][7] == 1_000_000
    assert not bench.access.F[1]
    assert not bench.access.O[110]


@pytest.mark.manual("ARP-044", "ARP-049")
def test_ctrl_f2_resets_without_an_error() -> None:
    bench = running("V1 == 1 / V2\nSET O101\nLOOP:\nGOTO LOOP")
    assert bench.warning == 201
    bench.access.reset()
    assert (bench.state, bench.error, bench.warning) == (RESET_COMMAND, 0, 0)
    bench.run_for(100)
    assert bench.state is RESET_COMMAND  # until a user runs the program
    assert bench.access.run_program()
    assert bench.state is RUN


@pytest.mark.manual("ARP-044")
def test_ctrl_f2_ends_a_blocking_error() -> None:
    bench = without_program()
    bench.access.reset()
    assert (bench.state, bench.error) == (RESET_COMMAND, 0)


@pytest.mark.manual("ARP-016")
@pytest.mark.parametrize("period_ms", [10, 37, 100])
def test_enable_is_looked_at_once_a_scheduler_period_and_no_more(period_ms: int) -> None:
    bench = CardBench(LOOP, {"general": {16: period_ms}}, is_enabled=False).run_for(period_ms)
    for is_enabled in (True, False, True, False):
        before, after = (RESET_ENABLE, RUN) if is_enabled else (RUN, RESET_ENABLE)
        bench.drive("I108", is_enabled)
        assert bench.run_for(period_ms - 0.001).state is before
        assert bench.run_for(0.001).state is after


@pytest.mark.manual("ARP-016", "ARP-042")
@pytest.mark.parametrize("period_ms", [10, 40, 100])
def test_a20_a_drop_of_enable_in_motion_is_seen_within_the_scheduler_period(period_ms: int) -> None:
    bench = CardBench("SET O101\nPAC 1, 1000\nLOOP:\nGOTO LOOP", {**AXES, "general": {16: period_ms}})
    bench.run_for(period_ms + 0.5)
    assert bench.state is RUN
    bench.run_for(period_ms - 1)
    bench.drive("I108", False)
    fell_ns = bench.clock.now_ns()
    while bench.last_sent("O101"):
        bench.run_for(1)
    assert bench.clock.now_ns() - fell_ns <= (period_ms + 1) * 1_000_000
    stood_at = bench.position(1)
    assert 0 < stood_at < 1000
    bench.run_for(500)
    assert bench.position(1) == stood_at  # a simulated axis does not coast
    assert bench.access.program is not None
    assert bench.access.program.state is ProgramState.HELD


@pytest.mark.manual("ARP-042")
def test_a20_a_real_axis_coasts_and_is_read_on() -> None:
    bench = CardBench("LOOP:\nGOTO LOOP", {"axis1": {4: 2, 1: 10, 11: 1, 14: 100}}).drive("encoder1", 0).run_for(50)
    for counts in range(0, 500, 100):
        bench.drive("encoder1", counts).run_for(1)
    assert bench.last_sent("dac1") == -10.0  # 50 units pushed away, KP 1
    bench.drive("I108", False).run_for(11)
    assert bench.last_sent("dac1") == 0.0
    bench.drive("encoder1", 2_000).run_for(2)
    assert (bench.position(1), bench.last_sent("dac1")) == (200.0, 0.0)
    bench.drive("I108", True).run_for(12)
    assert (bench.position(1), bench.last_sent("dac1")) == (200.0, 0.0)  # under control at its position


def test_a_short_drop_of_enable_between_two_passes_is_not_seen() -> None:
    bench = running().run_for(1)
    bench.drive("I108", False).run_for(3).drive("I108", True).run_for(20)
    assert bench.state is RUN


@pytest.mark.manual("ARP-041")
def test_power_on_without_enable_waits_for_it() -> None:
    bench = CardBench(LOOP, is_enabled=False)
    assert (bench.state, bench.last_sent("O101"), bench.last_sent("dac1")) == (INIT, False, 0.0)
    bench.run_for(10)
    assert (bench.state, bench.error) == (RESET_ENABLE, codes.RESET)
    bench.drive("I108", True).run_for(10)
    assert (bench.state, bench.error) == (RUN, 0)


@pytest.mark.long
@pytest.mark.manual("ARP-050")
def test_e05_stays_as_long_as_enable_is_low() -> None:
    bench = CardBench(LOOP, is_enabled=False, with_can=True, io_nodes=[1], terminal=True).run_for(10)
    errors = {bench.run_for(10).error for _ in range(300)}  # terminal and I/O node are missing
    assert errors == {codes.RESET}
    bench.drive("I108", True).run_for(20)
    assert (bench.state, bench.error) == (RUN, codes.CAN)


def test_at_its_end_the_main_program_leaves_outputs_as_they_are() -> None:
    bench = running("SET O101\nDAC 1, 5\nPAC 1, 100")
    assert (bench.state, bench.error) == (STOPPED, 0)
    bench.run_for(1_000)
    assert (bench.last_sent("O101"), bench.last_sent("dac1"), bench.position(1)) == (True, 5.0, 100.0)
    assert bench.access.set_output(102, 1)
    bench.run_for(2)
    assert bench.last_sent("O102") is True


def test_a_stopped_program_runs_again_from_its_first_instruction() -> None:
    bench = running("V1 += 1\nLOOP:\nV2 += 1\nGOTO LOOP")
    bench.access.stop_program()
    bench.run_for(100)
    assert bench.variable(1) == 1
    assert bench.access.run_program()
    bench.run_for(5)
    assert bench.variable(1) == 2


def test_run_goes_on_after_a_pause() -> None:
    bench = running("V1 += 1\nLOOP:\nV2 += 1\nGOTO LOOP")
    assert bench.access.program is not None
    bench.access.program.pause()
    count = bench.run_for(20).variable(2)
    assert bench.access.run_program()
    assert bench.run_for(20).variable(2) > count
    assert bench.variable(1) == 1


@pytest.mark.parametrize("state", [RUN, RESET_ENABLE, BLOCKED])
def test_run_means_nothing_where_there_is_nothing_to_run(state: CardState) -> None:
    bench = WAYS[state]()
    assert not bench.access.run_program()
    assert bench.state is state


@pytest.mark.manual("ARP-050", "ARP-117")
def test_a_card_without_a_program_is_blocked_with_e11() -> None:
    bench = without_program()
    assert (bench.state, bench.error) == (BLOCKED, 111)


@pytest.mark.manual("ARP-050")
def test_the_11th_call_blocks_with_e12_and_shows_where() -> None:
    bench = CardBench("BEG M\nCALL A\nEND\nBEG A\nSET O101\nV1 += 1\nIF V1 < 11, CALL B\nEND\nBEG B\nCALL A\nEND")
    bench.run_for(30)
    assert (bench.state, bench.error) == (BLOCKED, 112)
    assert not any(bench.access.O)
    assert bench.access.program is not None
    assert bench.access.program.state is ProgramState.FAILED
    assert len(bench.access.program.calls) == 10


@pytest.mark.manual("ARP-046")
def test_an_error_that_does_not_block_leaves_the_program_running() -> None:
    bench = running("SET O101\nPST 1, 2, V10\nLOOP:\nV2 += 1\nV3 == ERROR\nGOTO LOOP")
    count = bench.variable(2)
    bench.run_for(10)
    assert (bench.state, bench.error, bench.variable(3)) == (RUN, 113, 113)
    assert bench.variable(2) > count
    assert bench.last_sent("O101") is True


@pytest.mark.manual("ARP-047", "ARP-048", "ARP-051")
@pytest.mark.parametrize(
    ("instruction", "code"),
    [("V1 == 1 / V2", 201), ("V1 == 999999 * 2", 202), ("VEL 1, 101", 203), ("@PAR1[4] == 7", 203), ("V2 == 0", 0)],
)
def test_a_warning_is_read_by_the_program_which_goes_on(instruction: str, code: int) -> None:
    bench = CardBench(f"{instruction}\nV10 == WARNING\nV11 == ERROR\nV12 == WARNING", is_enabled=False).run_for(10)
    bench.drive("I108", True).run_for(20)  # W04 of the first start is cleared
    assert (bench.variable(10), bench.variable(11), bench.variable(12)) == (code, 0, code)


@pytest.mark.manual("ARP-048")
def test_the_program_reads_the_most_recent_codes() -> None:
    bench = running("V1 == 1 / V9\nV2 == WARNING\nVEL 1, 101\nV3 == WARNING\nPST 1, 2, V20\nV4 == ERROR")
    assert [bench.variable(number) for number in (2, 3, 4)] == [201, 203, 113]
