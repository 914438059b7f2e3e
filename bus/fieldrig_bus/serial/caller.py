"""A caller in real time: passive code at a serial port of this host, with local TCP ports that lead through it.

Ctrl-C hangs up in order.
"""

import asyncio
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from ipaddress import IPv4Address
from typing import Any, Final, Protocol

from fieldrig.clock import S
from fieldrig.errors import BusError
from fieldrig.outside.limits import Limits
from fieldrig.system.this_process import on_signals
from fieldrig_bus.ip.socks import SocksClient
from fieldrig_bus.ip.stream import Opening
from fieldrig_bus.ip.tunnel import LIMITS, Tunnelled
from fieldrig_bus.net import TcpServer
from fieldrig_bus.serial.threaded_port import ThreadedPort

PATIENCE_S: Final = 15.0
"""Longest time for hanging up in order."""


class Session(Protocol):
    """The passive caller."""

    @property
    def is_over(self) -> bool: ...
    @property
    def is_up(self) -> bool: ...
    def start(self, now_ns: int) -> None: ...
    def receive(self, now_ns: int, data: bytes) -> None: ...
    def next_ns(self) -> int | None: ...
    def advance(self, now_ns: int) -> None: ...
    @property
    def peer_address(self) -> IPv4Address: ...
    def open(self, port: int) -> Opening: ...
    def hang_up(self, now_ns: int) -> None: ...


@dataclass(frozen=True, slots=True)
class Forward:
    """A local port, and the port at the far end to which it leads."""

    local: str
    """`host:port`."""
    remote_port: int | None
    """None for a SOCKS proxy, whose clients name the port."""


MakeSession = Callable[[Callable[[bytes], None]], Session]
"""Makes the session; its argument takes bytes for the line."""


def call(
    url: str, baud: int, make_session: MakeSession, forwards: Sequence[Forward], on_up: Callable[[], None]
) -> Session:
    """Run a session to its end, and return it.  Ctrl-C and SIGTERM hang up, and the second time without waiting.

    `on_up` is called when the link is up; before that, clients of the local ports are disconnected.  BusError if the
    serial port or a local port is not available.
    """
    return asyncio.run(_Call(url, baud, make_session, forwards, on_up).run())


class _Call:
    """One call in a running event loop."""

    def __init__(
        self,
        url: str,
        baud: int,
        make_session: MakeSession,
        forwards: Sequence[Forward],
        on_up: Callable[[], None],
    ) -> None:
        self._port = ThreadedPort(url, baud)
        self._session = make_session(self._port.send)
        self._servers = [self._server(forward) for forward in forwards]
        self._on_up = on_up
        self._arrived = bytearray()
        self._gone = ""
        self._is_leaving = self._is_forced = False
        self._url = url
        self._changed = asyncio.Event()

    async def run(self) -> Session:
        loop = asyncio.get_running_loop()
        on_signals(("SIGINT", "SIGTERM"), self._hang_up)
        self._port.start(
            lambda data: _in(loop, self._on_data, data),
            lambda why: _in(loop, self._on_gone, why),
        )
        try:
            await self._talk()
        finally:
            for server in self._servers:
                await server.close()
            await asyncio.to_thread(self._port.close)
        if self._gone and not self._session.is_over:
            raise BusError(f"{self._url} is gone: {self._gone}", "check the cable, or start its rig again")
        return self._session

    async def _talk(self) -> None:
        session, is_reported = self._session, False
        for server in self._servers:  # before the call, so that an address that is taken costs none
            await server.open()
        session.start(time.monotonic_ns())
        while not (session.is_over or self._is_forced or (self._gone and not self._arrived)):
            if session.is_up and not is_reported:
                is_reported = True
                self._on_up()
            due_ns = session.next_ns()
            wait_s = None if due_ns is None else max(due_ns - time.monotonic_ns(), 0) / S
            with suppress(TimeoutError):
                async with asyncio.timeout(wait_s):
                    await self._changed.wait()
            self._changed.clear()
            self._step()

    def _step(self) -> None:
        """Take everything that has arrived at once, because each look at all timers of many connections costs time."""
        data, now_ns = bytes(self._arrived), time.monotonic_ns()
        self._arrived.clear()
        if data:
            self._session.receive(now_ns, data)
        self._session.advance(now_ns)

    def _server(self, forward: Forward) -> TcpServer:
        """Return the server of a local port.  Only a client of the proxy has to say something, which is its request."""
        limits = Limits() if forward.remote_port is None else LIMITS
        return TcpServer(forward.local, self._way_to(forward.remote_port), limits, speaks_http=True)

    def _way_to(self, port: int | None) -> Callable[[TcpServer], Tunnelled]:
        if port is None:
            return lambda server: SocksClient(server, self._connect, self._changed.set)
        return lambda server: Tunnelled(server, lambda: self._session.open(port), self._changed.set)

    def _connect(self, address: IPv4Address, port: int) -> Opening:
        if address != self._session.peer_address:
            raise ConnectionError(f"{address} is not at the other end, but {self._session.peer_address}")
        return self._session.open(port)

    def _on_data(self, data: bytes) -> None:
        self._arrived += data
        self._changed.set()

    def _on_gone(self, why: str) -> None:
        self._gone = why or "it was closed"
        self._changed.set()

    def _hang_up(self) -> None:
        """Hang up in order; the second time, or if that takes too long, by closing the port."""
        if self._is_leaving:
            self._force()
            return
        self._is_leaving = True
        self._session.hang_up(time.monotonic_ns())
        self._changed.set()
        asyncio.get_running_loop().call_later(PATIENCE_S, self._force)

    def _force(self) -> None:
        self._is_forced = True
        self._changed.set()


def _in(loop: asyncio.AbstractEventLoop, action: Callable[[Any], None], argument: object) -> None:
    """Call an action in the loop, from another thread; the loop may have ended."""
    with suppress(RuntimeError):
        loop.call_soon_threadsafe(action, argument)
