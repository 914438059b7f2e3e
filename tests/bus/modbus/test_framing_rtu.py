"""RTU frames: Modbus over serial line V1.02, 2.5.1 and 6.2.2."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymodbus.framer import FramerRTU

from fieldrig.clock import MS, US
from fieldrig_bus.modbus.framing import LineTiming
from fieldrig_bus.modbus.framing_rtu import (
    FRAME_TIMEOUT_NS,
    RtuFramer,
    crc16,
    request_size,
    response_size,
    rtu_frame,
    split,
)

SLOW = LineTiming(baud=9600)  # a character takes 11 bits: 1.145 ms
CHARACTER_NS = SLOW.characters_ns(1)
READ = bytes.fromhex("11 03 006B 0003 7687")  # a well-known example of function 3
WRITE = bytes.fromhex("11 06 0001 0003 9A9B")
T0 = 1_000 * MS


def taken(framer: RtuFramer, now_ns: int = 10**15) -> list[tuple[int, bytes]]:
    return framer.take(now_ns)


def pdu(frame: bytes) -> tuple[int, bytes]:
    return frame[0], frame[1:-2]


@pytest.mark.parametrize(
    ("data", "crc"),
    [("0207", 0x1241), ("", 0xFFFF), ("313233343536373839", 0x4B37), ("1103006B0003", 0x8776), ("01", 0x807E)],
)
def test_the_crc_is_the_published_one(data: str, crc: int) -> None:
    """02 07 is the example of V1.02, 6.2.2; 4B37 the check value of CRC-16/MODBUS."""
    assert crc16(bytes.fromhex(data)) == crc


@given(st.binary(max_size=256))
def test_the_crc_is_that_of_pymodbus(data: bytes) -> None:
    assert crc16(data).to_bytes(2, "little") == FramerRTU.compute_CRC(data).to_bytes(2, "big")


def test_a_frame_to_send_has_its_crc_low_byte_first() -> None:
    assert rtu_frame(0x11, READ[1:-2]) == READ


def test_a_frame_is_whole_after_three_and_a_half_characters() -> None:
    framer = RtuFramer(SLOW)
    framer.feed(T0, READ)
    end_ns = T0 + SLOW.frame_ns(5) + SLOW.silence_ns
    assert framer.next_ns() == end_ns
    assert taken(framer, end_ns - 1) == []
    assert taken(framer, end_ns) == [pdu(READ)]
    assert framer.next_ns() is None
    assert (framer.messages, framer.errors) == (1, 0)


def test_above_19200_baud_the_silences_are_fixed() -> None:
    fast = LineTiming(baud=115200)
    assert (fast.gap_ns, fast.silence_ns) == (750 * US, 1750 * US)
    slow = LineTiming(baud=19200)
    assert (slow.gap_ns, slow.silence_ns) == (859_375, 2_005_208)


@pytest.mark.parametrize(("characters", "is_whole"), [(1.4, True), (1.6, False), (3.4, False), (3.6, False)])
def test_a_gap_of_one_and_a_half_characters_spoils_a_frame(characters: float, is_whole: bool) -> None:
    framer = RtuFramer(SLOW)
    framer.feed(T0, READ[:3])
    framer.feed(T0 + 3 * CHARACTER_NS + SLOW.characters_ns(characters), READ[3:])
    assert taken(framer) == ([pdu(READ)] if is_whole else [])
    assert framer.errors == {1.4: 0, 1.6: 1, 3.4: 1, 3.6: 2}[characters]


def test_after_a_spoilt_frame_the_next_is_heard() -> None:
    framer = RtuFramer(SLOW)
    framer.feed(T0, READ[:3])
    framer.feed(T0 + 100 * MS, WRITE)
    assert taken(framer) == [pdu(WRITE)]
    assert (framer.messages, framer.errors) == (1, 1)


def test_on_a_real_port_characters_have_arrived_when_they_are_read() -> None:
    framer = RtuFramer(SLOW, is_burst=False)
    for position, byte in enumerate(READ):
        framer.feed(T0 + position * CHARACTER_NS, bytes((byte,)))
    assert taken(framer, T0 + 7 * CHARACTER_NS + SLOW.silence_ns) == [pdu(READ)]


def test_a_wrong_crc_is_silence_and_counted() -> None:
    framer = RtuFramer(SLOW)
    framer.feed(T0, READ[:-1] + b"\x00")
    assert taken(framer) == []
    assert (framer.messages, framer.errors) == (0, 1)


@pytest.mark.parametrize("data", [b"\x11", b"\x11\x03", b"\x11\x03\x00", bytes(257)])
def test_what_is_too_short_or_too_long_is_no_frame(data: bytes) -> None:
    framer = RtuFramer(SLOW)
    framer.feed(T0, data)
    assert taken(framer) == []
    assert framer.errors == 1


def test_strict_takes_requests_without_a_silence_between_them_as_one_damaged_frame() -> None:
    framer = RtuFramer(SLOW)
    framer.feed(T0, READ + WRITE)
    assert taken(framer) == []
    assert (framer.messages, framer.errors) == (0, 1)  # V1.02, 2.5.1.1: 3.5 characters separate two frames
    framer.feed(T0 + 100 * MS, READ)
    assert taken(framer) == [pdu(READ)]


def test_tolerant_separates_requests_that_were_read_together() -> None:
    framer = RtuFramer(SLOW, is_strict=False)
    framer.feed(T0, READ + WRITE)
    framer.feed(T0, READ)
    assert taken(framer) == [pdu(READ), pdu(WRITE), pdu(READ)]


def test_tolerant_takes_a_frame_in_pieces_when_its_crc_is_right() -> None:
    framer = RtuFramer(SLOW, is_strict=False)
    framer.feed(T0, READ[:3])
    assert taken(framer, T0 + 20 * MS) == []
    framer.feed(T0 + 20 * MS, READ[3:])
    assert taken(framer, T0 + 40 * MS) == [pdu(READ)]
    assert framer.errors == 0


def test_tolerant_gives_a_piece_up_in_the_end() -> None:
    framer = RtuFramer(SLOW, is_strict=False)
    framer.feed(T0, READ[:3])
    assert taken(framer, T0 + 20 * MS) == []
    wish_ns = framer.next_ns()
    assert wish_ns == T0 + SLOW.characters_ns(3) + FRAME_TIMEOUT_NS
    assert taken(framer, wish_ns) == []
    assert framer.errors == 1
    framer.feed(T0 + 100 * MS, WRITE)
    assert taken(framer) == [pdu(WRITE)]


def test_tolerant_waits_for_the_rest_of_a_frame_up_to_its_timeout() -> None:
    framer = RtuFramer(SLOW, is_strict=False, frame_timeout_ns=300 * MS)
    framer.feed(T0, READ[:3])
    framer.take(T0 + 20 * MS)
    assert framer.next_ns() == T0 + SLOW.characters_ns(3) + 300 * MS
    framer.feed(T0 + 280 * MS, READ[3:])
    assert taken(framer, T0 + 300 * MS) == [pdu(READ)]


def test_tolerant_hears_the_next_frame_behind_a_piece() -> None:
    framer = RtuFramer(SLOW, is_strict=False)
    framer.feed(T0, READ[:3])
    assert taken(framer, T0 + 10 * MS) == []
    framer.feed(T0 + 20 * MS, WRITE)
    assert taken(framer, T0 + 40 * MS) == [pdu(WRITE)]
    assert (framer.messages, framer.errors) == (1, 1)


@pytest.mark.parametrize(
    "request_hex",
    [
        "11 01 0013 0025",
        "11 05 00AC FF00",
        "11 07",
        "11 08 0000 A537",
        "11 0F 0013 000A 02 CD01",
        "11 10 0001 0002 04 000A 0102",
        "11 11",
        "11 16 0004 00F2 0025",
        "11 17 0003 0006 000E 0003 06 00FF 00FF 00FF",
        "11 18 04DE",
        "11 2B 0E 01 00",
    ],
)
def test_a_request_tells_its_size(request_hex: str) -> None:
    body = bytes.fromhex(request_hex)
    frame = body + FramerRTU.compute_CRC(body).to_bytes(2, "big")
    assert request_size(frame) == len(frame)
    assert split(frame) == [frame]


frames = st.builds(lambda unit, pdu: (unit, pdu), st.integers(0, 255), st.binary(min_size=1, max_size=253))


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.lists(frames, max_size=4), st.lists(st.integers(1, 40), max_size=30), st.booleans())
def test_frames_arrive_however_their_bytes_are_cut(
    sent: list[tuple[int, bytes]], cuts: list[int], is_strict: bool
) -> None:
    framer, now_ns, heard = RtuFramer(SLOW, is_strict), T0, []
    sizes = iter(cuts)
    for unit, body in sent:
        data = rtu_frame(unit, body)
        while data:
            size = next(sizes, len(data))
            framer.feed(now_ns, data[:size])
            now_ns += SLOW.characters_ns(min(size, len(data)))
            data = data[size:]
        now_ns += SLOW.silence_ns
        heard += framer.take(now_ns)
    assert heard == sent
    assert framer.messages == len(sent)


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 100 * MS), st.binary(max_size=600))), st.booleans(), st.booleans())
def test_garbage_never_raises_and_ends(chunks: list[tuple[int, bytes]], is_strict: bool, is_burst: bool) -> None:
    framer, now_ns = RtuFramer(SLOW, is_strict, is_burst), T0
    for pause_ns, data in chunks:
        now_ns += pause_ns
        framer.feed(now_ns, data)
        framer.take(now_ns)
    for _ in range(3):
        wish_ns = framer.next_ns()
        if wish_ns is None:
            break
        framer.take(wish_ns)
    assert framer.next_ns() is None


# V1.1b3, chapter 6: PDUs of responses, a CRC and a unit make them three bytes longer.
RESPONSES = [
    "01 03 CD6B05", "02 03 ACDB35", "03 06 022B 0000 0064", "04 02 000A", "05 00AC FF00", "06 0001 0003", "07 6D",
    "08 0000 A537", "0B FFFF 0108", "0C 08 0000 0108 0121 20 00", "0F 0013 000A", "10 0001 0002", "11 03 2A FF 31",
    "16 0004 00F2 0025", "17 0C 00FE 0ACD 0001 0003 000D 00FF", "18 0006 0002 01B8 1284", "83 02",
    "2B 0E 01 01 00 00 03 00 16 436F6D70616E79206964656E74696669636174696F6E 01 04 434F4445 02 00",
    "2B 0E 04 81 00 00 01 06 03 4D4544",
]  # fmt: skip


@pytest.mark.parametrize("response", RESPONSES)
def test_a_response_says_how_long_it_is(response: str) -> None:
    frame = rtu_frame(7, bytes.fromhex(response))
    assert response_size(frame) == len(frame)
    assert all(response_size(frame[:end]) in (None, len(frame)) for end in range(len(frame)))


def test_a_response_of_unknown_length_is_none() -> None:
    assert response_size(bytes.fromhex("07 2B 0E 01")) is None
    assert response_size(b"") is None


@pytest.mark.parametrize("late", RESPONSES)
def test_responses_that_were_read_together_are_separated(late: str) -> None:
    framer = RtuFramer(SLOW, is_strict=False, size_of=response_size)
    right = bytes.fromhex("03 02 0001")
    framer.feed(T0, rtu_frame(7, bytes.fromhex(late)) + rtu_frame(7, right))
    assert taken(framer) == [(7, bytes.fromhex(late)), (7, right)]


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.lists(st.binary(max_size=40) | st.sampled_from(RESPONSES).map(bytes.fromhex).map(lambda p: rtu_frame(7, p))))
def test_any_bytes_make_frames_or_none(pieces: list[bytes]) -> None:
    framer = RtuFramer(SLOW, is_strict=False, size_of=response_size)
    for number, piece in enumerate(pieces):
        framer.feed(T0 + number * MS, piece)
        framer.take(T0 + number * MS)
    assert all(0 <= unit <= 255 and 1 <= len(pdu) <= 253 for unit, pdu in taken(framer))
    assert framer.next_ns() is None
