import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_bus.can.bits import Place
from fieldrig_bus.can.codec import decode, encode, show
from fieldrig_bus.can.frame import FD_LENGTHS, CanFrame
from fieldrig_bus.can.notices import BitRate, BusState, CanControl, CanError, CanState, ErrorKind, FaultNote, Notice

# By hand from the layout: identifier with flags (4, little endian), length (1), data.
BYTES = {
    "23 01 00 00 03 01 02 03": CanFrame(0x123, b"\x01\x02\x03"),
    "ff 07 00 00 00": CanFrame(0x7FF),
    "00 f1 fe 98 01 55": CanFrame(0x18FEF100, b"\x55", is_extended=True),
    "23 01 00 40 08": CanFrame(0x123, is_remote=True, remote_length=8),
    "01 00 00 c0 00": CanFrame(1, is_extended=True, is_remote=True),
    "05 00 00 20 0c" + " aa" * 12: CanFrame(5, b"\xaa" * 12, is_fd=True),
    "05 00 00 a0 81 aa": CanFrame(5, b"\xaa", is_extended=True, is_fd=True, is_bit_rate_switched=True),
}


@pytest.mark.parametrize("text", BYTES)
def test_a_frame_has_one_form_in_bytes(text: str) -> None:
    assert encode(BYTES[text]) == bytes.fromhex(text)
    assert decode(bytes.fromhex(text)) == BYTES[text]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "23 01 00 00",
        "23 01 00 00 03 01 02",
        "23 01 00 00 01 01 02",
        "00 08 00 00 00",  # 12 bits
        "23 01 00 00 80",  # a switched bit rate without FD
        "23 01 00 40 09",  # a remote frame that requests 9 bytes
        "23 01 00 40 01 55",  # a remote frame with data
        "23 01 00 60 00",  # remote and FD
        "23 01 00 20 09" + " 00" * 9,  # no DLC encodes 9
        "23 01 00 00 09" + " 00" * 9,
    ],
)
def test_other_bytes_are_no_frame(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        decode(bytes.fromhex(text))


@st.composite
def frames(draw: st.DrawFn) -> CanFrame:
    is_extended = draw(st.booleans())
    identifier = draw(st.integers(0, 0x1FFF_FFFF if is_extended else 0x7FF))
    kind = draw(st.sampled_from(["data", "remote", "fd"]))
    if kind == "remote":
        return CanFrame(identifier, b"", is_extended, True, draw(st.integers(0, 8)))
    length = draw(st.sampled_from(FD_LENGTHS if kind == "fd" else range(9)))
    data = draw(st.binary(min_size=length, max_size=length))
    is_fd = kind == "fd"
    return CanFrame(identifier, data, is_extended, is_fd=is_fd, is_bit_rate_switched=is_fd and draw(st.booleans()))


@pytest.mark.long
@settings(max_examples=300, deadline=None)
@given(frames())
def test_decode_is_the_inverse_of_encode(frame: CanFrame) -> None:
    assert decode(encode(frame)) == frame


@pytest.mark.long
@settings(max_examples=300, deadline=None)
@given(st.binary(max_size=80))
def test_any_bytes_are_a_sound_frame_or_refused(data: bytes) -> None:
    try:
        frame = decode(data)
    except ValueError:
        return
    assert encode(frame) == data


# By hand from the layout: the word 6000_0000 with the notice's number, then its fields.
NOTICES: dict[str, Notice] = {
    "01 00 00 60 05 19 29 00 23 01 00 80 01 80 00 07": CanError(
        ErrorKind.ACK, Place.ACK, 41, 0x8000_0123, is_transmitter=True, is_given_up=False, tec=128, rec=7
    ),
    "02 00 00 60 04 00 01 ff": BusState(CanState.BUS_OFF, 256, 255),
    "03 00 00 60 02 00 00 00" + b"dropped".hex(): FaultNote(2, "dropped"),
    "04 00 00 60 02 00 01": CanControl(is_one_shot=True, recover=True),
    "05 00 00 60 90 d0 03 00": BitRate(250_000),
}


@pytest.mark.parametrize("text", NOTICES)
def test_a_notice_has_one_form_in_bytes(text: str) -> None:
    assert encode(NOTICES[text]) == bytes.fromhex(text)
    assert decode(bytes.fromhex(text)) == NOTICES[text]


@pytest.mark.parametrize(
    "text",
    [
        "00 00 00 60 00",
        "05 00 00 60 00",
        "05 00 00 60 00 00 00 00",  # a bit rate of 0
        "05 00 00 60 ff ff ff ff",
        "06 00 00 60 00 00 00 00",
        "02 00 00 60 05 00 01 ff",  # an unknown state
        "02 00 00 60 04 00 01",
        "01 00 00 60 05 19 29 00 23 01 00 80 04 80 00 07",  # unknown flags
        "03 00 00 60 02 00 00 00 ff",  # not UTF-8
        "04 00 00 60 03 00 01",
        "04 00 00 60 02 00 02",
    ],
)
def test_other_bytes_are_no_notice(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        decode(bytes.fromhex(text))


@pytest.mark.long
@settings(max_examples=300, deadline=None)
@given(st.integers(0, 6), st.binary(max_size=14))
def test_any_bytes_are_a_notice_or_refused(number: int, body: bytes) -> None:
    data = bytes([number, 0, 0, 0x60]) + body
    try:
        notice = decode(data)
    except ValueError:
        return
    assert encode(notice) == data
    assert show(notice)


def test_a_person_sees_what_a_notice_says() -> None:
    assert [show(notice) for notice in NOTICES.values()] == [
        "ack error in ack, bit 41, sending; TEC 128 REC 7",
        "now bus off; TEC 256 REC 255",
        "fault 2: dropped",
        "control: is_one_shot=True, is_listen_only=None, recover=True",
        "bit rate 250000 bit/s",
    ]


@pytest.mark.parametrize(
    ("frame", "line"),
    [
        (CanFrame(0x123, b"\x01\x02\xab"), "123 [3] 01 02 AB"),
        (CanFrame(0x7), "007 [0]"),
        (CanFrame(0x7, is_extended=True), "00000007 [0]"),
        (CanFrame(0x123, is_remote=True, remote_length=2), "123 [2] remote request"),
        (CanFrame(0x123, b"\x01", is_fd=True), "123 [01] 01"),
    ],
)
def test_a_person_sees_what_candump_shows(frame: CanFrame, line: str) -> None:
    assert show(frame) == line
