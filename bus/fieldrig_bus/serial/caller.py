"""A caller in real time: passive code at a serial port of this host, with local TCP ports that lead through it.

The port is any that pyserial opens: a device, a pty, socket://HOST:PORT (or tcp://), rfc2217://HOST:PORT.  Threads read
and write it, because not every such port can be waited for together with sockets.
"""

import asyncio
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from ipaddress import IPv4Address
from queue import SimpleQueue
from typing import Any, Final, Protocol, cast

from serial import serial_for_url
from serial.serialutil import SerialException

from fieldrig.clock import S
from fieldrig.errors import BusError
from fieldrig.this_process import on_signals
from fieldrig_bus.ip.socks import SocksClient
from fieldrig_bus.ip.stream import Stream
from fieldrig_bus.ip.tunnel import Tunnelled
from fieldrig_bus.net import TcpServer

READ_S: Final = 0.1
"""Longest wait of a read, in seconds, after which the reading thread looks whether it should end."""
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
    def open(self, port: int) -> Stream: ...
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
    """Run a session to its end, and return it.  Ctrl-C and SIGTERM hang up.

    `on_up` is called when the link is up; before that, clients of the local ports are disconnected.  BusError if the
    serial port or a local port is not available.
    """
    return asyncio.run(_Call(url, baud, make_session, forwards, on_up).run())


class _SerialPort:
    """A serial port with a thread that reads and a thread that writes."""

    def __init__(self, url: str, baud: int) -> None:
        url = url.replace("tcp://", "socket://", 1) if url.startswith("tcp://") else url
        open_port = cast(Callable[..., Any], serial_for_url)
        try:
            self._port = open_port(url, baud, timeout=READ_S)
        except (SerialException, OSError, ValueError) as cause:
            expected = "expected a device, a pty, tcp://HOST:PORT or rfc2217://HOST:PORT"
            raise BusError(f"can't open {url}: {cause}", expected) from cause
        self._is_open = True
        self._unsent: SimpleQueue[bytes] = SimpleQueue()
        self._threads: list[threading.Thread] = []

    def start(self, on_data: Callable[[bytes], None], on_gone: Callable[[str], None]) -> None:
        """Call the handlers, in threads of the port."""
        for work in (self._read, self._write):
            thread = threading.Thread(target=self._work, args=(work, on_data, on_gone), daemon=True)
            thread.start()
            self._threads.append(thread)

    def send(self, data: bytes) -> None:
        self._unsent.put(data)

    def close(self) -> None:
        """Drop DTR, which makes a modem hang up, and close the port."""
        self._is_open = False
        self._unsent.put(b"")
        for thread in self._threads:
            thread.join(timeout=1.0)
        with suppress(SerialException, OSError):
            self._port.dtr = False
        with suppress(SerialException, OSError):
            self._port.close()

    def _work(
        self, work: Callable[[Callable[[bytes], None]], None], on_data: Callable[[bytes], None], on_gone: Any
    ) -> None:
        try:
            while self._is_open:
                work(on_data)
        except (SerialException, OSError, TypeError) as cause:  # TypeError: pyserial, if the port closes while it reads
            if self._is_open:
                on_gone(str(cause))

    def _read(self, on_data: Callable[[bytes], None]) -> None:
        data: bytes = self._port.read(1)
        if data:
            on_data(data + self._port.read(self._port.in_waiting))

    def _write(self, _: Callable[[bytes], None]) -> None:
        data = self._unsent.get()
        while not self._unsent.empty():
            data += self._unsent.get()
        if data:
            self._port.write(data)


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
        self._port = _SerialPort(url, baud)
        self._session = make_session(self._port.send)
        self._servers = [TcpServer(forward.local, self._way_to(forward.remote_port)) for forward in forwards]
        self._on_up = on_up
        self._gone = ""
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
        while not (session.is_over or self._gone):
            if session.is_up and not is_reported:
                is_reported = True
                self._on_up()
            due_ns = session.next_ns()
            wait_s = None if due_ns is None else max(due_ns - time.monotonic_ns(), 0) / S
            with suppress(TimeoutError):
                await asyncio.wait_for(self._changed.wait(), wait_s)
            self._changed.clear()
            session.advance(time.monotonic_ns())

    def _way_to(self, port: int | None) -> Callable[[TcpServer], Tunnelled]:
        if port is None:
            return lambda server: SocksClient(server, self._connect, self._changed.set)
        return lambda server: Tunnelled(server, lambda: self._session.open(port), self._changed.set)

    def _connect(self, address: IPv4Address, port: int) -> Stream:
        if address != self._session.peer_address:
            raise ConnectionError(f"{address} is not at the other end, but {self._session.peer_address}")
        return self._session.open(port)

    def _on_data(self, data: bytes) -> None:
        self._session.receive(time.monotonic_ns(), data)
        self._changed.set()

    def _on_gone(self, why: str) -> None:
        self._gone = why or "it was closed"
        self._changed.set()

    def _hang_up(self) -> None:
        self._session.hang_up(time.monotonic_ns())
        self._changed.set()
        asyncio.get_running_loop().call_later(PATIENCE_S, self._on_gone, "the modem did not hang up")


def _in(loop: asyncio.AbstractEventLoop, action: Callable[[Any], None], argument: object) -> None:
    """Call an action in the loop, from another thread; the loop may have ended."""
    with suppress(RuntimeError):
        loop.call_soon_threadsafe(action, argument)
