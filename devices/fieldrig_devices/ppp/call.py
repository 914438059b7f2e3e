"""One call: the phases of a link from the carrier to its end (RFC 1661 chapter 3).

Each phase lets only its protocols pass, so that no order of frames gets past the login.  LCP passes always.  A protocol
that is unknown here, such as IPv6CP or CCP, is answered by a Protocol-Reject once the logins
are done, and before that it is dropped.
"""

import logging
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from ipaddress import IPv4Address
from typing import Final, Protocol

from fieldrig.clock import Alarm, VirtualClock
from fieldrig_devices.logins.guard import LoginGuard
from fieldrig_devices.ppp.framing import ALL_CONTROLS, Deframer, FrameCounts, FrameFormat, framed, unpacked
from fieldrig_devices.ppp.ipcp import Ipcp
from fieldrig_devices.ppp.lcp import Lcp
from fieldrig_devices.ppp.logins import Logins
from fieldrig_devices.ppp.phases import End, Phase
from fieldrig_devices.ppp.protocols import ProtocolNumber
from fieldrig_devices.ppp.settings import DEFAULT_MRU, UNSET, Login, PppSettings
from fieldrig_devices.ppp.transitions import Event
from fieldrig_devices.ppp.vj import Compressor, Decompressor

log = logging.getLogger(__name__)

PASSES: Final[Mapping[Phase, frozenset[int]]] = {
    Phase.AUTHENTICATE: frozenset({ProtocolNumber.PAP}),
    Phase.NETWORK: frozenset({ProtocolNumber.PAP, ProtocolNumber.IPCP}),
    Phase.RUNNING: frozenset(
        {
            ProtocolNumber.PAP,
            ProtocolNumber.IPCP,
            ProtocolNumber.IP,
            ProtocolNumber.VJ_COMPRESSED,
            ProtocolNumber.VJ_WHOLE,
        }
    ),
}
"""The protocols beside LCP that pass in a phase (RFC 1661 3.4 to 3.7)."""
PAST_LOGIN: Final = frozenset({Phase.NETWORK, Phase.RUNNING})
REASONS: Final[Mapping[Event, End]] = {
    Event.TERMINATE_REQUEST: End.PEER_CLOSED,
    Event.FATAL_REJECT: End.PROTOCOL_REJECTED,
}
"""Reasons for the end by the event of LCP that caused it; `NO_ANSWER` for all others."""


class User(Protocol):
    """The receiver of the reports of a call."""

    def transmit(self, data: bytes) -> None: ...
    def on_ip(self, packet: bytes) -> None: ...
    def on_phase(self, phase: Phase) -> None: ...
    def on_login(self, login: Login, is_accepted: bool) -> None: ...


@dataclass(slots=True)
class CallState:
    """The state of a call, for its user to read."""

    phase: Phase = Phase.DEAD
    ended_by: End | None = None
    local_address: IPv4Address = UNSET
    peer_address: IPv4Address = UNSET
    peer_name: bytes | None = None


class Call:
    def __init__(
        self, now_ns: int, settings: PppSettings, guard: LoginGuard, new_magic: Callable[[], int], user: User
    ) -> None:
        self.clock = VirtualClock(now_ns)
        self.state = CallState()
        self._settings, self._user = settings, user
        self._format = FrameFormat()
        self._deframer = Deframer()
        self._lcp = Lcp(self.clock, settings, self, self._send, new_magic)
        self._logins = Logins(self.clock, settings, guard, self, lambda data: self._send(ProtocolNumber.PAP, data))
        self._ipcp = Ipcp(
            self.clock,
            settings,
            self,
            lambda data: self._send(ProtocolNumber.IPCP, data),
            lambda: self._lcp.options.peer_mru,
        )
        self._compressor: Compressor | None = None
        self._decompressor: Decompressor | None = None
        self._frames_lost = 0
        self._setup_timer = Alarm(self.clock)
        self._takers: Mapping[int, Callable[[bytes], None]] = {
            ProtocolNumber.PAP: self._logins.receive,
            ProtocolNumber.IPCP: self._ipcp.receive,
            ProtocolNumber.IP: user.on_ip,
            ProtocolNumber.VJ_COMPRESSED: partial(self._on_vj, ProtocolNumber.VJ_COMPRESSED),
            ProtocolNumber.VJ_WHOLE: partial(self._on_vj, ProtocolNumber.VJ_WHOLE),
        }

    @property
    def mtu(self) -> int:
        return min(self._lcp.options.peer_mru, DEFAULT_MRU)

    @property
    def counts(self) -> FrameCounts:
        return self._deframer.counts

    @property
    def is_over(self) -> bool:
        return self.state.phase is Phase.DEAD

    def begin(self) -> None:
        self._enter(Phase.ESTABLISH)
        self._lcp.open()

    def lose_line(self) -> None:
        self._note_end(End.LINE_LOST)
        self._enter(Phase.DEAD)

    def frames(self, data: bytes) -> Iterator[bytes]:
        """Yield the contents of the frames in `data`; take each before the next is read."""
        return self._deframer.feed(data)

    def take(self, content: bytes) -> None:
        """Take the content of a frame."""
        try:
            protocol, payload = unpacked(content)
        except ValueError as fault:
            log.debug("dropped a frame: %s", fault)
            return
        phase = self.state.phase
        if protocol == ProtocolNumber.LCP:
            self._lcp.receive(payload)
        elif protocol in PASSES.get(phase, ()):
            self._takers[protocol](payload)
        elif phase in PAST_LOGIN and protocol not in self._takers:
            self._lcp.reject_protocol(protocol, payload)

    def send_ip(self, packet: bytes) -> bool:
        if self.state.phase is not Phase.RUNNING or len(packet) > self.mtu:
            return False
        compressed = self._compressor.compress(packet) if self._compressor is not None else None
        if compressed is None:
            self._send(ProtocolNumber.IP, packet)
        else:
            data, is_compressed = compressed
            self._send(ProtocolNumber.VJ_COMPRESSED if is_compressed else ProtocolNumber.VJ_WHOLE, data)
        return True

    def _on_vj(self, protocol: int, payload: bytes) -> None:
        """Take a packet with compressed headers."""
        decompressor = self._decompressor
        if decompressor is None:
            self._lcp.reject_protocol(protocol, payload)
            return
        if self._frames_lost != self.counts.lost:
            self._frames_lost = self.counts.lost
            decompressor.toss()
        restored = decompressor.whole if protocol == ProtocolNumber.VJ_WHOLE else decompressor.compressed
        try:
            packet = restored(payload)
        except ValueError as fault:
            log.debug("dropped a packet with compressed headers: %s", fault)
            return
        self._user.on_ip(packet)

    def _send(self, protocol: int, payload: bytes) -> None:
        self._user.transmit(framed(protocol, payload, self._format))

    # Phases.

    def give_up(self, reason: End) -> None:
        """End the call in order, unless it is ending already."""
        if self._note_end(reason):
            self._enter(Phase.TERMINATE)
            self._lcp.close()

    def _note_end(self, reason: End) -> bool:
        """Keep the first reason for the end; return whether it was this one."""
        is_first = self.state.ended_by is None
        if is_first:
            self.state.ended_by = reason
        return is_first

    def _enter(self, phase: Phase) -> None:
        state = self.state
        if phase is state.phase:
            return
        state.phase = phase
        is_running = phase is Phase.RUNNING
        state.local_address, state.peer_address = self._ipcp.addresses if is_running else (UNSET, UNSET)
        if phase is Phase.ESTABLISH and not self._setup_timer.is_set:
            self._setup_timer.after(self._settings.setup_limit_ns, self._on_setup_limit)
        elif phase in (Phase.RUNNING, Phase.DEAD):
            self._setup_timer.stop()
        self._user.on_phase(phase)

    def _on_setup_limit(self) -> None:
        is_waiting = self.state.phase is Phase.AUTHENTICATE
        self.give_up(End.LOGIN_TIMEOUT if is_waiting else End.NO_AGREEMENT)

    # Reports of LCP.

    def layer_up(self, event: Event) -> None:
        self._format = self._lcp.format()
        self._deframer.accm = self._lcp.options.accm
        self._enter(Phase.AUTHENTICATE)
        self._logins.begin(self._lcp.options.must_log_in)

    def layer_down(self, event: Event) -> None:
        self._format, self._deframer.accm = FrameFormat(), ALL_CONTROLS
        self._logins.stop()
        if event in REASONS:
            self._note_end(REASONS[event])
        self._enter(Phase.ESTABLISH if self.state.ended_by is None else Phase.TERMINATE)
        self._ipcp.down()

    def layer_finished(self, event: Event) -> None:
        self._note_end(REASONS.get(event, End.NO_ANSWER))
        self._enter(Phase.DEAD)

    def on_protocol_reject(self, protocol: int) -> None:
        if protocol in (ProtocolNumber.VJ_COMPRESSED, ProtocolNumber.VJ_WHOLE):
            self._compressor = None
        elif protocol == ProtocolNumber.IPCP:
            self._ipcp.on_protocol_reject()
        elif protocol == ProtocolNumber.IP:
            self.give_up(End.PROTOCOL_REJECTED)
        elif protocol == ProtocolNumber.PAP and self.state.phase is Phase.AUTHENTICATE:
            self.give_up(End.NO_AUTHENTICATION if self._settings.demanded else End.LOGIN_REFUSED)

    # Reports of the logins and of IPCP.

    def on_peer_login(self, login: Login, is_accepted: bool) -> None:
        if is_accepted:
            self.state.peer_name = login.name
        self._user.on_login(login, is_accepted)

    def on_logins_done(self) -> None:
        self._enter(Phase.NETWORK)
        self._ipcp.up()

    def on_ip_up(self) -> None:
        self._compressor, self._decompressor = self._ipcp.compressor(), self._ipcp.decompressor()
        self._frames_lost = self.counts.lost
        self._enter(Phase.RUNNING)

    def on_ip_down(self) -> None:
        self._compressor = self._decompressor = None
        if self.state.phase is Phase.RUNNING:
            self._enter(Phase.NETWORK)
