"""The options of IPCP (RFC 1332 chapter 3): the address of each end, and the compression of headers.

An end that asks for the compression (RFC 1332 4) is ready to receive it.  Every other one but that of Van Jacobson is
rejected, as are the addresses of name servers (RFC 1877) and the old form of the addresses (RFC 1332 3.1).
"""

from collections.abc import Sequence
from ipaddress import IPv4Address
from typing import Final, NamedTuple

from fieldrig_devices.ppp.packets import Option
from fieldrig_devices.ppp.phases import End
from fieldrig_devices.ppp.protocols import ProtocolNumber
from fieldrig_devices.ppp.settings import UNSET, PppSettings
from fieldrig_devices.ppp.vj import MOST_SLOTS

COMPRESSION: Final = 2
VJ: Final = ProtocolNumber.VJ_COMPRESSED.to_bytes(2, "big")
IP_ADDRESS: Final = 3
LENGTH: Final = 4
MOST_NAKS: Final = 5
"""Refusals of a fixed address before there is no agreement."""


class Compression(NamedTuple):
    """The value of the option: what its sender can receive."""

    slots: int
    may_omit_slot: bool

    @property
    def option(self) -> Option:
        return Option(COMPRESSION, VJ + bytes((self.slots - 1, self.may_omit_slot)))


OURS: Final = Compression(MOST_SLOTS, may_omit_slot=True)


class IpcpOptions:
    """Both addresses and the compression, as agreed since the last `begin`."""

    def __init__(self, settings: PppSettings) -> None:
        self._settings = settings
        self.refusal: End | None = None
        """The reason why no agreement is possible."""
        self.begin()

    def begin(self) -> None:
        self.local_address = self._settings.local_address
        self.peer_address = self._settings.peer_address
        self._is_asked_for = True
        self.is_compression_asked_for = self._settings.compresses_headers
        """True while this end is ready to receive compressed headers, and the peer has not refused that."""
        self.peer_compression: Compression | None = None
        self._naks = 0

    def request(self) -> Sequence[Option]:
        compression = [OURS.option] if self.is_compression_asked_for else []
        address = [Option(IP_ADDRESS, self.local_address.packed)] if self._is_asked_for else []
        return [*compression, *address]

    def on_nak(self, option: Option) -> None:
        if option.kind == COMPRESSION:  # the peer proposes what it would send; ours is not negotiable
            self.is_compression_asked_for = False
            return
        if option.kind != IP_ADDRESS or len(option.data) != LENGTH:
            return
        self._naks += 1
        if self._settings.local_address == UNSET:
            self.local_address = IPv4Address(option.data)
        elif self._naks >= MOST_NAKS:  # until then the fixed address is asked for again
            self.refusal = End.NO_ADDRESSES

    def on_reject(self, option: Option) -> None:
        if option.kind == COMPRESSION:
            self.is_compression_asked_for = False
        if option.kind == IP_ADDRESS:
            self._is_asked_for = False
            if self.local_address == UNSET:
                self.refusal = End.NO_ADDRESSES

    def judge(self, option: Option) -> Option | None:
        if option.kind == COMPRESSION:
            return self._judge_compression(option)
        if option.kind != IP_ADDRESS:
            return None
        wanted = self._settings.peer_address
        is_whole = len(option.data) == LENGTH
        if wanted != UNSET:
            return Option(IP_ADDRESS, wanted.packed)
        return option if is_whole and IPv4Address(option.data) != UNSET else None

    def _judge_compression(self, option: Option) -> Option | None:
        if not self._settings.compresses_headers:
            return None
        is_vj = option.data[:2] == VJ and len(option.data) == 4 and option.data[3] <= 1
        return option if is_vj else OURS.option

    def missing(self, options: Sequence[Option]) -> Sequence[Option]:
        """Propose the address of the peer if it has asked for none (RFC 1332 3.3)."""
        wanted = self._settings.peer_address
        is_there = wanted == UNSET or any(option.kind == IP_ADDRESS for option in options)
        return [] if is_there else [Option(IP_ADDRESS, wanted.packed)]

    def agree(self, options: Sequence[Option]) -> None:
        self.peer_compression = None
        for option in options:
            if option.kind == COMPRESSION:
                self.peer_compression = Compression(option.data[2] + 1, bool(option.data[3]))
            if option.kind == IP_ADDRESS:
                self.peer_address = IPv4Address(option.data)
