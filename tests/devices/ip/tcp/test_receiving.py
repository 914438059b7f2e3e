"""The reception path: RFC 9293, 3.8.6 and 3.10.7.4, and RFC 5681, 4.2."""

from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ip_line import Peer, User

from fieldrig_devices.ip.tcp.incoming import Incoming
from fieldrig_devices.ip.tcp.segment import ACK, FIN, PSH


def connected(window: int = 8192) -> tuple[Peer, User]:
    peer = Peer(window=window)
    return peer, peer.connect()


def send(peer: Peer, place: int, data: bytes) -> None:
    peer.send(ACK | PSH, 101 + place, peer.theirs + 1, data)


def test_an_acknowledgment_waits_up_to_40_ms() -> None:
    peer, user = connected()
    send(peer, 0, b"abc")
    assert bytes(user.received) == b"abc"
    assert peer.take() == []
    peer.wait(0.04)
    assert [(segment.flags, segment.acknowledgment) for segment in peer.take()] == [(ACK, 104)]


def test_every_second_segment_is_acknowledged_at_once() -> None:
    peer, _ = connected()
    send(peer, 0, b"abc")
    send(peer, 3, b"def")
    assert [segment.acknowledgment for segment in peer.take()] == [107]


def test_an_answer_carries_the_acknowledgment() -> None:
    peer, user = connected()
    user.connection.on_data = lambda data: user.connection.send(b"answer")
    send(peer, 0, b"abc")
    assert [(segment.data, segment.acknowledgment) for segment in peer.take()] == [(b"answer", 104)]


def test_a_gap_is_acknowledged_at_once_and_filled() -> None:
    peer, user = connected()
    send(peer, 3, b"def")
    send(peer, 6, b"ghi")
    assert [segment.acknowledgment for segment in peer.take()] == [101, 101]
    send(peer, 0, b"abc")
    assert [segment.acknowledgment for segment in peer.take()] == [110]
    assert bytes(user.received) == b"abcdefghi"


def test_data_that_come_again_are_acknowledged_again() -> None:
    peer, user = connected()
    send(peer, 0, b"abc")
    send(peer, 0, b"abc")
    assert [segment.acknowledgment for segment in peer.take()] == [104]
    assert bytes(user.received) == b"abc"


@pytest.mark.parametrize(("back", "is_taken"), [(8192, True), (8193, False), (2**31 - 1, False), (-1, False)])
def test_data_with_an_acknowledgment_that_nobody_can_have_sent_are_challenged(back: int, is_taken: bool) -> None:
    """RFC 5961, 5.2: acceptable from SND.UNA - MAX.SND.WND to SND.NXT, where the peer's window was 8192."""
    peer, user = connected()
    user.connection.send(bytes(8192))
    for place in range(2, 8194, 1000):
        peer.act()
        peer.send(ACK, 101, peer.theirs + min(place + 999, 8193))
    peer.take()
    peer.send(ACK | PSH, 101, peer.theirs + 8193 - back, b"blind")
    answers = peer.take()
    assert bytes(user.received) == (b"blind" if is_taken else b"")
    if not is_taken:
        assert [(segment.flags, segment.acknowledgment) for segment in answers] == [(ACK, 101)]


def test_an_end_before_its_data_waits_for_them() -> None:
    peer, user = connected()
    peer.send(ACK | FIN, 104, peer.theirs + 1)
    assert not user.has_end
    send(peer, 0, b"abc")
    assert (bytes(user.received), user.has_end) == (b"abc", True)
    assert peer.take()[-1].acknowledgment == 105


def test_a_paused_user_closes_the_window_and_opens_it_again() -> None:
    peer, user = connected(window=1000)
    user.connection.pause()
    send(peer, 0, bytes(1000))
    peer.wait(0.1)
    assert [(segment.acknowledgment, segment.window) for segment in peer.take()] == [(1101, 0)]
    send(peer, 1000, b"x")
    assert [segment.window for segment in peer.take()] == [0]
    assert user.received == b""
    user.connection.resume()
    assert [segment.window for segment in peer.act()] == [1000]
    assert len(user.received) == 1000


def test_a_probe_of_a_closed_window_acknowledges_our_data() -> None:
    """RFC 9293, 3.10.7.4: valid ACKs are accepted where no data are; else both ends repeat theirs forever."""
    peer, user = connected(window=1000)
    user.connection.pause()
    send(peer, 0, bytes(1000))
    user.connection.send(b"ours")
    assert peer.act()[-1].data == b"ours"
    peer.send(ACK, 1101, peer.theirs + 5, b"x")
    assert [segment.acknowledgment for segment in peer.take()] == [1101]
    peer.wait(10)
    assert [segment.data for segment in peer.take() if segment.data] == []
    peer.send(ACK, 1101, peer.theirs + 99, b"x")  # of what was never sent
    peer.wait(10)
    assert user.connection.outgoing.queued == 0


def test_a_paused_user_learns_of_the_end_after_the_data() -> None:
    peer, user = connected()
    user.connection.pause()
    user.connection.end()
    peer.act()
    peer.send(ACK | FIN | PSH, 101, peer.theirs + 2, b"last words")
    peer.wait(100)
    assert (bytes(user.received), user.endings) == (b"", [])
    user.connection.resume()
    peer.wait(0)
    assert (bytes(user.received), user.has_end, len(user.endings)) == (b"last words", True, 1)


@pytest.mark.parametrize(
    ("window", "start", "length", "is_acceptable"),
    [
        (0, 0, 0, True),
        (0, 1, 0, False),
        (0, 0, 1, False),
        (100, -1, 0, False),
        (100, 0, 0, True),
        (100, 99, 0, True),
        (100, 100, 0, True),  # where Linux sends the ACK of an end that has filled the window
        (100, 101, 0, False),
        (100, -1, 1, False),
        (100, -1, 2, True),
        (100, 99, 5, True),
        (100, 100, 5, False),
    ],
)
def test_acceptable_segments_are_those_of_table_6(window: int, start: int, length: int, is_acceptable: bool) -> None:
    incoming = Incoming(999, 100, 10)
    incoming.edge = incoming.next + window
    assert incoming.is_acceptable(1000 + start, length) == is_acceptable


@settings(deadline=None)
@given(st.integers(0, 2**32))
def test_pieces_in_any_order_become_the_stream(seed: int) -> None:
    random = Random(seed)
    stream = bytes(range(200))
    incoming = Incoming(0xFFFF_FF00, 150, 50)
    received = bytearray()
    for _ in range(200):
        start = random.randint(max(len(received) - 10, 0), min(len(received) + 60, 200))
        piece = stream[start : start + random.randint(0, 40)]
        is_last = start + len(piece) == 200
        place = 0xFFFF_FF01 + start
        if incoming.is_acceptable(place, len(piece) + is_last):
            incoming.arrived(place, piece, is_last)
        received += incoming.take()
        incoming.open_window()
        if incoming.has_ended:
            break
    assert stream.startswith(bytes(received))
    assert incoming.next == 0xFFFF_FF01 + len(received) + incoming.has_ended


def test_many_small_pieces_occupy_little() -> None:
    incoming = Incoming(0, 65_535, 1460)
    for place in range(2, 60_000, 2):
        incoming.arrived(1 + place, b"x", False)
    assert len(incoming._pieces) == 64
