"""TCP servers for outside clients: addresses in settings, a listener with its connections, a member for each client."""

import asyncio
import contextlib
import logging
import time
from abc import abstractmethod
from collections.abc import Callable, Iterable
from typing import Any, cast

from pydantic import Field

from fieldrig.bus import Doors, Hub, Port, Refusal
from fieldrig.errors import BusError
from fieldrig.link import Link
from fieldrig.loop.pace import Pace
from fieldrig.outside.addresses import bind_remedy, split_address
from fieldrig.outside.limits import Door, Limits
from fieldrig.outside.portions import MOST_AT_ONCE, Hold, Portions
from fieldrig.settings import Address, Settings
from fieldrig_bus.browsers import FirstLine

log = logging.getLogger(__name__)

MOST_UNREAD = 256 * 1024
"""Bytes kept for a client that does not read; data beyond that is lost to it."""


class HubSettings(Settings):
    """Addresses by which device processes reach the hub of a bus, other than its Unix socket."""

    attach: Address | None = Field(default=None, description="tcp://host:port where devices of other machines attach")
    connect: Address | None = Field(default=None, description="tcp://host:port of the hub, as device processes see it")


class Connection(Portions):
    """One client.  A subclass handles its bytes in `data_received`, in small portions."""

    transport: asyncio.Transport

    def __init__(self, server: "TcpServer", most: int = MOST_AT_ONCE) -> None:
        """`most` is the size of a portion, in bytes."""
        super().__init__(most)
        self.server = server
        self.lost: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.is_full = False
        """True if the client does not read and `MOST_UNREAD` bytes wait for it."""
        self._first_line = None if server.speaks_http else FirstLine()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = cast(
            asyncio.Transport, transport
        )  # uvloop's transport has the methods, but not the base class
        self.transport.set_write_buffer_limits(high=MOST_UNREAD)
        self.server.connections.add(self)
        self.hold(Hold.HUB, self.server.is_held)
        self.pace = self.server.pace

    def connection_lost(self, exc: Exception | None) -> None:
        self.server.connections.discard(self)
        self.server.door.leave(self)
        if self.pace is not None:
            self.pace.leave(self)
            self.pace = None
        if not self.lost.done():  # the wait for it may have been cut short
            self.lost.set_result(None)

    def take(self, data: bytes) -> None:
        if self.transport.is_closing():  # something in the same portion was the reason
            return
        if self._first_line is not None:
            if self._first_line.is_request(data):
                self.server.door.reached.note("requests of HTTP", "a client sends HTTP; its connection is closed")
                self.shut()
                return
            if self._first_line.is_over:
                self._first_line = None
        self.data_received(data)

    def heard(self) -> None:
        """Note that a complete message has arrived: this client is one of the service, and not silent."""
        self.server.door.heard(self)

    def shut(self) -> None:
        """Close the connection at once."""
        self.transport.abort()

    def read_on(self, is_wanted: bool) -> None:
        """Resume or pause reading from the client."""
        self.hold(Hold.OWN, not is_wanted)

    def read_from_now(self, is_wanted: bool) -> None:
        if self.transport.is_closing():
            return
        if is_wanted:
            self.transport.resume_reading()
        else:
            self.transport.pause_reading()

    def pause_writing(self) -> None:
        self.is_full = True

    def resume_writing(self) -> None:
        self.is_full = False

    def write(self, data: bytes) -> None:
        """Send `data`, or drop all of it when the client does not read."""
        if not self.is_full:
            self.transport.write(data)
        elif not self.transport.is_closing():
            self.server.door.reached.note("messages lost", "a client does not read, and what is for it is lost")


class TcpServer:
    """Listens at `address`; `make` creates the protocol of each connection that the limits allow."""

    def __init__(
        self,
        address: str,
        make: Callable[["TcpServer"], Connection],
        limits: Limits = Limits(),  # noqa: B008  it is frozen
        service: str = "",
        speaks_http: bool = False,
    ) -> None:
        """`service` names it in the log; by default that is its address.

        Without `speaks_http`, a client that begins with a request of HTTP is disconnected (`browsers`).
        """
        self.address = address
        self.speaks_http = speaks_http
        self.connections: set[Connection] = set()
        self.door = Door(f"{service} at {address}" if service else address, limits)
        self.pace: Pace | None = None
        self.is_held = False
        """True while nothing is read from any client."""
        self._make = make
        self._server: asyncio.Server | None = None
        self._port: int | None = None
        """The port on which it has listened; a server that was never opened has none."""
        self._loop: asyncio.AbstractEventLoop | None = None
        self._coming_back: asyncio.Task[None] | None = None
        self._timer: asyncio.TimerHandle | None = None

    @property
    def port(self) -> int:
        """The port on which it listens; while it is closed, the configured one."""
        if self._server is not None and self._server.sockets:
            return int(self._server.sockets[0].getsockname()[1])
        return split_address(self.address)[1] if self._port is None else self._port

    async def open(self, pace: Pace | None = None) -> None:
        """Listen, and read at this pace.  BusError, with its remedy, if the address is not available."""
        self.pace = pace
        self._loop = asyncio.get_running_loop()
        await self._listen()
        self._port = self.port

    async def _listen(self) -> None:
        host, port = split_address(self.address)[0], self.port
        loop = asyncio.get_running_loop()
        try:
            self._server = await loop.create_server(lambda: _Entrance(self), host, port)
        except OSError as cause:
            raise BusError(f"cannot listen at {self.address}: {cause}", bind_remedy(cause)) from cause

    def let_in(self, transport: asyncio.Transport) -> None:
        """Make the protocol of a new connection, or close it."""
        address = transport.get_extra_info("peername")
        peer = address[0] if address else ""
        if not self.door.is_open_to(peer):
            transport.abort()
            return
        connection = self._make(self)
        self.door.enter(connection, peer)
        transport.set_protocol(connection)
        connection.connection_made(transport)
        self._watch_the_silent()

    def hold(self, is_held: bool) -> None:
        """Read nothing from all clients, or go on."""
        self.is_held = is_held
        for connection in self.connections:
            connection.hold(Hold.HUB, is_held)

    def stop_listening(self) -> None:
        """Accept no more connections; those that there are stay open."""
        if self._server is not None:
            self._server.close()
            self._server = None

    def refuse(self, is_on: bool) -> None:
        """Have the system refuse new connections, or listen again; those that there are stay open."""
        if self._coming_back is not None:
            self._coming_back.cancel()
            self._coming_back = None
        if is_on:
            self.stop_listening()
        elif self._server is None and self._loop is not None:
            self._coming_back = self._loop.create_task(self._come_back())

    async def _come_back(self) -> None:
        try:
            await self._listen()
        except BusError as cause:  # another program has taken the port meanwhile
            log.warning("%s; %s", cause.what, cause.remedy)

    async def close(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        if self._coming_back is not None:
            await cancel(self._coming_back)
        server, self._server = self._server, None
        if server is not None:
            server.close()
        connections = list(self.connections)
        for connection in connections:
            connection.transport.abort()
        await asyncio.gather(*(connection.lost for connection in connections))
        if server is not None:
            await server.wait_closed()

    def _watch_the_silent(self) -> None:
        due_s = self.door.next_s()
        if due_s is not None and (self._timer is None or self._timer.cancelled()):
            loop = asyncio.get_running_loop()
            self._timer = loop.call_later(max(0.0, due_s - time.monotonic()), self._on_timer)

    def _on_timer(self) -> None:
        self._timer = None
        self.door.expire()
        self._watch_the_silent()


class _Entrance(asyncio.Protocol):
    """A connection before the door has decided about it."""

    def __init__(self, server: TcpServer) -> None:
        self._server = server

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._server.let_in(cast(asyncio.Transport, transport))


class ServingPort(Port):
    """A port whose clients come in by `TcpServer`s."""

    @abstractmethod
    def servers(self) -> Iterable[TcpServer]:
        """Return the servers that are there now."""

    def hold(self, is_held: bool) -> None:
        for server in self.servers():
            server.hold(is_held)

    def meet(self, doors: Doors) -> None:
        """Let a fault have its effect on the clients."""
        for server in self.servers():
            if isinstance(doors, Refusal):
                server.refuse(doors.is_on)
            else:
                for connection in server.connections:
                    connection.transport.close()

    def statistics(self) -> dict[str, float]:
        figures: dict[str, float] = {}
        for server in self.servers():
            for name, count in server.door.reached.figures().items():
                figures[name] = figures.get(name, 0.0) + count
        return figures


async def cancel(task: asyncio.Task[None]) -> None:
    """Cancel a task, and wait until it has ended."""
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task


def join_as_client(hub: Hub, prefix: str) -> tuple[str, Link[Any]]:
    """Join under the lowest free number: `socketcand:1`, `socketcand:2`."""
    number = 1
    while True:
        member = f"{prefix}:{number}"
        try:
            return member, hub.join(member)
        except ValueError:
            number += 1
