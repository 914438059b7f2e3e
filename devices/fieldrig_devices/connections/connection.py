"""A TCP connection and the session that a service has on it.

A service such as HTTP or FTP makes a session for each connection.  The session only reacts, to bytes, the end, and
room for more bytes.
"""

from collections.abc import Callable
from typing import Final, Protocol

UNREAD: Final = "clients that did not read"
"""The limit of a client that leaves too much of what it is sent unread."""
TOO_LONG: Final = "messages over the limit"
"""The limit of a client whose message is too long."""


class Connection(Protocol):
    """The end of the service."""

    @property
    def peer(self) -> str:
        """IP address of the client."""

    @property
    def local(self) -> str:
        """IP address that the client used."""

    @property
    def unsent(self) -> int:
        """Number of bytes written that the network has not taken yet."""

    def handle_later(self) -> None:
        """Let the session report with `handled` what it has done; otherwise it has done all when `received` returns."""

    def handled(self, count: int) -> None:
        """Tell that this many bytes are handled, so that the client may send as many more."""

    def write(self, data: bytes) -> None:
        """Send bytes; any number of them is kept until the network takes them."""

    def close(self) -> None:
        """Close the connection after everything written; the session hears nothing more."""

    def cut(self, limit: str) -> None:
        """Close the connection, because the client has reached this limit of the service, named in lower-case words.

        It is counted and logged.  What the network has no room for is not sent.
        """

    def listen(self, on_port: Callable[[int], None], on_connection: "Serve") -> None:
        """Open an extra port for this client, instead of an earlier one.

        `on_port` is called with its number, 0 if there is none, and `on_connection` with each connection to it.
        """

    def connect(self, port: int, on_failed: Callable[[], None], on_connection: "Serve") -> None:
        """Open a connection to a port of this client, instead of listening at an extra port.

        `on_connection` is called with it, or `on_failed` if the client does not accept it.
        """

    def stop_listening(self) -> None:
        """Close the extra port, and give up a connection that `connect` has not opened yet; others stay."""


class Session(Protocol):
    """The part of a service that handles one connection."""

    def received(self, data: bytes) -> None: ...

    def drained(self) -> None:
        """Everything written has been taken by the network."""

    def ended(self) -> None:
        """The client has sent everything.  What is written still reaches it; the session closes the connection."""

    def lost(self) -> None:
        """The connection was lost, perhaps in the middle of what the client sends.  It is closed already."""


Serve = Callable[[Connection], Session]
