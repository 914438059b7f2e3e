"""Messages of a relay: services that are offered, and channels to them.

A member offers ports (`Offered`).  Another one, the opener, opens channels to a port (`Opened`) under numbers of its
own choice.  Each end sends data in portions, at most `WINDOW` bytes that were not reported as `Consumed`, and then
`Ended`.  `Closed` at any time means that the channel is lost.  Messages of the offering end have `is_answer` set.
"""

from dataclasses import dataclass
from typing import Any, Final

WINDOW: Final = 65_536
LARGEST: Final = 8_192
"""Bytes in one portion."""
MOST_PORTS: Final = 100
LONGEST_NAME: Final = 255
"""Longest name of a member and longest reason, in bytes of UTF-8."""


@dataclass(frozen=True, slots=True)
class Offered:
    """The ports that the sender serves from now on."""

    ports: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Opened:
    """The sender, `opener`, opens a channel to a port."""

    opener: str
    number: int
    port: int


@dataclass(frozen=True, slots=True)
class Portion:
    """Data, 1 to `LARGEST` bytes."""

    opener: str
    number: int
    is_answer: bool
    data: bytes


@dataclass(frozen=True, slots=True)
class Consumed:
    """The sender has passed on this number of bytes, so the other end may send as many more."""

    opener: str
    number: int
    is_answer: bool
    size: int


@dataclass(frozen=True, slots=True)
class Ended:
    """The sender has no more data."""

    opener: str
    number: int
    is_answer: bool


@dataclass(frozen=True, slots=True)
class Closed:
    """The channel is lost."""

    opener: str
    number: int
    is_answer: bool
    why: str


RelayMessage = Offered | Opened | Portion | Consumed | Ended | Closed
IN_CHANNEL: Final = (Portion, Consumed, Ended, Closed)


def check_sent(message: Any) -> None:
    """Raise TypeError or ValueError for a message that a relay can't carry."""
    if isinstance(message, Offered):
        _check_ports(message.ports)
        return
    if not isinstance(message, (Opened, *IN_CHANNEL)):
        raise TypeError(f"expected a message of a relay, found {type(message).__name__}")
    _check_text("opener", message.opener)
    _check_number("number", message.number, 0, 0xFFFF_FFFF)
    match message:
        case Opened():
            _check_number("port", message.port, 1, 0xFFFF)
            return
        case Portion():
            if type(message.data) is not bytes:
                raise TypeError(f"data: expected bytes, found {type(message.data).__name__}")
            _check_number("size of the data", len(message.data), 1, LARGEST)
        case Consumed():
            _check_number("size", message.size, 1, WINDOW)
        case Closed():
            _check_text("why", message.why)
    if type(message.is_answer) is not bool:
        raise TypeError(f"is_answer: expected bool, found {type(message.is_answer).__name__}")


def _check_ports(ports: Any) -> None:
    if type(ports) is not tuple:
        raise TypeError(f"ports: expected tuple, found {type(ports).__name__}")
    if len(ports) > MOST_PORTS:
        raise ValueError(f"{len(ports)} ports, expected at most {MOST_PORTS}")
    for port in ports:
        _check_number("port", port, 1, 0xFFFF)


def _check_text(name: str, text: Any) -> None:
    if type(text) is not str:
        raise TypeError(f"{name}: expected str, found {type(text).__name__}")
    length = len(text.encode())  # UnicodeEncodeError is a ValueError
    if length > LONGEST_NAME:
        raise ValueError(f"{name} has {length} bytes, expected at most {LONGEST_NAME}")


def _check_number(name: str, value: Any, lowest: int, highest: int) -> None:
    if type(value) is not int:
        raise TypeError(f"{name}: expected int, found {type(value).__name__}")
    if not lowest <= value <= highest:
        raise ValueError(f"{name} {value}: expected {lowest} to {highest}")
