"""The states of a connection and the events between them (RFC 9293, figure 5 and 3.10).

LISTEN is not a state here, because a listener is no connection: it makes one in SYN-RECEIVED for each SYN.  A close
before the connection is established waits until it is.  From each state a reset or a time-out leads to CLOSED.
"""

from enum import Enum, auto
from typing import Final


class State(Enum):
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
    (State.CLOSED, Event.OPENED): State.SYN_SENT,
    (State.CLOSED, Event.SYN): State.SYN_RECEIVED,
    (State.SYN_SENT, Event.SYN): State.SYN_RECEIVED,
    (State.SYN_SENT, Event.SYN_AND_ACK): State.ESTABLISHED,
    (State.SYN_RECEIVED, Event.ACK_OF_SYN): State.ESTABLISHED,
    (State.ESTABLISHED, Event.ENDED): State.FIN_WAIT_1,
    (State.ESTABLISHED, Event.FIN): State.CLOSE_WAIT,
    (State.FIN_WAIT_1, Event.ACK_OF_FIN): State.FIN_WAIT_2,
    (State.FIN_WAIT_1, Event.FIN): State.CLOSING,
    (State.FIN_WAIT_2, Event.FIN): State.TIME_WAIT,
    (State.CLOSING, Event.ACK_OF_FIN): State.TIME_WAIT,
    (State.CLOSE_WAIT, Event.ENDED): State.LAST_ACK,
    (State.LAST_ACK, Event.ACK_OF_FIN): State.CLOSED,
    (State.TIME_WAIT, Event.WAITED): State.CLOSED,
}

SENDING: Final = frozenset({State.ESTABLISHED, State.CLOSE_WAIT, State.FIN_WAIT_1, State.CLOSING, State.LAST_ACK})
"""The states in which data or a FIN of ours may still be on their way."""
RECEIVING: Final = frozenset({State.ESTABLISHED, State.FIN_WAIT_1, State.FIN_WAIT_2})
"""The states in which the peer may send data."""
OPENING: Final = frozenset({State.SYN_SENT, State.SYN_RECEIVED})
