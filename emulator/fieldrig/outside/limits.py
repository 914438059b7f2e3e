"""Limits for what comes from outside: how many connections, from whom, and how long one may stay without a message.

Nothing that an outsider sends is queued without limit.  A `Door` decides about the connections of one listening
service: how many there are, how many of one peer, and how long each may stay before its first complete message.
`Reached` counts how often a limit was reached, for `fieldrig status`, and logs it.  What a connection may have waiting
is limited where it is read (`portions`, and the ports of the buses).

Connections that have not sent a complete message yet give way to new ones, the oldest first.  So a peer that opens
connections and leaves them silent keeps no client out for longer than it needs for its first message.  A connection
whose bytes wait for their turn here is not silent: if it gave way, none would have its turn on a busy service.
"""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

log = logging.getLogger(__name__)

QUIET_S: Final = 10.0
"""Time between two lines of the log about the same limit of a service."""
OVER_LIMIT: Final = "connections over the limit"
"""The name of the limit of a client whose connection was refused, or closed for another one."""
FIRST_MESSAGE_S: Final = 30.0
"""Time for the first complete message of a connection."""

OnLimit = Callable[[str, str], object]
"""Counts and logs that a client has reached a limit: the name of it in lower-case words, and what has happened."""


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits of one listening service."""

    connections: int = 64
    """Connections at a time."""
    first_message_s: float | None = FIRST_MESSAGE_S
    """Time for the first complete message, in seconds; None where a client may only listen."""
    silent: int | None = None
    """Connections at a time without a complete message, or None if only `connections` limits them."""
    replaces_idle: bool = False
    """True if a new connection replaces the one that was idle longest (Modbus TCP guide, 4.2); otherwise it is refused.
    """

    @property
    def of_a_peer(self) -> int:
        """Connections of one peer: a quarter of the places is for others."""
        return self.connections - self.connections // 4


class Guest(Protocol):
    """A connection, as its door sees it."""

    @property
    def is_pending(self) -> bool:
        """True while bytes of it wait to be handled, which may be its first message."""

    def shut(self) -> None:
        """Close the connection at once.  It leaves the door when it is closed."""


class Reached:
    """The limits of one service that were reached."""

    def __init__(self, service: str, now_s: Callable[[], float] = time.monotonic) -> None:
        self._service, self._now_s = service, now_s
        self._counts: dict[str, int] = {}
        self._logged_s: dict[str, float] = {}

    def note(self, limit: str, what: str) -> None:
        """Count that a limit was reached, and log it, but not more often than every `QUIET_S`."""
        count = self._counts[limit] = self._counts.get(limit, 0) + 1
        now_s, logged_s = self._now_s(), self._logged_s.get(limit)
        if logged_s is None or now_s - logged_s >= QUIET_S:
            self._logged_s[limit] = now_s
            log.warning("%s: %s (%s: %d so far)", self._service, what, limit, count)

    def figures(self) -> dict[str, float]:
        """Return how often each limit was reached, by its name."""
        return {limit: float(count) for limit, count in self._counts.items()}


class Door:
    """Decides which connections of one service are let in, and which have to go."""

    def __init__(self, service: str, limits: Limits, now_s: Callable[[], float] = time.monotonic) -> None:
        self._limits, self._now_s = limits, now_s
        self.reached = Reached(service, now_s)
        self._peers: dict[Guest, str] = {}  # in the order of their last use
        self._silent: dict[Guest, float] = {}  # the instants by which they have to speak, in this order

    def __len__(self) -> int:
        return len(self._peers)

    def is_open_to(self, peer: str) -> bool:
        """Return whether a new connection of this peer may come in.  Another one may have to go for it."""
        limits = self._limits
        others = [guest for guest, other in self._peers.items() if other == peer]
        is_room = len(others) < limits.of_a_peer or self._make_room(
            others, "connections over the limit of a peer", f"{peer} has {limits.of_a_peer} connections"
        )
        if is_room and len(self._peers) >= limits.connections:
            is_room = self._make_room(list(self._peers), OVER_LIMIT, f"{limits.connections} connections are open")
        if is_room and limits.silent is not None and len(self._silent) >= limits.silent:
            return self._make_room(list(self._silent), OVER_LIMIT, f"{limits.silent} connections have sent nothing yet")
        return is_room

    def enter(self, guest: Guest, peer: str) -> None:
        """Take a connection in, after `is_open_to` has allowed it."""
        self._peers[guest] = peer
        if self._limits.first_message_s is not None:
            self._silent[guest] = self._now_s() + self._limits.first_message_s

    def heard(self, guest: Guest) -> None:
        """Note that a complete message of the connection has arrived; it is idle from now on."""
        self._silent.pop(guest, None)
        if self._limits.replaces_idle and guest in self._peers:
            self._peers[guest] = self._peers.pop(guest)

    def leave(self, guest: Guest) -> None:
        self._peers.pop(guest, None)
        self._silent.pop(guest, None)

    def next_s(self) -> float | None:
        """Return the instant at which `expire` should be called; None while no connection has to speak."""
        return next(iter(self._silent.values()), None)

    def expire(self) -> None:
        """Close the connections whose first message is overdue."""
        now_s = self._now_s()
        for guest in [guest for guest, due_s in self._silent.items() if due_s <= now_s]:
            peer = self._peers[guest]
            what = f"a connection of {peer} is closed: no complete message within {self._limits.first_message_s:g} s"
            self._send_away(guest, "connections without a message", what)

    def _make_room(self, candidates: list[Guest], limit: str, why: str) -> bool:
        """Close the connection that is the first to go among these.  Return whether there was one."""
        leaver = next((guest for guest in candidates if guest in self._silent and not guest.is_pending), None)
        if leaver is None and self._limits.replaces_idle:
            leaver = next((guest for guest in candidates if not guest.is_pending), next(iter(candidates), None))
        if leaver is None:
            self.reached.note(limit, f"{why}; another one is refused")
            return False
        self._send_away(leaver, limit, f"{why}; the longest {'silent' if leaver in self._silent else 'idle'} is closed")
        return True

    def _send_away(self, guest: Guest, limit: str, what: str) -> None:
        self.leave(guest)
        self.reached.note(limit, what)
        guest.shut()
