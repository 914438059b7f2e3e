"""The reception path: what a segment does to its connection (RFC 9293, 3.10.7.3 and 3.10.7.4, in their order).

The checks of RFC 5961, which RFC 9293 contains, are made: only a RST at exactly the expected number resets, and an
acknowledgment counts only if it is not older than the widest window of the peer.
"""

from typing import Final

from fieldrig.clock import MS, S
from fieldrig_devices.ip.tcp.connection import Connection, Ending
from fieldrig_devices.ip.tcp.segment import ACK, FIN, RST, SYN, Segment
from fieldrig_devices.ip.tcp.sequence import position
from fieldrig_devices.ip.tcp.states import OPENING, RECEIVING, Event, TcpState

CHALLENGE_NS: Final = 500 * MS
"""Shortest time between two answers to segments that are not acceptable and have no data, so that no two ends answer
each other without end (RFC 5961, 7)."""
DELAYED_ACK_NS: Final = 40 * MS
"""How long an acknowledgment may wait for data that carry it; RFC 9293, 3.8.6.3 allows less than 0.5 s."""
MSL_NS: Final = 30 * S
"""The maximum segment lifetime, which RFC 9293, 3.4.2 leaves to the implementation."""

_ENDED: Final = frozenset({TcpState.CLOSING, TcpState.LAST_ACK, TcpState.TIME_WAIT})
"""The states in which a RST is no error, because both ends have said everything."""


def refusal(segment: Segment) -> Segment | None:
    """Return the RST for a segment that belongs to no connection (RFC 9293, 3.10.7.1), or None for a RST."""
    if segment.flags & RST:
        return None
    ports = segment.destination_port, segment.source_port
    if segment.flags & ACK:
        return Segment(*ports, segment.acknowledgment, 0, RST, 0)
    return Segment(*ports, 0, (segment.sequence + segment.length) % (1 << 32), RST | ACK, 0)


def arrive(connection: Connection, now_ns: int, segment: Segment) -> Segment | None:
    """Take a segment.  Return a RST to be sent for it, or None."""
    if connection.state is TcpState.SYN_SENT:
        return _in_syn_sent(connection, now_ns, segment)
    sequence = position(segment.sequence, connection.incoming.next)
    if not _is_in_window(connection, now_ns, sequence, segment):
        if sequence == connection.incoming.next and connection.incoming.window == 0:
            _take_acknowledgment(connection, now_ns, sequence, segment)
        return None
    if segment.flags & (RST | SYN):
        _reset_or_challenge(connection, now_ns, sequence, segment)
        return None
    if not segment.flags & ACK:
        return None
    acknowledgment = position(segment.acknowledgment, connection.outgoing.unacknowledged)
    if connection.state is TcpState.SYN_RECEIVED:
        if not connection.outgoing.unacknowledged < acknowledgment <= connection.outgoing.highest:
            return refusal(segment)
        _establish(connection, now_ns, acknowledgment, Event.ACK_OF_SYN)
    if not connection.outgoing.oldest_acknowledgment <= acknowledgment <= connection.outgoing.highest:
        _challenge(connection, now_ns)  # RFC 5961, 5.2; its data are dropped as well
        return None
    _acknowledged(connection, now_ns, sequence, acknowledgment, segment)
    _take_data(connection, now_ns, sequence, segment)
    return None


def _take_acknowledgment(connection: Connection, now_ns: int, sequence: int, segment: Segment) -> None:
    """Take a valid ACK with data for which the window has no room (RFC 9293, 3.10.7.4: the special allowance)."""
    acknowledgment = position(segment.acknowledgment, connection.outgoing.unacknowledged)
    is_valid = connection.outgoing.oldest_acknowledgment <= acknowledgment <= connection.outgoing.highest
    if segment.flags & (ACK | SYN | RST) == ACK and is_valid and connection.state not in OPENING:
        _acknowledged(connection, now_ns, sequence, acknowledgment, segment)


def _in_syn_sent(connection: Connection, now_ns: int, segment: Segment) -> Segment | None:
    outgoing = connection.outgoing
    acknowledgment = position(segment.acknowledgment, outgoing.unacknowledged)
    has_ack = bool(segment.flags & ACK)
    if has_ack and not outgoing.first < acknowledgment <= outgoing.highest:
        return refusal(segment)
    if segment.flags & RST:
        if has_ack:
            connection.finish(Ending.REFUSED)
        return None
    if not segment.flags & SYN:
        return None
    connection.begin(segment.sequence, segment.mss)
    if not has_ack:  # both ends have opened at once: our SYN goes out again, with an ACK
        connection.enter(Event.SYN)
        outgoing.go_back()
        return None
    outgoing.update_window(segment.sequence, acknowledgment, segment.window)
    _establish(connection, now_ns, acknowledgment, Event.SYN_AND_ACK)
    connection.needs_ack = True
    _take_data(connection, now_ns, segment.sequence + 1, segment)
    return None


def _is_in_window(connection: Connection, now_ns: int, sequence: int, segment: Segment) -> bool:
    """True for an acceptable segment; another one is answered with an ACK, if it is no RST."""
    incoming, outgoing = connection.incoming, connection.outgoing
    if segment.flags & RST:  # RFC 5961, 3.2: by its number alone
        return sequence == incoming.next or incoming.next < sequence < incoming.edge
    if incoming.is_acceptable(sequence, segment.length):
        return True
    is_same_syn = segment.flags & (SYN | ACK) == SYN and sequence == incoming.next - 1
    if connection.state is TcpState.SYN_RECEIVED and is_same_syn:
        outgoing.go_back()  # the answer to the SYN was lost
        connection.retransmit_ns = None
        return False
    if connection.state is TcpState.TIME_WAIT and segment.flags & FIN:
        connection.wait_ns = now_ns + 2 * MSL_NS
    if segment.length:
        connection.needs_ack = True
    else:
        _challenge(connection, now_ns)
    return False


def _reset_or_challenge(connection: Connection, now_ns: int, sequence: int, segment: Segment) -> None:
    is_called = connection.state is TcpState.SYN_RECEIVED and connection.is_passive
    if is_called and not segment.flags & RST:
        connection.finish(Ending.RESET)  # back to LISTEN: the caller has begun again, and will repeat its SYN
    elif not segment.flags & RST or sequence != connection.incoming.next:
        _challenge(connection, now_ns)
    elif connection.state in _ENDED:
        connection.state = TcpState.CLOSED
        connection.finish(Ending.COMPLETE)
    else:
        is_refused = connection.state in OPENING and not connection.is_passive
        connection.finish(Ending.REFUSED if is_refused else Ending.RESET)


def _challenge(connection: Connection, now_ns: int) -> None:
    if connection.challenged_ns is None or now_ns - connection.challenged_ns >= CHALLENGE_NS:
        connection.challenged_ns = now_ns
        connection.needs_ack = True


def _establish(connection: Connection, now_ns: int, acknowledgment: int, event: Event) -> None:
    connection.outgoing.acknowledge(acknowledgment)
    connection.round_trip.acknowledged(now_ns, acknowledgment)
    if connection.timeouts:
        connection.round_trip.opened_after_loss()
        connection.reno.window = connection.mss  # RFC 5681, 3.1
    _heard(connection)
    connection.enter(event)
    connection.on_open()


def _heard(connection: Connection) -> None:
    """The peer is there and has made progress: the timer begins again."""
    connection.timeouts, connection.unanswered, connection.retransmit_ns = 0, 0, None


def _acknowledged(connection: Connection, now_ns: int, sequence: int, acknowledgment: int, segment: Segment) -> None:
    outgoing = connection.outgoing
    if acknowledgment < outgoing.unacknowledged:
        return
    if outgoing.in_flight == 0:  # we are probing its window, and it answers
        connection.unanswered = 0
    is_duplicate = (
        acknowledgment == outgoing.unacknowledged
        and outgoing.in_flight > 0
        and segment.length == 0
        and segment.window == outgoing.window
    )
    if acknowledgment > outgoing.unacknowledged:
        _advance(connection, now_ns, acknowledgment)
    elif is_duplicate:
        connection.needs_resend |= connection.reno.duplicated(acknowledgment, outgoing.highest, outgoing.in_flight)
    if outgoing.update_window(sequence, acknowledgment, segment.window) and outgoing.in_flight == 0:
        connection.timeouts, connection.retransmit_ns = 0, None


def _advance(connection: Connection, now_ns: int, acknowledgment: int) -> None:
    outgoing = connection.outgoing
    covered = outgoing.acknowledge(acknowledgment)
    connection.round_trip.acknowledged(now_ns, acknowledgment)
    _heard(connection)
    connection.needs_resend = connection.reno.advanced(covered, acknowledgment, outgoing.in_flight)
    if outgoing.is_end_acknowledged and connection.enter(Event.ACK_OF_FIN):
        _wait_in_time_wait(connection, now_ns)


def _take_data(connection: Connection, now_ns: int, sequence: int, segment: Segment) -> None:
    incoming = connection.incoming
    if connection.state not in RECEIVING or not (segment.data or segment.flags & FIN):
        return
    if connection.is_detached and segment.data and sequence + len(segment.data) > incoming.next:
        connection.needs_reset = True  # RFC 9293, 3.6.1: the user has closed without waiting for these data
        connection.finish(Ending.RESET)
        return
    had_gaps = incoming.has_gaps
    incoming.arrived(sequence, segment.data, bool(segment.flags & FIN))
    connection.unacknowledged_segments += 1
    if had_gaps or incoming.has_gaps or incoming.has_ended or connection.unacknowledged_segments >= 2:
        connection.needs_ack = True  # RFC 5681, 4.2
    elif connection.ack_ns is None:
        connection.ack_ns = now_ns + DELAYED_ACK_NS
    if incoming.has_ended and connection.enter(Event.FIN):
        _wait_in_time_wait(connection, now_ns)


def _wait_in_time_wait(connection: Connection, now_ns: int) -> None:
    if connection.state is TcpState.TIME_WAIT:
        connection.wait_ns = now_ns + 2 * MSL_NS
