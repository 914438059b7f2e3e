"""A TCP connection to an outside address that is opened when it is needed, and reopened with increasing pauses.

Source: Modbus messaging on TCP/IP implementation guide V1.0b, 4.2: a client opens a connection when it has something to
send, and keeps it.  After a failure it waits 0.25 s, then twice as long each time, up to 8 s, until `worked` reports
that the connection has served its purpose.
"""

import asyncio
import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from fieldrig.outside.addresses import split_address
from fieldrig_bus.net import Connection, TcpServer, cancel

log = logging.getLogger(__name__)

FIRST_PAUSE_S: Final = 0.25
LONGEST_PAUSE_S: Final = 8.0
CONNECT_S: Final = 5.0


def pause_s(failures: int) -> float:
    """The pause before the next attempt, after this number of failures in a row."""
    return min(FIRST_PAUSE_S * 2.0 ** (failures - 1), LONGEST_PAUSE_S) if failures else 0.0


@dataclass(frozen=True, slots=True)
class Handlers:
    """The user of the connection."""

    opened: Callable[[], None]
    received: Callable[[bytes], None]
    closed: Callable[[], None]
    is_wanted: Callable[[], bool]
    """True if the connection is to be opened, or reopened, without a further `want`."""


class Dialler:
    def __init__(self, bus: str, address: str, handlers: Handlers) -> None:
        self._name, self._address, self.handlers = f"{bus}: {address}", address, handlers
        self._place = TcpServer(address, lambda server: _Outgoing(server, self))  # holds the connection; never opened
        self._connection: _Outgoing | None = None
        self._dialling: asyncio.Task[None] | None = None
        self._failures = 0
        self._is_told = False
        """The failure to reach the address has already been logged."""

    @property
    def is_open(self) -> bool:
        return self._connection is not None

    def want(self) -> None:
        """Connect as soon as the pause after the last failure is over."""
        if self._connection is None and self._dialling is None:
            self._dialling = asyncio.get_running_loop().create_task(self._dial(pause_s(self._failures)))

    def write(self, data: bytes) -> None:
        if self._connection is not None:
            self._connection.write(data)

    def read_on(self, is_wanted: bool) -> None:
        """Read what the address sends, or pause."""
        if self._connection is not None:
            self._connection.read_on(is_wanted)

    def worked(self) -> None:
        self._failures = 0

    def drop(self, why: str) -> None:
        """Close this connection because it is no longer usable."""
        if self._connection is not None:
            log.debug("%s: %s", self._name, why)
            self._connection.transport.abort()

    async def close(self) -> None:
        if self._dialling is not None:
            await cancel(self._dialling)
            self._dialling = None
        connection, self._connection = self._connection, None
        if connection is not None:
            connection.transport.abort()
            await connection.lost

    async def _dial(self, wait_s: float) -> None:
        host, port = split_address(self._address)
        while True:
            await asyncio.sleep(wait_s)
            if not self.handlers.is_wanted():
                break
            try:
                async with asyncio.timeout(CONNECT_S):
                    await asyncio.get_running_loop().create_connection(self._place_for_one, host, port)
            except OSError as fault:  # includes TimeoutError, and a name that cannot be resolved
                wait_s = self._fail(str(fault) or "no answer")
            else:
                break
        self._dialling = None
        if self._connection is None and self.handlers.is_wanted():  # it was closed immediately
            self.want()

    def _place_for_one(self) -> "_Outgoing":
        return _Outgoing(self._place, self)

    def arrived(self, connection: "_Outgoing") -> None:
        get = connection.transport.get_extra_info
        if get("sockname") == get("peername"):  # TCP allows an end to connect to itself where no server listens
            self._failures += 1
            connection.transport.abort()
            return
        (log.info if self._is_told else log.debug)("%s is connected", self._name)
        self._is_told = False
        self._connection = connection
        self._failures += 1  # until it has worked
        self.handlers.opened()

    def left(self, connection: "_Outgoing") -> None:
        if connection is not self._connection:
            return
        self._connection = None
        log.debug("%s has closed", self._name)
        self.handlers.closed()
        if self.handlers.is_wanted():
            self.want()

    def _fail(self, why: str) -> float:
        self._failures += 1
        (log.debug if self._is_told else log.info)("%s cannot be reached: %s; trying again", self._name, why)
        self._is_told = True
        return pause_s(self._failures)


class _Outgoing(Connection):
    def __init__(self, server: TcpServer, dialler: Dialler) -> None:
        super().__init__(server)
        self._dialler = dialler

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self._dialler.arrived(self)

    def data_received(self, data: bytes) -> None:
        self._dialler.handlers.received(data)

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        self._dialler.left(self)
