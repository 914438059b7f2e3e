"""The negotiation of options that LCP and IPCP share (RFC 1661 chapter 5): packets in, events for the automaton out.

What an option means is the matter of its `Options`.  After five Configure-Naks for one request of the peer, the options
in question are rejected instead, and after five for one of ours, what the peer refuses is no longer asked for (4.6,
Max-Failure).
"""

import logging
from collections.abc import Callable, Mapping, Sequence
from typing import Final, Protocol

from fieldrig.clock import Clock
from fieldrig_devices.ppp.automaton import Automaton
from fieldrig_devices.ppp.packets import Code, Option, Packet, decode_options, encode_options
from fieldrig_devices.ppp.settings import DEFAULT_MRU, PppSettings
from fieldrig_devices.ppp.transitions import Event, PppState

log = logging.getLogger(__name__)

MOST_NAKS: Final = 5
NEGOTIATING: Final = frozenset({PppState.REQ_SENT, PppState.ACK_RCVD, PppState.ACK_SENT})
MOST_CODE: Final = Code.CODE_REJECT
"""Codes up to this one are needed by every layer, so that a reject of them is fatal."""


class Options(Protocol):
    """The options of one layer: those that this end asks for, and its opinion on those of the peer."""

    def begin(self) -> None:
        """Forget every agreement, as a negotiation begins."""

    def request(self) -> Sequence[Option]:
        """Return the options to ask for."""

    def judge(self, option: Option) -> Option | None:
        """Return an option of the peer as it is if it is acceptable, another proposal, or None to reject it."""

    def missing(self, options: Sequence[Option]) -> Sequence[Option]:
        """Return proposals for options that the peer should have asked for."""

    def agree(self, options: Sequence[Option]) -> None:
        """Take the options of the peer, all of which were acceptable."""

    def on_nak(self, option: Option) -> None:
        """Take a proposal of the peer for an option of ours."""

    def on_reject(self, option: Option) -> None:
        """Ask for this option no more."""


class Owner(Protocol):
    """The receiver of the reports of a layer, each with the event that caused it."""

    def layer_up(self, event: Event) -> None: ...
    def layer_down(self, event: Event) -> None: ...
    def layer_finished(self, event: Event) -> None: ...


class Negotiation:
    """One layer of RFC 1661: its automaton and its packets."""

    def __init__(
        self,
        clock: Clock,
        settings: PppSettings,
        options: Options,
        owner: Owner,
        send: Callable[[Packet], None],
        peer_mru: Callable[[], int],
        more_codes: Mapping[int, Callable[[Packet], None]] | None = None,
    ) -> None:
        """`more_codes` are the codes beyond Code-Reject that the layer knows."""
        self.automaton = Automaton(clock, self, settings.restart_ns, settings.most_requests)
        self._options, self._owner, self._send, self._peer_mru = options, owner, send, peer_mru
        self._codes = {
            Code.CONFIGURE_REQUEST: self._on_request,
            Code.CONFIGURE_ACK: self._on_ack,
            Code.CONFIGURE_NAK: self._on_nak,
            Code.CONFIGURE_REJECT: self._on_reject,
            Code.TERMINATE_REQUEST: lambda packet: self.automaton.handle(Event.TERMINATE_REQUEST, packet),
            Code.TERMINATE_ACK: lambda packet: self.automaton.handle(Event.TERMINATE_ACK, packet),
            Code.CODE_REJECT: self._on_code_reject,
            **(more_codes or {}),
        }
        self._identifier = self._asked_identifier = 0
        self._asked = b""
        """The options of the last Configure-Request, as sent."""
        self._is_answered = True
        self._naks_sent = self._naks_received = 0

    def open(self) -> None:
        """Begin the negotiation on a lower layer that is up."""
        self.automaton.handle(Event.OPEN)
        self.automaton.handle(Event.UP)

    @property
    def is_opened(self) -> bool:
        return self.automaton.state is PppState.OPENED

    def next_identifier(self) -> int:
        self._identifier = (self._identifier + 1) & 0xFF
        return self._identifier

    def receive(self, payload: bytes) -> None:
        """Take a packet; one that breaks the rules of RFC 1661 chapter 5 is dropped."""
        if self.automaton.state in (PppState.INITIAL, PppState.STARTING):
            return
        try:
            packet = Packet.decode(payload)
            self._codes.get(packet.code, self._on_unknown)(packet)
        except ValueError as fault:
            log.debug("dropped %s: %s", payload.hex(), fault)

    # What came.

    def _on_request(self, packet: Packet) -> None:
        asked = decode_options(packet.data)
        judged = [(option, self._options.judge(option)) for option in asked]
        rejected = [option for option, opinion in judged if opinion is None]
        better = [(option, opinion) for option, opinion in judged if opinion is not None and opinion != option]
        missing = self._options.missing(asked)
        if not rejected and (better or missing):
            self._naks_sent += 1
            if self._naks_sent > MOST_NAKS:
                rejected, missing = [option for option, _ in better], ()
        if rejected:
            code, options = Code.CONFIGURE_REJECT, rejected
        elif self._naks_sent <= MOST_NAKS and (better or missing):
            code, options = Code.CONFIGURE_NAK, [*(opinion for _, opinion in better), *missing]
        else:
            code, options = Code.CONFIGURE_ACK, asked
        event = Event.GOOD_REQUEST if code is Code.CONFIGURE_ACK else Event.BAD_REQUEST
        answer = Packet(code, packet.identifier, encode_options(options))
        if len(answer.data) > DEFAULT_MRU - Packet.WIRE.size:
            raise ValueError("too many options: the answer would be longer than a packet may be")
        self.automaton.handle(event, packet, answer)

    def _on_ack(self, packet: Packet) -> None:
        if packet.data == self._asked and self._is_answer(packet):
            self.automaton.handle(Event.ACK, packet)

    def _on_nak(self, packet: Packet) -> None:
        options = decode_options(packet.data)
        if not self._is_answer(packet):
            return
        self._naks_received += 1
        refuse = self._options.on_nak if self._naks_received <= MOST_NAKS else self._options.on_reject
        for option in options:
            refuse(option)
        self.automaton.handle(Event.NAK_OR_REJECT, packet)

    def _on_reject(self, packet: Packet) -> None:
        options = decode_options(packet.data)
        asked = decode_options(self._asked)
        if not options or any(option not in asked for option in options) or not self._is_answer(packet):
            return
        for option in options:
            self._options.on_reject(option)
        self.automaton.handle(Event.NAK_OR_REJECT, packet)

    def _is_answer(self, packet: Packet) -> bool:
        """Return whether it answers our last request, which is then answered."""
        if packet.identifier != self._asked_identifier:
            return False
        self._is_answered = True
        return True

    def _on_code_reject(self, packet: Packet) -> None:
        if not packet.data:
            raise ValueError("a Code-Reject without the rejected packet")
        is_fatal = packet.data[0] <= MOST_CODE
        self.automaton.handle(Event.FATAL_REJECT if is_fatal else Event.HARMLESS_REJECT, packet)

    def _on_unknown(self, packet: Packet) -> None:
        self.automaton.handle(Event.UNKNOWN_CODE, packet)

    # What the automaton does.

    def layer_up(self, event: Event) -> None:
        self._owner.layer_up(event)

    def layer_down(self, event: Event) -> None:
        self._owner.layer_down(event)

    def layer_finished(self, event: Event) -> None:
        self._owner.layer_finished(event)

    def send_request(self) -> None:
        """Send a Configure-Request: the same again, or one with a new identifier if anything has changed (5.1)."""
        if self.automaton.state not in NEGOTIATING:
            self._options.begin()
            self._naks_sent = self._naks_received = 0
            self._is_answered = True
        asked = encode_options(self._options.request())
        if self._is_answered or asked != self._asked:
            self._asked_identifier = self.next_identifier()
        self._asked, self._is_answered = asked, False
        self._send(Packet(Code.CONFIGURE_REQUEST, self._asked_identifier, asked))

    def send_terminate_request(self) -> None:
        self._send(Packet(Code.TERMINATE_REQUEST, self.next_identifier()))

    def send_answer(self, answer: Packet) -> None:
        if answer.code == Code.CONFIGURE_ACK:
            self._naks_sent = 0
            self._options.agree(decode_options(answer.data))
        self._send(answer)

    def send_terminate_ack(self, cause: Packet) -> None:
        self._send(Packet(Code.TERMINATE_ACK, cause.identifier))

    def send_code_reject(self, cause: Packet) -> None:
        packet = Packet(Code.CODE_REJECT, self.next_identifier(), cause.encode())
        self._send(packet.cut_to(self._peer_mru()))
