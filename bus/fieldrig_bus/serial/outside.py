"""Base of the TCP ports of serial buses: one outside client is on the line at a time.

A second client waits for `GRACE_S`, so that a client that closes and reopens its connection gets the line regardless of
which event is seen first; after that its connection is closed.  TCP keepalive detects a client whose machine is gone.
"""

import asyncio
import logging
import socket
from collections.abc import Callable
from typing import Protocol

from fieldrig.net import split_address
from fieldrig_bus.net import Connection, TcpServer, cancel

log = logging.getLogger(__name__)

GRACE_S = 0.5
RETRY_S = 1.0
KEEPALIVE = {
    "TCP_KEEPIDLE": 10,
    "TCP_KEEPINTVL": 5,
    "TCP_KEEPCNT": 3,
}  # seconds, seconds, probes; where the system has them


class Client(Protocol):
    """The object that a port creates for one connection."""

    def started(self) -> None: ...
    def received(self, data: bytes) -> None: ...
    def ended(self) -> None: ...


class ClientPlace:
    """The place on the line, which one client at a time has; `make` creates a client for its connection.

    It listens at the address, or, with `is_dialling`, connects to it again whenever the other side has closed.
    """

    def __init__(self, address: str, make: Callable[[Connection], Client], is_dialling: bool = False) -> None:
        self._make = make
        self._address, self._is_dialling = address, is_dialling
        self._server = TcpServer(address, self._connection)
        self._dialling: asyncio.Task[None] | None = None
        self._current: _Connection | None = None
        self._waiting: list[_Connection] = []

    @property
    def port(self) -> int:
        """The port on which it listens."""
        return self._server.port

    async def open(self) -> None:
        """Open the port.  BusError, with its remedy, if it can't listen; the server that it dials may start later."""
        if self._is_dialling:
            self._dialling = asyncio.get_running_loop().create_task(self._dial())
        else:
            await self._server.open()

    async def close(self) -> None:
        if self._dialling is not None:
            await cancel(self._dialling)
            self._dialling = None
            if self._current is not None:
                self._current.transport.abort()
                await self._current.lost
        await self._server.close()

    def write(self, data: bytes) -> None:
        if self._current is not None:
            self._current.write(data)

    def read_on(self, is_wanted: bool) -> None:
        if self._current is not None:
            self._current.read_on(is_wanted)

    def arrived(self, connection: "_Connection") -> None:
        if self._current is None:
            self._begin(connection)
            return
        connection.read_on(False)
        self._waiting.append(connection)
        asyncio.get_running_loop().call_later(GRACE_S, self._refuse, connection)

    def left(self, connection: "_Connection") -> None:
        if connection in self._waiting:
            self._waiting.remove(connection)
        if connection is not self._current:
            return
        self._current = None
        if connection.client is not None:
            connection.client.ended()
        if self._waiting:
            self._begin(self._waiting.pop(0))

    def _connection(self, server: TcpServer) -> "_Connection":
        return _Connection(server, self)

    def _begin(self, connection: "_Connection") -> None:
        self._current = connection
        connection.client = self._make(connection)
        connection.client.started()
        connection.read_on(True)

    def _refuse(self, connection: "_Connection") -> None:
        if connection in self._waiting:
            log.info("%s: %s refused, %s is on the line", self._address, connection, self._current)
            connection.transport.abort()

    async def _dial(self) -> None:
        loop = asyncio.get_running_loop()
        host, port = split_address(self._address)
        while True:
            try:
                _, connection = await loop.create_connection(lambda: _Connection(self._server, self), host, port)
                await asyncio.shield(connection.lost)
            except OSError as fault:
                log.debug("%s: %s", self._address, fault)
            await asyncio.sleep(RETRY_S)


class _Connection(Connection):
    """One TCP connection of an outside client."""

    def __init__(self, server: TcpServer, place: ClientPlace) -> None:
        super().__init__(server)
        self._place = place
        self.client: Client | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        _keep_alive(transport.get_extra_info("socket"))
        self._place.arrived(self)

    def data_received(self, data: bytes) -> None:
        if self.client is not None:
            self.client.received(data)

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        self._place.left(self)

    def __str__(self) -> str:
        return str(self.transport.get_extra_info("peername"))


def _keep_alive(sock: socket.socket) -> None:
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in KEEPALIVE.items():
        if hasattr(socket, name):
            sock.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
