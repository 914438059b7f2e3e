"""Messages between the port that accepts TCP connections and the devices that serve them.

A connection has a number, which the port gives it and does not use again.  `Connected`, `Data`, `Taken`, `Ended` and
`Listening` and `Unreached` come from the port.  A device sends `Data`, `Close`, `Listen`, `Unlisten` and `Connect`.
"""

import re
from dataclasses import dataclass
from ipaddress import ip_address
from typing import Any, Final

from fieldrig.faults.note import FaultNote

MOST_DATA: Final = 16 * 1024
"""Longest data of a message, in bytes."""
WINDOW: Final = 4 * 1024
"""Bytes of a client that its device has not handled yet, from which on nothing is read from it."""
LIMIT: Final = re.compile("[a-z][a-z ]{0,63}|")
"""Names of limits."""
SERVICE: Final = re.compile("[a-z][a-z0-9_-]{0,31}")
"""Names of services."""
HIGHEST_NUMBER: Final = 0xFFFF_FFFF


@dataclass(frozen=True, slots=True)
class Connected:
    """A client has connected to a service."""

    connection: int
    service: str
    """Name of the service; empty for a connection to the extra port of `origin`, or one that it asked for."""
    peer: str
    """IP address of the client."""
    local: str
    """IP address that the client used."""
    origin: int = 0
    """The connection for which the port listened or connected; 0 for a connection to a service."""


@dataclass(frozen=True, slots=True)
class Data:
    """Bytes in either direction, at most `MOST_DATA`."""

    connection: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Taken:
    """The network has taken this many more bytes of the device; or the device has handled this many of its client.

    A client that has sent `WINDOW` bytes more than its device has handled waits.
    """

    connection: int
    count: int


@dataclass(frozen=True, slots=True)
class Ended:
    """The client has sent everything, or is gone."""

    connection: int
    is_lost: bool = False
    """True if the connection was lost before the client had said that this is all."""


@dataclass(frozen=True, slots=True)
class Close:
    """Close the connection when the client has taken everything, with its extra port."""

    connection: int
    limit: str = ""
    """The limit of the service that the client has reached, as a name for people; empty for any other reason."""


@dataclass(frozen=True, slots=True)
class Listen:
    """Open an extra port for the client of this connection, instead of an earlier one."""

    connection: int


@dataclass(frozen=True, slots=True)
class Listening:
    """The extra port of this connection is open."""

    connection: int
    port: int
    """The TCP port; 0 if none is free."""


@dataclass(frozen=True, slots=True)
class Unlisten:
    """Close the extra port of this connection, and give up what it asked for by `Connect`; connections stay."""

    connection: int


@dataclass(frozen=True, slots=True)
class Connect:
    """Open a connection to the client of this connection, instead of an extra port."""

    connection: int
    port: int
    """The client's TCP port, 1 to 65535."""


@dataclass(frozen=True, slots=True)
class Unreached:
    """The client does not accept the connection that `Connect` asked for."""

    connection: int


TcpMessage = Connected | Data | Taken | Ended | Close | Listen | Listening | Unlisten | Connect | Unreached
OnTcp = TcpMessage | FaultNote
"""The same, and the notes of faults that are in the trace."""
KINDS: Final[tuple[type[Any], ...]] = (
    Connected, Data, Taken, Ended, Close, Listen, Listening, Unlisten, Connect, Unreached,
)  # fmt: skip


def check_sent(message: Any) -> None:
    """Raise TypeError or ValueError for a message that no bus of this family carries."""
    if type(message) not in KINDS:
        raise TypeError(f"expected a message of TCP, found {type(message).__name__}")
    _check_number("connection", message.connection, 1)
    match message:
        case Connected(service=service, peer=peer, local=local, origin=origin):
            _check_text("service", service)
            if service and SERVICE.fullmatch(service) is None:
                raise ValueError(f"service {service!r}: expected a name such as http")
            for name, address in (("peer", peer), ("local", local)):
                _check_text(name, address)
                ip_address(address)
            _check_number("origin", origin, 0)
        case Data(data=data):
            if type(data) is not bytes:
                raise TypeError(f"data: expected bytes, found {type(data).__name__}")
            if not 1 <= len(data) <= MOST_DATA:
                raise ValueError(f"{len(data)} bytes, expected 1 to {MOST_DATA}")
        case Taken(count=count):
            _check_number("count", count, 1)
        case Ended(is_lost=is_lost):
            if type(is_lost) is not bool:
                raise TypeError(f"is_lost: expected bool, found {type(is_lost).__name__}")
        case Listening(port=port):
            _check_number("port", port, 0, 0xFFFF)
        case Close(limit=limit):
            _check_text("limit", limit)
            if LIMIT.fullmatch(limit) is None:
                raise ValueError(f"limit {limit!r}: expected a name of lower-case words")
        case Connect(port=port):
            _check_number("port", port, 1, 0xFFFF)


def _check_text(name: str, value: Any) -> None:
    if type(value) is not str:
        raise TypeError(f"{name}: expected a text, found {type(value).__name__}")


def _check_number(name: str, value: Any, low: int, high: int = HIGHEST_NUMBER) -> None:
    if type(value) is not int:
        raise TypeError(f"{name}: expected int, found {type(value).__name__}")
    if not low <= value <= high:
        raise ValueError(f"{name} {value}: expected {low} to {high}")
