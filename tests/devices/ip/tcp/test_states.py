"""The states of a connection: RFC 9293, figure 5, state by event, and the exchanges of its section 3."""

import pytest
from ip_line import CALLER, CONTROLLER, PORT, Line, Peer, User

from fieldrig_devices.ip.tcp.connection import Ending
from fieldrig_devices.ip.tcp.segment import ACK, FIN, PSH, RST, SYN, Flags, Segment
from fieldrig_devices.ip.tcp.states import TcpState

WINDOW = 8192
"""The receive window of the host under test, in bytes."""

OUR_END = "our user ends"
FIN_ARRIVES = "a FIN arrives"
ACK_ARRIVES = "our FIN is acknowledged"

# The ways through figure 5 from ESTABLISHED: events, and the state after each of them.
WAYS = [
    ([OUR_END, ACK_ARRIVES, FIN_ARRIVES], [TcpState.FIN_WAIT_1, TcpState.FIN_WAIT_2, TcpState.TIME_WAIT]),
    ([OUR_END, FIN_ARRIVES, ACK_ARRIVES], [TcpState.FIN_WAIT_1, TcpState.CLOSING, TcpState.TIME_WAIT]),
    ([FIN_ARRIVES, OUR_END, ACK_ARRIVES], [TcpState.CLOSE_WAIT, TcpState.LAST_ACK, TcpState.CLOSED]),
]


@pytest.mark.parametrize(("events", "states"), WAYS)
def test_every_way_to_the_end(events: list[str], states: list[TcpState]) -> None:
    peer = Peer()
    user = peer.connect()
    ours, theirs = 101, peer.theirs + 1
    found = []
    for event in events:
        if event == OUR_END:
            user.connection.end()
            assert peer.act()[-1].flags == FIN | ACK
        elif event == FIN_ARRIVES:
            peer.send(FIN | ACK, ours, theirs)
            ours += 1
        else:
            theirs += 1
            peer.send(ACK, ours, theirs)
        found.append(user.connection.state)
    assert found == states
    assert user.has_end
    assert user.endings == [Ending.COMPLETE]


def test_a_fin_that_acknowledges_ours_ends_at_once() -> None:
    peer = Peer()
    user = peer.connect()
    user.connection.end()
    peer.act()
    peer.send(FIN | ACK, 101, peer.theirs + 2)
    assert user.connection.state is TcpState.TIME_WAIT


def test_time_wait_is_two_segment_lifetimes_and_acknowledges_a_repeated_fin() -> None:
    peer = Peer()
    user = peer.connect()
    user.connection.end()
    peer.act()
    peer.send(FIN | ACK, 101, peer.theirs + 2)
    peer.take()
    peer.wait(59)
    peer.send(FIN | ACK, 101, peer.theirs + 2)
    assert [(segment.flags, segment.acknowledgment) for segment in peer.take()] == [(ACK, 102)]
    peer.wait(59)
    assert len(peer.stack.connections) == 1
    peer.wait(1)
    assert peer.stack.connections == []


def test_a_handshake_announces_the_segment_size_of_the_link() -> None:
    peer = Peer(mtu=576)
    peer.send(SYN, 100)
    (answer,) = peer.take()
    assert (answer.flags, answer.acknowledgment, answer.mss) == (SYN | ACK, 101, 536)


def test_a_syn_that_comes_again_is_answered_again() -> None:
    peer = Peer()
    peer.send(SYN, 100)
    peer.send(SYN, 100)
    first, second = peer.take()
    assert first == second


def test_an_answer_to_a_syn_is_given_up_after_5_repetitions() -> None:
    peer = Peer()
    peer.send(SYN, 100)
    peer.wait(100)
    assert [segment.flags for segment in peer.take()] == [SYN | ACK] * 6
    assert peer.stack.connections == []


def test_both_ends_may_open_at_once() -> None:
    """RFC 9293, figure 8."""
    peer = Peer()
    user = User(peer.stack.connect(CALLER, 1000))
    (syn,) = peer.act()
    port = syn.source_port
    peer.give(Segment(1000, port, 100, 0, SYN, 8192))
    (both,) = peer.take()
    assert (both.flags, both.sequence, both.acknowledgment) == (SYN | ACK, syn.sequence, 101)
    peer.give(Segment(1000, port, 100, syn.sequence + 1, SYN | ACK, 8192))
    assert [segment.flags for segment in peer.take()] == [ACK]
    peer.give(Segment(1000, port, 101, syn.sequence + 1, ACK, 8192))
    assert user.connection.state is TcpState.ESTABLISHED


@pytest.mark.parametrize("sequence", [100, 5000])
def test_a_segment_to_a_closed_port_is_reset(sequence: int) -> None:
    peer = Peer()
    peer.stack._listeners.clear()
    peer.send(SYN, sequence)
    (answer,) = peer.take()
    assert (answer.flags, answer.sequence, answer.acknowledgment) == (RST | ACK, 0, sequence + 1)


def test_a_segment_of_an_unknown_connection_is_reset_with_its_own_number() -> None:
    peer = Peer()
    peer.send(ACK, 300, 77)
    (answer,) = peer.take()
    assert (answer.flags, answer.sequence) == (RST, 77)


def test_a_reset_of_an_unknown_connection_gets_no_answer() -> None:
    peer = Peer()
    peer.send(RST, 300)
    assert peer.take() == []


def test_a_reset_at_the_expected_number_ends_the_connection() -> None:
    peer = Peer()
    user = peer.connect()
    peer.send(RST, 101)
    assert (user.endings, peer.stack.connections) == ([Ending.RESET], [])


@pytest.mark.parametrize("data", [b"", b"why"])
@pytest.mark.parametrize("sequence", [0, 98, 100, 101 + WINDOW, 102 + WINDOW, 101 + (1 << 31)])
def test_a_reset_outside_the_window_gets_no_answer(sequence: int, data: bytes) -> None:
    """RFC 5961, 3.2: it is dropped silently, also with data (RFC 9293, 3.5.2) and next to the window."""
    peer = Peer()
    user = peer.connect()
    peer.send(RST, sequence, data=data)
    assert (peer.act(), user.endings) == ([], [])


@pytest.mark.parametrize(
    ("flags", "sequence"),
    [(RST, 102), (RST, 100 + WINDOW), (SYN, 101), (SYN, 500)],
    ids=["a RST further on", "a RST at the end", "a SYN", "a SYN further on"],
)
def test_a_guessed_reset_is_challenged(flags: Flags, sequence: int) -> None:
    """RFC 9293, 3.10.7.4, third and fourth check, after RFC 5961."""
    peer = Peer()
    user = peer.connect()
    peer.send(flags, sequence)
    assert [(segment.flags, segment.acknowledgment) for segment in peer.take()] == [(ACK, 101)]
    assert user.endings == []


def test_a_caller_that_begins_again_before_it_is_connected_is_called_back_at_its_next_syn() -> None:
    """RFC 9293, 3.10.7.4, fourth check: in SYN-RECEIVED a SYN in the window returns a called end to LISTEN."""
    peer = Peer()
    peer.send(SYN, 100)
    assert [segment.flags for segment in peer.take()] == [SYN | ACK]
    peer.send(SYN, 150)
    assert (peer.take(), peer.stack.connections) == ([], [])
    peer.send(SYN, 150)
    assert [(segment.flags, segment.acknowledgment) for segment in peer.take()] == [(SYN | ACK, 151)]


def test_challenges_are_rare() -> None:
    peer = Peer()
    peer.connect()
    for _ in range(10):
        peer.send(ACK, 90, peer.theirs + 1)  # before the window
    assert len(peer.take()) == 1


def test_an_acknowledgment_of_what_was_not_sent_changes_nothing() -> None:
    peer = Peer()
    user = peer.connect()
    peer.send(ACK | PSH, 101, peer.theirs + 2, b"data")
    assert [segment.flags for segment in peer.take()] == [ACK]
    assert user.received == b""


def test_an_abort_resets_and_calls_no_handler() -> None:
    peer = Peer()
    user = peer.connect()
    user.connection.abort()
    assert [(segment.flags, segment.sequence) for segment in peer.act()] == [(RST | ACK, peer.theirs + 1)]
    assert (user.endings, peer.stack.connections) == ([], [])


def test_data_after_a_close_reset_the_connection() -> None:
    peer = Peer()
    user = peer.connect()
    user.connection.close()
    peer.act()
    peer.send(ACK | PSH, 101, peer.theirs + 2, b"more")
    assert peer.take()[-1].flags == RST | ACK


def test_a_closed_connection_does_not_wait_for_the_peer_without_end() -> None:
    peer = Peer()
    user = peer.connect()
    user.connection.close()
    peer.act()
    peer.send(ACK, 101, peer.theirs + 2)
    assert user.connection.state is TcpState.FIN_WAIT_2
    peer.wait(60)
    assert peer.stack.connections == []


def test_a_refused_connection_says_so() -> None:
    line = Line()
    user = User(line.caller.connect(CONTROLLER, 81))
    line.run()
    assert user.endings == [Ending.REFUSED]


def test_a_connection_to_nowhere_times_out() -> None:
    line = Line()
    line.lose = lambda packet: True
    user = User(line.caller.connect(CONTROLLER, PORT))
    line.run()
    assert user.endings == [Ending.TIMED_OUT]
    assert line.now_ns >= 180_000_000_000  # RFC 9293, 3.8.3: R2 of a SYN


def test_data_and_end_may_be_given_before_the_connection_is_established() -> None:
    line = Line()
    accepted: list[User] = []
    line.controller.listen(PORT, lambda connection: accepted.append(User(connection)))
    user = User(line.caller.connect(CONTROLLER, PORT))
    user.connection.send(b"early")
    user.connection.end()
    line.run_for(1)
    assert (bytes(accepted[0].received), accepted[0].has_end) == (b"early", True)


def test_a_lost_link_ends_every_connection_without_a_packet() -> None:
    line = Line()
    caller, _ = line.connected()
    line.packets.clear()
    line.caller.link_down(line.now_ns)
    assert (caller.endings, line.packets, line.caller.connections) == ([Ending.LINK_DOWN], [], [])
