"""LCP: the link control protocol (RFC 1661), with echo, discard and the rejects of unknown protocols."""

from collections.abc import Callable
from typing import Final, Protocol

from fieldrig.clock import Alarm, Clock
from fieldrig_devices.ppp.framing import FrameFormat
from fieldrig_devices.ppp.lcp_options import LcpOptions
from fieldrig_devices.ppp.negotiation import Negotiation, Owner
from fieldrig_devices.ppp.packets import Code, Packet
from fieldrig_devices.ppp.phases import End
from fieldrig_devices.ppp.protocols import ProtocolNumber
from fieldrig_devices.ppp.settings import PppSettings
from fieldrig_devices.ppp.transitions import Event, PppState

MAGIC_LENGTH: Final = 4
PROTOCOL_LENGTH: Final = 2


class LcpOwner(Owner, Protocol):
    """The receiver of the reports of LCP."""

    def give_up(self, reason: End) -> None:
        """End the link, as no agreement is possible or the peer no longer answers."""

    def on_protocol_reject(self, protocol: int) -> None:
        """Take note that the peer doesn't know this protocol."""


class Lcp:
    def __init__(
        self,
        clock: Clock,
        settings: PppSettings,
        owner: LcpOwner,
        send: Callable[[int, bytes], None],
        new_magic: Callable[[], int],
    ) -> None:
        self._clock, self._settings, self._owner = clock, settings, owner
        self._send_frame = send
        self.options = LcpOptions(settings, new_magic)
        more_codes: dict[int, Callable[[Packet], None]] = {
            Code.PROTOCOL_REJECT: self._on_protocol_reject,
            Code.ECHO_REQUEST: self._on_echo_request,
            Code.ECHO_REPLY: self._on_echo_reply,
            Code.DISCARD_REQUEST: lambda packet: self.automaton.handle(Event.ECHO_OR_DISCARD, packet),
        }
        self._negotiation = Negotiation(
            clock, settings, self.options, self, self._send, lambda: self.options.peer_mru, more_codes
        )
        self.automaton = self._negotiation.automaton
        self._echo_timer = Alarm(self._clock)
        self._unanswered = 0

    def open(self) -> None:
        self._negotiation.open()

    def close(self) -> None:
        self.automaton.handle(Event.CLOSE)

    def receive(self, payload: bytes) -> None:
        self._negotiation.receive(payload)
        if self.options.refusal is not None:
            self._owner.give_up(self.options.refusal)

    def format(self) -> FrameFormat:
        """Return how to send to the peer, as it was granted."""
        options = self.options
        return FrameFormat(options.peer_accm, options.has_short_header, options.has_short_protocol)

    def reject_protocol(self, protocol: int, payload: bytes) -> None:
        """Answer a packet of an unknown protocol, if LCP is open (RFC 1661 5.7)."""
        if self._negotiation.is_opened:
            data = protocol.to_bytes(PROTOCOL_LENGTH, "big") + payload
            packet = Packet(Code.PROTOCOL_REJECT, self._negotiation.next_identifier(), data)
            self._send(packet.cut_to(self.options.peer_mru))

    def _send(self, packet: Packet) -> None:
        self._send_frame(ProtocolNumber.LCP, packet.encode())

    # Reports of the automaton.

    def layer_up(self, event: Event) -> None:
        self._unanswered = 0
        self._set_echo_timer()
        self._owner.layer_up(event)

    def layer_down(self, event: Event) -> None:
        self._echo_timer.stop()
        self._owner.layer_down(event)

    def layer_finished(self, event: Event) -> None:
        self._owner.layer_finished(event)

    # Echo and rejects.

    def _set_echo_timer(self) -> None:
        if self._settings.echo_period_ns:
            self._echo_timer.after(self._settings.echo_period_ns, self._send_echo)

    def _send_echo(self) -> None:
        if self._unanswered >= self._settings.most_echoes:
            self._owner.give_up(End.NO_ECHO)
            return
        self._unanswered += 1
        self._set_echo_timer()
        self._send(Packet(Code.ECHO_REQUEST, self._negotiation.next_identifier(), self._magic()))

    def _magic(self) -> bytes:
        return self.options.own_magic.to_bytes(MAGIC_LENGTH, "big")

    def _on_echo_request(self, packet: Packet) -> None:
        if len(packet.data) < MAGIC_LENGTH:
            raise ValueError("an Echo-Request without a magic number")
        reply = Packet(Code.ECHO_REPLY, packet.identifier, self._magic() + packet.data[MAGIC_LENGTH:])
        reply = reply.cut_to(self.options.peer_mru)
        self.automaton.handle(Event.ECHO_OR_DISCARD, packet, reply)

    def _on_echo_reply(self, packet: Packet) -> None:
        if len(packet.data) < MAGIC_LENGTH:
            raise ValueError("an Echo-Reply without a magic number")
        if packet.data[:MAGIC_LENGTH] != self._magic() or self.options.own_magic == 0:
            self._unanswered = 0  # with our own number it would be an echo of the line
        self.automaton.handle(Event.ECHO_OR_DISCARD, packet)

    def _on_protocol_reject(self, packet: Packet) -> None:
        if len(packet.data) < PROTOCOL_LENGTH:
            raise ValueError("a Protocol-Reject without a protocol")
        if self.automaton.state is not PppState.OPENED:
            return  # RFC 1661 5.7
        protocol = int.from_bytes(packet.data[:PROTOCOL_LENGTH], "big")
        self.automaton.handle(Event.FATAL_REJECT if protocol == ProtocolNumber.LCP else Event.HARMLESS_REJECT, packet)
        self._owner.on_protocol_reject(protocol)
