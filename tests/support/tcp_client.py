"""A client of a service, and the connection between them, in memory."""

from collections.abc import Callable

from fieldrig_devices.connections.connection import Serve, Session


class ServedConnection:
    """A connection whose network takes everything at once, or only when the test says so (`is_taking`)."""

    def __init__(self, serve: Serve, *, is_taking: bool = True) -> None:
        self.peer, self.local = "10.0.0.7", "10.0.0.1"
        self.is_taking, self.is_closed = is_taking, False
        self.limit = ""
        """The limit because of which the session has closed the connection."""
        self.arrived = bytearray()
        """Bytes that the client has."""
        self._waiting = bytearray()
        self.port = 0
        self.serve_extra: Serve | None = None
        self.is_opening_late = False
        """True for a network that opens a port only when the test calls `opened`."""
        self.opened: Callable[[], None] = lambda: None
        self.connecting: tuple[int, Callable[[], None], Serve] | None = None
        """The port of the client to which the session connects, and what it wants to be called."""
        self.session: Session = serve(self)

    # ---- for the session

    @property
    def unsent(self) -> int:
        return len(self._waiting)

    def handle_later(self) -> None:
        """Do nothing, as the test decides what it sends."""

    def handled(self, count: int) -> None:
        """Do nothing, as the test decides what it sends."""

    def write(self, data: bytes) -> None:
        assert not self.is_closed, "nothing is written to a connection that was closed"
        (self.arrived if self.is_taking else self._waiting).extend(data)

    def close(self) -> None:
        self.is_closed = True
        self.arrived += self._waiting
        self._waiting.clear()

    def cut(self, limit: str) -> None:
        self.limit = limit
        self.close()

    def listen(self, on_port: Callable[[int], None], on_connection: Serve) -> None:
        self.serve_extra = on_connection
        self.port = 50_001
        self.opened = lambda: on_port(self.port)
        if not self.is_opening_late:
            self.opened()

    def connect(self, port: int, on_failed: Callable[[], None], on_connection: Serve) -> None:
        self.connecting = port, on_failed, on_connection

    def stop_listening(self) -> None:
        self.serve_extra = self.connecting = None

    # ---- for the client

    def send(self, data: bytes) -> bytes:
        """Send bytes, and return what has arrived since the last call."""
        if not self.is_closed:
            self.session.received(data)
        return self.take()

    def take(self) -> bytes:
        """Return what has arrived since the last call."""
        arrived = bytes(self.arrived)
        self.arrived.clear()
        return arrived

    def accept(self, count: int | None = None) -> bytes:
        """The network takes `count` of the bytes that wait, all by default; return what has arrived."""
        count = len(self._waiting) if count is None else count
        self.arrived += self._waiting[:count]
        del self._waiting[:count]
        if not self._waiting and not self.is_closed:
            self.session.drained()
        return self.take()

    def end(self) -> None:
        """The client has sent everything."""
        if not self.is_closed:
            self.session.ended()

    def lose(self) -> None:
        """The connection breaks."""
        if not self.is_closed:
            self.session.lost()
            self.is_closed = True
