"""Modbus masters on TCP: each connection is a member of the bus.  Their number is limited; idle ones may be closed."""

import asyncio
import logging
from collections.abc import Callable
from operator import attrgetter
from typing import Any

from fieldrig.bus import Hub, Port
from fieldrig.link import Link
from fieldrig.net import split_address
from fieldrig_bus.net import Connection, TcpServer, join_as_client

log = logging.getLogger(__name__)

HALF_CLOSED_S = 1.0
"""Time for which a master that has finished sending still gets its answers."""


class Master(Connection):
    """One master.  While it does not read its answers, no further requests are read from it."""

    server: "Masters"

    def __init__(self, server: "Masters", hub: Hub) -> None:
        super().__init__(server)
        self.hub = hub
        self.member = ""
        self.used = 0
        """The number of its last request, counted over all masters."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self.member, link = join_as_client(self.hub, "tcp")
        self.on_open(link)
        self.server.add(self)

    def connection_lost(self, exc: Exception | None) -> None:
        self.on_close()
        self.hub.leave(self.member)
        self.server.remove(self)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        self.server.spoken += 1
        self.used = self.server.spoken
        self.on_bytes(data)

    def eof_received(self) -> bool:
        """The master has finished sending, as `nc -N` does; its requests are still answered (RFC 9293, 3.6)."""
        asyncio.get_running_loop().call_later(HALF_CLOSED_S, self.transport.close)
        return True

    def pause_writing(self) -> None:
        self.read_on(False)

    def resume_writing(self) -> None:
        self.read_on(True)

    def on_open(self, link: Link[Any]) -> None:
        """Called when the connection has become a member of the bus, before anything arrives."""

    def on_bytes(self, data: bytes) -> None:
        raise NotImplementedError

    def on_close(self) -> None:
        """Called when the connection is closed."""


class Masters(TcpServer):
    """A connection beyond `most` closes the longest idle one; any is closed after `idle_s` without requests."""

    def __init__(
        self, address: str, make: Callable[["Masters"], Master], most: int, idle_s: float | None = None
    ) -> None:
        super().__init__(address, lambda _: make(self))
        self._most, self._idle_s = most, idle_s
        self._masters: set[Master] = set()
        self.spoken = 0
        self._reaped = 0
        self._reaper: asyncio.TimerHandle | None = None

    async def open(self) -> None:
        await super().open()
        if self._idle_s is not None:
            self._reaper = asyncio.get_running_loop().call_later(self._idle_s, self._reap, self._idle_s)

    async def close(self) -> None:
        if self._reaper is not None:
            self._reaper.cancel()
        await super().close()

    def add(self, master: Master) -> None:
        self.spoken += 1
        master.used = self.spoken
        self._masters.add(master)
        if len(self._masters) > self._most:
            silent = min(self._masters, key=attrgetter("used"))
            log.debug("%s is closed for %s", silent.member, master.member)
            self.remove(silent)
            silent.transport.close()

    def remove(self, master: Master) -> None:
        self._masters.discard(master)

    def _reap(self, idle_s: float) -> None:
        """Close connections that have been idle for one to two such periods."""
        for master in self._masters:
            if master.used <= self._reaped:
                master.transport.close()
        self._reaped = self.spoken
        self._reaper = asyncio.get_running_loop().call_later(idle_s, self._reap, idle_s)


class MastersPort(Port):
    """A port for masters on TCP; `make` returns the bus member behind a connection."""

    def __init__(
        self, address: str, make: Callable[[Masters, Hub], Master], most: int, idle_s: float | None = None
    ) -> None:
        self._address, self._make, self._most, self._idle_s = address, make, most, idle_s
        self._masters: Masters | None = None

    @property
    def number(self) -> int:
        """The TCP port on which it listens."""
        return self._masters.port if self._masters is not None else split_address(self._address)[1]

    async def open(self, hub: Hub) -> None:
        masters = Masters(self._address, lambda masters: self._make(masters, hub), self._most, self._idle_s)
        await masters.open()
        self._masters = masters

    async def close(self) -> None:
        if self._masters is not None:
            await self._masters.close()
