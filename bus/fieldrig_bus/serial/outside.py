"""What the ports of serial buses to TCP have in common: one outsider on the line at a time.

A second client waits for `GRACE_S`, so that one who closes and opens again gets the line whichever of the two is seen
first; then it is refused by closing its connection.  A client whose machine vanished is found by TCP's keepalive.
"""

import asyncio
import contextlib
import logging
import socket
from collections.abc import Callable
from typing import Protocol

from fieldrig.net import split_address
from fieldrig_bus.net import Connection, TcpServer

log = logging.getLogger(__name__)

GRACE_S = 0.5
RETRY_S = 1.0
KEEPALIVE = {"TCP_KEEPIDLE": 10, "TCP_KEEPINTVL": 5, "TCP_KEEPCNT": 3}  # seconds, seconds, probes; where there is such


class Client(Protocol):
    """What a port makes of one connection."""

    def started(self) -> None: ...
    def received(self, data: bytes) -> None: ...
    def ended(self) -> None: ...


class ClientPlace:
    """The place that one outsider at a time has; `make` makes a client of its connection.

    The address is listened at, or with `is_dialling` dialled, again whenever the other side has closed.
    """

    def __init__(self, address: str, make: Callable[[Connection], Client], is_dialling: bool = False) -> None:
        self._make = make
        self._address, self._is_dialling = address, is_dialling
        self._server = TcpServer(address, self._connection)
        self._dialling: asyncio.Task[None] | None = None
        self._current: _Outsider | None = None
        self._waiting: list[_Outsider] = []

    @property
    def port(self) -> int:
        """Where it listens."""
        return self._server.port

    async def open(self) -> None:
        """BusError, with its remedy, if the address can't be had; who is dialled may come later."""
        if self._is_dialling:
            self._dialling = asyncio.get_running_loop().create_task(self._dial())
        else:
            await self._server.open()

    async def close(self) -> None:
        if self._dialling is not None:
            self._dialling.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._dialling
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

    def arrived(self, outsider: "_Outsider") -> None:
        if self._current is None:
            self._begin(outsider)
            return
        outsider.read_on(False)
        self._waiting.append(outsider)
        asyncio.get_running_loop().call_later(GRACE_S, self._refuse, outsider)

    def left(self, outsider: "_Outsider") -> None:
        if outsider in self._waiting:
            self._waiting.remove(outsider)
        if outsider is not self._current:
            return
        self._current = None
        if outsider.client is not None:
            outsider.client.ended()
        if self._waiting:
            self._begin(self._waiting.pop(0))

    def _connection(self, server: TcpServer) -> "_Outsider":
        return _Outsider(server, self)

    def _begin(self, outsider: "_Outsider") -> None:
        self._current = outsider
        outsider.client = self._make(outsider)
        outsider.client.started()
        outsider.read_on(True)

    def _refuse(self, outsider: "_Outsider") -> None:
        if outsider in self._waiting:
            log.info("%s: %s refused, %s is on the line", self._address, outsider, self._current)
            outsider.transport.abort()

    async def _dial(self) -> None:
        loop = asyncio.get_running_loop()
        host, port = split_address(self._address)
        while True:
            try:
                _, outsider = await loop.create_connection(lambda: _Outsider(self._server, self), host, port)
                await asyncio.shield(outsider.lost)
            except OSError as fault:
                log.debug("%s: %s", self._address, fault)
            await asyncio.sleep(RETRY_S)


class _Outsider(Connection):
    """One TCP connection of an outsider."""

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
