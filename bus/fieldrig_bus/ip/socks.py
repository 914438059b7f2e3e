"""A SOCKS 5 proxy for one host (RFC 1928): the command CONNECT, without authentication, to an IPv4 address.

A client gets its reply when the other end has accepted or refused the connection, or when it does not answer.  Left
out: BIND, UDP, IPv6, and names, apart from an address written as a name.
"""

from collections.abc import Callable
from dataclasses import dataclass
from ipaddress import IPv4Address
from typing import Final

from fieldrig_bus.ip.stream import Opening, Stream
from fieldrig_bus.ip.tunnel import Tunnelled
from fieldrig_bus.net import TcpServer

VERSION: Final = 5
NO_AUTHENTICATION: Final = 0
NO_METHOD: Final = 0xFF
CONNECT: Final = 1
IPV4, NAME, IPV6 = 1, 3, 4

# RFC 1928, 6: the field REP of a reply
SUCCEEDED, GENERAL_FAILURE, NOT_REACHABLE, HOST_UNREACHABLE = 0, 1, 3, 4
CONNECTION_REFUSED, COMMAND_REFUSED, ADDRESS_REFUSED = 5, 7, 8

_ADDRESS_BYTES: Final = {IPV4: 4, IPV6: 16}


@dataclass(frozen=True, slots=True)
class Request:
    """A client wants to connect; `refusal` is the reply that it gets instead, or None."""

    address: IPv4Address | None
    port: int
    refusal: int | None = None


class Handshake:
    """The conversation with a client up to its request, as passive code."""

    def __init__(self) -> None:
        self._received = bytearray()
        self._has_method = False

    def feed(self, data: bytes) -> tuple[bytes, Request | None]:
        """Take bytes, and return the answer to them, and the request when it is complete.

        ValueError for a client that does not speak SOCKS 5, or wants to authenticate.  Once a method is chosen, a
        request that is none has a reply like any other.
        """
        self._received += data
        answer = b""
        if not self._has_method:
            method = self._take_method()
            if method is None:
                return b"", None
            answer = bytes((VERSION, method))
        return answer, self._take_request()

    @property
    def rest(self) -> bytes:
        """The bytes that came behind the request."""
        return bytes(self._received)

    def _take_method(self) -> int | None:
        received = self._received
        if received[:1] not in (b"", bytes((VERSION,))):
            raise ValueError(f"version {received[0]}, expected SOCKS 5")
        if len(received) < 2 or len(received) < 2 + received[1]:
            return None
        methods = received[2 : 2 + received[1]]
        if NO_AUTHENTICATION not in methods:
            raise ValueError("the client wants to authenticate, expected that it does not")
        del received[: 2 + received[1]]
        self._has_method = True
        return NO_AUTHENTICATION

    def _take_request(self) -> Request | None:
        received = self._received
        if received[:1] not in (b"", bytes((VERSION,))):
            return Request(None, 0, GENERAL_FAILURE)
        if len(received) < 4:
            return None
        command, address_type = received[1], received[3]
        if address_type not in (NAME, *_ADDRESS_BYTES):  # its length is not known, nor what follows it
            return Request(None, 0, ADDRESS_REFUSED if command == CONNECT else COMMAND_REFUSED)
        if len(received) < 5:
            return None
        start = 5 if address_type == NAME else 4
        size = received[4] if address_type == NAME else _ADDRESS_BYTES[address_type]
        if len(received) < start + size + 2:
            return None
        host, port = (
            bytes(received[start : start + size]),
            int.from_bytes(received[start + size : start + size + 2], "big"),
        )
        del received[: start + size + 2]
        if command != CONNECT:
            return Request(None, port, COMMAND_REFUSED)
        address = _address(address_type, host)
        return Request(address, port, ADDRESS_REFUSED if address is None else None)


def reply(code: int) -> bytes:
    """Return a reply, whose address is left empty."""
    return bytes((VERSION, code, 0, IPV4)) + bytes(6)


def _address(address_type: int, host: bytes) -> IPv4Address | None:
    try:
        return IPv4Address(host if address_type == IPV4 else host.decode("ascii"))
    except ValueError:  # includes AddressValueError and UnicodeDecodeError
        return None


class SocksClient(Tunnelled):
    """A client of the proxy."""

    def __init__(
        self, server: TcpServer, connect: Callable[[IPv4Address, int], Opening], on_change: Callable[[], None]
    ) -> None:
        """`connect` raises ConnectionError for an address that it does not reach."""
        super().__init__(server, self._open, on_change)
        self._connect = connect
        self._handshake: Handshake | None = Handshake()
        self._request = Request(None, 0)
        self._opening: Opening | None = None

    def begin(self) -> None:
        """Wait for the request."""

    def data_received(self, data: bytes) -> None:
        if self._handshake is None:
            super().data_received(data)
            return
        try:
            answer, request = self._handshake.feed(data)
        except ValueError:
            self.transport.write(bytes((VERSION, NO_METHOD)))
            self.transport.close()
            return
        self.transport.write(answer)
        if request is not None:
            self.heard()
            rest, self._handshake = self._handshake.rest, None
            self._on_request(request, rest)

    def _on_request(self, request: Request, rest: bytes) -> None:
        self._request = request
        if request.refusal is not None:
            self.transport.write(reply(request.refusal))
            self.transport.close()
        else:
            super().begin()
            if rest:
                super().data_received(rest)

    def _open(self) -> Stream:
        assert self._request.address is not None, "a request without a refusal has an address"
        try:
            self._opening = self._connect(self._request.address, self._request.port)
        except ConnectionError:
            self.transport.write(reply(NOT_REACHABLE))
            raise
        self._opening.on_open = self._on_open
        return self._opening

    def _on_open(self) -> None:
        self._opening = None
        self.transport.write(reply(SUCCEEDED))

    def _on_close(self, reason: object) -> None:
        if self._opening is None:
            super()._on_close(reason)
            return
        self._stream = None
        self.transport.write(reply(CONNECTION_REFUSED if self._opening.is_refused else HOST_UNREACHABLE))
        self.transport.close()
