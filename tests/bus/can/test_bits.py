"""Frames bit by bit, as in textbooks and counted by hand."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_bus.can.bits import Place, stream
from fieldrig_bus.can.frame import FD_LENGTHS, CanFrame
from fieldrig_bus.can.length import classical_bits, fd_bits

# By hand: fields with spaces between, stuff bits in brackets.  The CRC of zeros is zero.
BY_HAND = {
    # SOF, identifier, RTR, IDE, r0, DLC, CRC, delimiter, ACK slot and delimiter, end of frame
    "0 0000(1)00000(1)00 0 0 0(1) 0000 0(1)00000(1)00000(1)0000 1 1 1 1111111": CanFrame(0),
}


def bits(text: str) -> bytes:
    return bytes(int(character) for character in text if character in "01")


@pytest.mark.parametrize("text", BY_HAND)
def test_a_frame_is_on_the_wire_as_counted_by_hand(text: str) -> None:
    assert stream(BY_HAND[text]).bits == bits(text)


@st.composite
def frames(draw: st.DrawFn) -> CanFrame:
    is_extended, is_fd = draw(st.booleans()), draw(st.booleans())
    identifier = draw(st.integers(0, 0x1FFF_FFFF if is_extended else 0x7FF))
    length = draw(st.sampled_from(FD_LENGTHS if is_fd else range(9)))
    data = draw(st.binary(min_size=length, max_size=length) | st.sampled_from([bytes(length), b"\xff" * length]))
    return CanFrame(identifier, data, is_extended, is_fd=is_fd, is_bit_rate_switched=is_fd and draw(st.booleans()))


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(frames())
def test_there_are_as_many_bits_as_the_length_says(frame: CanFrame) -> None:
    """`length` also counts the three bits of intermission."""
    wire = stream(frame)
    nominal, switched = fd_bits(frame) if frame.is_fd else (classical_bits(frame), 0)
    assert len(wire.bits) == len(wire.places) == nominal + switched - 3
    assert wire.ticks(len(wire.bits), 1000, 1) == (nominal - 3) * 1000 + switched


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(frames())
def test_nowhere_before_the_end_of_frame_are_six_bits_equal(frame: CanFrame) -> None:
    wire = stream(frame)
    text = "".join(map(str, wire.bits[: wire.delimiter]))
    assert "000000" not in text
    assert "111111" not in text
    assert wire.places[wire.acknowledge] == Place.ACK


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(frames())
def test_places_tell_the_fields_apart(frame: CanFrame) -> None:
    wire = stream(frame)
    assert wire.places[0] == Place.START
    assert all(place == Place.END_OF_FRAME for place in wire.places[-7:])
    assert (Place.DATA in wire.places) is bool(frame.data)
    assert (wire.fd_format >= 0) is frame.is_fd
