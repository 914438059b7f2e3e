"""PAP: a user name and a password in plain text (RFC 1334 chapter 2), both ends of it."""

from collections.abc import Callable
from enum import IntEnum

from fieldrig.clock import Alarm, Clock
from fieldrig_devices.logins.guard import LoginGuard
from fieldrig_devices.ppp.packets import Packet
from fieldrig_devices.ppp.settings import Login


class PapCode(IntEnum):
    REQUEST = 1
    ACK = 2
    NAK = 3


def encode_login(login: Login) -> bytes:
    return b"".join(bytes((len(text),)) + text for text in (login.name, login.password))


def decode_login(data: bytes) -> Login:
    """Return the login of an Authenticate-Request.  ValueError if its lengths lead past the end."""
    name, rest = _counted(data)
    password, _ = _counted(rest)
    return Login(name, password)


def _counted(data: bytes) -> tuple[bytes, bytes]:
    if not data or len(data) < 1 + data[0]:
        raise ValueError("a text leads past the end of the packet")
    return data[1 : 1 + data[0]], data[1 + data[0] :]


class PapPeer:
    """The end that logs in.  It repeats its request until it is answered."""

    def __init__(
        self,
        clock: Clock,
        restart_ns: int,
        most_requests: int,
        send: Callable[[bytes], None],
        on_result: Callable[[bool | None], None],
    ) -> None:
        """`on_result` is called with True or False as the answer says, or with None if there is none."""
        self._clock, self._restart_ns, self._most_requests = clock, restart_ns, most_requests
        self._send, self._on_result = send, on_result
        self._login: Login | None = None
        self._timer = Alarm(self._clock)
        self._identifier = self._count = 0

    def begin(self, login: Login) -> None:
        self.stop()
        self._login, self._count = login, self._most_requests
        self._request()

    def stop(self) -> None:
        self._login = None
        self._timer.stop()

    def _request(self) -> None:
        assert self._login is not None, "a timer of a login that has stopped"
        if self._count == 0:
            self.stop()
            self._on_result(None)
            return
        self._count -= 1
        self._identifier = (self._identifier + 1) & 0xFF
        self._timer.after(self._restart_ns, self._request)
        self._send(Packet(PapCode.REQUEST, self._identifier, encode_login(self._login)).encode())

    def receive(self, packet: Packet) -> None:
        """Take an Authenticate-Ack or -Nak.  One to an earlier request counts too, as the login was the same."""
        if self._login is not None and packet.code in (PapCode.ACK, PapCode.NAK):
            self.stop()
            self._on_result(packet.code == PapCode.ACK)


class PapAuthenticator:
    """The end that checks the login.  It checks one attempt, and repeats its answer to every further request."""

    def __init__(
        self,
        clock: Clock,
        guard: LoginGuard,
        send: Callable[[bytes], None],
        on_result: Callable[[Login, bool], None],
    ) -> None:
        self._clock, self._guard, self._send, self._on_result = clock, guard, send, on_result
        self._demanded: Login | None = None
        self._answer: PapCode | None = None
        self._attempt: tuple[int, Login] | None = None
        self._timer = Alarm(self._clock)

    def begin(self, demanded: Login) -> None:
        self.stop()
        self._demanded = demanded

    def stop(self) -> None:
        self._demanded = self._answer = self._attempt = None
        self._timer.stop()

    def receive(self, packet: Packet) -> None:
        """Take an Authenticate-Request.  ValueError for a malformed one."""
        if packet.code != PapCode.REQUEST or self._demanded is None:
            return
        login = decode_login(packet.data)
        if self._answer is not None:
            self._reply(packet.identifier, self._answer)  # RFC 1334 2.2.1: the same answer again
            return
        is_waiting, self._attempt = self._attempt is not None, (packet.identifier, login)
        if is_waiting:
            return  # the answer is for the latest request
        if self._guard.delay_ns:
            self._timer.after(self._guard.delay_ns, self._decide)
        else:
            self._decide()

    def _decide(self) -> None:
        assert self._attempt is not None
        assert self._demanded is not None
        identifier, login = self._attempt
        demanded = self._demanded
        is_accepted = self._guard.is_right((login.name, login.password), (demanded.name, demanded.password))
        self._attempt, self._answer = None, PapCode.ACK if is_accepted else PapCode.NAK
        self._reply(identifier, self._answer)
        self._on_result(login, is_accepted)

    def _reply(self, identifier: int, code: PapCode) -> None:
        text = b"" if code == PapCode.ACK else b"Login incorrect"
        self._send(Packet(code, identifier, bytes((len(text),)) + text).encode())
