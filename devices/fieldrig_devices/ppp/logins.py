"""The logins of a call: the peer's, our own, both or none, before anything else may pass (RFC 1661 3.5)."""

import logging
from collections.abc import Callable
from typing import Protocol

from fieldrig.clock import Clock
from fieldrig_devices.logins.guard import LoginGuard
from fieldrig_devices.ppp.packets import Packet
from fieldrig_devices.ppp.pap import PapAuthenticator, PapCode, PapPeer
from fieldrig_devices.ppp.phases import End
from fieldrig_devices.ppp.settings import Login, PppSettings

log = logging.getLogger(__name__)


class LoginsOwner(Protocol):
    """The receiver of the reports of the logins."""

    def on_peer_login(self, login: Login, is_accepted: bool) -> None:
        """The peer tried to log in."""

    def on_logins_done(self) -> None:
        """All logins that were asked for are accepted."""

    def give_up(self, reason: End) -> None:
        """End the link, as a login failed."""


class Logins:
    def __init__(
        self,
        clock: Clock,
        settings: PppSettings,
        guard: LoginGuard,
        owner: LoginsOwner,
        send: Callable[[bytes], None],
    ) -> None:
        self._settings, self._owner = settings, owner
        self._authenticator = PapAuthenticator(clock, guard, send, self._on_peer_login)
        self._peer = PapPeer(clock, settings.restart_ns, settings.most_requests, send, self._on_own_login)
        self._is_peer_missing = self._is_own_missing = False

    def begin(self, must_log_in: bool) -> None:
        """Begin with a link that LCP has opened; `must_log_in` if the peer demands our login."""
        demanded, own = self._settings.demanded, self._settings.own
        self._is_peer_missing, self._is_own_missing = demanded is not None, must_log_in
        if demanded is not None:
            self._authenticator.begin(demanded)
        if must_log_in:
            assert own is not None, "LCP agrees to log in only with a login"
            self._peer.begin(own)
        self._go_on()

    def stop(self) -> None:
        self._authenticator.stop()
        self._peer.stop()

    def receive(self, payload: bytes) -> None:
        try:
            packet = Packet.decode(payload)
            receiver = self._authenticator if packet.code == PapCode.REQUEST else self._peer
            receiver.receive(packet)
        except ValueError as fault:
            log.debug("dropped a PAP packet: %s", fault)  # without its bytes, which may hold a password

    def _on_peer_login(self, login: Login, is_accepted: bool) -> None:
        self._owner.on_peer_login(login, is_accepted)
        if is_accepted:
            self._is_peer_missing = False
            self._go_on()
        else:
            self._owner.give_up(End.LOGIN_FAILED)

    def _on_own_login(self, is_accepted: bool | None) -> None:
        if is_accepted:
            self._is_own_missing = False
            self._go_on()
        else:
            self._owner.give_up(End.NO_ANSWER if is_accepted is None else End.LOGIN_REFUSED)

    def _go_on(self) -> None:
        if not self._is_peer_missing and not self._is_own_missing:
            self._owner.on_logins_done()
