"""A connection, as its user sees it and as the files that work on it see it (RFC 9293, 3.3.1 and 3.9.1).

`arrival` takes segments, `output` sends them, `timers` watches the time; none of them keeps anything of its own.
A call of the user changes the connection at once, and its stack sends the segments that follow from it at its next
`receive` or `advance`.
"""

from collections.abc import Callable
from enum import Enum
from ipaddress import IPv4Address
from typing import Any, Final, NamedTuple

from fieldrig_devices.ip.tcp.congestion import Reno
from fieldrig_devices.ip.tcp.incoming import Incoming
from fieldrig_devices.ip.tcp.outgoing import Outgoing
from fieldrig_devices.ip.tcp.round_trip import RoundTrip
from fieldrig_devices.ip.tcp.segment import DEFAULT_MSS
from fieldrig_devices.ip.tcp.states import NEXT_STATE, OPENING, Event, TcpState

SEND_CAPACITY: Final = 32_768
"""Bytes that a connection keeps for sending before its user should wait for `on_room`."""


class Ending(Enum):
    """Why a connection is over, as the second half of a sentence that begins with "the connection"."""

    COMPLETE = "has ended in order"
    REFUSED = "was refused by the peer"
    RESET = "was reset by the peer"
    TIMED_OUT = "got no answer for too long"
    LINK_DOWN = "was lost with its link"


class Key(NamedTuple):
    """The two ends of a connection, which no other connection of the stack has."""

    local_port: int
    remote_address: IPv4Address
    remote_port: int


def _ignore(*_: Any) -> None:
    """Do nothing, for a handler that the user did not set."""


class Connection:
    """One connection.  Its user sets the handlers that it needs, at the latest in the call of `accept`."""

    def __init__(self, key: Key, first: int, mss: int, capacity: int, wake: Callable[["Connection"], None]) -> None:
        """`first` is the position of our SYN, `mss` the largest segment that this link carries."""
        self.key = key
        self.state = TcpState.CLOSED
        self.on_open: Callable[[], None] = _ignore
        """Called when the connection is established."""
        self.on_data: Callable[[bytes], None] = _ignore
        self.on_end: Callable[[], None] = _ignore
        """Called after the last data of the peer; it may still be sent to."""
        self.on_close: Callable[[Ending], None] = _ignore
        """Called once, when both directions have ended, or the connection was lost."""
        self.on_room: Callable[[], None] = _ignore
        """Called when there is room again for what should be sent, after there was none."""

        self.outgoing = Outgoing(first)
        self.incoming = Incoming(0, capacity, mss)
        self.round_trip = RoundTrip()
        self.link_mss = mss
        self.mss = min(DEFAULT_MSS, mss)
        self.reno = Reno(self.mss)
        self.is_passive = False
        self.is_detached = False
        self.ending: Ending | None = None
        self.needs_ack = False
        self.needs_resend = False
        """True if the segment at SND.UNA was lost and goes out again, before everything else."""
        self.needs_probe = False
        self.is_held = False
        """True while segments with data wait for room on the link."""
        self.needs_reset = False
        self.unacknowledged_segments = 0
        """Segments with data that arrived since our last acknowledgment."""
        self.timeouts = 0
        """Time-outs since the last progress."""
        self.unanswered = 0
        """Time-outs since the peer was last heard."""
        self.retransmit_ns: int | None = None
        self.ack_ns: int | None = None
        self.wait_ns: int | None = None
        self.challenged_ns: int | None = None
        self.sent_ns = 0
        self._capacity, self._wake = capacity, wake
        self._is_ending = self._was_full = self._is_end_reported = self._is_close_reported = False

    # ---- the user's side

    @property
    def room(self) -> int:
        """The bytes that should be sent at most now; a user that has more waits for `on_room`."""
        return max(SEND_CAPACITY - self.outgoing.queued, 0)

    @property
    def is_open(self) -> bool:
        """True while data can be sent, if only later."""
        return self.ending is None and not self._is_ending

    @property
    def is_complete(self) -> bool:
        """True if both directions have ended in order."""
        return self.ending is Ending.COMPLETE

    @property
    def is_refused(self) -> bool:
        """True if the peer has refused the connection that we opened."""
        return self.ending is Ending.REFUSED

    def send(self, data: bytes) -> None:
        """Send data, all of them, however many; dropped if the connection is over, or was ended by the user."""
        if self.is_open and data:
            self.outgoing.append(data)
            self._was_full |= self.room == 0
            self._wake(self)

    def end(self) -> None:
        """End our direction after the data that were given to `send`.  The peer may still send."""
        if self.is_open:
            self._is_ending = True
            self.end_if_due()
            self._wake(self)

    def close(self) -> None:
        """End our direction, and receive nothing more: further data of the peer reset the connection."""
        self.end()
        self.is_detached = True
        self.on_data, self.on_end, self.on_room = _ignore, _ignore, _ignore
        self.resume()
        self._wake(self)

    def abort(self) -> None:
        """Reset the connection at once.  `on_close` is not called."""
        self._is_close_reported = True
        if self.ending is None:
            self.needs_reset = self.state is not TcpState.SYN_SENT
            self.finish(Ending.RESET)

    def pause(self) -> None:
        """Call `on_data` no more until `resume`.  The peer can send until the window is full."""
        self.incoming.is_paused = True

    def resume(self) -> None:
        if self.incoming.is_paused:
            self.incoming.is_paused = False
            self._wake(self)

    # ---- the stack's side

    def begin(self, sequence: int, mss: int | None) -> None:
        """Take the position of the peer's SYN, and the segment size in it."""
        self.incoming = Incoming(sequence, self._capacity, self.link_mss)
        self.mss = max(min(DEFAULT_MSS if mss is None else mss, self.link_mss), 1)
        self.reno = Reno(self.mss)

    def enter(self, event: Event) -> bool:
        """Take the arrow of the table for this event; True if there is one."""
        following = NEXT_STATE.get((self.state, event))
        if following is None:
            return False
        was_opening = self.state in OPENING
        self.state = following
        if following is TcpState.ESTABLISHED and was_opening:
            self.end_if_due()
        elif following in (TcpState.TIME_WAIT, TcpState.CLOSED):
            self.finish(Ending.COMPLETE)
        return True

    def end_if_due(self) -> None:
        if self._is_ending and self.enter(Event.ENDED):
            self.outgoing.has_ended = True

    def finish(self, ending: Ending) -> None:
        """End the connection for this reason, unless it has ended already."""
        if self.state is not TcpState.TIME_WAIT:
            self.state = TcpState.CLOSED
        if self.ending is None:
            self.ending = ending
        self.retransmit_ns = None
        self._wake(self)

    def report(self) -> None:
        """Call the handlers for what has happened."""
        data = self.incoming.take()
        if data:
            self.on_data(data)
        if self.incoming.has_ended and not self.incoming.is_paused and not self._is_end_reported:
            self._is_end_reported = True
            self.on_end()
        if self._was_full and 2 * self.room >= SEND_CAPACITY and self.is_open:
            self._was_full = False
            self.on_room()
        is_delivered = not self.incoming.is_paused or self.ending is not Ending.COMPLETE
        if self.ending is not None and is_delivered and not self._is_close_reported:
            self._is_close_reported = True
            self.on_close(self.ending)
