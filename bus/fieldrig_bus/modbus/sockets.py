"""Modbus masters on TCP: each connection is a member of the bus.  Their number is limited; idle ones may be closed."""

import asyncio
from collections.abc import Callable, Iterable
from typing import Any

from fieldrig.bus import Hub
from fieldrig.link import Link
from fieldrig.loop.pace import Pace
from fieldrig.outside.addresses import split_address
from fieldrig.outside.limits import Limits
from fieldrig.outside.portions import MOST_AT_ONCE
from fieldrig_bus.modbus.damaged import write_damaged
from fieldrig_bus.modbus.message import DamagedAnswer
from fieldrig_bus.modbus.turns import Turns
from fieldrig_bus.net import Connection, ServingPort, TcpServer, join_as_client

HALF_CLOSED_S = 1.0
"""Time for which a master that has finished sending still gets its answers."""


class Master(Connection):
    """One master.  While it does not read its answers, no further requests are read from it."""

    server: "Masters"

    def __init__(self, server: "Masters", hub: Hub, most: int = MOST_AT_ONCE) -> None:
        """`most` is the size of a portion, in bytes."""
        super().__init__(server, most)
        self.hub = hub
        self.member = ""
        self.used = 0
        """The number of its last request, counted over all masters."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self.member, link = join_as_client(self.hub, "tcp")
        self.server.spoken += 1
        self.used = self.server.spoken
        self.on_open(link)

    def connection_lost(self, exc: Exception | None) -> None:
        self.on_close()
        self.hub.leave(self.member)
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
        self.is_full = True
        self.read_on(False)

    def resume_writing(self) -> None:
        self.is_full = False
        self.read_on(True)

    def on_open(self, link: Link[Any]) -> None:
        """Called when the connection has become a member of the bus, before anything arrives."""

    def on_bytes(self, data: bytes) -> None:
        raise NotImplementedError

    def on_close(self) -> None:
        """Called when the connection is closed."""

    def _write_damaged(self, answer: DamagedAnswer) -> None:
        """Write the bytes of a damaged answer at their instants, and cut the connection if it says so."""
        write_damaged(self.hub.clock, self._write_open, answer)
        if answer.is_cut:
            self.transport.close()

    def _write_open(self, data: bytes) -> None:
        if not self.transport.is_closing():
            self.transport.write(data)


class Masters(TcpServer):
    """A connection beyond `most` closes the longest idle one; any is closed after `idle_s` without requests."""

    def __init__(
        self, address: str, make: Callable[["Masters"], Master], most: int, idle_s: float | None = None
    ) -> None:
        limits = Limits(most, replaces_idle=True)
        super().__init__(address, lambda _: make(self), limits, "Modbus")
        self._idle_s = idle_s
        self.turns = Turns()
        self.spoken = 0
        self._reaped = 0
        self._reaper: asyncio.TimerHandle | None = None

    async def open(self, pace: Pace | None = None) -> None:
        await super().open(pace)
        if self._idle_s is not None:
            self._reaper = asyncio.get_running_loop().call_later(self._idle_s, self._reap, self._idle_s)

    async def close(self) -> None:
        if self._reaper is not None:
            self._reaper.cancel()
        await super().close()

    def _reap(self, idle_s: float) -> None:
        """Close connections that have been idle for one to two such periods."""
        for master in self.connections:
            if isinstance(master, Master) and master.used <= self._reaped:
                master.transport.close()
        self._reaped = self.spoken
        self._reaper = asyncio.get_running_loop().call_later(idle_s, self._reap, idle_s)


class MastersPort(ServingPort):
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
        await masters.open(hub.pace)
        self._masters = masters
        hub.on_doors(self.meet)

    def servers(self) -> Iterable[TcpServer]:
        return () if self._masters is None else (self._masters,)

    async def close(self) -> None:
        if self._masters is not None:
            await self._masters.close()
