"""Base of the TCP ports of serial buses: one outside client is on the line at a time.

A second client waits for `GRACE_S`, so that a client that closes and reopens its connection gets the line regardless of
which event is seen first; after that its connection is closed.  A client that has sent nothing for `SILENT_S` gives way
to a second one, so that a connection which is only opened does not lock others out.  TCP keepalive detects a client
whose machine is gone.
"""

import asyncio
import logging
import time
from collections.abc import Callable
from typing import Protocol

from fieldrig.loop.pace import Pace
from fieldrig.outside.addresses import split_address
from fieldrig.outside.limits import FIRST_MESSAGE_S, OVER_LIMIT, Limits
from fieldrig.outside.vanished import notice_silence
from fieldrig_bus.net import Connection, TcpServer, cancel

log = logging.getLogger(__name__)

LIMITS = Limits(connections=8, first_message_s=None)
"""One client is on the line, and others wait for `GRACE_S`.  A client may only listen, and every byte is valid."""
GRACE_S = 0.5
SILENT_S = FIRST_MESSAGE_S
"""Time after which a client that has sent nothing gives way, in seconds."""
RETRY_S = 1.0


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
        self.server = TcpServer(address, self._connection, LIMITS, "serial line")
        self._dialling: asyncio.Task[None] | None = None
        self._current: _Connection | None = None
        self._waiting: list[_Connection] = []

    @property
    def port(self) -> int:
        """The port on which it listens."""
        return self.server.port

    async def open(self, pace: Pace | None = None) -> None:
        """Open the port.  BusError, with its remedy, if it cannot listen; the server that it dials may start later."""
        if self._is_dialling:
            self._dialling = asyncio.get_running_loop().create_task(self._dial())
        else:
            await self.server.open(pace)

    async def close(self) -> None:
        if self._dialling is not None:
            await cancel(self._dialling)
            self._dialling = None
            if self._current is not None:
                self._current.transport.abort()
                await self._current.lost
        await self.server.close()

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
        if self._current.is_silent:
            what = f"{self._current} has sent nothing for {SILENT_S:g} s and gives way to {connection}"
            self.server.door.reached.note("connections without a message", what)
            self._current.transport.abort()
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
            what = f"{connection} refused, {self._current} is on the line"
            self.server.door.reached.note(OVER_LIMIT, what)
            connection.transport.abort()

    async def _dial(self) -> None:
        loop = asyncio.get_running_loop()
        host, port = split_address(self._address)
        while True:
            try:
                _, connection = await loop.create_connection(lambda: _Connection(self.server, self), host, port)
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
        self._since_s: float | None = None

    @property
    def is_silent(self) -> bool:
        """True if the client has sent nothing in the time that it had for that."""
        return self._since_s is not None and time.monotonic() - self._since_s >= SILENT_S

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self._since_s = time.monotonic()
        notice_silence(transport.get_extra_info("socket"))
        self._place.arrived(self)

    def data_received(self, data: bytes) -> None:
        self._since_s = None
        if self.client is not None:
            self.client.received(data)

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        self._place.left(self)

    def __str__(self) -> str:
        return str(self.transport.get_extra_info("peername"))
