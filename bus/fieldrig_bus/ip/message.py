"""Messages of a relay: services that are offered, and channels to them.

A member offers ports (`Offered`).  Another one, the opener, opens channels to a port (`Opened`) under numbers of its
own choice.  Each end sends data in portions, at most `WINDOW` bytes that were not reported as `Consumed`, and then
`Ended`.  `Closed` at any time means that the channel is lost.  Messages of the offering end have `is_answer` set.

A kernel may offer itself as the end of IP (`KernelOffered`).  A device whose link is up (`LinkUp`) then sends it whole
packets (`IpPacket`) instead of channels, and the kernel opens a channel to the device for each connection to one of the
device's ports.  The packets of the kernel, and its refusal (`LinkDown`), have `is_answer` set.
"""

from dataclasses import dataclass
from ipaddress import IPv4Address
from typing import Any, Final

from fieldrig.faults.note import FaultNote

WINDOW: Final = 65_536
LARGEST: Final = 8_192
"""Bytes in one portion."""
LARGEST_PACKET: Final = 0xFFFF
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


@dataclass(frozen=True, slots=True)
class KernelOffered:
    """The sender ends the IP of one device at a time in the kernel of its host."""


@dataclass(frozen=True, slots=True)
class LinkUp:
    """The link of a device is up, or offers further ports: the kernel is `address`, and its peer is `peer`."""

    device: str
    address: IPv4Address
    peer: IPv4Address
    mtu: int
    ports: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class LinkDown:
    """The link is gone, or the kernel does not end it any more."""

    device: str
    is_answer: bool
    why: str


@dataclass(frozen=True, slots=True)
class IpPacket:
    """A packet of IPv4 from the link, or to it."""

    device: str
    is_answer: bool
    data: bytes


RelayMessage = Offered | Opened | Portion | Consumed | Ended | Closed | KernelOffered | LinkUp | LinkDown | IpPacket
OnRelay = RelayMessage | FaultNote
"""The same, and the notes of faults that are in the trace."""
IN_CHANNEL: Final = (Portion, Consumed, Ended, Closed)
OF_LINK: Final = (LinkUp, LinkDown, IpPacket)


def check_sent(message: Any) -> None:
    """Raise TypeError or ValueError for a message that a relay cannot carry."""
    if isinstance(message, Offered):
        _check_ports(message.ports)
        return
    if isinstance(message, KernelOffered):
        return
    if isinstance(message, OF_LINK):
        _check_link(message)
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
            _check_data(message.data, LARGEST)
        case Consumed():
            _check_number("size", message.size, 1, WINDOW)
        case Closed():
            _check_text("why", message.why)
    _check_direction(message.is_answer)


def _check_link(message: LinkUp | LinkDown | IpPacket) -> None:
    _check_text("device", message.device)
    match message:
        case LinkUp():
            for name, address in (("address", message.address), ("peer", message.peer)):
                if type(address) is not IPv4Address:
                    raise TypeError(f"{name}: expected IPv4Address, found {type(address).__name__}")
            _check_number("mtu", message.mtu, 1, LARGEST_PACKET)
            _check_ports(message.ports)
            return
        case LinkDown():
            _check_text("why", message.why)
        case IpPacket():
            _check_data(message.data, LARGEST_PACKET)
    _check_direction(message.is_answer)


def _check_direction(is_answer: Any) -> None:
    if type(is_answer) is not bool:
        raise TypeError(f"is_answer: expected bool, found {type(is_answer).__name__}")


def _check_data(data: Any, largest: int) -> None:
    if type(data) is not bytes:
        raise TypeError(f"data: expected bytes, found {type(data).__name__}")
    _check_number("size of the data", len(data), 1, largest)


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
