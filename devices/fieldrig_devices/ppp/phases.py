"""The phases of a link, and the reasons for its end."""

from enum import Enum, auto


class Phase(Enum):
    """The phases of RFC 1661 3.2; its network phase is divided at the instant at which IP packets pass."""

    DEAD = auto()
    """The line is down, or PPP has ended and waits for the line to be hung up."""
    ESTABLISH = auto()
    """LCP negotiates."""
    AUTHENTICATE = auto()
    """The logins are checked; nothing else passes."""
    NETWORK = auto()
    """IPCP negotiates the addresses."""
    RUNNING = auto()
    """IP packets pass."""
    TERMINATE = auto()
    """One side has asked for the end, and the other has not confirmed it yet."""


class End(Enum):
    """The reason for which a link ended; the value is a phrase for logs."""

    LINE_LOST = "the line was lost"
    CLOSED = "closed at this end"
    PEER_CLOSED = "closed by the peer"
    NO_ANSWER = "the peer does not answer"
    NO_ECHO = "the peer no longer answers echo requests"
    NO_AGREEMENT = "the peer refuses what the link needs"
    LOOPED_BACK = "the line is looped back"
    PROTOCOL_REJECTED = "the peer does not support a protocol that the link needs"
    NO_AUTHENTICATION = "the peer refuses to log in"
    LOGIN_FAILED = "the peer logged in with a wrong user name or password"
    LOGIN_REFUSED = "the peer refused our user name or password"
    LOGIN_TIMEOUT = "the peer did not log in within the limit"
    NO_ADDRESSES = "no agreement about the IP addresses"
