"""The services of a device at the end of an IP link of its own, such as a telephone line."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final

from fieldrig.outside.limits import OVER_LIMIT, OnLimit
from fieldrig_devices.connections.connection import Serve, Session
from fieldrig_devices.ip.kernel_end import Accepted, IpEnd

EXTRA_PORTS: Final = range(50_000, 50_032)
"""Ports for the data of passive FTP; as many connections can have one at a time."""

Opening = Callable[[], None]
"""Gives up a connection to a client that is not open yet."""


class StackServices:
    """Serves one link, as long as it is up."""

    def __init__(
        self,
        stack: IpEnd,
        services: Mapping[int, Serve],
        wake: Callable[[], None],
        on_connected: Callable[[str], None],
        on_limit: OnLimit,
    ) -> None:
        """`services` are by TCP port; `wake` is called after calls to the stack from outside of its handlers."""
        self.wake, self.on_limit = wake, on_limit
        self.local = str(stack.address)
        self._on_connected = on_connected
        self._extra: dict[int, tuple[_StackConnection, Serve]] = {}
        self._opening: dict[_StackConnection, Opening] = {}
        self._ports = 0
        self._stack = stack
        for port, serve in services.items():
            stack.listen(port, partial(self._accept, serve))
        for port in EXTRA_PORTS:
            stack.listen(port, partial(self._accept_extra, port))

    def listen(self, owner: "_StackConnection", serve: Serve) -> int:
        """Return an extra port for the client of this connection; 0 if none is free."""
        self.stop_listening(owner)
        for _ in EXTRA_PORTS:
            port = EXTRA_PORTS[self._ports % len(EXTRA_PORTS)]
            self._ports += 1
            if port not in self._extra:
                self._extra[port] = owner, serve
                return port
        self.on_limit(OVER_LIMIT, f"{len(EXTRA_PORTS)} extra ports of FTP are open")
        return 0

    def connect(self, owner: "_StackConnection", port: int, on_failed: Callable[[], None], serve: Serve) -> None:
        """Open a connection to the client of this connection; `on_failed` is called if it does not accept it."""
        self.stop_listening(owner)
        try:
            connection = self._stack.connect(owner.remote, port)
        except ConnectionError:
            on_failed()
            return

        def on_open() -> None:
            self._opening.pop(owner, None)
            _StackConnection(self, connection).begin(serve)

        def on_close(_reason: Any) -> None:
            if self._opening.pop(owner, None) is not None:
                on_failed()

        connection.on_open, connection.on_close = on_open, on_close
        self._opening[owner] = connection.abort
        self.wake()

    def stop_listening(self, owner: "_StackConnection") -> None:
        give_up = self._opening.pop(owner, None)
        if give_up is not None:
            give_up()
        self._extra = {port: entry for port, entry in self._extra.items() if entry[0] is not owner}

    def _accept(self, serve: Serve, connection: Accepted) -> None:
        own = _StackConnection(self, connection)
        self._on_connected(own.peer)
        own.begin(serve)

    def _accept_extra(self, port: int, connection: Accepted) -> None:
        entry = self._extra.get(port)
        if entry is None:
            connection.abort()
        else:
            _StackConnection(self, connection).begin(entry[1])


class _StackConnection:
    """The `Connection` of one client of the stack."""

    def __init__(self, services: StackServices, connection: Accepted) -> None:
        self._services, self._connection = services, connection
        self._session: Session | None = None
        self._waiting = bytearray()
        self._is_closing = False
        self.remote = connection.key.remote_address
        self.peer = str(self.remote)
        self.local = services.local

    def begin(self, serve: Serve) -> None:
        connection = self._connection
        connection.on_data = self._on_data
        connection.on_end = self._on_end
        connection.on_close = self._on_close
        connection.on_room = self._on_room
        self._session = serve(self)

    # ---- for the session

    @property
    def unsent(self) -> int:
        return len(self._waiting)

    def handle_later(self) -> None:
        """Do nothing: the window of TCP, and the line, limit what a client sends."""

    def handled(self, count: int) -> None:
        """Do nothing either."""

    def write(self, data: bytes) -> None:
        if not self._is_closing:
            self._waiting += data
            self._feed()

    def close(self) -> None:
        self._session = None
        self._is_closing = True
        self._services.stop_listening(self)
        self._feed()

    def cut(self, limit: str) -> None:
        self._services.on_limit(limit, f"a connection of {self.peer} is closed")
        self._waiting.clear()
        self.close()

    def listen(self, on_port: Callable[[int], None], on_connection: Serve) -> None:
        on_port(self._services.listen(self, on_connection))

    def connect(self, port: int, on_failed: Callable[[], None], on_connection: Serve) -> None:
        self._services.connect(self, port, on_failed, on_connection)

    def stop_listening(self) -> None:
        self._services.stop_listening(self)

    # ---- for the stack

    def _on_data(self, data: bytes) -> None:
        if self._session is not None:
            self._session.received(data)

    def _on_end(self) -> None:
        if self._session is not None:
            self._session.ended()

    def _on_close(self, _reason: Any) -> None:
        session, self._session = self._session, None
        if session is not None:
            session.lost()
            self.close()

    def _on_room(self) -> None:
        self._feed()
        if not self._waiting and self._session is not None:
            self._session.drained()

    def _feed(self) -> None:
        if not self._connection.is_open:
            self._waiting.clear()
        room = self._connection.room
        if self._waiting and room:
            self._connection.send(bytes(self._waiting[:room]))
            del self._waiting[:room]
        if self._is_closing and not self._waiting:
            self._connection.close()
        self._services.wake()
