"""One end of a PPP link on an asynchronous line: bytes and time in, bytes, IP packets and phases out.

The way of a received byte: `framing` finds the frames, `protocols` says what each carries, and LCP, PAP, IPCP or the
user of this class takes it.  RFC 1661 chapter 3 decides which protocols pass in which phase.
"""

from collections.abc import Callable
from dataclasses import dataclass
from ipaddress import IPv4Address

from fieldrig.clock import VirtualClock
from fieldrig_devices.ppp.phases import End, Phase
from fieldrig_devices.ppp.settings import UNSET, PppSettings


@dataclass(frozen=True, slots=True)
class LoginAttempt:
    """One attempt of the peer to log in, as `on_login` reports it."""

    name: bytes
    """The user name as received, up to 255 bytes of any value."""
    is_accepted: bool
    failures: int
    """Failed attempts in a row, this one included, across all calls; 0 if it was accepted."""


class PppLink:
    """One end of a link, for one call after another.

    `up` begins when the line has a carrier, and `down` when it is lost.  After every call of a method, `next_ns`
    may have changed; `advance` must be called at that instant.  The callbacks are called within these methods:

    - `transmit(data)`: bytes for the line, whole frames
    - `on_ip(packet)`: an IPv4 packet from the peer; `send_ip` may be called at once
    - `on_phase(phase)`: the phase has changed.  With `Phase.DEAD` the line should be hung up; `ended_by` has the reason
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
        self.phase = Phase.DEAD
        self.ended_by: End | None = None
        """The reason for the end of the last call; None during a call and before the first."""
        self.local_address: IPv4Address = UNSET
        """The address of this end while the phase is RUNNING."""
        self.peer_address: IPv4Address = UNSET
        """The address of the peer while the phase is RUNNING."""
        self.mtu = 1500
        """Longest packet that the peer takes, in bytes."""
        self.peer_name: bytes | None = None
        """The user name with which the peer logged in during this call; None before it has."""
        self._clock = VirtualClock()
        self._new_magic = new_magic
        self._transmit, self._on_ip, self._on_phase, self._on_login = transmit, on_ip, on_phase, on_login

    def up(self, now_ns: int) -> None:
        """Begin a call, as the line has a carrier.  Without effect during a call."""

    def down(self, now_ns: int) -> None:
        """End the call at once, as the line has lost its carrier."""

    def close(self, now_ns: int) -> None:
        """End the call in order.  `Phase.DEAD` follows when the peer has confirmed, or after two tries."""

    def receive(self, now_ns: int, data: bytes) -> None:
        """Take any number of bytes from the line."""

    def send_ip(self, now_ns: int, packet: bytes) -> bool:
        """Send an IPv4 packet.  False, and nothing is sent, unless the phase is RUNNING and it fits into `mtu`."""
        return False

    def next_ns(self) -> int | None:
        """Return the instant of the next timer; None without one."""
        return self._clock.next_ns()

    def advance(self, now_ns: int) -> None:
        """Let the timers act that are due at `now_ns` or before."""
        self._clock.advance_to(now_ns)
