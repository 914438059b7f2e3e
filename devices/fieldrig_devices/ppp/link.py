"""One end of a PPP link on an asynchronous line: bytes and time in, bytes, IP packets and phases out.

The way of a received byte: `framing` finds the frames, `call` decides what passes in the present phase, and `lcp`,
`pap`, `ipcp` or the user of this class takes it.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from ipaddress import IPv4Address

from fieldrig_devices.logins.guard import ALARM_AFTER, LoginGuard
from fieldrig_devices.ppp.call import Call
from fieldrig_devices.ppp.framing import FrameCounts
from fieldrig_devices.ppp.phases import End, Phase
from fieldrig_devices.ppp.settings import Login, PppSettings


@dataclass(frozen=True, slots=True)
class LoginAttempt:
    """One attempt of the peer to log in, as `on_login` reports it."""

    name: bytes
    """The user name as received, up to 255 bytes of any value."""
    is_accepted: bool
    failures: int
    """Failed attempts in a row, this one included, across all calls; 0 if it was accepted."""

    @property
    def is_alarm(self) -> bool:
        """True from the third failure in a row on, from which on answers are delayed by 10 s."""
        return self.failures >= ALARM_AFTER


class PppLink:
    """One end of a link, for one call after another.

    `up` begins when the line has a carrier, and `down` when it is lost.  After every call of a method, `next_ns`
    may have changed; `advance` must be called at that instant.  The callbacks are called within these methods, and may
    call all of them but `receive`:

    - `transmit(data)`: bytes for the line, whole frames; this one must not call the link
    - `on_ip(packet)`: an IPv4 packet from the peer
    - `on_phase(phase)`: the phase has changed.  After `Phase.DEAD` the line should be hung up, once the last frame has
      passed; `ended_by` has the reason
    - `on_login(attempt)`: the peer tried to log in

    `new_magic` returns any 32-bit number, each time another: `lambda: random.getrandbits(32)`.
    """

    def __init__(
        self,
        settings: PppSettings,
        new_magic: Callable[[], int],
        transmit: Callable[[bytes], None],
        on_ip: Callable[[bytes], None],
        on_phase: Callable[[Phase], None] = lambda phase: None,
        on_login: Callable[[LoginAttempt], None] = lambda attempt: None,
    ) -> None:
        self.settings = settings
        """May be replaced at any time; a new value acts from the next `up` on."""
        self._new_magic = new_magic
        self._user = _User(transmit, on_ip, on_phase, on_login)
        self._call = Call(0, settings, self._user.guard, new_magic, self._user)

    @property
    def phase(self) -> Phase:
        return self._call.state.phase

    @property
    def ended_by(self) -> End | None:
        """The reason for the end of the last call; None before the first and while none is known."""
        return self._call.state.ended_by

    @property
    def local_address(self) -> IPv4Address:
        """The address of this end while the phase is RUNNING; 0.0.0.0 in all others."""
        return self._call.state.local_address

    @property
    def peer_address(self) -> IPv4Address:
        """The address of the peer while the phase is RUNNING; 0.0.0.0 in all others and if it has stated none."""
        return self._call.state.peer_address

    @property
    def peer_name(self) -> bytes | None:
        """The user name with which the peer logged in during the last call; None if it has not."""
        return self._call.state.peer_name

    @property
    def mtu(self) -> int:
        """Longest packet that the peer takes, in bytes, at most 1500."""
        return self._call.mtu

    @property
    def counts(self) -> FrameCounts:
        """The frames received during the last call."""
        return self._call.counts

    def up(self, now_ns: int) -> None:
        """Begin a call, as the line has a carrier.  Without effect during a call."""
        if self._call.is_over:
            self._call = Call(now_ns, self.settings, self._user.guard, self._new_magic, self._user)
            self._call.begin()
            self._user.report()

    def down(self, now_ns: int) -> None:
        """End the call at once, as the line has lost its carrier.  Without effect if it has ended."""
        if not self._call.is_over:
            self._call.lose_line()
            self._user.report()

    def close(self, now_ns: int) -> None:
        """End the call in order.  `Phase.DEAD` follows when the peer has confirmed, or after two tries."""
        if not self._call.is_over:
            self._call.clock.advance_to(now_ns)
            self._call.give_up(End.CLOSED)
            self._user.report()

    def receive(self, now_ns: int, data: bytes) -> None:
        """Take any number of bytes from the line; bytes outside of a call are dropped."""
        self.advance(now_ns)
        call = self._call
        for content in call.frames(data):
            if call.is_over:
                break
            call.take(content)
            self._user.report()

    def send_ip(self, now_ns: int, packet: bytes) -> bool:
        """Send an IPv4 packet.  False, and nothing is sent, unless the phase is RUNNING and it fits into `mtu`."""
        return self._call.send_ip(packet)

    def next_ns(self) -> int | None:
        """Return the instant of the next timer; None without one."""
        return None if self._call.is_over else self._call.clock.next_ns()

    def advance(self, now_ns: int) -> None:
        """Let the timers act that are due at `now_ns` or before."""
        if not self._call.is_over:
            self._call.clock.advance_to(now_ns)
            self._user.report()


class _User:
    """Keeps the reports of a call until its step is complete, so that the callbacks may call the link."""

    def __init__(
        self,
        transmit: Callable[[bytes], None],
        on_ip: Callable[[bytes], None],
        on_phase: Callable[[Phase], None],
        on_login: Callable[[LoginAttempt], None],
    ) -> None:
        self.transmit = transmit
        self._take_ip, self._take_phase, self._take_login = on_ip, on_phase, on_login
        self.guard = LoginGuard()
        self._waiting: deque[Callable[[], None]] = deque()

    def on_ip(self, packet: bytes) -> None:
        self._waiting.append(partial(self._take_ip, packet))

    def on_phase(self, phase: Phase) -> None:
        self._waiting.append(partial(self._take_phase, phase))

    def on_login(self, login: Login, is_accepted: bool) -> None:
        attempt = LoginAttempt(login.name, is_accepted, self.guard.failures)
        self._waiting.append(partial(self._take_login, attempt))

    def report(self) -> None:
        while self._waiting:
            self._waiting.popleft()()
