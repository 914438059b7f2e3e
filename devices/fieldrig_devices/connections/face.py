"""The services of a device on a `tcp.server` bus.

A device sends at most a window ahead of what the network has taken, so a client that does not read costs the bus no
memory.  The rest waits in the device, and sessions limit it.
"""

from collections.abc import Callable, Mapping
from typing import Final

from fieldrig.link import Link
from fieldrig_bus.tcp.message import (
    MOST_DATA,
    Close,
    Connect,
    Connected,
    Data,
    Ended,
    Listen,
    Listening,
    Taken,
    TcpMessage,
    Unlisten,
    Unreached,
)
from fieldrig_devices.connections.connection import Serve, Session

WINDOW: Final = 64 * 1024
"""Bytes that may be under way, beyond what the network has taken."""


class TcpFace:
    """`on_connected` is called with the address of each client; `services` are by name."""

    def __init__(
        self,
        link: Link[TcpMessage],
        services: Mapping[str, Serve],
        on_connected: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._link, self._services, self._on_connected = link, services, on_connected
        self._connections: dict[int, _LinkConnection] = {}
        self._is_open = False
        link.on_receive(self._on_message, sorted(services))

    def open(self) -> None:
        """Accept connections from now on; before, each is closed at once."""
        self._is_open = True

    def close(self) -> None:
        """End all connections, and accept no more, at power-off."""
        self._is_open = False
        for connection in list(self._connections.values()):
            connection.lose()
            connection.close_at_once()

    def forget(self, number: int) -> None:
        self._connections.pop(number, None)

    def _on_message(self, message: TcpMessage) -> None:
        if isinstance(message, Connected):
            self._on_connection(message)
            return
        connection = self._connections.get(message.connection)
        if connection is None:
            return
        match message:
            case Data(data=data):
                connection.hear(data)
            case Taken(count=count):
                connection.taken(count)
            case Ended(is_lost=True):
                connection.lose()
            case Ended():
                connection.end()
            case Listening(port=port):
                connection.listening(port)
            case Unreached():
                connection.unreached()

    def _on_connection(self, message: Connected) -> None:
        stale = self._connections.get(message.connection)
        if stale is not None:  # the hub has been restarted, and counts from 1 again
            stale.lose()
        serve = self._services.get(message.service)
        if message.origin:
            origin = self._connections.get(message.origin)
            serve = origin.on_connection if origin is not None else None
        if serve is None or not self._is_open:
            self._link.send(Close(message.connection))
            return
        connection = _LinkConnection(self, self._link, message)
        self._connections[message.connection] = connection
        if not message.origin:
            self._on_connected(message.peer)
        connection.session = serve(connection)


class _LinkConnection:
    """The `Connection` of one client."""

    def __init__(self, face: TcpFace, link: Link[TcpMessage], connected: Connected) -> None:
        self._face, self._link, self._number = face, link, connected.connection
        self.peer, self.local = connected.peer, connected.local
        self.session: Session | None = None
        self.on_connection: Serve | None = None
        self._on_port: Callable[[int], None] = lambda _: None
        self._on_failed: Callable[[], None] = lambda: None
        self._waiting = bytearray()
        self._under_way = 0
        self._is_closing = self._is_told = False

    # ---- for the session

    @property
    def unsent(self) -> int:
        return len(self._waiting) + self._under_way

    def handle_later(self) -> None:
        self._is_told = True

    def handled(self, count: int) -> None:
        self._link.send(Taken(self._number, count))

    def write(self, data: bytes) -> None:
        if not self._is_closing:
            self._waiting += data
            self._feed()

    def close(self) -> None:
        self._is_closing = True
        self.session = None
        if not self._waiting:
            self.close_at_once()

    def cut(self, limit: str) -> None:
        self.session = None
        self.close_at_once(limit)

    def listen(self, on_port: Callable[[int], None], on_connection: Serve) -> None:
        self._on_port, self.on_connection = on_port, on_connection
        self._link.send(Listen(self._number))

    def connect(self, port: int, on_failed: Callable[[], None], on_connection: Serve) -> None:
        self._on_failed, self.on_connection = on_failed, on_connection
        self._link.send(Connect(self._number, port))

    def stop_listening(self) -> None:
        self.on_connection = None
        self._link.send(Unlisten(self._number))

    # ---- for the face

    def hear(self, data: bytes) -> None:
        if self.session is not None:
            self.session.received(data)
        if not self._is_told or self.session is None:
            self.handled(len(data))

    def taken(self, count: int) -> None:
        self._under_way = max(0, self._under_way - count)
        self._feed()
        if not self.unsent and self.session is not None:
            self.session.drained()

    def listening(self, port: int) -> None:
        self._on_port(port)

    def unreached(self) -> None:
        if self.session is not None:
            self._on_failed()

    def end(self) -> None:
        if self.session is not None:
            self.session.ended()

    def lose(self) -> None:
        session, self.session = self.session, None
        if session is not None:
            session.lost()
        self.close_at_once()

    def close_at_once(self, limit: str = "") -> None:
        self._waiting.clear()
        self._is_closing = True
        self._link.send(Close(self._number, limit))
        self._face.forget(self._number)

    def _feed(self) -> None:
        while self._waiting and self._under_way < WINDOW:
            part = bytes(self._waiting[:MOST_DATA])
            del self._waiting[: len(part)]
            self._under_way += len(part)
            self._link.send(Data(self._number, part))
        if self._is_closing and not self._waiting:
            self.close_at_once()
