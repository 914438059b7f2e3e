"""IP of a link that ends in the kernel of the host, over a relay that offers one; seen from the device.

It is used like a `Stack`.  What the kernel is not for, such as connections to ports without a service, ends in a stack
of our own, and so does everything as soon as the kernel gives the link up.
"""

import logging
from collections.abc import Callable
from ipaddress import IPv4Address
from typing import Final, Protocol

from fieldrig_bus.ip.channel import Channel
from fieldrig_bus.ip.channels import Channels
from fieldrig_bus.ip.message import MOST_PORTS, IpPacket, LinkDown, LinkUp, Opened, RelayMessage
from fieldrig_bus.ip.stream import Stream
from fieldrig_devices.ip.ipv4 import Packet
from fieldrig_devices.ip.ipv4 import Protocol as IpProtocol
from fieldrig_devices.ip.stack import Stack
from fieldrig_devices.ip.tcp.connection import Connection, Key

log = logging.getLogger(__name__)

MOST_WAITING: Final = 8192
"""Bytes that may wait for the line; further packets of the kernel are dropped, as in any router.

They are some 2 s of a line at 38400 bit/s, behind which an echo of LCP waits as well.
"""
GONE: Final = "the link is gone"


class Accepted(Stream, Protocol):
    """A connection that a service accepts, from whatever end of IP."""

    key: Key

    @property
    def is_open(self) -> bool:
        """True while data can be sent, if only later."""

    def close(self) -> None:
        """End our direction, and receive nothing more."""


class IpEnd(Protocol):
    """A host at the end of a link: a stack of our own, or the kernel."""

    address: IPv4Address

    def listen(self, port: int, accept: Callable[[Accepted], None]) -> None: ...
    def connect(self, address: IPv4Address, port: int) -> Connection: ...
    def receive(self, now_ns: int, packet: bytes) -> None: ...
    def advance(self, now_ns: int) -> None: ...
    def next_ns(self) -> int | None: ...
    def link_down(self, now_ns: int) -> None: ...


class KernelConnection(Channel):
    """A connection that the kernel has accepted."""

    def __init__(self, key: Key, opener: str, number: int, emit: Callable[[RelayMessage], None]) -> None:
        super().__init__(opener, number, True, emit)
        self.key = key

    @property
    def is_open(self) -> bool:
        return not (self.is_over or self._is_ending)

    def close(self) -> None:
        self.end()
        self.on_data, self.on_end, self.on_room = _drop, _do_nothing, _do_nothing
        self.resume()


class KernelEnd:
    """One link.  `take` gets everything that comes from the relay for it."""

    def __init__(
        self,
        name: str,
        stack: Stack,
        peer: IPv4Address,
        mtu: int,
        send: Callable[[RelayMessage], None],
        transmit: Callable[[bytes], None],
        waiting: Callable[[], int],
    ) -> None:
        """`name` is the device's; `send` is for the relay, `transmit` for the line, for which `waiting` bytes wait."""
        self.address = stack.address
        self._name, self._stack, self._peer, self._mtu = name, stack, peer, mtu
        self._send, self._transmit, self._waiting = send, transmit, waiting
        self._listeners: dict[int, Callable[[Accepted], None]] = {}
        self._connections = Channels()
        self._is_linked = False

    # ---- as a stack

    def listen(self, port: int, accept: Callable[[Accepted], None]) -> None:
        self._listeners[port] = accept
        if len(self._listeners) > MOST_PORTS:
            self.give_up(f"there are more than {MOST_PORTS} ports")
        elif self._is_linked:
            self.begin()

    def connect(self, address: IPv4Address, port: int) -> Connection:
        """Open a connection from our own stack, as the kernel would open one for any process of the host."""
        return self._stack.connect(address, port)

    def begin(self) -> None:
        """Hand the link to the kernel, with all ports that have a listener."""
        self._is_linked = True
        self._send(LinkUp(self._name, self.address, self._peer, self._mtu, tuple(sorted(self._listeners))))

    def receive(self, now_ns: int, packet: bytes) -> None:
        if self._is_linked and self._is_for_kernel(packet):
            self._send(IpPacket(self._name, False, packet))
        else:
            self._stack.receive(now_ns, packet)

    def advance(self, now_ns: int) -> None:
        self._stack.advance(now_ns)

    def next_ns(self) -> int | None:
        return self._stack.next_ns()

    def link_down(self, now_ns: int) -> None:
        if self._is_linked:
            self._is_linked = False
            self._send(LinkDown(self._name, False, GONE))
        self._connections.lose(GONE)
        self._stack.link_down(now_ns)

    # ---- for the relay

    def take(self, message: RelayMessage) -> None:
        match message:
            case IpPacket() if self._is_linked and self._waiting() < MOST_WAITING:
                self._transmit(message.data)
            case LinkDown():
                self.give_up(message.why)
            case Opened():
                self._accept(message)
            case _:
                self._connections.take(message)

    def give_up(self, why: str) -> None:
        """Serve the rest of the call with our own stack."""
        log.warning("IP ends in the device's own stack: %s", why)
        self._is_linked = False
        self._connections.lose(why)
        for port, accept in self._listeners.items():
            self._stack.listen(port, accept)

    def _accept(self, message: Opened) -> None:
        accept = self._listeners.get(message.port)
        key = Key(message.port, self._peer, 0)
        connection = KernelConnection(key, message.opener, message.number, self._send_in_channel)
        if accept is None:
            connection.abort()
        else:
            self._connections.add((message.opener, message.number), connection)
            accept(connection)

    def _send_in_channel(self, message: RelayMessage) -> None:
        self._send(message)
        self._connections.sent(message)

    def _is_for_kernel(self, data: bytes) -> bool:
        """True for what a service may answer, and for ICMP."""
        try:
            packet = Packet.decode(data)
        except ValueError:
            return False
        if (packet.source, packet.destination) != (self._peer, self.address):
            return False
        if packet.is_fragment:  # the kernel puts it together; only the first one has ports
            return packet.protocol in (IpProtocol.TCP, IpProtocol.ICMP)
        if packet.protocol == IpProtocol.TCP:
            remote, local = (int.from_bytes(packet.payload[at : at + 2], "big") for at in (0, 2))
            return local in self._listeners and not self._stack.has_connection(Key(local, packet.source, remote))
        return packet.protocol == IpProtocol.ICMP


def _drop(_data: bytes) -> None:
    """Take data that the user does not want any more."""


def _do_nothing() -> None:
    """Ignore an event after the end."""
