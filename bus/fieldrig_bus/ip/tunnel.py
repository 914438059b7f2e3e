"""Sockets of this host that lead into a TCP/IP stack which is passive code: data, ends and back-pressure of both ways.

Each client of a local port, and each connection to a listener, has a `Stream` of its own.
"""

import asyncio
import logging
from collections.abc import Callable
from contextlib import suppress
from typing import Final

from fieldrig.outside.limits import Limits
from fieldrig_bus.ip.stream import Stream
from fieldrig_bus.net import Connection, TcpServer

log = logging.getLogger(__name__)

LIMITS: Final = Limits(first_message_s=None)
"""Limits of the connections that lead to a device, or from it to the host: a caller of it is an outsider as well.

Either end may speak first, so none has to say anything.
"""


def held_connections(bus: str) -> TcpServer:
    """Return a server that holds such connections and is never opened; which protocol they speak is not its matter."""
    return TcpServer(bus, _never, LIMITS, speaks_http=True)


def _never(_server: TcpServer) -> Connection:
    raise AssertionError("this server never listens")


class Tunnelled(Connection):
    """A client of a local port, and its stream."""

    def __init__(self, server: TcpServer, open_stream: Callable[[], Stream], on_change: Callable[[], None]) -> None:
        """`open_stream` raises ConnectionError if there is no way.

        `on_change` is called after calls of the stream, whose stack then has something to do.
        """
        super().__init__(server)
        self._open_stream, self._on_change = open_stream, on_change
        self._stream: Stream | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self.begin()

    def enter(self, peer: str) -> None:
        """Take a place among the connections, until this one is lost.  ConnectionError if this peer gets none."""
        if not self.server.door.is_open_to(peer):
            raise ConnectionError(f"{peer} has too many connections")
        self.server.door.enter(self, peer)

    def begin(self) -> None:
        """Open the stream."""
        try:
            stream = self._open_stream()
        except ConnectionError as cause:
            log.debug("a client was disconnected: %s", cause)
            self.transport.close()
            return
        stream.on_data, stream.on_end = self.transport.write, self._on_end
        stream.on_close, stream.on_room = self._on_close, lambda: self.read_on(True)
        self._stream = stream
        stream.resume()  # a stream whose other end speaks first is paused until it has these handlers
        self._on_change()

    def data_received(self, data: bytes) -> None:
        if self._stream is not None:
            self._stream.send(data)
            if self._stream.room == 0:
                self.read_on(False)
            self._on_change()

    def eof_received(self) -> bool:
        """The client has no more data; it may still be sent to."""
        if self._stream is not None:
            self._stream.end()
            self._on_change()
        return self._stream is not None

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.abort()
            self._on_change()

    def pause_writing(self) -> None:
        if self._stream is not None:
            self._stream.pause()

    def resume_writing(self) -> None:
        if self._stream is not None:
            self._stream.resume()
            self._on_change()

    def _on_end(self) -> None:
        if not self.transport.is_closing():
            with suppress(OSError):  # the client has reset the connection, and the loop tells us soon
                self.transport.write_eof()

    def _on_close(self, _reason: object) -> None:
        stream, self._stream = self._stream, None
        if stream is not None and stream.is_complete:
            self.transport.close()
        else:
            self.transport.abort()
