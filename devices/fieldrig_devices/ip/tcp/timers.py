"""The timers of a connection: retransmission, window probes, delayed acknowledgments, and the waits at its end.

Source: RFC 6298, 5, and RFC 9293, 3.8.1, 3.8.3 and 3.8.6.1.
"""

from typing import Final

from fieldrig.clock import S
from fieldrig_devices.ip.tcp.connection import Connection, Ending
from fieldrig_devices.ip.tcp.round_trip import MOST_NS
from fieldrig_devices.ip.tcp.states import OPENING, SENDING, Event, TcpState

MOST_UNANSWERED: Final = {TcpState.SYN_SENT: 8, TcpState.SYN_RECEIVED: 5}
"""How often a SYN is repeated without an answer: R2 is at least 3 minutes where we opened (RFC 9293, 3.8.3)."""
MOST_UNANSWERED_DATA: Final = 12
"""How often data are repeated, or the window is probed, without an answer: R2 is several minutes."""
DETACHED_NS: Final = 60 * S
"""How long the FIN of the peer is awaited in FIN-WAIT-2 after the user has closed."""


def next_ns(connection: Connection) -> int | None:
    """Return the instant of the next timer; None without one."""
    due = [
        when_ns for when_ns in (connection.retransmit_ns, connection.ack_ns, connection.wait_ns) if when_ns is not None
    ]
    return min(due, default=None)


def arm(connection: Connection, now_ns: int) -> None:
    """Start and stop the timers, after everything that could be sent was sent."""
    outgoing, state = connection.outgoing, connection.state
    if state is TcpState.CLOSED:
        connection.retransmit_ns = connection.ack_ns = connection.wait_ns = None
    elif state not in SENDING and state not in OPENING:
        connection.retransmit_ns = None
    elif outgoing.in_flight > 0:
        if connection.retransmit_ns is None:
            connection.retransmit_ns = now_ns + connection.round_trip.timeout_ns
    elif outgoing.is_everything_sent or connection.is_held:  # the window is open: there is nothing to probe
        connection.retransmit_ns = None
    elif connection.retransmit_ns is None:
        connection.retransmit_ns = now_ns + min(
            connection.round_trip.timeout_ns << min(connection.timeouts, 6), MOST_NS
        )
    if state is TcpState.FIN_WAIT_2 and connection.is_detached and connection.wait_ns is None:
        connection.wait_ns = now_ns + DETACHED_NS


def expire(connection: Connection, now_ns: int) -> None:
    """Do what is due."""
    if _is_due(connection.ack_ns, now_ns):
        connection.ack_ns, connection.needs_ack = None, True
    if _is_due(connection.wait_ns, now_ns):
        connection.wait_ns = None
        if not connection.enter(Event.WAITED):
            connection.finish(Ending.TIMED_OUT)
    if _is_due(connection.retransmit_ns, now_ns):
        connection.retransmit_ns = None
        _on_silence(connection, now_ns)


def _on_silence(connection: Connection, now_ns: int) -> None:
    outgoing = connection.outgoing
    if connection.unanswered >= MOST_UNANSWERED.get(connection.state, MOST_UNANSWERED_DATA):
        connection.finish(Ending.TIMED_OUT)
        return
    connection.unanswered += 1
    if outgoing.in_flight == 0:
        connection.needs_probe = True
    else:
        connection.reno.timed_out(outgoing.highest, outgoing.in_flight, connection.timeouts == 0)
        connection.round_trip.repeated()
        connection.round_trip.back_off()
        connection.needs_resend = False
        outgoing.go_back()
    connection.timeouts += 1


def _is_due(when_ns: int | None, now_ns: int) -> bool:
    return when_ns is not None and when_ns <= now_ns
