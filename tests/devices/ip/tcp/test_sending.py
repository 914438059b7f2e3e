"""The sending path and its timers: RFC 9293, 3.8, RFC 5681 and RFC 6298."""

import pytest
from ip_line import Peer, User

from fieldrig.clock import MS, S
from fieldrig_devices.ip.tcp.congestion import Reno, first_window
from fieldrig_devices.ip.tcp.connection import Ending
from fieldrig_devices.ip.tcp.round_trip import RoundTrip
from fieldrig_devices.ip.tcp.segment import ACK, FIN, PSH, Segment

MSS = 1000


def places(peer: Peer, segments: list[Segment]) -> list[tuple[int, int]]:
    """Return place and size of the data of segments, the first byte being 0."""
    return [(segment.sequence - peer.theirs - 1, len(segment.data)) for segment in segments if segment.data]


def sending(size: int, window: int = 60_000) -> tuple[Peer, User]:
    peer = Peer()
    user = peer.connect(mss=MSS, window=window)
    user.connection.send(bytes(size))
    return peer, user


def acknowledge(peer: Peer, bytes_received: int, window: int = 60_000) -> list[tuple[int, int]]:
    peer.send(ACK, 101, peer.theirs + 1 + bytes_received, window=window)
    return places(peer, peer.take())


def test_slow_start_sends_two_segments_more_for_each_acknowledged_one() -> None:
    peer, _ = sending(20_000)
    assert places(peer, peer.act()) == [(0, MSS), (1000, MSS), (2000, MSS), (3000, MSS)]  # RFC 5681, 3.1: 4 segments
    assert acknowledge(peer, 1000) == [(4000, MSS), (5000, MSS)]
    assert acknowledge(peer, 2000) == [(6000, MSS), (7000, MSS)]


@pytest.mark.parametrize(("mss", "window"), [(536, 2144), (1095, 4380), (1460, 4380), (2190, 4380), (4000, 8000)])
def test_the_initial_window_is_that_of_rfc_5681(mss: int, window: int) -> None:
    assert first_window(mss) == window


def test_congestion_avoidance_adds_a_segment_in_a_round_trip() -> None:
    reno = Reno(MSS)
    reno.threshold = 4000
    for place in range(1, 5):
        reno.advanced(MSS, place * MSS, 4000)
    assert 4900 <= reno.window <= 5000


def test_the_last_segment_has_push() -> None:
    peer, _ = sending(1500)
    assert [segment.flags for segment in peer.act()] == [ACK, PSH | ACK]


def test_the_end_is_sent_with_the_last_data() -> None:
    peer, user = sending(1500)
    user.connection.end()
    assert [segment.flags for segment in peer.act()] == [ACK, FIN | PSH | ACK]


def test_data_are_repeated_after_1_s_and_then_after_twice_the_time_each() -> None:
    peer, _ = sending(500)
    peer.act()
    instants = []
    for _ in range(5):
        due_ns = peer.stack.next_ns()
        assert due_ns is not None
        peer.wait((due_ns - peer.now_ns) / S)
        assert places(peer, peer.take()) == [(0, 500)]
        instants.append(peer.now_ns // S)
    assert instants == [1, 3, 7, 15, 31]  # RFC 6298, 5.5


def test_a_peer_that_stays_silent_is_given_up() -> None:
    peer, user = sending(500)
    peer.wait(1000)
    assert (user.endings, peer.stack.connections) == ([Ending.TIMED_OUT], [])
    assert len(places(peer, peer.take())) == 13


def test_after_a_time_out_one_segment_is_sent_and_then_two() -> None:
    peer, _ = sending(20_000)
    peer.act()
    peer.wait(1)
    assert places(peer, peer.take()) == [(0, MSS)]
    assert acknowledge(peer, 1000) == [(1000, MSS), (2000, MSS)]


def test_the_third_duplicate_repeats_one_segment_at_once() -> None:
    """RFC 5681, 3.2."""
    peer, user = sending(20_000)
    peer.act()
    assert acknowledge(peer, 0) == acknowledge(peer, 0) == []
    assert acknowledge(peer, 0) == [(0, MSS), (4000, MSS)]  # ssthresh is 2 segments, inflated by 3
    assert acknowledge(peer, 0) == [(5000, MSS)]
    assert acknowledge(peer, 6000) == [(6000, MSS), (7000, MSS)]
    assert user.connection.reno.window == 2000


def test_a_repeated_segment_has_nothing_that_was_not_sent_before() -> None:
    peer, user = sending(5000, window=500)
    assert places(peer, peer.act()) == [(0, 500)]
    user.connection.end()
    for _ in range(3):
        peer.send(ACK, 101, peer.theirs + 1, window=500)
    assert [(segment.flags, len(segment.data)) for segment in peer.take()] == [(PSH | ACK, 500)]


def test_a_partial_acknowledgment_repeats_the_next_segment() -> None:
    """RFC 6582, 3.2, step 3."""
    peer, user = sending(20_000)
    peer.act()
    for _ in range(3):
        acknowledge(peer, 0)
    assert (1000, MSS) in acknowledge(peer, 1000)
    assert user.connection.reno.is_recovering


def test_nothing_is_sent_beyond_the_window_of_the_peer() -> None:
    peer, _ = sending(20_000, window=2500)
    assert places(peer, peer.act()) == [(0, MSS), (1000, MSS)]  # 500 bytes would be silly
    assert acknowledge(peer, 2000, window=500) == []


def test_a_closed_window_is_probed_and_the_peer_is_waited_for() -> None:
    """RFC 9293, 3.8.6.1."""
    peer, user = sending(5000, window=1000)
    peer.act()
    acknowledge(peer, 1000, window=0)
    instants = []
    for _ in range(20):
        due_ns = peer.stack.next_ns()
        assert due_ns is not None
        peer.wait((due_ns - peer.now_ns) / S)
        (probe,) = peer.take()
        assert (probe.data, probe.sequence) == (b"", peer.theirs + 1000)
        instants.append(peer.now_ns // S)
        peer.send(ACK, 101, peer.theirs + 1001, window=0)
    assert instants[:7] == [1, 3, 7, 15, 31, 63, 123]
    assert user.endings == []
    assert acknowledge(peer, 1000, window=2000) == [(1000, MSS), (2000, MSS)]


def test_a_window_that_stays_small_is_used_after_a_while() -> None:
    """RFC 9293, 3.8.6.2.1: the sender overrides."""
    peer, _ = sending(5000, window=4000)
    peer.act()
    assert acknowledge(peer, 4000, window=300) == []
    peer.wait(1)
    assert places(peer, peer.take()) == [(4000, 300)]


def test_a_window_that_shrinks_below_what_was_sent_delays_no_repetition() -> None:
    """RFC 9293, 3.8.6: old data are repeated as always, between SND.UNA and SND.UNA + SND.WND."""
    peer, _ = sending(3000, window=8192)
    peer.act()
    assert acknowledge(peer, 0, window=500) == []
    peer.wait(1)
    assert places(peer, peer.take()) == [(0, 500)]
    peer.wait(2)
    assert places(peer, peer.take()) == [(0, 500)]
    assert acknowledge(peer, 500, window=500)[0] == (500, 500)


def test_a_peer_without_the_option_gets_segments_of_536_bytes() -> None:
    peer = Peer()
    user = peer.connect(mss=None)
    user.connection.send(bytes(1000))
    assert places(peer, peer.act()) == [(0, 536), (536, 464)]


def test_a_tiny_segment_size_is_kept() -> None:
    peer = Peer()
    user = peer.connect(mss=0)
    user.connection.send(b"abc")
    assert places(peer, peer.act())[0] == (0, 1)


def test_there_is_room_again_after_half_of_the_data_has_gone() -> None:
    peer = Peer()
    user = peer.connect(mss=MSS, window=60_000)
    calls: list[int] = []
    user.connection.on_room = lambda: calls.append(user.connection.room)
    user.connection.send(bytes(40_000))
    assert user.connection.room == 0
    peer.act()
    sent = 0
    while not calls:
        sent += MSS
        acknowledge(peer, sent)
    assert sent == 24_000  # 16,000 of 32,768 bytes are left


def test_the_time_out_follows_the_rules_of_rfc_6298() -> None:
    trip = RoundTrip()
    assert trip.timeout_ns == 1 * S  # 2.1
    trip.sent(0, 10)
    trip.acknowledged(2 * S, 10)
    assert (trip.smoothed_ns, trip.timeout_ns) == (2 * S, 6 * S)  # 2.2: R + 4 * R / 2
    trip.sent(10 * S, 20)
    trip.acknowledged(14 * S, 20)
    # 2.3: RTTVAR = 0.75 * 1 s + 0.25 * |2 s - 4 s| = 1.25 s, SRTT = 0.875 * 2 s + 0.125 * 4 s = 2.25 s
    assert (trip.smoothed_ns, trip.timeout_ns) == (2250 * MS, 7250 * MS)


def test_a_repeated_segment_is_not_measured() -> None:
    trip = RoundTrip()
    trip.sent(0, 10)
    trip.repeated()
    trip.acknowledged(5 * S, 10)
    assert trip.smoothed_ns is None


def test_the_time_out_is_at_most_a_minute() -> None:
    trip = RoundTrip()
    for _ in range(10):
        trip.back_off()
    assert trip.timeout_ns == 60 * S
