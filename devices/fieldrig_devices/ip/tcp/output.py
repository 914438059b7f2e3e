"""The sending path: the segments that a connection has to send now (RFC 9293, 3.8 and 3.10).

Segments with data wait while the link has no room, so that a slow link has no long queue of them: the round trip stays
short, connections take turns, and what else goes over the link is not late.
Segments that are not full wait only where the peer's window would be filled in silly pieces (RFC 9293, 3.8.6.2.1).
Left out: the algorithm of Nagle, because a stack sends once for all that its user sends within one event.
"""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.ip.tcp.connection import Connection
from fieldrig_devices.ip.tcp.segment import ACK, FIN, PSH, RST, SYN, Flags, Segment
from fieldrig_devices.ip.tcp.sequence import on_wire
from fieldrig_devices.ip.tcp.states import OPENING, SENDING, TcpState

MOST_WINDOW: Final = 0xFFFF
"""The window field is 16 bits wide, and the option to scale it is left out."""

Emit = Callable[[Segment], None]
HasRoom = Callable[[], bool]


def always() -> bool:
    """Return True, for a link that takes everything at once."""
    return True


def output(connection: Connection, now_ns: int, emit: Emit, has_room: HasRoom = always) -> None:
    """Send what may be sent now.  `has_room` returns whether the link takes a further segment with data."""
    connection.is_held = False
    if connection.needs_reset:
        connection.needs_reset = False
        emit(_segment(connection, connection.outgoing.highest, RST | ACK))
    if connection.state is TcpState.CLOSED:
        return
    if connection.incoming.open_window():
        connection.needs_ack |= connection.ack_ns is None
    if connection.state in OPENING:
        _send_syn(connection, now_ns, emit)
    elif connection.state in SENDING:
        if connection.needs_resend and has_room():
            connection.needs_resend = False
            _resend(connection, now_ns, emit)
        _send_data(connection, now_ns, emit, has_room)
        connection.is_held |= connection.needs_resend
    if connection.needs_ack and connection.state is not TcpState.SYN_SENT:
        _send(connection, now_ns, emit, _segment(connection, connection.outgoing.highest, ACK))
    elif connection.needs_probe:
        # A number that was acknowledged already demands an answer, which tells the window.
        _send(connection, now_ns, emit, _segment(connection, connection.outgoing.unacknowledged - 1, ACK))
    connection.needs_probe = False


def _send_syn(connection: Connection, now_ns: int, emit: Emit) -> None:
    outgoing = connection.outgoing
    if outgoing.next > outgoing.first:
        return
    flags = SYN if connection.state is TcpState.SYN_SENT else SYN | ACK
    if outgoing.sent(outgoing.first + 1):
        connection.round_trip.sent(now_ns, outgoing.next)
    else:
        connection.round_trip.repeated()
    _send(connection, now_ns, emit, _segment(connection, outgoing.first, flags, mss=connection.link_mss))


def _resend(connection: Connection, now_ns: int, emit: Emit) -> None:
    outgoing = connection.outgoing
    start = outgoing.unacknowledged
    data = outgoing.at(start, min(connection.mss, outgoing.highest - start))  # nothing that was not sent before
    has_fin = outgoing.highest > outgoing.end_of_data == start + len(data)
    connection.round_trip.repeated()
    connection.retransmit_ns = None
    _send(connection, now_ns, emit, _segment(connection, start, ACK | (FIN if has_fin else PSH), data))


def _send_data(connection: Connection, now_ns: int, emit: Emit, has_room: HasRoom) -> None:
    outgoing = connection.outgoing
    if outgoing.in_flight == 0 and now_ns - connection.sent_ns > connection.round_trip.timeout_ns:
        connection.reno.idled()
    limit = outgoing.unacknowledged + min(outgoing.window, connection.reno.window)
    while not outgoing.is_everything_sent:
        start, room = outgoing.next, limit - outgoing.next
        data = outgoing.at(start, max(min(room, connection.mss), 0))
        is_last = start + len(data) == outgoing.end_of_data
        has_fin = is_last and outgoing.has_ended and room > len(data)
        if not (has_fin or (data and _is_worth_sending(connection, len(data), is_last))):
            return
        if not has_room():
            connection.is_held = True
            return
        connection.needs_probe = False
        flags = (ACK | PSH if is_last and data else ACK) | (FIN if has_fin else 0)
        if outgoing.sent(start + len(data) + has_fin):
            connection.round_trip.sent(now_ns, outgoing.next)
        _send(connection, now_ns, emit, _segment(connection, start, Flags(flags), data))


def _is_worth_sending(connection: Connection, size: int, is_last: bool) -> bool:
    """Data that were sent before are sent again also in a piece that a smaller window leaves (RFC 9293, 3.8.6)."""
    outgoing = connection.outgoing
    is_full = is_last or size == connection.mss or 2 * size >= outgoing.widest
    return is_full or connection.needs_probe or outgoing.next < outgoing.highest


def _segment(connection: Connection, start: int, flags: Flags, data: bytes = b"", mss: int | None = None) -> Segment:
    key, incoming = connection.key, connection.incoming
    has_ack = bool(flags & ACK)
    return Segment(
        key.local_port,
        key.remote_port,
        on_wire(start),
        on_wire(incoming.next) if has_ack else 0,
        flags,
        min(incoming.window, MOST_WINDOW),
        data,
        mss,
    )


def _send(connection: Connection, now_ns: int, emit: Emit, segment: Segment) -> None:
    """Send a segment, which also acknowledges what has arrived."""
    connection.sent_ns = now_ns
    connection.needs_ack, connection.ack_ns, connection.unacknowledged_segments = False, None, 0
    emit(segment)
