import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.ring.pam.message import (
    GROUP,
    Cycle,
    Frames,
    Reception,
    Reports,
    RingMessage,
    decode,
    encode,
    show,
    span_bytes,
)

NUMBERS = st.integers(0, 0xFFFF_FFFF)
CONTENTS = st.binary(min_size=1, max_size=40)
FRAMES = st.lists(st.tuples(st.integers(0, GROUP + 15), CONTENTS), max_size=8).map(tuple)
ADDRESSES = st.integers(1, 255)
MESSAGES = (
    st.builds(Frames, NUMBERS, FRAMES)
    | st.builds(Cycle, NUMBERS, FRAMES, st.sampled_from(Reception))
    | st.builds(
        Reports,
        NUMBERS,
        st.lists(st.tuples(ADDRESSES, st.binary(min_size=1, max_size=300)), max_size=5).map(tuple),
        st.lists(ADDRESSES, max_size=22).map(tuple),
        st.sampled_from(Reception),
        st.integers(0, 255),
        st.integers(0, 60_000),
    )
    | CONTENTS
)


@given(MESSAGES)
def test_every_message_comes_back(message: RingMessage) -> None:
    assert decode(encode(message)) == message


@given(st.binary(max_size=40))
def test_anything_else_is_refused_or_read(data: bytes) -> None:
    try:
        decode(data)
    except ValueError:
        return


# The bytes are those of docs/devices/pam/pam-ring.md: version, kind, number; then target or address, length and
# contents.
@pytest.mark.parametrize(
    ("message", "expected"),
    [
        (Frames(7, ((17, b"\x02"), (GROUP + 1, b"\x01\x02"))), "01 00 07000000 1100 01 02 0101 02 0102"),
        (Cycle(8, (), Reception.NO_CARRIER), "01 01 08000000 01"),
        (Reports(9, ((33, b"\x05"),), (17, 33), Reception.CRC_ERROR, 33, 2),
         "01 02 09000000 02 21 0200 02 11 21 2100 0100 05"),
        (b"\x01\x84", "01 03 00000000 01 84"),
    ],
)  # fmt: skip
def test_messages_look_as_the_page_says(message: RingMessage, expected: str) -> None:
    assert encode(message) == bytes.fromhex(expected)


@pytest.mark.parametrize(
    "data", ["", "01", "02 00 00000000", "01 09 00000000", "01 00 00000000 11", "01 00 00000000 1100 05 00",
             "01 01 00000000", "01 01 00000000 09", "01 02 00000000 00 00 0000 05 01"],
)  # fmt: skip
def test_what_is_no_message_is_refused(data: str) -> None:
    with pytest.raises(ValueError, match=r"ring message|frame|addresses|Reception"):
        decode(bytes.fromhex(data))


def test_frames_are_found_by_their_target() -> None:
    cycle = Cycle(1, ((17, b"a"), (0, b"b"), (17, b"c")))
    assert cycle.by_target == {17: [b"a", b"c"], 0: [b"b"]}
    assert not cycle.has_groups
    assert Cycle(1, ((GROUP + 1, b"a"),)).has_groups


def test_a_frame_takes_its_head_and_its_crc_on_the_fibre() -> None:
    assert span_bytes([(17, b"abc"), (18, b"d")]) == 2 + 1 + 3 + 2 + 2 + 1 + 1 + 2


def test_a_line_for_a_person() -> None:
    assert show(Frames(7, ((17, b"\x02"), (0, b"\x01"), (GROUP + 3, b"\x09")))) == (
        "7 to 17: 02; to all: 01; to group 3: 09"
    )
    assert show(Frames(7, ())) == "7 no frames"
    assert show(Cycle(8, (), Reception.CRC_ERROR)) == "8 wrong CRC"
    assert show(b"\x01\x84") == "report 01 84"
    assert show(Reports(9, ((33, b"\x01\x84"),), (33,))) == "9 from 33: 01 84"
    assert show(Reports(9, (), (17, 33), Reception.NO_CARRIER, 33, 2)) == "9 no reports, no carrier at node 33, 2 late"
    assert show(Reports(9, (), (), Reception.CRC_ERROR)) == "9 no reports, wrong CRC at the PAM"
