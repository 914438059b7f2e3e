"""Requests in general: their addressee, how often they are carried out, and what is left after a PC has gone."""

import re
import struct

import pytest
from arp_bench import CardBench
from arp_user_port import PortBench, an_object, bodies, frame
from doc_pages import page_named

from fieldrig_bus.serial.message import Format
from fieldrig_devices.arp.user_port.messages import Command, Status

HELLO, STATE, READ, WRITE_V, EVENTS, TRACE = 0x01, 0x02, 0x10, 0x12, 0x50, 0x51
ADD = "L:\nV1 += 1\nWAIT 0.1\nGOTO L"


@pytest.fixture
def bench() -> PortBench:
    return PortBench()


PAGE = page_named("arp-user-port.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"^\| `([<>])` \| `([0-9a-f ]+)` \|", PAGE, re.MULTILINE)


def test_the_examples_of_the_page_are_what_is_on_the_line(bench: PortBench) -> None:
    assert len(EXAMPLES) >= 10
    for way, text in EXAMPLES:
        wire = bytes.fromhex(text)
        assert [frame(body) for body in bodies(wire)] == [wire]  # checked again by RFC 1662
        if way == ">":
            bench.user.deliver(wire)
        else:
            assert bench.user.take() == [wire]


def test_the_tables_of_the_page_are_complete() -> None:
    commands = re.findall(r"^\| `([0-9A-F]{2})` \| ([A-Z_]+) \|", PAGE, re.MULTILINE)
    unsolicited = {"EVENT": 0xE0, "SAMPLES": 0xE1, "PROGRESS": 0xE2}
    assert {name: int(code, 16) for code, name in commands} == {
        command.name: command.value for command in Command
    } | unsolicited
    statuses = re.findall(r"^\| (\d) \| ([A-Z_]+) \|", PAGE, re.MULTILINE)
    assert {name: int(code) for code, name in statuses} == {status.name: status.value for status in Status}


@pytest.mark.parametrize("number", [0, 2, 99, 0xFE, 0xFF])
def test_requests_for_another_card_are_not_heard(bench: PortBench, number: int) -> None:
    assert bench.send(WRITE_V, bytes.fromhex("01 00 01 00 00 00"), number) == []
    assert bench.access.V[1] == 0


def test_hello_to_any_card_tells_the_number() -> None:
    bench = PortBench(number=37)
    [answer] = bench.send(HELLO, number=0xFF, sequence=0)
    assert answer == bytes.fromhex("01 25 00 81 00 25 00 01")


def test_hello_tells_the_name_of_the_program() -> None:
    assert PortBench("V1 == 1").ok(HELLO) == bytes.fromhex("01 00 01") + b"program"


def test_another_version_is_answered_with_ours(bench: PortBench) -> None:
    bench.user.deliver(frame(bytes.fromhex("02 01 07 02")))
    assert bench.heard() == [bytes.fromhex("01 01 07 82 01")]


def test_answers_of_a_card_are_no_requests(bench: PortBench) -> None:
    """Two cards, or an echo, on one line."""
    assert [bench.send(command) for command in (0x80, 0x82, 0xE0, 0xFF)] == [[]] * 4


def test_the_same_request_is_carried_out_once_and_answered_as_often_as_it_comes() -> None:
    bench = PortBench("L:\nGOTO L", is_enabled=True)
    stop = 0x04
    first = bench.send(stop, sequence=9)
    assert bench.send(stop, sequence=9) == first == [bytes.fromhex("01 01 09 84 00")]
    bench.access.run_program()
    assert bench.send(stop, sequence=9) == first
    assert bench.condition()[0] == 3  # RUN: it was not stopped again
    bench.send(stop, sequence=10)
    assert bench.condition()[0] == 4


@pytest.mark.long
def test_it_is_so_after_a_long_silence_too() -> None:
    bench = PortBench("L:\nGOTO L", is_enabled=True)
    first = bench.send(0x04, sequence=9)
    bench.run_for(20_000)
    bench.access.run_program()
    assert bench.send(0x04, sequence=9) == first
    assert bench.condition()[0] == 3


def test_another_request_with_the_same_number_is_another_request(bench: PortBench) -> None:
    bench.send(WRITE_V, bytes.fromhex("01 00 01 00 00 00"), sequence=5)
    bench.send(WRITE_V, bytes.fromhex("01 00 02 00 00 00"), sequence=5)
    assert bench.access.V[1] == 2


def test_number_0_is_carried_out_each_time(bench: PortBench) -> None:
    for value in (1, 2):
        bench.access.V[1] = value
        assert bench.send(READ, bytes.fromhex("56 01 00 01 00"), sequence=0) == [
            bytes.fromhex("01 01 00 90 00") + struct.pack("<i", value)
        ]


def test_a_new_pc_is_not_taken_for_the_last_one(bench: PortBench) -> None:
    request = bytes.fromhex("56 01 00 01 00")
    bench.send(READ, request, sequence=1)
    bench.access.V[1] = 5
    bench.send(HELLO, sequence=0)
    assert bench.send(READ, request, sequence=1)[0][5:] == struct.pack("<i", 5)


@pytest.mark.manual("ARP-045")
@pytest.mark.parametrize(
    ("enabled", "program", "does", "expected"),
    [
        (False, ADD, "", (1, 1, 105)),  # Enable open: the program is held
        (False, "", "", (1, 0, 105)),
        (True, ADD, "", (3, 2, 0)),
        (True, ADD, "reset", (2, 1, 0)),
        (True, ADD, "stop_program", (4, 3, 0)),
        (True, "V1 == 1", "", (4, 4, 0)),  # its END
        (True, "", "", (5, 0, 111)),  # no program: blocked
        (True, "BEG M\nCALL R\nEND\nBEG R\nCALL R\nEND", "", (5, 5, 112)),
    ],
)
def test_the_state_code_can_be_asked_for_in_every_state(
    enabled: bool, program: str, does: str, expected: tuple[int, ...]
) -> None:
    bench = PortBench(program, is_enabled=enabled)
    if does:
        getattr(bench.access, does)()
    assert bench.condition()[:3] == expected
    bench.ok(WRITE_V, bytes.fromhex("64 00 07 00 00 00"))  # and everything else works too
    assert bench.ok(READ, bytes.fromhex("56 64 00 01 00")) == bytes.fromhex("07 00 00 00")


def test_before_the_first_control_loop_the_state_is_init() -> None:
    bench = CardBench(ADD)
    bench.user.take()
    bench.user.deliver(frame(bytes.fromhex("01 01 01 02")))
    [answer] = bench.user.take()
    assert isinstance(answer, bytes)
    assert answer[5:7] == b"\x00\x00"  # OK, INIT


def test_a_pc_that_is_silent_for_ten_seconds_has_gone() -> None:
    bench = PortBench(ADD, is_enabled=True)
    bench.access.stop_program()
    data = an_object("V2 == 1")
    bench.ok(0x30, struct.pack("<II", len(data), 0))
    bench.ok(EVENTS, b"\x01")
    bench.ok(TRACE, bytes.fromhex("64 00 56 01 00"))
    bench.run_for(9_990)
    assert len(bench.heard()) > 90
    bench.run_for(20)
    bench.heard()
    bench.run_for(1_000)
    bench.access.run_program()
    bench.run_for(100)
    assert bench.heard() == []
    assert bench.ask(0x31, bytes(4) + data[:240])[0] == 6  # no download has begun


@pytest.mark.parametrize(("silent_ms", "is_reported"), [(10_000, True), (10_001, False)])
def test_the_ten_seconds_have_an_exact_end(silent_ms: int, is_reported: bool) -> None:
    bench = PortBench(ADD, is_enabled=True)
    bench.access.stop_program()
    bench.run_for(1)
    bench.ok(EVENTS, b"\x01")
    bench.run_for(silent_ms - 1)
    bench.heard()
    bench.access.run_program()
    bench.run_for(1)
    assert bool(bench.heard()) is is_reported


@pytest.mark.long
def test_a_pc_that_asks_now_and_then_is_there() -> None:
    bench = PortBench()
    bench.ok(0x30, struct.pack("<II", 10, 0))
    for _ in range(5):
        bench.run_for(9_000)
        bench.ok(STATE)
    bench.ok(0x31, bytes(4) + b"x")


def test_the_card_says_its_baud_rate_to_the_line() -> None:
    assert CardBench(user_port={"baud": 19_200}).user.sent[0] == Format(baud=19_200)
