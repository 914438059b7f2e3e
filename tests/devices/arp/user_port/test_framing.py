"""Frames on the serial line, against RFC 1662 and a second implementation."""

from itertools import pairwise

import pytest
from arp_user_port import fcs, frame
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.arp.user_port.framing import LONGEST_BODY, Deframer, encode, fcs16

BODIES = st.binary(min_size=4, max_size=LONGEST_BODY)


def test_fcs_as_the_catalogue_of_crcs_has_it() -> None:
    """CRC-16/IBM-SDLC, which is that of RFC 1662: its check value is 906Eh."""
    assert fcs16(b"123456789") ^ 0xFFFF == 0x906E


def test_good_fcs_of_rfc_1662() -> None:
    assert fcs16(b"123456789" + bytes.fromhex("6e 90")) == 0xF0B8  # C.2, PPPGOODFCS16


def test_a_frame_in_hex() -> None:
    """RFC 1662, 3.1 and 4.2: flag, body with 7Eh and 7Dh escaped, FCS with its least significant octet first, flag."""
    assert encode(bytes.fromhex("01 01 00 01")) == bytes.fromhex("7e 01 01 00 01") + fcs(b"\x01\x01\x00\x01") + b"~"
    assert encode(bytes.fromhex("7e 7d 5e 5d")).startswith(bytes.fromhex("7e 7d 5e 7d 5d 5e 5d"))


@settings(max_examples=200, deadline=None)
@given(BODIES)
def test_both_implementations_make_the_same_frame(body: bytes) -> None:
    assert encode(body) == frame(body)


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.lists(BODIES, max_size=4), st.lists(st.integers(0, 1200), max_size=8), st.booleans())
def test_bodies_come_out_whatever_the_pieces(sent: list[bytes], cuts: list[int], share_flags: bool) -> None:
    wire = b"".join(map(frame, sent))
    if share_flags:
        wire = wire.replace(b"~~", b"~")
    deframer = Deframer()
    places = [0, *sorted(min(cut, len(wire)) for cut in cuts), len(wire)]
    heard = [body for start, end in pairwise(places) for body in deframer.feed(wire[start:end])]
    assert heard == sent


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(BODIES, st.data())
def test_a_damaged_frame_is_dropped_and_the_next_one_is_heard(body: bytes, data: st.DataObject) -> None:
    wire = bytearray(frame(body))
    place = data.draw(st.integers(1, len(wire) - 2))
    wire[place] ^= data.draw(st.integers(1, 255))
    assert Deframer().feed(bytes(wire) + frame(b"next"))[-1:] == [b"next"]
    heard = Deframer().feed(bytes(wire) + frame(b"next"))
    assert body not in heard[:-1]


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.lists(st.binary(max_size=700), max_size=6))
def test_any_bytes_leave_it_able_to_hear(chunks: list[bytes]) -> None:
    deframer = Deframer()
    for chunk in chunks:
        deframer.feed(chunk)
    assert deframer.feed(b"~" + frame(b"body"))[-1] == b"body"


@pytest.mark.parametrize(
    "wire",
    [
        "7e 7e",  # empty
        "7e 01 01 00 7e",  # too short for an FCS
        "7e 31 32 33 34 35 36 37 38 39 6e 91 7e",  # wrong FCS
        "7e 31 32 33 34 35 36 37 38 39 6e 90 7d 7e",  # aborted (RFC 1662, 4.3)
        "7e 7d 7e",
        "31 32 33 34 35 36 37 38 39 6e 90 7e",  # no flag before it
    ],
)
def test_what_is_no_frame_is_dropped(wire: str) -> None:
    assert Deframer().feed(bytes.fromhex(wire)) == []


def test_what_is_too_long_is_dropped_and_takes_no_memory() -> None:
    deframer = Deframer()
    assert deframer.feed(frame(bytes(LONGEST_BODY))) == [bytes(LONGEST_BODY)]
    assert deframer.feed(frame(bytes(LONGEST_BODY + 1))) == []
    deframer.feed(b"~")
    for _ in range(100):
        deframer.feed(b"x" * 10_000)
    assert deframer.feed(b"~" + frame(b"body")) == [b"body"]
