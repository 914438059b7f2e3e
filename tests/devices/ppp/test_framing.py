"""Frames against RFC 1662 and against lines recorded between two pppd 2.4.9 on Linux."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ppp_bench import check_sequence, content_of

from fieldrig_devices.ppp.framing import (
    ALL_CONTROLS,
    LONGEST,
    Deframer,
    FrameCounts,
    FrameFormat,
    fcs16,
    framed,
    unpacked,
)

# pppd with `asyncmap 0`, its first Configure-Request and the acknowledgement of the other.
PPPD_REQUEST = bytes.fromhex(
    "7eff7d23c0217d217d217d207d387d227d267d207d207d207d207d237d24c0237d257d267d21713f747d277d227d287d2244f67e"
)
PPPD_REQUEST_PAYLOAD = bytes.fromhex("01010018020600000000 0304c023 0506 01713f74 0702 0802")
# Without Address and Control field, and with a shared flag between two frames.
PPPD_TWO_FRAMES = bytes.fromhex("c02109000008d989248961107ec0230101000f036c61620667656865696d2d937e")
# A compressed packet in a frame with protocol FDh in one byte.
PPPD_SHORT_PROTOCOL = bytes.fromhex(
    "fd00000a4f6000020eabffff1a18c0a07305ef8ef6cca527ff33312003a656861d8b410c00003c087e"
)
ANY_FORM = st.builds(FrameFormat, st.integers(0, ALL_CONTROLS), st.booleans(), st.booleans())
PROTOCOLS = (
    st.integers(0, 0x3FFF)
    .map(lambda number: ((number >> 7) << 9) | ((number & 0x7F) << 1) | 1)
    .filter(lambda number: number != 0xFF)
)
"""Protocol numbers as RFC 1661 chapter 2 forms them: the low byte odd, the high byte even.  FFh is reserved."""


def all_of(data: bytes, accm: int = ALL_CONTROLS) -> list[bytes]:
    deframer = Deframer()
    deframer.accm = accm
    return list(deframer.feed(data))


def test_check_sequence_of_the_usual_nine_digits() -> None:
    assert fcs16(b"123456789") == bytes.fromhex("6e 90")  # CRC-16/X-25: 906Eh


@given(st.binary(max_size=200))
def test_check_sequence_is_that_of_the_rfc(data: bytes) -> None:
    assert fcs16(data) == check_sequence(data)


def test_a_request_of_pppd_is_read_and_written() -> None:
    (content,) = all_of(PPPD_REQUEST)
    assert unpacked(content) == (0xC021, PPPD_REQUEST_PAYLOAD)
    form = FrameFormat(accm=0, has_short_header=True, has_short_protocol=True)
    assert framed(0xC021, PPPD_REQUEST_PAYLOAD, form) == PPPD_REQUEST  # LCP is never shortened


def test_short_frames_of_pppd_with_a_shared_flag_are_read() -> None:
    echo, login = all_of(PPPD_TWO_FRAMES, accm=0)
    assert unpacked(echo) == (0xC021, bytes.fromhex("09000008d9892489"))
    assert unpacked(login) == (0xC023, bytes.fromhex("0101000f036c61620667656865696d"))
    form = FrameFormat(accm=0, has_short_header=True)
    assert framed(0xC023, bytes.fromhex("0101000f036c61620667656865696d"), form) == bytes.fromhex(
        "7ec0230101000f036c61620667656865696d2d937e"
    )


def test_protocol_in_one_byte_is_read() -> None:
    (content,) = all_of(PPPD_SHORT_PROTOCOL, accm=0)
    assert unpacked(content)[0] == 0xFD


def test_plain_control_characters_that_the_peer_escapes_came_from_a_modem() -> None:
    spoiled = PPPD_REQUEST.replace(b"\x7d", b"\x11\x7d\x13")
    assert all_of(spoiled) == all_of(PPPD_REQUEST)
    assert all_of(spoiled, accm=0) == []


@pytest.mark.parametrize(
    ("data", "fate"),
    [
        ("7e ff 03 c0 21 7d 7e", "aborted"),
        ("7e ff 03 c0 7e", "too_short"),
        ("7e ff 7d 23 c0 21 00 00 00 00 7e", "wrong_check"),
        ("434f4e4e4543540d0a 7e", "wrong_check"),
        ("7e" + "20" * (LONGEST + 1) + "7e", "too_long"),
        ("7e" + "20" * 4 * LONGEST + "7e", "too_long"),
        ("7e 7e 7e", None),
    ],
)
def test_bad_frame_is_dropped_and_counted_and_the_next_is_read(data: str, fate: str | None) -> None:
    deframer = Deframer()
    assert len(list(deframer.feed(bytes.fromhex(data) + PPPD_REQUEST))) == 1
    expected = FrameCounts(good=1)
    if fate is not None:
        setattr(expected, fate, 1)
    assert deframer.counts == expected


@pytest.mark.parametrize("content", ["", "ff", "ff 03", "ff 13 c0 21", "ff 03 c0", "c0"])
def test_content_without_a_protocol_is_refused(content: str) -> None:
    with pytest.raises(ValueError, match="field"):
        unpacked(bytes.fromhex(content))


@given(PROTOCOLS, st.binary(min_size=1, max_size=300), ANY_FORM)
def test_any_frame_arrives_as_it_was_sent(protocol: int, payload: bytes, form: FrameFormat) -> None:
    line = framed(protocol, payload, form)
    assert not any(form.accm >> byte & 1 for byte in line if byte < 32)
    (content,) = all_of(line, form.accm)
    assert unpacked(content) == (protocol, payload)
    assert content_of(line) == protocol.to_bytes(2, "big") + payload


@given(st.binary(max_size=400), st.lists(st.integers(1, 50), max_size=20))
def test_frames_do_not_depend_on_how_bytes_are_cut(garbage: bytes, cuts: list[int]) -> None:
    data = PPPD_REQUEST + garbage + b"\x7e" + PPPD_REQUEST + garbage
    whole, pieces = Deframer(), Deframer()
    expected = list(whole.feed(data))
    found: list[bytes] = []
    at = 0
    for cut in cuts:
        found += pieces.feed(data[at : at + cut])
        at += cut
    found += pieces.feed(data[at:])
    assert (found, pieces.counts) == (expected, whole.counts)
    assert len(expected) >= 2


@pytest.mark.parametrize(("length", "is_read"), [(1500, True), (1501, False)])
def test_longest_packet_is_1500_bytes_behind_a_whole_header(length: int, is_read: bool) -> None:
    deframer = Deframer()
    contents = list(deframer.feed(framed(0x21, bytes(length), FrameFormat())))
    assert [unpacked(content) for content in contents] == ([(0x21, bytes(length))] if is_read else [])
    assert deframer.counts == (FrameCounts(good=1) if is_read else FrameCounts(too_long=1))


def test_an_endless_frame_takes_no_memory() -> None:
    deframer = Deframer()
    for _ in range(100):
        assert list(deframer.feed(bytes(range(0x20, 0x70)) * 100)) == []
    assert deframer.counts.too_long == 1
    assert len(deframer._begun) <= 3 * LONGEST
