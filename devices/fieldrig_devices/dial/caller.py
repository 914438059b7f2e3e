"""A caller on a serial line: the modem, PPP and the TCP/IP stack one after another, as passive code."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from ipaddress import IPv4Address
from typing import Final

from fieldrig.clock import MS, S, VirtualClock
from fieldrig_devices.dial.chat import DEFAULT_INIT, Chat, Failure
from fieldrig_devices.ip.stack import Stack
from fieldrig_devices.ip.tcp.connection import Connection
from fieldrig_devices.ppp.link import PppLink
from fieldrig_devices.ppp.phases import End, Phase
from fieldrig_devices.ppp.settings import Login, PppSettings

GUARD_NS: Final = 1_200 * MS
"""Silence before and behind `+++` (V.250 leaves it to S12, usually 1 s)."""
HANG_UP_NS: Final = 2 * S
"""How long the answer to ATH is awaited."""

_NO_CARRIER: Final = re.compile(rb"(?:^|~)\r?\nNO CARRIER\r\n$")
"""The message of a modem between two frames; within a frame nothing begins with the end of a line."""

FAILURES: Final = {
    End.LINE_LOST: Failure("The connection was lost.", "Call again."),
    End.PEER_CLOSED: Failure("The controller has ended the connection.", "Call again."),
    End.NO_ANSWER: Failure(
        "No PPP answers at the other end.",
        "Check that COM1 of the controller belongs to the modem (Com1User), and that the line has 8 bits, no parity.",
    ),
    End.NO_ECHO: Failure("The controller no longer answers.", "Call again."),
    End.NO_AGREEMENT: Failure(
        "The two ends found no common way to run PPP.", "Set --user and --password, as the controller wants a login."
    ),
    End.LOOPED_BACK: Failure("The line is looped back.", "Check the cable: the answers are our own bytes."),
    End.PROTOCOL_REJECTED: Failure("The other end does not support PAP or IP.", "Check that it is a controller."),
    End.LOGIN_REFUSED: Failure(
        "The controller refuses the user name or the password.",
        "Compare --user and --password with the parameters UserName and Password of its Modem object.",
    ),
    End.NO_ADDRESSES: Failure(
        "The two ends did not agree about the IP addresses.", "Check the parameter RemoteIpAddress of the Modem object."
    ),
}


@dataclass(frozen=True, slots=True)
class Plan:
    """The number to call, and the login there."""

    number: str | None = None
    """The number to dial; None on a line without a modem."""
    init: tuple[str, ...] = DEFAULT_INIT
    login: Login | None = None
    dial_ns: int = 60 * S
    """Longest time from dialling until the modems are connected."""
    setup_ns: int = 60 * S
    """Longest time from then on until IP packets pass."""


class Caller:
    """One call.  `say` gets its progress in sentences, `transmit` the bytes for the line."""

    def __init__(
        self, plan: Plan, new_magic: Callable[[], int], transmit: Callable[[bytes], None], say: Callable[[str], None]
    ) -> None:
        """`new_magic` returns any 32-bit number, each time another."""
        self._plan, self._transmit, self._say = plan, transmit, say
        self.is_over = False
        self.failure: Failure | None = None
        """Why the call is over; None after `hang_up`."""
        self._clock = VirtualClock()
        self._stack: Stack | None = None
        self._tail = b""
        self._is_leaving = False
        settings = PppSettings(
            own=plan.login, setup_limit_ns=plan.setup_ns, echo_period_ns=10 * S, compresses_headers=True
        )
        self._secret = new_magic().to_bytes(4, "big")
        self._ppp = PppLink(settings, new_magic, transmit, self._on_ip, self._on_phase)
        self._chat: Chat | None = None
        if plan.number is not None:
            self._chat = Chat(plan.number, plan.init, plan.dial_ns, transmit, say, self._on_connected, self._on_failed)

    @property
    def is_up(self) -> bool:
        """True while connections can be opened."""
        return self._stack is not None

    @property
    def peer_address(self) -> IPv4Address:
        return self._ppp.peer_address

    def start(self, now_ns: int) -> None:
        self._clock.advance_to(now_ns)
        if self._chat is None:
            self._on_connected(b"")
        else:
            self._chat.start(now_ns)

    def open(self, port: int) -> Connection:
        """Open a connection to a port of the controller.  ConnectionError unless the link is up."""
        if self._stack is None:
            raise ConnectionError("the link is not up")
        return self._stack.connect(self._ppp.peer_address, port)

    def receive(self, now_ns: int, data: bytes) -> None:
        """Take bytes from the line."""
        self.advance(now_ns)
        if self._chat is not None and not self._chat.is_over:
            self._chat.receive(now_ns, data)
        elif not self.is_over:
            self._tail = (self._tail + data)[-32:]
            if self._chat is not None and _NO_CARRIER.search(self._tail) and not self._is_leaving:
                self._ppp.down(now_ns)
            self._ppp.receive(now_ns, data)

    def next_ns(self) -> int | None:
        """Return the instant at which `advance` is due; None if only the line or the user can change anything."""
        if self.is_over:
            return None
        parts = (self._clock, self._ppp, self._chat, self._stack)
        due = [due_ns for part in parts if part is not None and (due_ns := part.next_ns()) is not None]
        return min(due, default=None)

    def advance(self, now_ns: int) -> None:
        """Do everything that is due, and send what follows from the calls of users."""
        self._clock.advance_to(now_ns)
        if self._chat is not None and not self._chat.is_over:
            self._chat.advance(now_ns)
        self._ppp.advance(now_ns)
        if self._stack is not None:
            self._stack.advance(now_ns)

    def hang_up(self, now_ns: int) -> None:
        """End the call in order; `is_over` follows within some seconds."""
        self._clock.advance_to(now_ns)
        if self.is_over or self._is_leaving:
            return
        self._is_leaving = True
        if self._chat is not None and not self._chat.is_over:
            self._chat.stop()
            self._finish()
        elif self._ppp.phase is Phase.DEAD:
            self._escape()
        else:
            self._ppp.close(now_ns)

    # ---- what happens

    def _on_connected(self, data: bytes) -> None:
        now_ns = self._clock.now_ns()
        self._ppp.up(now_ns)
        self._ppp.receive(now_ns, data)

    def _on_failed(self, failure: Failure) -> None:
        self.failure = failure
        self._finish()

    def _on_ip(self, packet: bytes) -> None:
        if self._stack is not None:
            self._stack.receive(self._clock.now_ns(), packet)

    def _on_phase(self, phase: Phase) -> None:
        match phase:
            case Phase.AUTHENTICATE if self._plan.login is not None:
                self._say(f"The controller checks the login of {self._plan.login.name.decode(errors='replace')}.")
            case Phase.RUNNING:
                self._stack = Stack(self._ppp.local_address, self._ppp.mtu, self._send_ip, secret=self._secret)
                here, there = self._ppp.local_address, self._ppp.peer_address
                self._say(f"The link is up: this end is {here}, the controller is {there}.")
            case Phase.DEAD:
                self._on_dead()

    def _on_dead(self) -> None:
        stack, self._stack = self._stack, None
        if stack is not None:
            stack.link_down(self._clock.now_ns())
        ended_by = self._ppp.ended_by
        has_peer = self._ppp.counts.good > 0
        if stack is None and has_peer and self._plan.login is None:
            ended_by = End.NO_AGREEMENT
        if not self._is_leaving and ended_by is not None:
            self.failure = FAILURES.get(ended_by, Failure(f"The link has ended: {ended_by.value}.", "Call again."))
        if ended_by is End.LINE_LOST:
            self._finish()
        else:
            self._escape()

    def _send_ip(self, packet: bytes) -> None:
        self._ppp.send_ip(self._clock.now_ns(), packet)

    # ---- hanging up

    def _escape(self) -> None:
        """Take the modem back to its commands, and hang up (V.250, 6.3.6)."""
        self._is_leaving = True
        if self._chat is None:
            self._finish()
            return
        now_ns = self._clock.now_ns()
        self._clock.call_at(now_ns + GUARD_NS, lambda: self._transmit(b"+++"))
        self._clock.call_at(now_ns + 2 * GUARD_NS, lambda: self._transmit(b"ATH\r"))
        self._clock.call_at(now_ns + 2 * GUARD_NS + HANG_UP_NS, self._finish)

    def _finish(self) -> None:
        self.is_over = True
