"""ASCII frames: Modbus over serial line V1.02, 2.5.2 and 6.2.1."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymodbus.framer import FramerAscii

from fieldrig.clock import MS, S
from fieldrig_bus.modbus.framing import LineTiming
from fieldrig_bus.modbus.framing_ascii import AsciiFramer, ascii_frame, lrc

TIMING = LineTiming("ascii", 9600, 10)
READ = b":1103006B00037E\r\n"
READ_PDU = (0x11, bytes.fromhex("03 006B 0003"))
T0 = 1_000 * MS


def heard(*chunks: bytes, pause_ns: int = 0) -> tuple[list[tuple[int, bytes]], int]:
    framer, now_ns = AsciiFramer(TIMING, is_burst=False), T0
    frames = []
    for chunk in chunks:
        framer.feed(now_ns, chunk)
        frames += framer.take(now_ns)
        now_ns += pause_ns
    return frames, framer.errors


def test_a_frame_runs_from_colon_to_line_feed() -> None:
    assert heard(READ) == ([READ_PDU], 0)
    assert ascii_frame(*READ_PDU) == READ


def test_a_frame_has_ended_when_its_characters_would_have() -> None:
    framer = AsciiFramer(TIMING)
    framer.feed(T0, READ)
    end_ns = T0 + TIMING.frame_ns(5)
    assert framer.next_ns() == end_ns == T0 + TIMING.characters_ns(17)
    assert framer.take(end_ns - 1) == []
    assert framer.take(end_ns) == [READ_PDU]
    assert framer.next_ns() is None


@pytest.mark.parametrize(
    ("data", "errors"),
    [
        (b":1103006B00037F\r\n", 1),  # LRC
        (b":1103006B00037\r\n", 1),  # half a byte is missing
        (b":1103006b00037e\r\n", 1),  # digits are 0 to 9 and A to F
        (b":1103 06B00037E\r\n", 1),
        (b":1103006B00037E\n", 1),  # CR is missing
        (b":1103006B00037E\rX", 1),
        (b":11EF\r\n", 1),  # a unit without a function
        (b":\r\n", 1),
        (b"1103006B00037E\r\n", 0),  # nothing was sent
        (b":" + 512 * b"0" + b"\r\n", 1),
    ],
)
def test_what_is_no_frame_is_silence(data: bytes, errors: int) -> None:
    assert heard(data) == ([], errors)


def test_after_what_is_no_frame_the_next_is_heard() -> None:
    assert heard(b"garbage\xff:11:" + READ + READ) == ([READ_PDU, READ_PDU], 2)


def test_a_colon_begins_anew() -> None:
    assert heard(b":110300" + READ) == ([READ_PDU], 1)


@pytest.mark.parametrize(("pause_ns", "frames"), [(1 * S, [READ_PDU]), (1 * S + 1, [])])
def test_characters_may_be_a_second_apart(pause_ns: int, frames: list[tuple[int, bytes]]) -> None:
    assert heard(READ[:5], READ[5:], pause_ns=pause_ns) == (frames, 0 if frames else 1)


def test_a_frame_that_stops_is_given_up_in_time() -> None:
    framer = AsciiFramer(TIMING)
    framer.feed(T0, READ[:5])
    wish_ns = framer.next_ns()
    assert wish_ns == T0 + TIMING.characters_ns(5) + 1 * S + 1
    assert framer.take(wish_ns) == []
    assert framer.errors == 1
    assert framer.next_ns() is None


def test_another_delimiter_takes_the_place_of_line_feed() -> None:
    framer = AsciiFramer(TIMING, is_burst=False)
    framer.delimiter = ord("!")
    framer.feed(T0, READ + READ.replace(b"\n", b"!"))
    assert framer.take(T0) == [READ_PDU]
    assert framer.frame(*READ_PDU) == b":1103006B00037E\r!"


@given(st.binary(min_size=1, max_size=255))
def test_the_lrc_is_that_of_pymodbus(data: bytes) -> None:
    assert lrc(data) == FramerAscii.compute_LRC(data)


frames = st.lists(st.tuples(st.integers(0, 255), st.binary(min_size=1, max_size=253)), max_size=4)


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(frames, st.lists(st.integers(1, 60)))
def test_frames_arrive_however_their_bytes_are_cut(sent: list[tuple[int, bytes]], cuts: list[int]) -> None:
    framer, data = AsciiFramer(TIMING, is_burst=False), b"".join(ascii_frame(unit, pdu) for unit, pdu in sent)
    got: list[tuple[int, bytes]] = []
    for size in [*cuts, len(data)]:
        framer.feed(T0, data[:size])
        got += framer.take(T0)
        data = data[size:]
    assert got == sent


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 2 * S), st.text(":0123456789ABCDEFabc\r\n", max_size=50))))
def test_garbage_never_raises(chunks: list[tuple[int, str]]) -> None:
    framer, now_ns = AsciiFramer(TIMING), T0
    for pause_ns, text in chunks:
        now_ns += pause_ns
        framer.feed(now_ns, text.encode())
        framer.take(now_ns)


def test_frames_that_are_read_ahead_of_the_line_are_counted() -> None:
    framer = AsciiFramer(TIMING)
    framer.feed(0, READ * 20)
    assert framer.ahead(0) == 20
    framer.take(TIMING.characters_ns(5 * len(READ)))
    assert framer.ahead(0) == 15


def test_characters_that_are_no_frame_are_ahead_of_the_line_as_well() -> None:
    framer = AsciiFramer(TIMING)
    framer.feed(0, b"x" * 5100)
    assert framer.ahead(0) == 10
    assert framer.ahead(TIMING.characters_ns(5100)) == 0


def test_the_rest_of_a_frame_that_was_read_ahead_may_come_when_the_line_is_there() -> None:
    framer = AsciiFramer(TIMING)
    framer.feed(0, b"x" * 10_000 + READ[:5])
    now_ns = TIMING.characters_ns(10_000)
    assert now_ns > S
    framer.feed(now_ns, READ[5:])
    assert len(framer.take(now_ns + S)) == 1
