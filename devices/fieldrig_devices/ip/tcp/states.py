"""The states of a connection and the events between them (RFC 9293, figure 5 and 3.10).

LISTEN is not a state here, because a listener is no connection: it makes one in SYN-RECEIVED for each SYN.  A close
before the connection is established waits until it is.  From each state a reset or a time-out leads to CLOSED.
"""

from enum import Enum, auto
from typing import Final


class TcpState(Enum):
    CLOSED = "CLOSED"
    SYN_SENT = "SYN-SENT"
    SYN_RECEIVED = "SYN-RECEIVED"
    ESTABLISHED = "ESTABLISHED"
    FIN_WAIT_1 = "FIN-WAIT-1"
    FIN_WAIT_2 = "FIN-WAIT-2"
    CLOSE_WAIT = "CLOSE-WAIT"
    CLOSING = "CLOSING"
    LAST_ACK = "LAST-ACK"
    TIME_WAIT = "TIME-WAIT"


class Event(Enum):
    OPENED = auto()
    """The user has opened the connection actively."""
    SYN = auto()
    SYN_AND_ACK = auto()
    """A SYN that acknowledges ours."""
    ACK_OF_SYN = auto()
    ENDED = auto()
    """The user has no more data to send (CLOSE)."""
    FIN = auto()
    ACK_OF_FIN = auto()
    WAITED = auto()
    """Two maximum segment lifetimes are over."""


# Figure 5, arrow by arrow.  A pair that is not listed changes nothing.
NEXT_STATE: Final = {
    (TcpState.CLOSED, Event.OPENED): TcpState.SYN_SENT,
    (TcpState.CLOSED, Event.SYN): TcpState.SYN_RECEIVED,
    (TcpState.SYN_SENT, Event.SYN): TcpState.SYN_RECEIVED,
    (TcpState.SYN_SENT, Event.SYN_AND_ACK): TcpState.ESTABLISHED,
    (TcpState.SYN_RECEIVED, Event.ACK_OF_SYN): TcpState.ESTABLISHED,
    (TcpState.ESTABLISHED, Event.ENDED): TcpState.FIN_WAIT_1,
    (TcpState.ESTABLISHED, Event.FIN): TcpState.CLOSE_WAIT,
    (TcpState.FIN_WAIT_1, Event.ACK_OF_FIN): TcpState.FIN_WAIT_2,
    (TcpState.FIN_WAIT_1, Event.FIN): TcpState.CLOSING,
    (TcpState.FIN_WAIT_2, Event.FIN): TcpState.TIME_WAIT,
    (TcpState.CLOSING, Event.ACK_OF_FIN): TcpState.TIME_WAIT,
    (TcpState.CLOSE_WAIT, Event.ENDED): TcpState.LAST_ACK,
    (TcpState.LAST_ACK, Event.ACK_OF_FIN): TcpState.CLOSED,
    (TcpState.TIME_WAIT, Event.WAITED): TcpState.CLOSED,
}

SENDING: Final = frozenset(
    {TcpState.ESTABLISHED, TcpState.CLOSE_WAIT, TcpState.FIN_WAIT_1, TcpState.CLOSING, TcpState.LAST_ACK}
)
"""The states in which data or a FIN of ours may still be on their way."""
RECEIVING: Final = frozenset({TcpState.ESTABLISHED, TcpState.FIN_WAIT_1, TcpState.FIN_WAIT_2})
"""The states in which the peer may send data."""
OPENING: Final = frozenset({TcpState.SYN_SENT, TcpState.SYN_RECEIVED})
