"""Debugging through the USER port: breakpoints, pause, step, place, and events for changes."""

import struct
from itertools import pairwise

import pytest
from arp_user_port import PortBench, an_object

LENGTH, REFUSED, NO_PROGRAM = 3, 5, 9
RUN, STOP, SET, GET, PAUSE, STEP, PLACE, EVENTS = 0x03, 0x04, 0x40, 0x41, 0x42, 0x43, 0x44, 0x50
RUNNING, PAUSED = 2, 3
PROGRAM = """\
BEG MAIN
L:
V1 += 1
CALL SUB
WAIT 0.01
GOTO L
END
BEG SUB
V2 += 1
END"""


def lines(*numbers: int) -> bytes:
    return struct.pack(f"<{len(numbers)}I", *numbers)


@pytest.fixture
def bench() -> PortBench:
    return PortBench(PROGRAM, is_enabled=True)


def test_breakpoints_stop_in_front_of_their_lines_and_run_goes_on(bench: PortBench) -> None:
    assert bench.ok(SET, lines(9, 1, 500)) == lines(9)
    assert bench.ok(GET) == lines(9)
    bench.run_for(20)
    assert bench.condition()[:2] == (3, PAUSED)
    assert bench.condition()[5:] == (9, 1)
    assert bench.ok(PLACE) == lines(9, 5)
    count = bench.access.V[2]
    bench.ok(RUN)
    bench.run_for(30)
    assert (bench.access.V[2], bench.ok(PLACE)) == (count + 1_000, lines(9, 5))
    bench.ok(SET)
    bench.ok(RUN)
    bench.run_for(30)
    assert bench.condition()[:2] == (3, RUNNING)


def test_pause_and_single_steps(bench: PortBench) -> None:
    bench.ok(SET, lines(3))
    bench.run_for(20)
    bench.ok(SET)
    places = [bench.ok(PLACE)]
    for _ in range(5):
        bench.ok(STEP)
        places.append(bench.ok(PLACE))
    assert places == [lines(3), lines(4), lines(9, 5), lines(10, 5), lines(5), lines(6)]
    bench.ok(RUN)
    bench.ok(PAUSE)
    assert bench.condition()[1] == PAUSED


def test_what_needs_a_pause_or_a_program_is_refused_without(bench: PortBench) -> None:
    assert bench.ask(STEP)[0] == REFUSED
    bench.ok(STOP)
    assert bench.ask(PAUSE)[0] == REFUSED
    assert bench.ask(STEP)[0] == REFUSED
    empty = PortBench()
    assert [empty.ask(command)[0] for command in (SET, GET, PAUSE, STEP, PLACE)] == [NO_PROGRAM] * 5
    assert bench.ask(SET, b"\x01")[0] == LENGTH
    assert bench.ask(SET, lines(*range(61)))[0] == LENGTH


def test_breakpoints_of_the_old_program_go_with_it(bench: PortBench) -> None:
    bench.ok(SET, lines(3))
    bench.ok(STOP)
    bench.downloaded(an_object(PROGRAM))
    assert bench.ok(GET) == b""


# ---- events


def events(bench: PortBench) -> list[tuple[int, int, int]]:
    """State, program and line of each event; the sequence numbers must be consecutive."""
    heard = bench.heard()
    assert all(body[:2] + body[3:4] == bytes((1, 1, 0xE0)) for body in heard)
    numbers = [body[2] for body in heard]
    assert all((before + 1) & 0xFF == after for before, after in pairwise(numbers))
    return [(body[4], body[5], struct.unpack_from("<I", body, 11)[0]) for body in heard]


def test_nothing_is_sent_unless_requested(bench: PortBench) -> None:
    bench.ok(0x02)
    bench.access.stop_program()
    bench.run_for(100)
    assert bench.heard() == []


def test_breakpoints_and_states_are_reported_at_once(bench: PortBench) -> None:
    bench.ok(EVENTS, b"\x01")
    bench.run_for(30)
    assert [event[:2] for event in events(bench)] == [(3, RUNNING)]  # the state at the beginning
    bench.ok(SET, lines(9))
    bench.run_for(30)
    assert events(bench) == [(3, PAUSED, 9)]
    bench.enable(False)
    bench.run_for(30)
    assert events(bench) == [(1, 1, 3)]
    bench.ok(EVENTS, b"\x00")
    bench.enable()
    assert events(bench) == []


def test_a_program_that_stops_at_once_again_is_reported(bench: PortBench) -> None:
    bench.ok(EVENTS, b"\x01")
    bench.ok(SET, lines(3, 4))
    bench.run_for(50)
    events(bench)
    bench.ok(RUN)  # from 3 to 4, in the next slice
    bench.run_for(50)
    assert events(bench)[-1] == (3, PAUSED, 4)
    for place in (9, 10):  # a step is over at once
        bench.ok(STEP)
        bench.run_for(30)
        assert events(bench)[-1] == (3, PAUSED, place)


def test_errors_are_reported() -> None:
    bench = PortBench("L:\nIF V9 = 0, L\nV1 == 1 / 0\nV8 == 1\nM:\nGOTO M", is_enabled=True)
    bench.ok(EVENTS, b"\x01")
    bench.run_for(20)
    bench.heard()
    bench.access.set_variables(9, [1])
    bench.run_for(20)
    [event] = bench.heard()
    assert struct.unpack_from("<H", event, 9) == (201,)  # the warning


@pytest.mark.parametrize("switch", [b"", b"\x02", b"\x01\x01"])
def test_a_switch_is_0_or_1(bench: PortBench, switch: bytes) -> None:
    assert bench.ask(EVENTS, switch)[0] in (LENGTH, 4)
