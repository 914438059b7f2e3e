"""TCP servers for outside clients: addresses in settings, a listener with its connections, a member for each client."""

import asyncio
import contextlib
from collections.abc import Callable
from typing import Annotated, Any, cast

from pydantic import AfterValidator, Field

from fieldrig.bus import Hub
from fieldrig.errors import BusError
from fieldrig.link import Link
from fieldrig.net import bind_remedy, split_address
from fieldrig.settings import Settings

MOST_UNREAD = 256 * 1024
"""Bytes kept for a client that does not read; data beyond that is lost to it."""
MOST_AT_ONCE = 4096
"""Bytes read from a client before the event loop continues with others."""


def _checked(address: str) -> str:
    split_address(address)
    return address


Address = Annotated[
    str,
    AfterValidator(_checked),
    Field(description="host:port, such as 127.0.0.1:5020; port 0: any free port"),
]
"""`host:port` in settings; `split_address` splits it."""


class HubSettings(Settings):
    """Addresses by which device processes reach the hub of a bus, other than its Unix socket."""

    attach: Address | None = Field(default=None, description="tcp://host:port where devices of other machines attach")
    connect: Address | None = Field(default=None, description="tcp://host:port of the hub, as device processes see it")


class Connection(asyncio.BufferedProtocol):
    """One client.  A subclass handles its bytes in `data_received`.

    Data is read in small portions: otherwise an event loop reads megabytes at once from a client that floods, and
    everything else in this process waits for seconds.
    """

    transport: asyncio.Transport

    def __init__(self, server: "TcpServer") -> None:
        self.server = server
        self.lost: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.is_full = False
        """True if the client does not read and `MOST_UNREAD` bytes wait for it."""
        self._portion = memoryview(bytearray(MOST_AT_ONCE))
        self._is_wanted = True

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = cast(
            asyncio.Transport, transport
        )  # uvloop's transport has the methods, but not the base class
        self.transport.set_write_buffer_limits(high=MOST_UNREAD)
        self.server.connections.add(self)

    def connection_lost(self, exc: Exception | None) -> None:
        self.server.connections.discard(self)
        self.lost.set_result(None)

    def get_buffer(self, sizehint: int) -> memoryview:
        return self._portion

    def buffer_updated(self, nbytes: int) -> None:
        self.data_received(self._portion[:nbytes].tobytes())
        if nbytes == MOST_AT_ONCE:
            self._read(False)
            asyncio.get_running_loop().call_soon(lambda: self._read(self._is_wanted))

    def data_received(self, data: bytes) -> None:
        raise NotImplementedError

    def read_on(self, is_wanted: bool) -> None:
        """Resume or pause reading from the client."""
        self._is_wanted = is_wanted
        self._read(is_wanted)

    def _read(self, is_wanted: bool) -> None:
        transport = self.transport
        if transport.is_closing() or transport.is_reading() == is_wanted:
            return
        if is_wanted:
            transport.resume_reading()
        else:
            transport.pause_reading()

    def pause_writing(self) -> None:
        self.is_full = True

    def resume_writing(self) -> None:
        self.is_full = False

    def write(self, data: bytes) -> None:
        """Send `data`, or drop all of it when the client does not read."""
        if not self.is_full:
            self.transport.write(data)


class TcpServer:
    """Listens at `address`; `make` creates the protocol of each connection."""

    def __init__(self, address: str, make: Callable[["TcpServer"], Connection]) -> None:
        self.address = address
        self.connections: set[Connection] = set()
        self._make = make
        self._server: asyncio.Server | None = None

    @property
    def port(self) -> int:
        """The port on which it listens; while it is closed, the configured one."""
        if self._server is not None and self._server.sockets:
            return int(self._server.sockets[0].getsockname()[1])
        return split_address(self.address)[1]

    async def open(self) -> None:
        """Listen.  BusError, with its remedy, if the address is not available."""
        host, port = split_address(self.address)
        loop = asyncio.get_running_loop()
        try:
            self._server = await loop.create_server(lambda: self._make(self), host, port)
        except OSError as cause:
            raise BusError(f"can't listen at {self.address}: {cause}", bind_remedy(cause)) from cause

    def stop_listening(self) -> None:
        """Accept no more connections; those that there are stay open."""
        if self._server is not None:
            self._server.close()
            self._server = None

    async def close(self) -> None:
        if self._server is None:
            return
        self._server.close()
        connections = list(self.connections)
        for connection in connections:
            connection.transport.abort()
        await asyncio.gather(*(connection.lost for connection in connections))
        await self._server.wait_closed()
        self._server = None


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
