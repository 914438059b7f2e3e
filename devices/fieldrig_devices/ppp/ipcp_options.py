"""The options of IPCP (RFC 1332 chapter 3): the address of each end.

The compression of headers by Van Jacobson (RFC 1144) is rejected, as are the addresses of name servers (RFC 1877) and
the old form of the addresses (RFC 1332 3.1).
"""

from collections.abc import Sequence
from ipaddress import IPv4Address
from typing import Final

from fieldrig_devices.ppp.packets import Option
from fieldrig_devices.ppp.phases import End
from fieldrig_devices.ppp.settings import UNSET, PppSettings

IP_ADDRESS: Final = 3
LENGTH: Final = 4
MOST_NAKS: Final = 5
"""Refusals of a fixed address before there is no agreement."""


class IpcpOptions:
    """Both addresses, as agreed since the last `begin`."""

    def __init__(self, settings: PppSettings) -> None:
        self._settings = settings
        self.refusal: End | None = None
        """The reason why no agreement is possible."""
        self.begin()

    def begin(self) -> None:
        self.local_address = self._settings.local_address
        self.peer_address = self._settings.peer_address
        self._is_asked_for = True
        self._naks = 0

    def request(self) -> Sequence[Option]:
        return [Option(IP_ADDRESS, self.local_address.packed)] if self._is_asked_for else []

    def on_nak(self, option: Option) -> None:
        if option.kind != IP_ADDRESS or len(option.data) != LENGTH:
            return
        self._naks += 1
        if self._settings.local_address == UNSET:
            self.local_address = IPv4Address(option.data)
        elif self._naks >= MOST_NAKS:  # until then the fixed address is asked for again
            self.refusal = End.NO_ADDRESSES

    def on_reject(self, option: Option) -> None:
        if option.kind == IP_ADDRESS:
            self._is_asked_for = False
            if self.local_address == UNSET:
                self.refusal = End.NO_ADDRESSES

    def judge(self, option: Option) -> Option | None:
        if option.kind != IP_ADDRESS:
            return None
        wanted = self._settings.peer_address
        is_whole = len(option.data) == LENGTH
        if wanted != UNSET:
            return Option(IP_ADDRESS, wanted.packed)
        return option if is_whole and IPv4Address(option.data) != UNSET else None

    def missing(self, options: Sequence[Option]) -> Sequence[Option]:
        """Propose the address of the peer if it has asked for none (RFC 1332 3.3)."""
        wanted = self._settings.peer_address
        is_there = wanted == UNSET or any(option.kind == IP_ADDRESS for option in options)
        return [] if is_there else [Option(IP_ADDRESS, wanted.packed)]

    def agree(self, options: Sequence[Option]) -> None:
        for option in options:
            if option.kind == IP_ADDRESS:
                self.peer_address = IPv4Address(option.data)
