"""MBAP headers: Modbus messaging on TCP/IP V1.0b, 3.1.3."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_bus.modbus.framing_mbap import MbapFramer, tcp_frame

READ = bytes.fromhex("15 01 00 00 00 06 FF 03 00 04 00 01")  # the guide's example (appendix A)
READ_PARTS = (0x1501, 0xFF, bytes.fromhex("03 0004 0001"))


def test_a_message_is_transaction_unit_and_pdu() -> None:
    assert MbapFramer().feed(READ) == [READ_PARTS]
    assert tcp_frame(*READ_PARTS) == READ


def test_messages_may_come_together_and_in_parts() -> None:
    framer = MbapFramer()
    assert framer.feed(READ + READ[:3]) == [READ_PARTS]
    assert framer.feed(READ[3:7]) == []
    assert framer.feed(READ[7:] + READ) == [READ_PARTS, READ_PARTS]


@pytest.mark.parametrize(
    "dropped",
    [
        "1501 0001 0006 FF 0300040001",  # another protocol
        "1501 0001 0300" + 0x300 * "AA",  # another protocol, longer than any Modbus message
        "1501 0000 0000",  # no unit
        "1501 0000 0001 FF",  # no function
    ],
)
def test_what_is_no_modbus_is_dropped(dropped: str) -> None:
    framer = MbapFramer()
    assert framer.feed(bytes.fromhex(dropped) + READ) == [READ_PARTS]
    assert (framer.dropped, framer.is_lost) == (1, False)


def test_the_longest_message_has_254_bytes_behind_the_length() -> None:
    assert MbapFramer().feed(bytes.fromhex("0001 0000 00FE 01") + bytes(253)) == [(1, 1, bytes(253))]


def test_a_length_that_no_message_has_puts_the_stream_out_of_step() -> None:
    framer = MbapFramer()
    assert framer.feed(READ + bytes.fromhex("0001 0000 00FF 01") + READ) == [READ_PARTS]
    assert framer.is_lost
    assert framer.feed(READ) == []


messages = st.tuples(st.integers(0, 0xFFFF), st.integers(0, 255), st.binary(min_size=1, max_size=253))


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.lists(messages, max_size=5), st.lists(st.integers(1, 40)))
def test_messages_arrive_however_their_bytes_are_cut(sent: list[tuple[int, int, bytes]], cuts: list[int]) -> None:
    framer, data = MbapFramer(), b"".join(tcp_frame(*message) for message in sent)
    got: list[tuple[int, int, bytes]] = []
    for size in [*cuts, len(data)]:
        got += framer.feed(data[:size])
        data = data[size:]
    assert got == sent


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.lists(st.binary(max_size=300)))
def test_cuts_make_no_difference_to_garbage(chunks: list[bytes]) -> None:
    whole, cut = MbapFramer(), MbapFramer()
    at_once = whole.feed(b"".join(chunks))
    in_parts = [message for chunk in chunks for message in cut.feed(chunk)]
    assert in_parts == at_once
    assert (whole.is_lost, whole.dropped) == (cut.is_lost, cut.dropped)


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.lists(st.one_of(messages.map(lambda message: tcp_frame(*message)), st.binary(max_size=20)), max_size=5),
       st.lists(st.integers(1, 40), max_size=20))  # fmt: skip
def test_one_turn_is_for_one_message(parts: list[bytes], cuts: list[int]) -> None:
    framer, whole, data = MbapFramer(), MbapFramer(), b"".join(parts)
    got, expected = [], whole.feed(data)
    for size in [*cuts, len(data)]:
        portion, data = data[:size], data[size:]
        while portion:
            size = framer.end_of_first(portion)
            found = framer.feed(portion[:size])
            assert size > 0
            assert len(found) <= 1
            got += found
            portion = portion[size:]
    assert (got, framer.dropped, framer.is_lost) == (expected, whole.dropped, whole.is_lost)
