"""IPCP: agrees on the IP addresses of both ends, and on the compression of headers (RFC 1332)."""

from collections.abc import Callable
from ipaddress import IPv4Address
from typing import Final, Protocol

from fieldrig.clock import Clock
from fieldrig_devices.ppp.ipcp_options import IpcpOptions
from fieldrig_devices.ppp.negotiation import Negotiation
from fieldrig_devices.ppp.phases import End
from fieldrig_devices.ppp.settings import UNSET, PppSettings
from fieldrig_devices.ppp.transitions import Event, PppState
from fieldrig_devices.ppp.vj import Compressor, Decompressor

DOWN: Final = frozenset({PppState.INITIAL, PppState.STARTING})
REASONS: Final = {
    Event.TERMINATE_REQUEST: End.PEER_CLOSED,
    Event.FATAL_REJECT: End.PROTOCOL_REJECTED,
}
"""Reasons for the end by the event that caused it; `NO_ADDRESSES` for all others."""


class IpcpOwner(Protocol):
    """The receiver of the reports of IPCP."""

    def on_ip_up(self) -> None:
        """Both addresses are agreed."""

    def on_ip_down(self) -> None:
        """The addresses are no longer agreed."""

    def give_up(self, reason: End) -> None:
        """End the link, as IP was its only purpose."""


class Ipcp:
    def __init__(
        self,
        clock: Clock,
        settings: PppSettings,
        owner: IpcpOwner,
        send: Callable[[bytes], None],
        peer_mru: Callable[[], int],
    ) -> None:
        self._owner = owner
        self._options = IpcpOptions(settings)
        self._negotiation = Negotiation(
            clock, settings, self._options, self, lambda packet: send(packet.encode()), peer_mru
        )
        self._automaton = self._negotiation.automaton

    @property
    def addresses(self) -> tuple[IPv4Address, IPv4Address]:
        """The address of this end and that of the peer."""
        return self._options.local_address, self._options.peer_address

    def compressor(self) -> Compressor | None:
        """Return a new compressor as the peer has asked for it; None if it has not."""
        asked = self._options.peer_compression
        return None if asked is None else Compressor(asked.slots, may_omit_slot=asked.may_omit_slot)

    def decompressor(self) -> Decompressor | None:
        """Return a new decompressor; None if this end is to receive nothing that is compressed."""
        return Decompressor() if self._options.is_compression_asked_for else None

    def up(self) -> None:
        self._negotiation.open()

    def down(self) -> None:
        """Stop, as LCP is down."""
        if self._automaton.state not in DOWN:
            self._automaton.handle(Event.DOWN)

    def receive(self, payload: bytes) -> None:
        self._negotiation.receive(payload)
        if self._options.refusal is not None:
            self._owner.give_up(self._options.refusal)

    def on_protocol_reject(self) -> None:
        """Finish, as the peer doesn't know the protocol."""
        if self._automaton.state not in DOWN:
            self._automaton.handle(Event.FATAL_REJECT)

    def layer_up(self, event: Event) -> None:
        if self._options.local_address == UNSET:
            self._owner.give_up(End.NO_ADDRESSES)
        else:
            self._owner.on_ip_up()

    def layer_down(self, event: Event) -> None:
        self._owner.on_ip_down()
        if event in REASONS:
            self._owner.give_up(REASONS[event])

    def layer_finished(self, event: Event) -> None:
        self._owner.give_up(REASONS.get(event, End.NO_ADDRESSES))
