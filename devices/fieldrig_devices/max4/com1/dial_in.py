"""A call at COM1: PPP with a login, and above it the services at the controller's own address.

Source: PacDrive manual 4539-4548, 4585-4601, 4933, 5079-5085 (digest PD-250, PD-258 to PD-260, PD-273).  With a
RemoteIpAddress that no host can have, the call ends after the login.  Without UserName and Password it ends at once.
The third failed login in a row and each further one are entries of the message logger, and are answered 10 s later.

A caller such as pppd takes the line for lost if an echo of LCP is not answered within seconds.  So data of TCP wait
in their connections while the line has enough to send, and a caller can have no more than `WINDOW` bytes under way.
"""

import logging
from collections.abc import Callable, Mapping
from ipaddress import IPv4Address
from typing import Final, Protocol

from fieldrig.clock import NEVER_NS, Clock, S
from fieldrig.outside.limits import Reached
from fieldrig_devices.connections.connection import Serve
from fieldrig_devices.connections.stack_services import StackServices
from fieldrig_devices.ip.kernel_end import IpEnd
from fieldrig_devices.ip.services import RelayedServices
from fieldrig_devices.ip.stack import Stack
from fieldrig_devices.max4.com1.parameters import LOCAL_IP_ADDRESS, Com1Parameters
from fieldrig_devices.max4.com1.port import FULL
from fieldrig_devices.ppp.link import LoginAttempt, PppLink
from fieldrig_devices.ppp.phases import Phase
from fieldrig_devices.ppp.settings import Login, PppSettings

log = logging.getLogger(__name__)

REPORTED_FAILURES: Final = 3
WINDOW: Final = 8192
"""Receive window of a connection: some 2 s of a line at 38400 bit/s, and many times what its round trip needs."""
LOCAL: Final = IPv4Address(LOCAL_IP_ADDRESS)


class Chance(Protocol):
    """The part of `random.Random` that calls use."""

    def getrandbits(self, k: int, /) -> int: ...

    def randbytes(self, n: int, /) -> bytes: ...


class Owner(Protocol):
    """The controller, as its calls see it."""

    def tcp_connected(self, peer: str) -> None: ...

    def login_refused(self, name: str) -> None:
        """Report failed logins."""


class DialIn:
    """Answers the calls of one controller, one after another."""

    def __init__(
        self,
        clock: Clock,
        random: Chance,
        owner: Owner,
        services: Mapping[int, Serve],
        parameters: Callable[[], Com1Parameters],
        relayed: RelayedServices | None = None,
    ) -> None:
        """`services` are by TCP port; `relayed` are services of others; `parameters` are those of the present boot."""
        self._clock, self._random, self._owner, self._services = clock, random, owner, services
        self._parameters, self._relayed = parameters, relayed
        self.reached = Reached("calls at COM1", lambda: clock.now_ns() / S)
        self._watchdog = clock.watch(self._on_due)
        self._send: Callable[[bytes], None] = _drop
        self._hang_up: Callable[[], None] = _do_nothing
        self._waiting: Callable[[], int] = _nothing
        self._end: IpEnd | None = None
        self._link = PppLink(
            PppSettings(),
            lambda: random.getrandbits(32),
            lambda data: self._send(data),
            self._on_ip,
            self._on_phase,
            self._on_login,
        )

    @property
    def phase(self) -> Phase:
        """The phase of the present call; DEAD without a call."""
        return self._link.phase

    def answer(
        self, send: Callable[[bytes], None], hang_up: Callable[[], None], waiting: Callable[[], int]
    ) -> "DialIn":
        """Answer a call (`port.Answer`)."""
        self._send, self._hang_up, self._waiting = send, hang_up, waiting
        settings = self._settings()
        if settings is None:
            log.warning("a call is hung up: the Modem object has no UserName or no Password")
            hang_up()
        else:
            self._link.settings = settings
            self._link.up(self._clock.now_ns())
            self.wake()
        return self

    # ---- for the port

    def received(self, data: bytes) -> None:
        self._link.receive(self._clock.now_ns(), data)
        self.wake()

    def has_room(self) -> None:
        if self._end is not None:
            self._end.advance(self._clock.now_ns())
        self.wake()

    def ended(self) -> None:
        self._send, self._hang_up, self._waiting = _drop, _do_nothing, _nothing
        self._link.down(self._clock.now_ns())
        self._end_ip()
        self.wake()

    # ---- PPP

    def _settings(self) -> PppSettings | None:
        modem = self._parameters().modem
        if modem is None or not modem.user_name.value or not modem.password.value:
            return None
        login = Login.of(str(modem.user_name.value), str(modem.password.value))
        return PppSettings(
            demanded=login,
            local_address=LOCAL,
            peer_address=IPv4Address(str(modem.remote.value)),
            compresses_headers=True,  # PD-260
        )

    def _on_phase(self, phase: Phase) -> None:
        now_ns = self._clock.now_ns()
        if phase is Phase.NETWORK and not is_host(self._link.settings.peer_address):
            log.warning("a call ends: no host can have the RemoteIpAddress %s", self._link.settings.peer_address)
            self._link.close(now_ns)
        elif phase is Phase.RUNNING:
            self._begin_ip()
        elif phase is Phase.DEAD:
            log.debug("a call has ended: %s", self._link.ended_by)
            self._end_ip()
            self._hang_up()

    def _on_login(self, attempt: LoginAttempt) -> None:
        if attempt.failures >= REPORTED_FAILURES:
            self._owner.login_refused(attempt.name.decode("utf-8", "replace"))

    def _on_ip(self, packet: bytes) -> None:
        if self._end is not None:
            self._end.receive(self._clock.now_ns(), packet)

    # ---- IP

    def _begin_ip(self) -> None:
        self._end_ip()
        link = self._link
        end: IpEnd = Stack(
            link.local_address,
            link.mtu,
            self._transmit,
            window=WINDOW,
            secret=self._random.randbytes(16),
            has_room=lambda: self._waiting() < FULL,
            on_limit=self.reached.note,
        )
        if self._relayed is not None and isinstance(end, Stack):
            end = self._relayed.end_of(end, link.peer_address, link.mtu, self._transmit, self._waiting)
        self._end = end
        StackServices(end, self._services, self.wake, self._owner.tcp_connected, self.reached.note)
        if self._relayed is not None:
            self._relayed.attach(end)

    def _end_ip(self) -> None:
        end, self._end = self._end, None
        if self._relayed is not None:
            self._relayed.attach(None)
        if end is not None:
            end.link_down(self._clock.now_ns())

    def _transmit(self, packet: bytes) -> None:
        self._link.send_ip(self._clock.now_ns(), packet)

    # ---- time

    def _on_due(self) -> None:
        now_ns = self._clock.now_ns()
        self._link.advance(now_ns)
        if self._end is not None:
            self._end.advance(now_ns)
        self.wake()

    def wake(self) -> None:
        """Set the watchdog again, after what may have given the link or the stack something to do."""
        parts = (self._link, self._end) if self._end is not None else (self._link,)
        due = [due_ns for part in parts if (due_ns := part.next_ns()) is not None]
        self._watchdog.due_ns = max(min(due), self._clock.now_ns()) if due else NEVER_NS


def is_host(address: IPv4Address) -> bool:
    """Return true if a caller can have this address: not reserved, and not the controller's own."""
    is_special = address.is_loopback or address.is_multicast or address.is_reserved or address.is_unspecified
    return not is_special and address.packed[0] != 0 and address != LOCAL


def _drop(_data: bytes) -> None:
    """Send nothing, because there is no line."""


def _do_nothing() -> None:
    """Hang up nothing, because there is no line."""


def _nothing() -> int:
    """Return 0, because nothing waits without a line."""
    return 0
